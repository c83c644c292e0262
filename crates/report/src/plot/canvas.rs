//! A panel in its place: the way from values to pixels.

use super::figure::{PlotAxis, PlotPanel};
use super::sketch::SketchAxis;
use crate::axis::{AxisScale, DrawnAxis, TICK_SIZE, Ticks, drawable};
use crate::font::shorten;
use crate::svg::Rect;
use crate::unit::PrefixedUnit;

/// A point (x, y): a place in the picture in pixels, y downwards, or a pair of values in SI units.
pub(super) type PlotPoint = (f64, f64);
/// A straight piece of a line between two places.
pub(super) type Segment = (PlotPoint, PlotPoint);

/// With more points than this, not every point is marked.
const MARKED: usize = 40;

/// Returns the step between marked points of a line: every point, or about 15 in all.
pub(super) fn marker_step(points: usize) -> usize {
    if points <= MARKED { 1 } else { points.div_ceil(15) }
}

/// An axis of a panel with the unit that its values are written in.
pub(super) struct PanelAxis {
    pub(super) drawn: DrawnAxis,
    pub(super) unit: PrefixedUnit,
}

impl PanelAxis {
    /// Fits an axis to values in SI units; `width` in pixels if it is horizontal.
    pub(super) fn new(axis: &PlotAxis, values: &[f64], width: Option<f64>) -> PanelAxis {
        if axis.categories.is_empty() {
            PanelAxis::of_numbers(axis, values, width)
        } else {
            PanelAxis::of_categories(axis)
        }
    }

    fn of_numbers(axis: &PlotAxis, values: &[f64], width: Option<f64>) -> PanelAxis {
        let values = || values.iter().copied().filter(|v| drawable(*v, axis.log));
        let unit = if axis.log {
            // The middle of the decades decides.
            let (low, high) =
                values().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
            PrefixedUnit::fitting(&axis.unit, (0.5 * (low.ln() + high.ln())).exp())
        } else {
            PrefixedUnit::fitting(&axis.unit, values().map(f64::abs).fold(0.0, f64::max))
        };
        let mut scale = AxisScale::around(values().map(|v| unit.of_si(v)), axis.log);
        if axis.from_zero && !axis.log && scale.high > 0.0 && values().all(|v| v >= 0.0) {
            scale.low = 0.0;
        }
        let drawn = match width {
            Some(width) => DrawnAxis::across(scale, width, &axis.label, &unit.name),
            None => {
                let ticks = scale.ticks(if axis.log { 8 } else { 5 });
                DrawnAxis::new(scale, ticks, &axis.label, &unit.name)
            }
        };
        PanelAxis { drawn, unit }
    }

    fn of_categories(axis: &PlotAxis) -> PanelAxis {
        let scale = AxisScale { low: -0.5, high: axis.categories.len() as f64 - 0.5, log: false };
        let labels = axis.categories.iter().map(|c| shorten(c, 110.0, TICK_SIZE));
        let major = labels.enumerate().map(|(i, label)| (i as f64, label)).collect();
        let ticks = Ticks { major, minor: Vec::new(), exponent: 0 };
        let drawn = DrawnAxis::new(scale, ticks, &axis.label, "");
        PanelAxis { drawn, unit: PrefixedUnit::plain("") }
    }

    /// Returns what the values along the axis mean.
    pub(super) fn sketched(&self, axis: &PlotAxis) -> SketchAxis {
        SketchAxis {
            label: axis.label.clone(),
            unit: self.unit.name.clone(),
            exponent: self.unit.exponent(),
            categories: axis.categories.clone(),
        }
    }

    /// Returns the position of an SI value: 0 at the low end of the axis, 1 at the high end.
    fn fraction(&self, si: f64) -> f64 {
        self.drawn.scale.fraction(self.unit.of_si(si))
    }
}

/// Says whether a value is drawn on an axis at all. The range of categories does not grow with the
/// values, and pixels far beyond the picture are beyond what renders it.
pub(super) fn has_place(axis: &PlotAxis, value: f64) -> bool {
    let count = axis.categories.len() as f64;
    drawable(value, axis.log)
        && (axis.categories.is_empty() || (-0.5..count - 0.5).contains(&value))
}

/// A panel in its place.
pub(super) struct Canvas<'a> {
    /// The frame around the panel, in pixels.
    pub(super) frame: Rect,
    pub(super) panel: &'a PlotPanel,
    pub(super) x: &'a PanelAxis,
    pub(super) y: &'a PanelAxis,
}

impl Canvas<'_> {
    /// Returns the place of a point with values in SI units, in pixels, if it has one.
    pub(super) fn place(&self, (x, y): PlotPoint) -> Option<PlotPoint> {
        let frame = self.frame;
        let drawn = has_place(&self.panel.x, x) && has_place(&self.panel.y, y);
        drawn.then(|| {
            (
                frame.x + self.x.fraction(x) * frame.width,
                frame.bottom() - self.y.fraction(y) * frame.height,
            )
        })
    }

    /// Returns the height of the level of the panel in pixels, if it has one that can be drawn.
    pub(super) fn height_of_level(&self) -> Option<f64> {
        let level = self.panel.level.filter(|level| has_place(&self.panel.y, *level))?;
        Some(self.frame.bottom() - self.y.fraction(level) * self.frame.height)
    }

    /// Returns the height of a value along y in pixels, if the axis has it.
    pub(super) fn place_on_y(&self, y: f64) -> Option<f64> {
        let fraction = has_place(&self.panel.y, y).then(|| self.y.fraction(y))?;
        (0.0..=1.0).contains(&fraction).then(|| self.frame.bottom() - fraction * self.frame.height)
    }
}
