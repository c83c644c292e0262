//! The elements that carry tractions, and the stresses that they make together.

use std::ops::Range;

use crate::foundation::{DepthSide, StressKernels};
use crate::model::{Fields, Foundation, Stress};

/// The stresses below tractions on the surface of a foundation.
#[derive(Clone, Debug)]
pub struct Subsurface<'a> {
    pub(super) foundation: &'a Foundation,
    pub(super) fields: &'a Fields,
    /// The columns and rows of elements that hold all tractions.
    pub(super) window: [Range<usize>; 2],
    /// The elements that carry tractions.
    elements: Vec<LoadedElement>,
    /// The farthest that a point on the grid is from a loaded one, along the surface \[m\].
    reach: f64,
}

/// An element with its tractions.
#[derive(Clone, Copy, Debug)]
struct LoadedElement {
    /// The centre \[m\].
    center: [f64; 2],
    /// The pressure, and the traction along x and y \[Pa\].
    tractions: [f64; 3],
}

/// The stresses at the centres of all elements at one depth, row-major with x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneStress {
    /// The depth \[m\].
    pub depth: f64,
    /// The stresses.
    pub stresses: Vec<Stress>,
}

impl<'a> Subsurface<'a> {
    /// Binds the tractions of `fields` to the foundation on which they act.
    pub fn new(foundation: &'a Foundation, fields: &'a Fields) -> Self {
        let [nx, ny] = fields.shape.map(|n| n as usize);
        let tractions = |e: usize| [fields.pressure[e], fields.traction_x[e], fields.traction_y[e]];
        let mut window = [nx..0, ny..0];
        let mut elements = Vec::new();
        for e in (0..nx * ny).filter(|e| tractions(*e) != [0.0; 3]) {
            for (range, place) in window.iter_mut().zip([e % nx, e / nx]) {
                *range = range.start.min(place)..range.end.max(place + 1);
            }
            elements.push(LoadedElement { center: center(fields, e), tractions: tractions(e) });
        }
        if elements.is_empty() {
            window = [0..0, 0..0];
        }
        let [width, height] = [0, 1].map(|i| f64::from(fields.shape[i]) * fields.element[i]);
        Self { foundation, fields, window, elements, reach: width.hypot(height) }
    }

    /// Returns the stress at the point (x, y, z) \[m\] by direct sums over the loaded elements;
    /// `None` inside a rigid base. Where materials meet it is that of the upper one.
    ///
    /// At z = 0 a stress that jumps on the edge of an element is the mean of both sides, and one
    /// that is infinite there is that at a distance of 1e-12 of the element's side.
    pub fn at(&self, [x, y, z]: [f64; 3]) -> Option<Stress> {
        let kernels = self.kernels(z, DepthSide::Above, [x, y])?;
        Some(self.sum(&kernels, [x, y]))
    }

    /// Prepares the stresses at a depth for a point (x, y) and for all elements.
    pub(super) fn kernels(
        &self,
        depth: f64,
        side: DepthSide,
        [x, y]: [f64; 2],
    ) -> Option<StressKernels> {
        let [x0, y0] = self.fields.origin;
        let reach = self.reach + (x - x0).hypot(y - y0);
        StressKernels::new(self.foundation, depth, side, reach)
    }

    /// Sums the stresses at (x, y) over the loaded elements, in their order.
    pub(super) fn sum(&self, kernels: &StressKernels, [x, y]: [f64; 2]) -> Stress {
        let half_sides = self.fields.element.map(|side| 0.5 * side);
        let mut sum = [0.0; 6];
        for LoadedElement { center, tractions } in &self.elements {
            let block = kernels.stresses([x - center[0], y - center[1]], half_sides);
            for (sum, row) in sum.iter_mut().zip(block) {
                *sum += row[0] * tractions[0] + row[1] * tractions[1] + row[2] * tractions[2];
            }
        }
        Stress::from_components(sum)
    }

    /// Sums the stresses at (x, y) over the quarters of the loaded elements.
    pub(super) fn sum_of_quarters(&self, kernels: &StressKernels, [x, y]: [f64; 2]) -> Stress {
        let quarters = self.fields.element.map(|side| 0.25 * side);
        let mut sum = [0.0; 6];
        for LoadedElement { center, tractions } in &self.elements {
            for [right, up] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
                let receiver =
                    [x - center[0] - right * quarters[0], y - center[1] - up * quarters[1]];
                let block = kernels.stresses(receiver, quarters);
                for (sum, row) in sum.iter_mut().zip(block) {
                    *sum += row[0] * tractions[0] + row[1] * tractions[1] + row[2] * tractions[2];
                }
            }
        }
        Stress::from_components(sum)
    }

    /// Returns the pressure and the tractions along x and y at a place of the surface; `None`
    /// within a thousandth of an element from an edge between elements.
    pub(super) fn tractions_inside(&self, place: [f64; 2]) -> Option<[f64; 3]> {
        let fields = self.fields;
        let across = [0, 1].map(|i| (place[i] - fields.origin[i]) / fields.element[i]);
        if across.iter().any(|across| (across - across.round()).abs() > 0.499) {
            return None;
        }
        let [i, j] = across.map(f64::round);
        let [nx, ny] = fields.shape.map(f64::from);
        if !(0.0..nx).contains(&i) || !(0.0..ny).contains(&j) {
            return Some([0.0; 3]);
        }
        let e = j as usize * fields.shape[0] as usize + i as usize;
        Some([fields.pressure[e], fields.traction_x[e], fields.traction_y[e]])
    }

    /// Returns the number of elements that carry tractions.
    pub(super) fn loaded(&self) -> usize {
        self.elements.len()
    }

    /// Returns the centre of an element \[m\].
    pub(super) fn center(&self, element: usize) -> [f64; 2] {
        center(self.fields, element)
    }
}

fn center(fields: &Fields, element: usize) -> [f64; 2] {
    let nx = fields.shape[0] as usize;
    let place = [element % nx, element / nx];
    [0, 1].map(|i| fields.origin[i] + place[i] as f64 * fields.element[i])
}
