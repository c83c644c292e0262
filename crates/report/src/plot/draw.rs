//! Drawing a figure.

use std::fmt::Write;

use super::legend::{Entry, Legend, Sample};
use super::names::{self, Taken};
use super::{Axis, Band, Figure, Panel, Series, Style, band, front, pareto_front, slope};
use crate::axis::{self, Drawn, INK, LABEL_SIZE, TICK_SIZE, TITLE_SIZE};
use crate::fit::Fit;
use crate::palette::Look;
use crate::scale::{Scale, Ticks, drawable};
use crate::si::Unit;
use crate::svg::{Anchor, Drawing, Rect, n, shorten, text_width, wrap};

const MARGIN: f64 = 10.0;
/// Between panels that share the vertical axis.
const NARROW: f64 = 14.0;
const PANELS_PER_ROW: usize = 4;
/// With more points than this, not every one is marked.
pub(super) const MARKED: usize = 40;
/// A line fitted to the ends of a band, beside its edge.
const FIT_OF_BAND: &str = r#" stroke-dasharray="5 3""#;
/// Between the slopes above a panel.
const KEY_LINE: f64 = 14.0;
/// Between the lines of a panel's title.
const TITLE_LINE: f64 = LABEL_SIZE + 3.0;

/// An axis with its values in the unit that is written.
struct Prepared {
    drawn: Drawn,
    unit: Unit,
}

impl Prepared {
    /// An axis for values in SI units; `width` in pixels if it is horizontal.
    fn new(axis: &Axis, values: &[f64], width: Option<f64>) -> Prepared {
        let values = || values.iter().copied().filter(|v| drawable(*v, axis.log));
        let unit = if !axis.categories.is_empty() {
            Unit::plain("")
        } else if axis.log {
            // The middle of the decades decides.
            let (low, high) =
                values().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
            Unit::fitting(&axis.unit, (0.5 * (low.ln() + high.ln())).exp())
        } else {
            Unit::fitting(&axis.unit, values().map(f64::abs).fold(0.0, f64::max))
        };
        let drawn = if axis.categories.is_empty() {
            let scale = Scale::around(values().map(|v| unit.of_si(v)), axis.log);
            match width {
                Some(width) => Drawn::across(scale, width, &axis.label, &unit.name),
                None => Drawn::new(
                    scale,
                    scale.ticks(if axis.log { 8 } else { 5 }),
                    &axis.label,
                    &unit.name,
                ),
            }
        } else {
            let scale = Scale { low: -0.5, high: axis.categories.len() as f64 - 0.5, log: false };
            let labels = axis.categories.iter().map(|c| shorten(c, 110.0, TICK_SIZE));
            let major = labels.enumerate().map(|(i, label)| (i as f64, label)).collect();
            Drawn::new(scale, Ticks { major, minor: Vec::new(), exponent: 0 }, &axis.label, "")
        };
        Prepared { drawn, unit }
    }

    fn at(&self, si: f64) -> f64 {
        self.drawn.scale.at(self.unit.of_si(si))
    }
}

/// A place in the picture, or values along x and y.
pub(super) type Point = (f64, f64);
/// A piece of a line.
pub(super) type Segment = (Point, Point);

/// Whether a value is drawn on an axis at all. The range of categories does not grow with the
/// values, and pixels far beyond the picture are beyond what renders it.
fn has_place(axis: &Axis, value: f64) -> bool {
    let count = axis.categories.len() as f64;
    drawable(value, axis.log)
        && (axis.categories.is_empty() || (-0.5..count - 0.5).contains(&value))
}

/// A panel in its place.
pub(super) struct Canvas<'a> {
    pub(super) frame: Rect,
    panel: &'a Panel,
    x: &'a Prepared,
    y: &'a Prepared,
}

impl Canvas<'_> {
    /// The place of a point with values in SI units, if it has one.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let frame = self.frame;
        let drawn = has_place(&self.panel.x, x) && has_place(&self.panel.y, y);
        drawn.then(|| {
            (frame.x + self.x.at(x) * frame.width, frame.bottom() - self.y.at(y) * frame.height)
        })
    }
}

impl Figure {
    /// The figure as SVG, in pixels of 1/96 inch; always a readable picture, whatever the points
    /// are.
    pub fn svg(&self) -> String {
        let columns = self.panels.len().clamp(1, PANELS_PER_ROW);
        let (width, height) = match columns {
            1 => (330.0, 240.0),
            2 => (250.0, 225.0),
            3 => (205.0, 205.0),
            _ => (175.0, 190.0),
        };
        let shared_x = self.panels.windows(2).all(|p| p[0].x == p[1].x);
        let shared_y = self.panels.windows(2).all(|p| p[0].y == p[1].y);
        let all_x = coordinates(&self.panels, |p| p.0);
        let all_y = coordinates(&self.panels, |p| p.1);
        let axes: Vec<(Prepared, Prepared)> = self
            .panels
            .iter()
            .map(|panel| {
                let own = std::slice::from_ref(panel);
                let x = if shared_x { all_x.clone() } else { coordinates(own, |p| p.0) };
                let y = if shared_y { all_y.clone() } else { coordinates(own, |p| p.1) };
                (Prepared::new(&panel.x, &x, Some(width)), Prepared::new(&panel.y, &y, None))
            })
            .collect();

        let mut entries = self.entries();
        let mut keys: Vec<Vec<Key>> = vec![Vec::new(); self.panels.len()];
        for ((panel, (x, y)), key) in self.panels.iter().zip(&axes).zip(&mut keys) {
            for (is_band, label, end, fit) in fits(panel) {
                let slope = format!("{end}{}", slope::text(fit, &x.unit, &y.unit));
                let Some(entry) = entries.iter_mut().find(|e| e.is(is_band, label)) else {
                    continue;
                };
                // of several panels each has its own slopes
                if self.panels.len() == 1 {
                    entry.slopes.push(slope)
                } else {
                    key.push(Key { look: entry.look, of_band: is_band, text: slope })
                }
            }
        }
        let fitted = self.panels.iter().any(|panel| fits(panel).next().is_some());

        let beside = axes.iter().map(|(_, y)| y.drawn.room_beside(height)).fold(0.0, f64::max);
        let below = axes.iter().map(|(x, _)| x.drawn.room_below(width)).fold(0.0, f64::max);
        let headings: Vec<Vec<String>> =
            self.panels.iter().map(|panel| heading(&panel.title, width)).collect();
        let room_above = headings
            .iter()
            .zip(&keys)
            .map(|(title, key)| title.len() as f64 * TITLE_LINE + key.len() as f64 * KEY_LINE);
        let above = 6.0 + room_above.fold(0.0, f64::max);
        let pitch = width + if shared_y { NARROW } else { NARROW + beside };
        let left = MARGIN + beside;
        let right = left + pitch * (columns as f64 - 1.0) + width;

        let legend = Legend::new(
            &self.legend,
            &entries,
            self.panels.len().div_ceil(columns) as f64 * height,
        );
        let total = right + if legend.is_empty() { 0.0 } else { 16.0 + legend.width() } + MARGIN;
        let title = wrap(&self.title, total - left - MARGIN, TITLE_SIZE, 3);
        let top = MARGIN + title.len() as f64 * (TITLE_SIZE + 4.0);

        let mut drawing = Drawing::default();
        for (i, line) in title.iter().enumerate() {
            let baseline = MARGIN + TITLE_SIZE + i as f64 * (TITLE_SIZE + 4.0) - 2.0;
            drawing.text((left, baseline), TITLE_SIZE, Anchor::Start, line);
        }
        let mut left_out = 0;
        for (i, (panel, (x, y))) in self.panels.iter().zip(&axes).enumerate() {
            let (row, column) = (i / columns, i % columns);
            let frame = Rect {
                x: left + column as f64 * pitch,
                y: top + above + row as f64 * (above + height + below),
                width,
                height,
            };
            for (line, key) in keys[i].iter().rev().enumerate() {
                key.draw(&mut drawing, (frame.x, frame.y - 6.0 - line as f64 * KEY_LINE), width);
            }
            for (line, text) in headings[i].iter().rev().enumerate() {
                let at = (
                    frame.x + width / 2.0,
                    frame.y - 6.0 - keys[i].len() as f64 * KEY_LINE - line as f64 * TITLE_LINE,
                );
                drawing.text(at, LABEL_SIZE, Anchor::Middle, text);
            }
            axis::grid(&mut drawing, frame, &x.drawn, &y.drawn);
            axis::below(&mut drawing, frame, &x.drawn, true);
            axis::left(&mut drawing, frame, &y.drawn, true, column == 0 || !shared_y);
            drawing.rect(frame, "none", INK, 0.9);
            left_out += inside(&mut drawing, &Canvas { frame, panel, x, y }, &entries);
        }
        legend.draw(&mut drawing, right + 16.0, top + above);

        let rows = self.panels.len().div_ceil(columns).max(1) as f64;
        let mut bottom = top + rows * (above + height + below);
        let points = if left_out == 1 { "point is" } else { "points are" };
        let not_drawn = format!(
            "{left_out} {points} not drawn: not positive on a logarithmic axis, of no category, or not finite"
        );
        let slopes = "Slopes are of least squares through the points that the fitted line spans, ± their standard error.".to_owned();
        for (note, _) in
            [(not_drawn, left_out > 0), (slopes, fitted)].iter().filter(|(_, said)| *said)
        {
            bottom += 4.0;
            for line in wrap(note, total - 2.0 * MARGIN, 10.0, 2) {
                bottom += TICK_SIZE + 2.0;
                drawing.text((MARGIN, bottom), 10.0, Anchor::Start, &line);
            }
        }
        bottom = bottom.max(top + above + legend.height());
        drawing.finish(total, bottom + MARGIN, &self.title)
    }

    /// The legend's entries: every label once, in order of appearance; curves, then bands, then
    /// what marks mean.
    fn entries(&self) -> Vec<Entry<'_>> {
        let mut entries: Vec<Entry<'_>> = Vec::new();
        for series in self.panels.iter().flat_map(|p| &p.series) {
            if !entries.iter().any(|e| e.is(false, &series.label)) {
                entries.push(Entry::of_series(&entries, series));
            }
        }
        for band in self.panels.iter().flat_map(|p| &p.bands) {
            if !entries.iter().any(|e| e.is(true, &band.label)) {
                entries.push(Entry::of_band(&entries, band));
            }
        }
        if self.panels.iter().any(|p| p.front) {
            entries.push(Entry::of_mark(Sample::Front, "cheapest for its accuracy"));
        }
        if self.panels.iter().flat_map(|p| &p.bands).any(band::any_open) {
            entries.push(Entry::of_mark(Sample::Open, "no upper end known"));
        }
        entries
    }
}

/// The fitted lines of a panel: whether they are a band's, its or their series' label, which of its
/// ends, and the line.
fn fits(panel: &Panel) -> impl Iterator<Item = (bool, &str, &'static str, &Fit)> {
    let curves =
        panel.series.iter().filter_map(|s| Some((false, s.label.as_str(), "", s.fit.as_ref()?)));
    let ends = |band| -> [(&Band, &'static str, usize); 2] {
        [(band, "upper end: ", 1), (band, "lower end: ", 0)]
    };
    let bands = panel
        .bands
        .iter()
        .flat_map(ends)
        .filter_map(|(b, end, i)| Some((true, b.label.as_str(), end, b.fits[i].as_ref()?)));
    curves.chain(bands)
}

/// A fitted line and its slope, above one of several panels.
#[derive(Clone)]
struct Key {
    look: Look,
    of_band: bool,
    text: String,
}

impl Key {
    fn draw(&self, drawing: &mut Drawing, (x, baseline): (f64, f64), width: f64) {
        const LINE: f64 = 17.0;
        const TEXT: f64 = 22.0;
        let middle = baseline - 0.36 * TICK_SIZE;
        let dash = if self.of_band { FIT_OF_BAND } else { "" };
        let color = self.look.color;
        drawing.push(&format!(
            r#"<path d="M{} {}h{LINE}" fill="none" stroke="{color}" stroke-width="1"{dash}/>"#,
            n(x),
            n(middle)
        ));
        drawing.push(&self.look.marker(x + LINE / 2.0, middle));
        drawing.text(
            (x + TEXT, baseline),
            TICK_SIZE,
            Anchor::Start,
            &shorten(&self.text, width - TEXT, TICK_SIZE),
        );
    }
}

/// The title of a panel in lines; one that is too long is broken before its value, if it has one,
/// and not within.
fn heading(title: &str, width: f64) -> Vec<String> {
    match title.rsplit_once(" = ") {
        Some((name, value)) if text_width(title, LABEL_SIZE) > width => {
            [name, &format!("= {value}")].map(|line| shorten(line, width, LABEL_SIZE)).to_vec()
        }
        _ => wrap(title, width, LABEL_SIZE, 2),
    }
}

fn coordinates(panels: &[Panel], of: fn(&(f64, f64)) -> f64) -> Vec<f64> {
    let drawn_in = |panel: &Panel| {
        let curves = panel
            .series
            .iter()
            .flat_map(|s| s.points.iter().copied().chain(s.fit.iter().flat_map(slope::ends)));
        let fitted = |b: &Band| b.fits.iter().flatten().flat_map(slope::ends).collect::<Vec<_>>();
        let bands = panel
            .bands
            .iter()
            .flat_map(|b| band::corners(b, panel.y.log).into_iter().chain(fitted(b)));
        // Only points that are drawn count: a point that is a gap must not widen the axis.
        let drawn = |p: &(f64, f64)| has_place(&panel.x, p.0) && has_place(&panel.y, p.1);
        curves.chain(bands).filter(drawn).map(|point| of(&point)).collect::<Vec<f64>>()
    };
    panels.iter().flat_map(drawn_in).collect()
}

/// Draws what is inside the frame of a panel; the number of points that have values but no place.
fn inside(drawing: &mut Drawing, canvas: &Canvas<'_>, entries: &[Entry<'_>]) -> usize {
    let Canvas { frame, panel, .. } = *canvas;
    let look = |is_band: bool, label: &str| {
        entries.iter().find(|e| e.is(is_band, label)).map_or(Look::of(0), |e| e.look)
    };
    let curves: Vec<(&Series, Vec<Option<Point>>, Look)> = panel
        .series
        .iter()
        .map(|s| (s, s.points.iter().map(|&p| canvas.place(p)).collect(), look(false, &s.label)))
        .collect();
    // bars at one place stand side by side
    let aside = |i: usize| (i as f64 - (panel.bands.len() as f64 - 1.0) / 2.0) * 9.0;
    let bands: Vec<band::Placed<'_>> = panel
        .bands
        .iter()
        .enumerate()
        .map(|(i, b)| band::Placed::new(canvas, b, look(true, &b.label), aside(i)))
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
        curve(drawing, series, places, *look);
    }
    mark(drawing, canvas, &curves, &bands);

    if bands.iter().all(band::Placed::is_empty)
        && curves.iter().all(|(_, places, _)| places.iter().all(Option::is_none))
    {
        let middle = (frame.x + frame.width / 2.0, frame.y + frame.height / 2.0);
        drawing.text(middle, LABEL_SIZE, Anchor::Middle, "nothing to draw");
    }
    // NaN is how a gap is asked for; anything else that is not drawn is worth saying.
    let asked = |p: &Point| p.0.is_nan() || p.1.is_nan();
    let without_place = |(series, places, _): &(&Series, Vec<Option<Point>>, Look)| {
        series.points.iter().zip(places).filter(|(p, place)| place.is_none() && !asked(p)).count()
    };
    curves.iter().map(without_place).sum::<usize>()
        + bands.iter().map(|band| band.left_out).sum::<usize>()
}

/// Marks the front, if it is asked for, and writes names beside its points, or else beside all.
fn mark(
    drawing: &mut Drawing,
    canvas: &Canvas<'_>,
    curves: &[(&Series, Vec<Option<Point>>, Look)],
    bands: &[band::Placed<'_>],
) {
    let drawn = curves.iter().flat_map(|(series, places, _)| {
        let name = |i: usize| series.names.get(i).map_or("", String::as_str);
        places
            .iter()
            .enumerate()
            .filter_map(move |(i, place)| Some((series.points[i], (*place)?, name(i))))
    });
    let drawn: Vec<(Point, Point, &str)> = drawn.collect();
    let on_front: Vec<(Point, Point, &str)> = if canvas.panel.front {
        let values: Vec<Point> = drawn.iter().map(|(value, ..)| *value).collect();
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
        .chain(bands.iter().flat_map(band::Placed::ends).map(|place| (place, MARKER)))
        .chain(rings)
        .collect();
    let clear = if canvas.panel.front { front::RING } else { 4.0 };
    let wanted: Vec<(Point, &str)> = named.iter().map(|(_, place, name)| (*place, *name)).collect();
    names::draw(
        drawing,
        &wanted,
        clear + 1.5,
        &Taken { frame: canvas.frame, markers, lines, stairs },
    );
}

fn curve(drawing: &mut Drawing, series: &Series, places: &[Option<(f64, f64)>], look: Look) {
    let mut markers = Vec::new();
    if series.style == Style::Markers {
        markers.extend(places.iter().flatten().copied());
    } else {
        let every = if places.len() <= MARKED { 1 } else { places.len().div_ceil(15) };
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
                    Style::Line | Style::Markers => false,
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
