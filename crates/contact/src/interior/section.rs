//! The stresses on a section down from the surface.

use super::loaded::{PlaneStress, Subsurface};
use crate::model::Stress;

/// The stresses on a section x = const or y = const, in the middle of equal rows from the surface
/// down; within a row they lie at the elements' centres.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionStress {
    /// The x or y of the section: that of the nearest elements' centres \[m\].
    pub place: f64,
    /// The height of a row \[m\].
    pub row: f64,
    /// The number of rows.
    pub rows: usize,
    /// The stresses, with the places of a row one after another.
    pub stresses: Vec<Stress>,
}

impl Subsurface<'_> {
    /// Returns the stresses on the section across `axis` (0 for x, 1 for y) through the elements
    /// whose centres are nearest to `place`, down to a depth \[m\], by default twice the radius of
    /// the disk of the loaded area; `None` inside a rigid base. Rows are as high as elements are
    /// wide, but each costs a plane: there are no more than 512, and no more than 16 of planes of
    /// half a million elements or more.
    pub fn section(&self, axis: usize, place: f64, down_to: Option<f64>) -> Option<SectionStress> {
        /// The most rows, and the most of the largest planes.
        const MOST: [usize; 2] = [512, 16];
        /// The elements of all rows together, about a quarter of a minute of one core.
        const ELEMENTS: usize = 8_000_000;
        let fields = self.fields;
        let shape = fields.shape.map(|n| n as usize);
        let [hx, hy] = fields.element;
        let radius = (self.loaded().max(1) as f64 * hx * hy / std::f64::consts::PI).sqrt();
        let bottom = self.foundation.depth().unwrap_or(f64::INFINITY);
        let depth = down_to.unwrap_or((2.0 * radius).min(bottom));
        let most = (ELEMENTS / (shape[0] * shape[1])).clamp(MOST[1], MOST[0]);
        let rows = ((depth / hx.min(hy)).round() as usize).clamp(1, most);
        let row = depth / rows as f64;
        let across = (place - fields.origin[axis]) / fields.element[axis];
        let index = (across.round().max(0.0) as usize).min(shape[axis] - 1);
        let mut stresses = Vec::with_capacity(rows * shape[1 - axis]);
        for k in 0..rows {
            let PlaneStress { stresses: plane, .. } = self.plane((k as f64 + 0.5) * row)?;
            stresses.extend((0..shape[1 - axis]).map(|along| {
                let [i, j] = if axis == 0 { [index, along] } else { [along, index] };
                plane[j * shape[0] + i]
            }));
        }
        let place = fields.origin[axis] + index as f64 * fields.element[axis];
        Some(SectionStress { place, row, rows, stresses })
    }
}
