//! The key to what is drawn, to the right of the panels so that it covers nothing.

use super::figure::{PlotBand, Series, Style};
use super::{band, front};
use crate::axis::TICK_SIZE;
use crate::font::{shorten, text_width, wrap};
use crate::palette::Look;
use crate::svg::{Anchor, Drawing, n};

/// Of the first line of an entry, and of every other.
const ENTRY: f64 = 17.0;
const LINE: f64 = 13.0;
const SAMPLE: f64 = 26.0;
const WIDEST_ENTRY: f64 = 190.0;
/// Of lines whose points are not marked, so that they are told apart in black and white too.
const DASHES: [&str; 6] = ["", "6 3", "2 2", "8 2.5 2 2.5", "12 3", "8 2 2 2 2 2"];

/// What stands before the text of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sample {
    Curve { style: Style, fitted: bool },
    Band { joined: bool },
    Front,
    Open,
}

/// What is drawn with its look.
pub(super) struct LegendEntry<'a> {
    pub(super) label: &'a str,
    pub(super) look: Look,
    pub(super) sample: Sample,
    kin: Option<usize>,
    /// Of its fitted lines, where there is one panel.
    pub(super) slopes: Vec<String>,
}

impl<'a> LegendEntry<'a> {
    /// The entry of a series after those `before`.
    pub(super) fn of_series(before: &[LegendEntry<'_>], series: &'a Series) -> LegendEntry<'a> {
        let mut look = Look::of(series.kin.unwrap_or(before.len()));
        if matches!(series.style, Style::Line | Style::Path) {
            let alike = if series.kin.is_some() {
                before.iter().filter(|e| e.kin == series.kin).count()
            } else {
                before.len()
            };
            look.dash = DASHES[alike % DASHES.len()];
        }
        let sample = Sample::Curve { style: series.style, fitted: series.fit.is_some() };
        LegendEntry { label: &series.label, look, sample, kin: series.kin, slopes: Vec::new() }
    }

    /// The entry of a band after those `before`.
    pub(super) fn of_band(before: &[LegendEntry<'_>], band: &'a PlotBand) -> LegendEntry<'a> {
        let sample = Sample::Band { joined: band.joined };
        LegendEntry {
            label: &band.label,
            look: Look::of(before.len()),
            sample,
            kin: None,
            slopes: Vec::new(),
        }
    }

    /// An entry for a mark that means the same on every curve.
    pub(super) fn of_mark(sample: Sample, label: &'static str) -> LegendEntry<'static> {
        LegendEntry { label, look: Look::of(0), sample, kin: None, slopes: Vec::new() }
    }

    /// Whether it is the entry of a band, or else of a series, of a label.
    pub(super) fn is(&self, band: bool, label: &str) -> bool {
        let kind = if band {
            matches!(self.sample, Sample::Band { .. })
        } else {
            matches!(self.sample, Sample::Curve { .. })
        };
        kind && self.label == label
    }

    /// The text in lines: what is fitted beside the name if it fits, else below.
    fn lines(&self) -> Vec<String> {
        let label = shorten(self.label, WIDEST_ENTRY, TICK_SIZE);
        let (Some(first), false) = (self.slopes.first(), label.is_empty()) else {
            return if label.is_empty() { self.slopes.clone() } else { vec![label] };
        };
        let together = format!("{label}, {first}");
        if self.slopes.len() == 1 && text_width(&together, TICK_SIZE) <= WIDEST_ENTRY {
            vec![together]
        } else {
            std::iter::once(label).chain(self.slopes.iter().cloned()).collect()
        }
    }

    fn draw_sample(&self, drawing: &mut Drawing, x: f64, y: f64) {
        let (style, fitted) = match self.sample {
            Sample::Curve { style, fitted } => (style, fitted),
            Sample::Band { joined } => {
                return band::sample(drawing, x, y, SAMPLE, self.look, joined);
            }
            Sample::Front => return front::sample(drawing, x, y, SAMPLE),
            Sample::Open => return band::sample_of_open(drawing, x, y, SAMPLE),
        };
        if style != Style::Markers || fitted {
            let width = if style == Style::Markers { 1.0 } else { 1.5 };
            drawing.push(&format!(
                r#"<path d="M{} {}h{SAMPLE}" fill="none" stroke="{}" stroke-width="{width}"{}/>"#,
                n(x),
                n(y),
                self.look.color,
                self.look.dash_attribute()
            ));
        }
        match style {
            Style::Line => {}
            Style::Path => drawing.push(&self.look.marker(x + SAMPLE, y)),
            Style::LineAndMarkers | Style::Markers => {
                drawing.push(&self.look.marker(x + SAMPLE / 2.0, y))
            }
        }
    }
}

/// The entries in columns.
pub(super) struct Legend<'a> {
    heading: Vec<String>,
    columns: Vec<Vec<(&'a LegendEntry<'a>, Vec<String>)>>,
    text: f64,
}

/// The height of an entry of so many lines.
fn height_of(lines: usize) -> f64 {
    ENTRY + LINE * (lines as f64 - 1.0)
}

impl<'a> Legend<'a> {
    /// In as few columns as `height` allows, about equally long.
    pub(super) fn new(heading: &str, entries: &'a [LegendEntry<'a>], height: f64) -> Legend<'a> {
        let entries: Vec<_> =
            entries.iter().map(|e| (e, e.lines())).filter(|(_, lines)| !lines.is_empty()).collect();
        let heading =
            if entries.is_empty() { Vec::new() } else { wrap(heading, WIDEST_ENTRY, TICK_SIZE, 3) };
        let text = entries
            .iter()
            .flat_map(|(_, lines)| lines)
            .map(|line| text_width(line, TICK_SIZE))
            .fold(0.0, f64::max);
        let whole: f64 = entries.iter().map(|(_, lines)| height_of(lines.len())).sum();
        let room = (height - heading.len() as f64 * ENTRY).max(ENTRY);
        let count = (whole / room).ceil().max(1.0);
        let mut limit = whole / count;
        loop {
            let columns = filled(&entries, limit);
            if columns.len() as f64 <= count {
                return Legend { heading, columns, text };
            }
            // a column more than were counted: as an entry cannot be parted, all become a little
            // longer
            limit += LINE / 2.0;
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    fn column_width(&self) -> f64 {
        SAMPLE + 7.0 + self.text + 12.0
    }

    pub(super) fn width(&self) -> f64 {
        let heading =
            self.heading.iter().map(|line| text_width(line, TICK_SIZE)).fold(0.0, f64::max);
        (self.columns.len() as f64 * self.column_width() - 12.0).max(heading)
    }

    pub(super) fn height(&self) -> f64 {
        let column = |column: &Vec<(_, Vec<String>)>| {
            column.iter().map(|(_, lines)| height_of(lines.len())).sum()
        };
        self.heading.len() as f64 * ENTRY + self.columns.iter().map(column).fold(0.0, f64::max)
    }

    pub(super) fn draw(&self, drawing: &mut Drawing, left: f64, top: f64) {
        for (i, line) in self.heading.iter().enumerate() {
            drawing.text(
                (left, top + i as f64 * ENTRY + TICK_SIZE),
                TICK_SIZE,
                Anchor::Start,
                line,
            );
        }
        for (i, column) in self.columns.iter().enumerate() {
            let x = left + i as f64 * self.column_width();
            let mut y = top + self.heading.len() as f64 * ENTRY;
            for (entry, lines) in column {
                let middle = y + ENTRY / 2.0;
                entry.draw_sample(drawing, x, middle);
                for (i, line) in lines.iter().enumerate() {
                    let baseline = middle + TICK_SIZE * 0.36 + i as f64 * LINE;
                    drawing.text((x + SAMPLE + 7.0, baseline), TICK_SIZE, Anchor::Start, line);
                }
                y += height_of(lines.len());
            }
        }
    }
}

type Lines<'a> = (&'a LegendEntry<'a>, Vec<String>);

/// The entries in columns of at most a height, but for an entry that is higher by itself.
fn filled<'a>(entries: &[Lines<'a>], limit: f64) -> Vec<Vec<Lines<'a>>> {
    let mut columns: Vec<Vec<Lines<'a>>> = Vec::new();
    let mut used = 0.0;
    for entry in entries {
        let height = height_of(entry.1.len());
        match columns.last_mut() {
            // a hair of rounding is no new column
            Some(column) if used + height <= limit + 1e-6 => column.push(entry.clone()),
            _ => {
                columns.push(vec![entry.clone()]);
                used = 0.0;
            }
        }
        used += height;
    }
    columns
}
