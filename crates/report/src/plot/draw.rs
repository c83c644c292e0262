//! Drawing a figure.

use std::fmt::Write;

use super::{Axis, Figure, Panel, Series, Style};
use crate::axis::{self, Drawn, INK, LABEL_SIZE, TICK_SIZE, TITLE_SIZE};
use crate::palette::Look;
use crate::scale::{Scale, Ticks, drawable};
use crate::si::Unit;
use crate::svg::{Anchor, Drawing, Rect, n, shorten, text_width, wrap};

const MARGIN: f64 = 10.0;
/// Between panels that share the vertical axis.
const NARROW: f64 = 14.0;
const PANELS_PER_ROW: usize = 4;
/// Of one entry of the legend.
const ENTRY: f64 = 17.0;
const SAMPLE: f64 = 26.0;
const WIDEST_ENTRY: f64 = 190.0;
/// With more points than this, not every one is marked.
const MARKED: usize = 40;
/// Of lines whose points are not marked, so that they are told apart in black and white too.
const DASHES: [&str; 6] = ["", "6 3", "2 2", "8 2.5 2 2.5", "12 3", "8 2 2 2 2 2"];
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
            let (low, high) = values().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
            Unit::fitting(&axis.unit, (0.5 * (low.ln() + high.ln())).exp())
        } else {
            Unit::fitting(&axis.unit, values().map(f64::abs).fold(0.0, f64::max))
        };
        let drawn = if axis.categories.is_empty() {
            let scale = Scale::around(values().map(|v| unit.of_si(v)), axis.log);
            match width {
                Some(width) => Drawn::across(scale, width, &axis.label, &unit.name),
                None => Drawn::new(scale, scale.ticks(if axis.log { 8 } else { 5 }), &axis.label, &unit.name),
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

/// A series with its look.
struct Entry<'a> {
    label: &'a str,
    look: Look,
    style: Style,
    kin: Option<usize>,
}

impl<'a> Entry<'a> {
    /// The entry after those `before`.
    fn after(before: &[Entry<'_>], series: &'a Series) -> Entry<'a> {
        let mut look = Look::of(series.kin.unwrap_or(before.len()));
        if matches!(series.style, Style::Line | Style::Path) {
            let alike = if series.kin.is_some() { before.iter().filter(|e| e.kin == series.kin).count() } else { before.len() };
            look.dash = DASHES[alike % DASHES.len()];
        }
        Entry { label: &series.label, look, style: series.style, kin: series.kin }
    }
}

impl Figure {
    /// The figure as SVG, in pixels of 1/96 inch; always a readable picture, whatever the points are.
    pub fn svg(&self) -> String {
        let entries = self.entries();
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

        let beside = axes.iter().map(|(_, y)| y.drawn.room_beside(height)).fold(0.0, f64::max);
        let below = axes.iter().map(|(x, _)| x.drawn.room_below(width)).fold(0.0, f64::max);
        let headings: Vec<Vec<String>> = self.panels.iter().map(|panel| heading(&panel.title, width)).collect();
        let above = 6.0 + headings.iter().map(Vec::len).max().unwrap_or(0) as f64 * TITLE_LINE;
        let pitch = width + if shared_y { NARROW } else { NARROW + beside };
        let left = MARGIN + beside;
        let right = left + pitch * (columns as f64 - 1.0) + width;

        let legend = Legend::new(&self.legend, &entries, self.panels.len().div_ceil(columns) as f64 * height);
        let total = right + if legend.columns > 0 { 16.0 + legend.width() } else { 0.0 } + MARGIN;
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
            let frame = Rect { x: left + column as f64 * pitch, y: top + above + row as f64 * (above + height + below), width, height };
            for (line, text) in headings[i].iter().rev().enumerate() {
                let at = (frame.x + width / 2.0, frame.y - 6.0 - line as f64 * TITLE_LINE);
                drawing.text(at, LABEL_SIZE, Anchor::Middle, text);
            }
            axis::grid(&mut drawing, frame, &x.drawn, &y.drawn);
            axis::below(&mut drawing, frame, &x.drawn, true);
            axis::left(&mut drawing, frame, &y.drawn, true, column == 0 || !shared_y);
            drawing.rect(frame, "none", INK, 0.9);
            left_out += curves(&mut drawing, frame, panel, x, y, &entries);
        }
        legend.draw(&mut drawing, right + 16.0, top + above);

        let rows = self.panels.len().div_ceil(columns).max(1) as f64;
        let mut bottom = top + rows * (above + height + below);
        if left_out > 0 {
            bottom += 4.0;
            let points = if left_out == 1 { "point is" } else { "points are" };
            let note = format!("{left_out} {points} not drawn: not positive on a logarithmic axis, or not finite");
            for line in wrap(&note, total - 2.0 * MARGIN, 10.0, 2) {
                bottom += TICK_SIZE + 2.0;
                drawing.text((MARGIN, bottom), 10.0, Anchor::Start, &line);
            }
        }
        bottom = bottom.max(top + above + legend.height());
        drawing.finish(total, bottom + MARGIN, &self.title)
    }

    /// The legend's entries: every label once, in order of appearance.
    fn entries(&self) -> Vec<Entry<'_>> {
        let mut entries: Vec<Entry<'_>> = Vec::new();
        for series in self.panels.iter().flat_map(|p| &p.series) {
            if !entries.iter().any(|e| e.label == series.label) {
                entries.push(Entry::after(&entries, series));
            }
        }
        entries
    }
}

/// The title of a panel in lines; one that is too long is broken before its value, if it has one, and not within.
fn heading(title: &str, width: f64) -> Vec<String> {
    match title.rsplit_once(" = ") {
        Some((name, value)) if text_width(title, LABEL_SIZE) > width => {
            [name, &format!("= {value}")].map(|line| shorten(line, width, LABEL_SIZE)).to_vec()
        }
        _ => wrap(title, width, LABEL_SIZE, 2),
    }
}

fn coordinates(panels: &[Panel], of: fn(&(f64, f64)) -> f64) -> Vec<f64> {
    // Only points that are drawn count: a point that is a gap must not widen the axis.
    let drawn = |panel: &Panel, p: &(f64, f64)| drawable(p.0, panel.x.log) && drawable(p.1, panel.y.log);
    panels.iter().flat_map(|p| p.series.iter().flat_map(|s| &s.points).filter(|point| drawn(p, point))).map(of).collect()
}

/// Draws the curves of a panel; the number of points that have values but no place.
fn curves(drawing: &mut Drawing, frame: Rect, panel: &Panel, x: &Prepared, y: &Prepared, entries: &[Entry<'_>]) -> usize {
    let mut left_out = 0;
    let mut any = false;
    for series in &panel.series {
        let look = entries.iter().find(|e| e.label == series.label).map_or(Look::of(0), |e| e.look);
        let place = |&(px, py): &(f64, f64)| {
            let inside = drawable(px, panel.x.log) && drawable(py, panel.y.log);
            inside.then(|| (frame.x + x.at(px) * frame.width, frame.bottom() - y.at(py) * frame.height))
        };
        let places: Vec<Option<(f64, f64)>> = series.points.iter().map(place).collect();
        // NaN is how a gap is asked for; anything else that is not drawn is worth saying.
        let asked = |p: &(f64, f64)| p.0.is_nan() || p.1.is_nan();
        left_out += series.points.iter().zip(&places).filter(|(p, place)| place.is_none() && !asked(p)).count();
        any |= places.iter().any(Option::is_some);
        curve(drawing, series, &places, look);
    }
    if !any {
        let middle = (frame.x + frame.width / 2.0, frame.y + frame.height / 2.0);
        drawing.text(middle, LABEL_SIZE, Anchor::Middle, "nothing to draw");
    }
    left_out
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

/// The key to the curves, to the right of the panels so that it covers nothing.
struct Legend<'a> {
    heading: Vec<String>,
    entries: Vec<(String, &'a Entry<'a>)>,
    rows: usize,
    columns: usize,
    text: f64,
}

impl<'a> Legend<'a> {
    fn new(heading: &str, entries: &'a [Entry<'a>], height: f64) -> Legend<'a> {
        let entries: Vec<(String, &Entry<'_>)> =
            entries.iter().filter(|e| !e.label.is_empty()).map(|e| (shorten(e.label, WIDEST_ENTRY, TICK_SIZE), e)).collect();
        let heading = if entries.is_empty() { Vec::new() } else { wrap(heading, WIDEST_ENTRY, TICK_SIZE, 3) };
        let fitting = ((height / ENTRY) as usize).saturating_sub(heading.len()).max(1);
        let columns = entries.len().div_ceil(fitting);
        let rows = entries.len().div_ceil(columns.max(1));
        let text = entries.iter().map(|(label, _)| text_width(label, TICK_SIZE)).fold(0.0, f64::max);
        Legend { heading, entries, rows, columns, text }
    }

    fn column_width(&self) -> f64 {
        SAMPLE + 7.0 + self.text + 12.0
    }

    fn width(&self) -> f64 {
        let heading = self.heading.iter().map(|line| text_width(line, TICK_SIZE)).fold(0.0, f64::max);
        (self.columns as f64 * self.column_width() - 12.0).max(heading)
    }

    fn height(&self) -> f64 {
        (self.heading.len() + self.rows) as f64 * ENTRY
    }

    fn draw(&self, drawing: &mut Drawing, left: f64, top: f64) {
        for (i, line) in self.heading.iter().enumerate() {
            drawing.text((left, top + i as f64 * ENTRY + TICK_SIZE), TICK_SIZE, Anchor::Start, line);
        }
        let top = top + self.heading.len() as f64 * ENTRY;
        for (i, (label, entry)) in self.entries.iter().enumerate() {
            let x = left + (i / self.rows) as f64 * self.column_width();
            let y = top + (i % self.rows) as f64 * ENTRY + ENTRY / 2.0;
            if entry.style != Style::Markers {
                drawing.push(&format!(
                    r#"<path d="M{} {}h{SAMPLE}" fill="none" stroke="{}" stroke-width="1.5"{}/>"#,
                    n(x),
                    n(y),
                    entry.look.color,
                    entry.look.dash_attribute()
                ));
            }
            match entry.style {
                Style::Line => {}
                Style::Path => drawing.push(&entry.look.marker(x + SAMPLE, y)),
                Style::LineAndMarkers | Style::Markers => drawing.push(&entry.look.marker(x + SAMPLE / 2.0, y)),
            }
            drawing.text((x + SAMPLE + 7.0, y + TICK_SIZE * 0.36), TICK_SIZE, Anchor::Start, label);
        }
    }
}
