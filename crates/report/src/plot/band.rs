//! Bands between a lower and an upper end, e.g. brackets of a number that is known only so far.

use std::fmt::Write;

use super::canvas::{Canvas, PlotPoint, marker_step};
use super::figure::{BandPoint, PlotBand};
use crate::axis::{INK, LARGEST};
use crate::palette::Look;
use crate::svg::{Drawing, Rect, n};

/// The opacity of the area.
const SHADE: f64 = 0.2;
/// The width in pixels of a bar that stands alone.
const BAR: f64 = 6.0;

/// Says whether an upper end is no number that an axis reaches.
fn is_open(high: f64) -> bool {
    high.is_nan() || high > LARGEST
}

/// Says whether a point is drawn with an arrow upwards.
fn is_open_point(point: &BandPoint) -> bool {
    point.x.is_finite() && point.low.is_finite() && is_open(point.high)
}

/// Lists the points that an axis has to show for a band: its ends, and room above those that are
/// open.
pub(super) fn corners(band: &PlotBand, log_y: bool) -> Vec<PlotPoint> {
    let ends = band.points.iter().flat_map(|&BandPoint { x, low, high }| {
        [(x, low), (x, if is_open(high) { low } else { high })]
    });
    let mut corners: Vec<PlotPoint> =
        ends.filter(|(_, y)| y.abs() <= LARGEST && (!log_y || *y > 1.0 / LARGEST)).collect();
    if let Some(open) = band.points.iter().find(|point| is_open_point(point)) {
        let (low, high) =
            corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, y)| {
                (low.min(*y), high.max(*y))
            });
        let above = match (log_y, high > low) {
            (true, true) => high * (high / low).powf(0.15),
            (true, false) => high * 2.0,
            (false, true) => high + 0.15 * (high - low),
            (false, false) => high + 0.3 * high.abs(),
        };
        corners.push((open.x, above));
    }
    corners
}

/// Says whether any end that is drawn is open.
pub(super) fn any_open(band: &PlotBand) -> bool {
    band.points.iter().any(is_open_point)
}

/// The two ends of a band at one x, in pixels; the upper end is `None` if it is open.
#[derive(Clone, Copy)]
struct BandPlace {
    x: f64,
    low: f64,
    high: Option<f64>,
}

/// A band in its place.
pub(super) struct PlacedBand<'a> {
    pub(super) band: &'a PlotBand,
    pub(super) look: Look,
    /// The runs of neighbouring points that are joined.
    runs: Vec<Vec<BandPlace>>,
    /// The upper edge of the panel's frame, in pixels.
    top: f64,
    /// The number of points that have values but no place.
    pub(super) left_out: usize,
}

impl<'a> PlacedBand<'a> {
    /// Places a band, moved `aside` pixels to the right if it is made of bars.
    pub(super) fn new(
        canvas: &Canvas<'_>,
        band: &'a PlotBand,
        look: Look,
        aside: f64,
    ) -> PlacedBand<'a> {
        let (mut runs, mut left_out) = (vec![Vec::new()], 0);
        for &BandPoint { x, low, high } in &band.points {
            let upper = if is_open(high) {
                Some(None)
            } else {
                canvas.place((x, high)).map(|(_, y)| Some(y))
            };
            match (canvas.place((x, low)), upper) {
                (Some((x, low)), Some(high)) => {
                    let x = x + if band.joined { 0.0 } else { aside };
                    runs.last_mut()
                        .into_iter()
                        .for_each(|run: &mut Vec<_>| run.push(BandPlace { x, low, high }));
                }
                _ => {
                    left_out += usize::from(!(x.is_nan() || low.is_nan()));
                    runs.push(Vec::new());
                }
            }
            if !band.joined {
                runs.push(Vec::new());
            }
        }
        runs.retain(|run| !run.is_empty());
        PlacedBand { band, look, runs, top: canvas.frame.y, left_out }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Iterates over the ends, which no name may cover.
    pub(super) fn ends(&self) -> impl Iterator<Item = PlotPoint> {
        self.runs
            .iter()
            .flatten()
            .flat_map(|place| [(place.x, place.low), (place.x, place.high.unwrap_or(place.low))])
    }

    /// Draws the shade between the ends, below all curves. Between an open end and a closed one
    /// there is nothing to shade.
    pub(super) fn shade(&self, drawing: &mut Drawing) {
        let stretches = self
            .runs
            .iter()
            .flat_map(|run| run.chunk_by(|a, b| a.high.is_some() == b.high.is_some()));
        for stretch in stretches {
            if let [BandPlace { x, low, high }] = stretch[..] {
                if high.is_some() || !self.band.joined {
                    let top = high.unwrap_or(self.top);
                    let bar = Rect {
                        x: x - BAR / 2.0,
                        y: top.min(low),
                        width: BAR,
                        height: (low - top).abs(),
                    };
                    shaded(drawing, bar, self.look);
                }
                continue;
            }
            let lower = stretch.iter().map(|place| (place.x, place.low));
            let upper = stretch.iter().rev().map(|place| (place.x, place.high.unwrap_or(self.top)));
            let outline: Vec<String> =
                lower.chain(upper).map(|(x, y)| format!("{},{}", n(x), n(y))).collect();
            drawing.push(&format!(
                r#"<polygon points="{}" fill="{}" fill-opacity="{SHADE}"/>"#,
                outline.join(" "),
                self.look.color
            ));
        }
    }

    /// Draws both edges, with a marker at each closed end and an arrow at each open one.
    pub(super) fn edges(&self, drawing: &mut Drawing) {
        let width = if self.band.fits.iter().any(Option::is_some) { 0.6 } else { 1.3 };
        let mut path = String::new();
        let mut polyline = |points: &[PlotPoint]| {
            for (i, &(x, y)) in points.iter().enumerate().filter(|_| points.len() > 1) {
                // Writing to a string does not fail.
                let _ = write!(path, "{}{} {}", if i == 0 { "M" } else { "L" }, n(x), n(y));
            }
        };
        for run in &self.runs {
            if let [BandPlace { x, low, high: Some(high) }] = run[..] {
                polyline(&[(x, low), (x, high)]);
            }
            polyline(&run.iter().map(|place| (place.x, place.low)).collect::<Vec<_>>());
            for closed in run.split(|place| place.high.is_none()) {
                let upper = closed.iter().filter_map(|place| Some((place.x, place.high?)));
                polyline(&upper.collect::<Vec<_>>());
            }
        }
        if !path.is_empty() {
            drawing.push(&format!(
                r#"<path d="{path}" fill="none" stroke="{}" stroke-width="{width}" stroke-linejoin="round"/>"#,
                self.look.color
            ));
        }
        let every = marker_step(self.runs.iter().map(Vec::len).sum());
        for &BandPlace { x, low, high } in self.runs.iter().flatten().step_by(every) {
            drawing.push(&self.look.marker(x, low));
            match high {
                Some(high) => drawing.push(&self.look.marker(x, high)),
                None => arrow(drawing, (x, low), self.top + 2.0, self.look.color),
            }
        }
    }
}

fn shaded(drawing: &mut Drawing, rect: Rect, look: Look) {
    drawing.push(&format!(
        r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{}" fill-opacity="{SHADE}"/>"#,
        n(rect.x),
        n(rect.y),
        n(rect.width),
        n(rect.height),
        look.color
    ));
}

/// Draws an arrow upwards from a place to the height `to`.
fn arrow(drawing: &mut Drawing, (x, from): PlotPoint, to: f64, color: &str) {
    let head = (from - to).clamp(0.0, 5.0);
    drawing.push(&format!(
        r#"<path d="M{0} {1}V{2}m-{3} {4}l{3} -{4}l{3} {4}" fill="none" stroke="{color}" stroke-width="1.1"/>"#,
        n(x),
        n(from),
        n(to),
        n(0.7 * head),
        n(head)
    ));
}

/// Draws a piece of a band for the legend, with its left end and its middle at `(x, y)`; a bar if
/// the points of the band are not joined.
pub(super) fn sample(
    drawing: &mut Drawing,
    (x, y): PlotPoint,
    width: f64,
    look: Look,
    joined: bool,
) {
    if joined {
        shaded(drawing, Rect { x, y: y - 5.0, width, height: 10.0 }, look);
        for edge in [y - 5.0, y + 5.0] {
            drawing.line((x, edge), (x + width, edge), look.color, 1.3);
        }
    } else {
        // The bar lies, so that the ends of entries one below the other do not mix.
        let bar = Rect { x: x + 4.0, y: y - BAR / 2.0, width: width - 8.0, height: BAR };
        shaded(drawing, bar, look);
        drawing.line((x + 4.0, y), (x + width - 4.0, y), look.color, 1.3);
        drawing.push(&look.marker(x + 4.0, y));
        drawing.push(&look.marker(x + width - 4.0, y));
    }
}

/// Draws the arrow of an open end for the legend, with its left end and its middle at `(x, y)`.
pub(super) fn sample_of_open(drawing: &mut Drawing, (x, y): PlotPoint, width: f64) {
    arrow(drawing, (x + width / 2.0, y + 6.0), y - 6.0, INK);
}
