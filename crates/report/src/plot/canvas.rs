//! A panel in its place: where values lie in the picture.

use super::figure::{PlotAxis, PlotPanel};
use crate::axis::{AxisScale, DrawnAxis, TICK_SIZE, Ticks, drawable};
use crate::font::shorten;
use crate::svg::Rect;
use crate::unit::PrefixedUnit;

/// With more points than this, not every one is marked.
pub(super) const MARKED: usize = 40;

/// An axis with its values in the unit that is written.
pub(super) struct PanelAxis {
    pub(super) drawn: DrawnAxis,
    pub(super) unit: PrefixedUnit,
}

impl PanelAxis {
    /// An axis for values in SI units; `width` in pixels if it is horizontal.
    pub(super) fn new(axis: &PlotAxis, values: &[f64], width: Option<f64>) -> PanelAxis {
        let values = || values.iter().copied().filter(|v| drawable(*v, axis.log));
        let unit = if !axis.categories.is_empty() {
            PrefixedUnit::plain("")
        } else if axis.log {
            // The middle of the decades decides.
            let (low, high) =
                values().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
            PrefixedUnit::fitting(&axis.unit, (0.5 * (low.ln() + high.ln())).exp())
        } else {
            PrefixedUnit::fitting(&axis.unit, values().map(f64::abs).fold(0.0, f64::max))
        };
        let drawn = if axis.categories.is_empty() {
            let scale = AxisScale::around(values().map(|v| unit.of_si(v)), axis.log);
            match width {
                Some(width) => DrawnAxis::across(scale, width, &axis.label, &unit.name),
                None => DrawnAxis::new(
                    scale,
                    scale.ticks(if axis.log { 8 } else { 5 }),
                    &axis.label,
                    &unit.name,
                ),
            }
        } else {
            let scale =
                AxisScale { low: -0.5, high: axis.categories.len() as f64 - 0.5, log: false };
            let labels = axis.categories.iter().map(|c| shorten(c, 110.0, TICK_SIZE));
            let major = labels.enumerate().map(|(i, label)| (i as f64, label)).collect();
            DrawnAxis::new(scale, Ticks { major, minor: Vec::new(), exponent: 0 }, &axis.label, "")
        };
        PanelAxis { drawn, unit }
    }

    fn at(&self, si: f64) -> f64 {
        self.drawn.scale.at(self.unit.of_si(si))
    }
}

/// A place in the picture, or values along x and y.
pub(super) type Place = (f64, f64);
/// A piece of a line.
pub(super) type Segment = (Place, Place);

/// Whether a value is drawn on an axis at all. The range of categories does not grow with the
/// values, and pixels far beyond the picture are beyond what renders it.
pub(super) fn has_place(axis: &PlotAxis, value: f64) -> bool {
    let count = axis.categories.len() as f64;
    drawable(value, axis.log)
        && (axis.categories.is_empty() || (-0.5..count - 0.5).contains(&value))
}

/// A panel in its place.
pub(super) struct Canvas<'a> {
    pub(super) frame: Rect,
    pub(super) panel: &'a PlotPanel,
    pub(super) x: &'a PanelAxis,
    pub(super) y: &'a PanelAxis,
}

impl Canvas<'_> {
    /// The place of a point with values in SI units, if it has one.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let frame = self.frame;
        let drawn = has_place(&self.panel.x, x) && has_place(&self.panel.y, y);
        drawn.then(|| {
            (frame.x + self.x.at(x) * frame.width, frame.bottom() - self.y.at(y) * frame.height)
        })
    }
}
