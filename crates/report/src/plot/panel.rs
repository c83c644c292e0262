//! The inside of a panel's frame.

use super::band::PlacedBand;
use super::canvas::{Canvas, PlotPoint, Segment};
use super::figure::{BandPoint, PlotPanel, Series, Style};
use super::legend::LegendEntry;
use super::names::{self, Obstacles};
use super::sketch::FigureSpot;
use super::slope::FIT_OF_BAND;
use super::{bars, curve, front, level, slope};
use crate::axis::LABEL_SIZE;
use crate::palette::Look;
use crate::pareto::{NoisyPoint, pareto_front_within};
use crate::svg::{Anchor, Drawing};

/// A series with the places of its points.
struct PlacedSeries<'a> {
    series: &'a Series,
    /// The place of each point, in pixels; `None` for a point that has none.
    places: Vec<Option<PlotPoint>>,
    look: Look,
}

impl PlacedSeries<'_> {
    /// Counts the points that have values but no place. NaN asks for a gap; anything else that is
    /// not drawn is worth saying.
    fn left_out(&self) -> usize {
        let is_gap = |point: &PlotPoint| point.0.is_nan() || point.1.is_nan();
        let points = self.series.points.iter().zip(&self.places);
        points.filter(|(point, place)| place.is_none() && !is_gap(point)).count()
    }

    /// Iterates over the points that have a place.
    fn drawn_points(&self) -> impl Iterator<Item = DrawnPoint<'_>> {
        self.places.iter().enumerate().filter_map(|(i, place)| {
            let name = self.series.names.get(i).map_or("", String::as_str);
            let noise = self.series.noise.get(i).copied().filter(|noise| noise.is_finite());
            let noise = noise.unwrap_or(0.0);
            Some(DrawnPoint { values: self.series.points[i], noise, place: (*place)?, name })
        })
    }

    /// Lists the pieces of the curve and of its fitted line.
    fn segments(&self, canvas: &Canvas<'_>) -> Vec<Segment> {
        let mut segments = Vec::new();
        let is_joined =
            !matches!(self.series.style, Style::Markers | Style::Dots | Style::WhiskerBars);
        if is_joined {
            let pairs = self.places.windows(2);
            segments.extend(pairs.filter_map(|pair| Some((pair[0]?, pair[1]?))));
        }
        let fit = self.series.fit.as_ref();
        if let Some([Some(from), Some(to)]) =
            fit.map(|fit| slope::ends(fit).map(|end| canvas.place(end)))
        {
            segments.push((from, to));
        }
        segments
    }
}

/// A point of a series that has a place.
#[derive(Clone, Copy)]
struct DrawnPoint<'a> {
    /// The values in SI units.
    values: PlotPoint,
    /// The noise of x on either side, relative to x.
    noise: f64,
    /// The place in pixels.
    place: PlotPoint,
    /// The name beside the point; empty for none.
    name: &'a str,
}

/// Draws the inside of a panel's frame and returns the number of points that have values but no
/// place.
pub(super) fn draw(
    drawing: &mut Drawing,
    canvas: &Canvas<'_>,
    entries: &[LegendEntry<'_>],
) -> usize {
    let Canvas { frame, panel, .. } = *canvas;
    let look = |is_band: bool, label: &str| {
        entries.iter().find(|entry| entry.is(is_band, label)).map_or(Look::new(0), |e| e.look)
    };
    let curves: Vec<PlacedSeries<'_>> = panel
        .series
        .iter()
        .map(|series| PlacedSeries {
            series,
            places: series.points.iter().map(|&point| canvas.place(point)).collect(),
            look: look(false, &series.label),
        })
        .collect();
    // Bars at one place stand side by side.
    let aside = |i: usize| (i as f64 - (panel.bands.len() as f64 - 1.0) / 2.0) * 9.0;
    let bands: Vec<PlacedBand<'_>> = panel
        .bands
        .iter()
        .enumerate()
        .map(|(i, band)| PlacedBand::new(canvas, band, look(true, &band.label), aside(i)))
        .collect();

    for band in &bands {
        drawing.begin(format_args!("data-entry=\"{}\"", index(entries, true, &band.band.label)));
        band.shade(drawing);
        drawing.end();
    }
    for band in &bands {
        drawing.begin(format_args!("data-entry=\"{}\"", index(entries, true, &band.band.label)));
        band.edges(drawing);
        for fit in band.band.fits.iter().flatten() {
            slope::draw(drawing, canvas, fit, band.look.color, FIT_OF_BAND);
        }
        drawing.end();
    }
    let begin = |drawing: &mut Drawing, series: &Series| {
        drawing.begin(format_args!("data-entry=\"{}\"", index(entries, false, &series.label)));
    };
    for curve in &curves {
        if let Some(fit) = &curve.series.fit {
            begin(drawing, curve.series);
            slope::draw(drawing, canvas, fit, curve.look.color, "");
            drawing.end();
        }
    }
    for curve in &curves {
        begin(drawing, curve.series);
        match curve.series.style {
            Style::WhiskerBars => bars::draw(drawing, canvas, curve.series, curve.look),
            _ => curve::draw(drawing, curve.series, &curve.places, curve.look),
        }
        drawing.end();
    }
    level::draw(drawing, canvas, curves.iter().map(|curve| &curve.places[..]));
    draw_marks(drawing, canvas, &curves, &bands);

    if bands.iter().all(PlacedBand::is_empty)
        && curves.iter().all(|curve| curve.places.iter().all(Option::is_none))
    {
        let middle = (frame.x + frame.width / 2.0, frame.y + frame.height / 2.0);
        drawing.text(middle, LABEL_SIZE, Anchor::Middle, "nothing to draw");
    }
    curves.iter().map(PlacedSeries::left_out).sum::<usize>()
        + bands.iter().map(|band| band.left_out).sum::<usize>()
}

/// Returns the index of the entry of a band, or else of a series, with a label.
fn index(entries: &[LegendEntry<'_>], is_band: bool, label: &str) -> usize {
    entries.iter().position(|entry| entry.is(is_band, label)).unwrap_or(0)
}

/// Lists the points of a panel in their places; the ends of a band are points each.
pub(super) fn spots(
    canvas: &Canvas<'_>,
    panel: usize,
    entries: &[LegendEntry<'_>],
) -> Vec<FigureSpot> {
    let PlotPanel { series, bands, .. } = canvas.panel;
    let mut spots = Vec::new();
    let mut add = |entry: usize, row: Option<&Option<usize>>, values: PlotPoint| {
        let row = row.copied().flatten();
        spots.extend(canvas.place(values).map(|place| FigureSpot {
            panel,
            entry,
            place,
            values,
            row,
        }));
    };
    for curve in series {
        let entry = index(entries, false, &curve.label);
        for (i, point) in curve.points.iter().enumerate() {
            add(entry, curve.rows.get(i), *point);
        }
    }
    for band in bands {
        let entry = index(entries, true, &band.label);
        for (i, &BandPoint { x, low, high }) in band.points.iter().enumerate() {
            add(entry, band.rows.get(i), (x, low));
            add(entry, band.rows.get(i), (x, high));
        }
    }
    spots
}

/// Marks the front, if the panel has one, and writes names beside its points, or else beside all
/// points.
fn draw_marks(
    drawing: &mut Drawing,
    canvas: &Canvas<'_>,
    curves: &[PlacedSeries<'_>],
    bands: &[PlacedBand<'_>],
) {
    let drawn: Vec<DrawnPoint<'_>> = curves.iter().flat_map(PlacedSeries::drawn_points).collect();
    let on_front: Vec<DrawnPoint<'_>> = if canvas.panel.front {
        let noisy = |point: &DrawnPoint<'_>| {
            let (x, y) = point.values;
            NoisyPoint { x, noise: point.noise, y }
        };
        let points: Vec<NoisyPoint> = drawn.iter().map(noisy).collect();
        pareto_front_within(&points).into_iter().map(|i| drawn[i]).collect()
    } else {
        Vec::new()
    };
    let values: Vec<PlotPoint> = on_front.iter().map(|point| point.values).collect();
    let places: Vec<PlotPoint> = on_front.iter().map(|point| point.place).collect();
    let stairs = front::stairs(canvas, &values);
    front::draw(drawing, &stairs, &places);

    let named = if canvas.panel.front { &on_front } else { &drawn };
    if named.iter().all(|point| point.name.is_empty()) {
        return;
    }
    const MARKER: f64 = 3.5;
    let of_curves = drawn.iter().map(|point| (point.place, MARKER));
    let of_bands = bands.iter().flat_map(PlacedBand::ends).map(|place| (place, MARKER));
    let rings = places.iter().map(|place| (*place, front::RING));
    let obstacles = Obstacles {
        frame: canvas.frame,
        markers: of_curves.chain(of_bands).chain(rings).collect(),
        lines: curves.iter().flat_map(|curve| curve.segments(canvas)).collect(),
        stairs,
    };
    let clear = if canvas.panel.front { front::RING } else { 4.0 };
    let wanted: Vec<(PlotPoint, &str)> =
        named.iter().map(|point| (point.place, point.name)).collect();
    names::draw(drawing, &wanted, clear + 1.5, &obstacles);
}
