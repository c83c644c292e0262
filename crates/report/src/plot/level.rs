//! A level: a dashed line at one value of the vertical axis, and a ring wherever a curve crosses
//! it.

use super::canvas::{Canvas, PlotPoint};
use super::front::ring;
use crate::svg::{Drawing, n};

/// The look of the line, as attributes of SVG.
const LINE: &str = r##"fill="none" stroke="#1a1a1a" stroke-width="0.9" stroke-dasharray="5 3""##;

/// Returns the places at which curves cross the height of a level, in pixels. Each curve is a list
/// of places; one that is missing breaks it.
pub(super) fn crossings<'c>(
    level: f64,
    curves: impl IntoIterator<Item = &'c [Option<PlotPoint>]>,
) -> Vec<PlotPoint> {
    let mut found = Vec::new();
    for places in curves {
        found.extend(places.iter().flatten().filter(|place| place.1 == level));
        let pairs = places.windows(2).filter_map(|pair| Some((pair[0]?, pair[1]?)));
        found.extend(
            pairs
                .filter(|(a, b)| (a.1 - level) * (b.1 - level) < 0.0)
                .map(|(a, b)| (a.0 + (b.0 - a.0) * (level - a.1) / (b.1 - a.1), level)),
        );
    }
    found
}

/// Draws the level of a panel and a ring around each crossing of its curves.
pub(super) fn draw<'c>(
    drawing: &mut Drawing,
    canvas: &Canvas<'_>,
    curves: impl IntoIterator<Item = &'c [Option<PlotPoint>]>,
) {
    let Some(height) = canvas.height_of_level() else { return };
    let (left, width) = (canvas.frame.x, canvas.frame.width);
    drawing.push(&format!(r#"<path d="M{} {}h{}" {LINE}/>"#, n(left), n(height), n(width)));
    for (x, y) in crossings(height, curves) {
        ring(drawing, x, y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_cross_between_points_on_both_sides_and_at_points_on_it() {
        let curve = [(0.0, 0.0), (1.0, 4.0), (2.0, 1.0), (3.0, 1.0)].map(Some);
        assert_eq!(crossings(2.0, [&curve[..]]), [(0.5, 2.0), (1.0 + 2.0 / 3.0, 2.0)]);
        assert_eq!(crossings(4.0, [&curve[..]]), [(1.0, 4.0)]);
        assert!(crossings(5.0, [&curve[..]]).is_empty());
        let broken = [Some((0.0, 0.0)), None, Some((1.0, 4.0))];
        assert!(crossings(2.0, [&broken[..]]).is_empty(), "a gap crosses nothing");
    }
}
