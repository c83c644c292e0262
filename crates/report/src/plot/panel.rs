//! What is inside the frame of a panel.

use super::canvas::{Canvas, Place, Segment};
use super::figure::{Series, Style};
use super::legend::LegendEntry;
use super::names::{self, Obstacles};
use super::slope::FIT_OF_BAND;
use super::{band, curve, front, slope};
use crate::axis::LABEL_SIZE;
use crate::palette::Look;
use crate::pareto::pareto_front;
use crate::svg::{Anchor, Drawing};

/// Draws what is inside the frame of a panel; the number of points that have values but no place.
pub(super) fn draw(
    drawing: &mut Drawing,
    canvas: &Canvas<'_>,
    entries: &[LegendEntry<'_>],
) -> usize {
    let Canvas { frame, panel, .. } = *canvas;
    let look = |is_band: bool, label: &str| {
        entries.iter().find(|e| e.is(is_band, label)).map_or(Look::of(0), |e| e.look)
    };
    let curves: Vec<(&Series, Vec<Option<Place>>, Look)> = panel
        .series
        .iter()
        .map(|s| (s, s.points.iter().map(|&p| canvas.place(p)).collect(), look(false, &s.label)))
        .collect();
    // bars at one place stand side by side
    let aside = |i: usize| (i as f64 - (panel.bands.len() as f64 - 1.0) / 2.0) * 9.0;
    let bands: Vec<band::PlacedBand<'_>> = panel
        .bands
        .iter()
        .enumerate()
        .map(|(i, b)| band::PlacedBand::new(canvas, b, look(true, &b.label), aside(i)))
        .collect();

    bands.iter().for_each(|band| band.shade(drawing));
    for band in &bands {
        band.edges(drawing);
        for fit in band.band.fits.iter().flatten() {
            slope::draw(drawing, canvas, fit, band.look.color, FIT_OF_BAND);
        }
    }
    for (series, _, look) in &curves {
        if let Some(fit) = &series.fit {
            slope::draw(drawing, canvas, fit, look.color, "");
        }
    }
    for (series, places, look) in &curves {
        curve::draw(drawing, series, places, *look);
    }
    mark(drawing, canvas, &curves, &bands);

    if bands.iter().all(band::PlacedBand::is_empty)
        && curves.iter().all(|(_, places, _)| places.iter().all(Option::is_none))
    {
        let middle = (frame.x + frame.width / 2.0, frame.y + frame.height / 2.0);
        drawing.text(middle, LABEL_SIZE, Anchor::Middle, "nothing to draw");
    }
    // NaN is how a gap is asked for; anything else that is not drawn is worth saying.
    let asked = |p: &Place| p.0.is_nan() || p.1.is_nan();
    let without_place = |(series, places, _): &(&Series, Vec<Option<Place>>, Look)| {
        series.points.iter().zip(places).filter(|(p, place)| place.is_none() && !asked(p)).count()
    };
    curves.iter().map(without_place).sum::<usize>()
        + bands.iter().map(|band| band.left_out).sum::<usize>()
}

/// Marks the front, if it is asked for, and writes names beside its points, or else beside all.
fn mark(
    drawing: &mut Drawing,
    canvas: &Canvas<'_>,
    curves: &[(&Series, Vec<Option<Place>>, Look)],
    bands: &[band::PlacedBand<'_>],
) {
    let drawn = curves.iter().flat_map(|(series, places, _)| {
        let name = |i: usize| series.names.get(i).map_or("", String::as_str);
        places
            .iter()
            .enumerate()
            .filter_map(move |(i, place)| Some((series.points[i], (*place)?, name(i))))
    });
    let drawn: Vec<(Place, Place, &str)> = drawn.collect();
    let on_front: Vec<(Place, Place, &str)> = if canvas.panel.front {
        let values: Vec<Place> = drawn.iter().map(|(value, ..)| *value).collect();
        pareto_front(&values).into_iter().map(|i| drawn[i]).collect()
    } else {
        Vec::new()
    };
    let stairs =
        front::stairs(canvas, &on_front.iter().map(|(value, ..)| *value).collect::<Vec<_>>());
    front::draw(drawing, &stairs, &on_front.iter().map(|(_, place, _)| *place).collect::<Vec<_>>());

    let named = if canvas.panel.front { &on_front } else { &drawn };
    if named.iter().all(|(.., name)| name.is_empty()) {
        return;
    }
    let mut lines: Vec<Segment> = Vec::new();
    for (series, places, _) in curves {
        if series.style != Style::Markers {
            lines.extend(places.windows(2).filter_map(|pair| Some((pair[0]?, pair[1]?))));
        }
        if let Some([Some(from), Some(to)]) =
            series.fit.as_ref().map(|fit| slope::ends(fit).map(|end| canvas.place(end)))
        {
            lines.push((from, to));
        }
    }
    const MARKER: f64 = 3.5;
    let of_curves = drawn.iter().map(|(_, place, _)| (*place, MARKER));
    let rings = on_front.iter().map(|(_, place, _)| (*place, front::RING));
    let markers = of_curves
        .chain(bands.iter().flat_map(band::PlacedBand::ends).map(|place| (place, MARKER)))
        .chain(rings)
        .collect();
    let clear = if canvas.panel.front { front::RING } else { 4.0 };
    let wanted: Vec<(Place, &str)> = named.iter().map(|(_, place, name)| (*place, *name)).collect();
    names::draw(
        drawing,
        &wanted,
        clear + 1.5,
        &Obstacles { frame: canvas.frame, markers, lines, stairs },
    );
}
