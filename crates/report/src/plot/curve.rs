//! A curve: its line and its markers.

use std::collections::HashSet;
use std::fmt::Write;

use super::canvas::{PlotPoint, marker_step};
use super::figure::{Series, Style};
use crate::palette::Look;
use crate::svg::{Drawing, n};

/// Draws a series whose points stand at `places`; a point without a place breaks the line. A point
/// that has no neighbour to be joined with is always marked.
pub(super) fn draw(
    drawing: &mut Drawing,
    series: &Series,
    places: &[Option<PlotPoint>],
    look: Look,
) {
    match series.style {
        Style::Dots => return draw_dots(drawing, places, look),
        Style::Bars => return draw_bars(drawing, places, look),
        Style::LineAndMarkers | Style::Line | Style::Path | Style::Markers | Style::WhiskerBars => {
        }
    }
    let mut markers = Vec::new();
    if series.style == Style::Markers {
        markers.extend(places.iter().flatten().copied());
    } else {
        let every = marker_step(places.len());
        let mut path = String::new();
        let mut start = 0;
        for run in places.split(Option::is_none) {
            for (i, &(x, y)) in run.iter().flatten().enumerate() {
                // Writing to a string does not fail.
                let _ = write!(path, "{}{} {}", if i == 0 { "M" } else { "L" }, n(x), n(y));
                let alone = run.len() == 1;
                let marked = match series.style {
                    Style::LineAndMarkers => (start + i).is_multiple_of(every),
                    Style::Path => i + 1 == run.len(),
                    Style::Line
                    | Style::Markers
                    | Style::Dots
                    | Style::Bars
                    | Style::WhiskerBars => false,
                };
                if alone || marked {
                    markers.push((x, y));
                }
            }
            start += run.len() + 1;
        }
        if !path.is_empty() {
            drawing.push(&format!(
                r#"<path d="{path}" fill="none" stroke="{}" stroke-width="1.5" stroke-linejoin="round"{}/>"#,
                look.color,
                look.dash_attribute()
            ));
        }
    }
    for (x, y) in markers {
        drawing.push(&look.marker(x, y));
    }
}

/// Draws very many points, each pixel once.
fn draw_dots(drawing: &mut Drawing, places: &[Option<PlotPoint>], look: Look) {
    let mut taken = HashSet::new();
    for (x, y) in places.iter().flatten().copied() {
        if taken.insert([x, y].map(|place| place.round() as i64)) {
            drawing.push(&look.dot(x, y));
        }
    }
}

/// Draws bars, whose outline begins and ends at their feet.
fn draw_bars(drawing: &mut Drawing, places: &[Option<PlotPoint>], look: Look) {
    let corners: Vec<String> =
        places.iter().flatten().map(|(x, y)| format!("{} {}", n(*x), n(*y))).collect();
    if corners.is_empty() {
        return;
    }
    let color = look.color;
    drawing.push(&format!(
        r#"<path d="M{}Z" fill="{color}" fill-opacity="{SHADE_OF_BARS}" stroke="{color}" stroke-width="1.3" stroke-linejoin="round"{}/>"#,
        corners.join("L"),
        look.dash_attribute()
    ));
}

/// The opacity of bars.
pub(super) const SHADE_OF_BARS: f64 = 0.25;

/// Draws a bar for the legend, with its left end and its middle at `(x, y)`.
pub(super) fn sample_of_bars(drawing: &mut Drawing, (x, y): PlotPoint, width: f64, look: Look) {
    let corners = [(x, y + 4.0), (x, y - 4.0), (x + width, y - 4.0), (x + width, y + 4.0)];
    draw_bars(drawing, &corners.map(Some), look);
}
