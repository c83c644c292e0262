//! Colours, markers and dashes that tell series apart, also for a colour-blind reader and in black
//! and white.

use crate::svg::n;

/// The colours of Okabe & Ito, <https://jfly.uni-koeln.de/color/>, without the yellow that fades on
/// white; the dark ones come first.
pub(crate) const COLORS: [&str; 7] =
    ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];
/// The dashes of lines, as SVG writes them; the first line is solid.
const DASHES: [&str; 4] = ["", "6 3", "2 2", "7 2 2 2"];
/// The number of shapes of markers.
const MARKERS: usize = 8;

/// The look of a series. Colours and markers repeat with different periods, so that 7·8 = 56 series
/// differ in one of them; every seven series the dash changes as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    pub(crate) color: &'static str,
    pub(crate) dash: &'static str,
    marker: usize,
}

impl Look {
    /// Returns the look of the series with an index.
    pub(crate) fn new(series: usize) -> Look {
        Look {
            color: COLORS[series % COLORS.len()],
            dash: DASHES[series / COLORS.len() % DASHES.len()],
            marker: series % MARKERS,
        }
    }

    /// Returns the SVG attribute for the line of the series.
    pub(crate) fn dash_attribute(&self) -> String {
        if self.dash.is_empty() {
            String::new()
        } else {
            format!(" stroke-dasharray=\"{}\"", self.dash)
        }
    }

    /// Returns a small dot at a point in pixels, through which others can be seen.
    pub(crate) fn dot(&self, x: f64, y: f64) -> String {
        format!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"1.4\" fill=\"{}\" fill-opacity=\"0.6\"/>",
            n(x),
            n(y),
            self.color
        )
    }

    /// Returns the marker at a point in pixels, about seven pixels across.
    pub(crate) fn marker(&self, x: f64, y: f64) -> String {
        // Shapes that would otherwise look alike when small are white inside an outline.
        let filled = format!("fill=\"{0}\" stroke=\"{0}\" stroke-width=\"1\"", self.color);
        let hollow = format!("fill=\"#ffffff\" stroke=\"{}\" stroke-width=\"1.3\"", self.color);
        let polygon = |corners: &[(f64, f64)], paint: &str| {
            let points: Vec<String> =
                corners.iter().map(|(dx, dy)| format!("{},{}", n(x + dx), n(y + dy))).collect();
            format!("<polygon points=\"{}\" {paint}/>", points.join(" "))
        };
        let circle =
            |paint: &str| format!("<circle cx=\"{}\" cy=\"{}\" r=\"3\" {paint}/>", n(x), n(y));
        match self.marker {
            0 => circle(&filled),
            1 => polygon(&[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)], &filled),
            2 => polygon(&[(0.0, -3.6), (3.5, 2.6), (-3.5, 2.6)], &filled),
            3 => polygon(&[(0.0, -4.0), (4.0, 0.0), (0.0, 4.0), (-4.0, 0.0)], &hollow),
            4 => polygon(&[(0.0, 3.6), (3.5, -2.6), (-3.5, -2.6)], &hollow),
            5 => circle(&hollow),
            6 => format!(
                "<path d=\"M{} {}l6 6m0 -6l-6 6\" stroke=\"{}\" stroke-width=\"1.6\" fill=\"none\"/>",
                n(x - 3.0),
                n(y - 3.0),
                self.color
            ),
            _ => polygon(&[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)], &hollow),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fifty_six_series_look_different() {
        let looks: Vec<Look> = (0..56).map(Look::new).collect();
        for (i, look) in looks.iter().enumerate() {
            assert!(
                !looks[..i]
                    .iter()
                    .any(|other| (other.color, other.marker) == (look.color, look.marker)),
                "{i}"
            );
        }
    }
}
