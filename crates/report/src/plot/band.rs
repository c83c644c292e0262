//! Bands between a lower and an upper end, e.g. brackets of a number that is known only so far.

use std::fmt::Write;

use super::canvas::{Canvas, MARKED};
use super::figure::PlotBand;
use crate::axis::{INK, LARGEST};
use crate::palette::Look;
use crate::svg::{Drawing, Rect, n};

const SHADE: f64 = 0.2;
/// Of a bar that stands alone.
const BAR: f64 = 6.0;

/// Whether an upper end is no number that an axis reaches.
fn is_open(high: f64) -> bool {
    high.is_nan() || high > LARGEST
}

/// What an axis has to show of a band: its ends, and room above for those that are open.
pub(super) fn corners(band: &PlotBand, log_y: bool) -> Vec<(f64, f64)> {
    let closed = band
        .points
        .iter()
        .flat_map(|&(x, low, high)| [(x, low), (x, if is_open(high) { low } else { high })]);
    let mut corners: Vec<(f64, f64)> =
        closed.filter(|(_, y)| y.abs() <= LARGEST && (!log_y || *y > 1.0 / LARGEST)).collect();
    if let Some(open) =
        band.points.iter().find(|p| p.0.is_finite() && p.1.is_finite() && is_open(p.2))
    {
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
        corners.push((open.0, above));
    }
    corners
}

/// Whether any end that is drawn is open.
pub(super) fn any_open(band: &PlotBand) -> bool {
    band.points.iter().any(|&(x, low, high)| x.is_finite() && low.is_finite() && is_open(high))
}

/// A band in its place.
pub(super) struct PlacedBand<'a> {
    pub(super) band: &'a PlotBand,
    pub(super) look: Look,
    /// Neighbours that are joined: x, lower end and, unless it is open, upper end of each.
    runs: Vec<Vec<(f64, f64, Option<f64>)>>,
    top: f64,
    /// Points that have values but no place.
    pub(super) left_out: usize,
}

impl<'a> PlacedBand<'a> {
    /// The band, `aside` pixels to the right of its place if it is made of bars.
    pub(super) fn new(
        canvas: &Canvas<'_>,
        band: &'a PlotBand,
        look: Look,
        aside: f64,
    ) -> PlacedBand<'a> {
        let (mut runs, mut left_out) = (vec![Vec::new()], 0);
        for &(x, low, high) in &band.points {
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
                        .for_each(|run: &mut Vec<_>| run.push((x, low, high)));
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

    /// The ends, which no name may cover.
    pub(super) fn ends(&self) -> impl Iterator<Item = (f64, f64)> {
        self.runs.iter().flatten().flat_map(|&(x, low, high)| [(x, low), (x, high.unwrap_or(low))])
    }

    /// The shade between the ends, below all curves; between an end that is open and one that is
    /// not there is nothing to shade.
    pub(super) fn shade(&self, drawing: &mut Drawing) {
        for part in
            self.runs.iter().flat_map(|run| run.chunk_by(|a, b| a.2.is_some() == b.2.is_some()))
        {
            if let [(x, low, high)] = part[..] {
                if high.is_some() || !self.band.joined {
                    let top = high.unwrap_or(self.top);
                    shaded(
                        drawing,
                        Rect {
                            x: x - BAR / 2.0,
                            y: top.min(low),
                            width: BAR,
                            height: (low - top).abs(),
                        },
                        self.look,
                    );
                }
                continue;
            }
            let lower = part.iter().map(|&(x, low, _)| (x, low));
            let upper = part.iter().rev().map(|&(x, _, high)| (x, high.unwrap_or(self.top)));
            let outline: Vec<String> =
                lower.chain(upper).map(|(x, y)| format!("{},{}", n(x), n(y))).collect();
            drawing.push(&format!(
                r#"<polygon points="{}" fill="{}" fill-opacity="{SHADE}"/>"#,
                outline.join(" "),
                self.look.color
            ));
        }
    }

    /// Both edges, with a marker at each end and an arrow where there is none.
    pub(super) fn edges(&self, drawing: &mut Drawing) {
        let width = if self.band.fits.iter().any(Option::is_some) { 0.6 } else { 1.3 };
        let mut path = String::new();
        let mut polyline = |points: &[(f64, f64)]| {
            for (i, &(x, y)) in points.iter().enumerate().filter(|_| points.len() > 1) {
                // Writing to a string does not fail.
                let _ = write!(path, "{}{} {}", if i == 0 { "M" } else { "L" }, n(x), n(y));
            }
        };
        for run in &self.runs {
            if let [(x, low, Some(high))] = run[..] {
                polyline(&[(x, low), (x, high)]);
            }
            polyline(&run.iter().map(|&(x, low, _)| (x, low)).collect::<Vec<_>>());
            for closed in run.split(|(.., high)| high.is_none()) {
                polyline(
                    &closed.iter().filter_map(|&(x, _, high)| Some((x, high?))).collect::<Vec<_>>(),
                );
            }
        }
        if !path.is_empty() {
            drawing.push(&format!(
                r#"<path d="{path}" fill="none" stroke="{}" stroke-width="{width}" stroke-linejoin="round"/>"#,
                self.look.color
            ));
        }
        let count: usize = self.runs.iter().map(Vec::len).sum();
        let every = if count <= MARKED { 1 } else { count.div_ceil(15) };
        for (i, &(x, low, high)) in self.runs.iter().flatten().enumerate() {
            if i.is_multiple_of(every) {
                drawing.push(&self.look.marker(x, low));
                match high {
                    Some(high) => drawing.push(&self.look.marker(x, high)),
                    None => arrow(drawing, x, low, self.top + 2.0, self.look.color),
                }
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

/// An arrow upwards from `from` to `to`.
fn arrow(drawing: &mut Drawing, x: f64, from: f64, to: f64, color: &str) {
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

/// A piece of a band for the legend, `x` at the left and `y` in the middle; a bar if its points are
/// not joined.
pub(super) fn sample(drawing: &mut Drawing, x: f64, y: f64, width: f64, look: Look, joined: bool) {
    if joined {
        shaded(drawing, Rect { x, y: y - 5.0, width, height: 10.0 }, look);
        for edge in [y - 5.0, y + 5.0] {
            drawing.line((x, edge), (x + width, edge), look.color, 1.3);
        }
    } else {
        // lying, so that the ends of entries one below the other do not mix
        shaded(
            drawing,
            Rect { x: x + 4.0, y: y - BAR / 2.0, width: width - 8.0, height: BAR },
            look,
        );
        drawing.line((x + 4.0, y), (x + width - 4.0, y), look.color, 1.3);
        drawing.push(&look.marker(x + 4.0, y));
        drawing.push(&look.marker(x + width - 4.0, y));
    }
}

/// The arrow of an open end for the legend.
pub(super) fn sample_of_open(drawing: &mut Drawing, x: f64, y: f64, width: f64) {
    arrow(drawing, x + width / 2.0, y + 6.0, y - 6.0, INK);
}
