//! The drawing of a Pareto front: stairs between its points and a ring around each.

use std::fmt::Write;

use super::canvas::{Canvas, PlotPoint, Segment};
use crate::axis::INK;
use crate::svg::{Drawing, n};

/// The look of the stairs, as attributes of SVG.
const STAIRS: &str = r##"fill="none" stroke="#1a1a1a" stroke-width="0.9" stroke-dasharray="3 2""##;
/// The radius of a ring, in pixels.
pub(super) const RING: f64 = 6.0;

/// Returns the stairs along a front, the least y that is reached at each x, as segments in pixels.
/// `front` has values in SI units, in order of x.
pub(super) fn stairs(canvas: &Canvas<'_>, front: &[PlotPoint]) -> Vec<Segment> {
    let places: Vec<PlotPoint> = front.iter().filter_map(|&point| canvas.place(point)).collect();
    let steps = places.windows(2).flat_map(|pair| {
        let corner = (pair[1].0, pair[0].1);
        [(pair[0], corner), (corner, pair[1])]
    });
    steps.collect()
}

/// Draws the stairs and a ring around each point of the front.
pub(super) fn draw(drawing: &mut Drawing, stairs: &[Segment], places: &[PlotPoint]) {
    let mut path = String::new();
    for (i, ((x1, y1), (x2, y2))) in stairs.iter().enumerate() {
        let start = if i == 0 { format!("M{} {}", n(*x1), n(*y1)) } else { String::new() };
        // Writing to a string does not fail.
        let _ = write!(path, "{start}L{} {}", n(*x2), n(*y2));
    }
    if !path.is_empty() {
        drawing.push(&format!(r#"<path d="{path}" {STAIRS}/>"#));
    }
    for &(x, y) in places {
        ring(drawing, x, y);
    }
}

/// Draws a ring around a place.
pub(super) fn ring(drawing: &mut Drawing, x: f64, y: f64) {
    drawing.push(&format!(
        r#"<circle cx="{}" cy="{}" r="{RING}" fill="none" stroke="{INK}" stroke-width="1.1"/>"#,
        n(x),
        n(y)
    ));
}

/// Draws a stair with a ring for the legend, with its left end and its middle at `(x, y)`.
pub(super) fn sample(drawing: &mut Drawing, (x, y): PlotPoint, width: f64) {
    drawing.push(&format!(r#"<path d="M{} {}h{}" {STAIRS}/>"#, n(x), n(y), n(width)));
    ring(drawing, x + width / 2.0, y);
}
