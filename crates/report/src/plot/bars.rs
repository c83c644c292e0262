//! Bars from zero with whiskers, e.g. shares with their intervals.

use super::canvas::{Canvas, PlotPoint, has_place};
use super::curve::SHADE_OF_BARS;
use super::figure::{PlotPanel, Series, Style};
use crate::axis::INK;
use crate::palette::Look;
use crate::svg::{Drawing, Rect, n};

/// Half the width of the end of a whisker, in pixels.
const CAP: f64 = 3.0;

/// Lists the points that the axes have to show for a series of bars besides the tops.
pub(super) fn corners(series: &Series, panel: &PlotPanel) -> Vec<PlotPoint> {
    if series.style != Style::WhiskerBars {
        return Vec::new();
    }
    let has_numbers = panel.x.categories.is_empty();
    let half = if has_numbers { series.bar_width / 2.0 } else { 0.0 };
    let feet = series.points.iter().flat_map(|(x, _)| [(x - half, 0.0), (x + half, 0.0)]);
    let ends = series.points.iter().zip(&series.whiskers);
    feet.chain(ends.flat_map(|((x, _), whisker)| whisker.map(|end| (*x, end)))).collect()
}

/// Draws the bars of a series, and their whiskers in front.
pub(super) fn draw(drawing: &mut Drawing, canvas: &Canvas<'_>, series: &Series, look: Look) {
    let foot = canvas.place_on_y(0.0).unwrap_or(canvas.frame.bottom());
    let half = series.bar_width / 2.0;
    for &(x, top) in &series.points {
        let [left, right] = [x - half, x + half].map(|x| canvas.place((x, top)));
        let (Some((left, top)), Some((right, _))) = (left, right) else { continue };
        let bar =
            Rect { x: left, y: top.min(foot), width: right - left, height: (foot - top).abs() };
        drawing.push(&format!(
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{4}" fill-opacity="{SHADE_OF_BARS}" stroke="{4}" stroke-width="0.8"/>"#,
            n(bar.x),
            n(bar.y),
            n(bar.width),
            n(bar.height),
            look.color
        ));
    }
    let mut path = String::new();
    for (&(x, _), &[low, high]) in series.points.iter().zip(&series.whiskers) {
        if !has_place(&canvas.panel.y, low) || !has_place(&canvas.panel.y, high) {
            continue;
        }
        let [low, high] = [low, high].map(|y| canvas.place((x, y)));
        let (Some((x, low)), Some((_, high))) = (low, high) else { continue };
        let (left, width) = (n(x - CAP), n(2.0 * CAP));
        path +=
            &format!("M{left} {0}h{width}M{left} {1}h{width}M{2} {0}V{1}", n(low), n(high), n(x));
    }
    if !path.is_empty() {
        drawing
            .push(&format!(r#"<path d="{path}" fill="none" stroke="{INK}" stroke-width="1.1"/>"#));
    }
}
