//! A curve: its line and its markers.

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
                    Style::Line | Style::Markers | Style::Bars => false,
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
