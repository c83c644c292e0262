//! The key to what is drawn, to the right of the panels so that it covers nothing.

use super::canvas::PlotPoint;
use super::figure::{PlotBand, Series, Style};
use super::{band, curve, front};
use crate::axis::TICK_SIZE;
use crate::font::{shorten, text_width, wrap};
use crate::palette::Look;
use crate::svg::{Anchor, Drawing, Rect, n};

/// The height of the first line of an entry, in pixels.
const ENTRY: f64 = 17.0;
/// The height of every other line.
const LINE: f64 = 13.0;
/// The width of the sample before the text.
const SAMPLE: f64 = 26.0;
/// The largest width of a line of text.
const WIDEST_ENTRY: f64 = 190.0;
/// The dashes of lines whose points are not marked, so that they are told apart in black and white
/// too.
const DASHES: [&str; 6] = ["", "6 3", "2 2", "8 2.5 2 2.5", "12 3", "8 2 2 2 2 2"];

/// The drawing before the text of an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sample {
    Curve {
        style: Style,
        fitted: bool,
    },
    Band {
        joined: bool,
    },
    /// A piece of the stairs along a front.
    Front,
    /// The arrow of an open end.
    Open,
}

/// A label with the look of what it stands for.
pub(super) struct LegendEntry<'a> {
    pub(super) label: &'a str,
    pub(super) look: Look,
    pub(super) sample: Sample,
    kin: Option<usize>,
    /// The slopes of the fitted lines, if there is one panel.
    pub(super) slopes: Vec<String>,
}

impl<'a> LegendEntry<'a> {
    /// Makes the entry of a series after those `before`.
    pub(super) fn of_series(before: &[LegendEntry<'_>], series: &'a Series) -> LegendEntry<'a> {
        let mut look = Look::new(series.kin.unwrap_or(before.len()));
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

    /// Makes the entry of a band after those `before`.
    pub(super) fn of_band(before: &[LegendEntry<'_>], band: &'a PlotBand) -> LegendEntry<'a> {
        LegendEntry {
            label: &band.label,
            look: Look::new(before.len()),
            sample: Sample::Band { joined: band.joined },
            kin: None,
            slopes: Vec::new(),
        }
    }

    /// Makes the entry of a mark that means the same on every curve.
    pub(super) fn of_mark(sample: Sample, label: &'static str) -> LegendEntry<'static> {
        LegendEntry { label, look: Look::new(0), sample, kin: None, slopes: Vec::new() }
    }

    /// Says whether this is the entry of a band, or else of a series, with a label.
    pub(super) fn is(&self, band: bool, label: &str) -> bool {
        let kind = if band {
            matches!(self.sample, Sample::Band { .. })
        } else {
            matches!(self.sample, Sample::Curve { .. })
        };
        kind && self.label == label
    }

    /// Sets the text in lines: a slope stands beside the label if it fits, otherwise below.
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

    /// Draws the sample, with its left end and its middle at `(x, y)`.
    fn draw_sample(&self, drawing: &mut Drawing, (x, y): PlotPoint) {
        let (style, fitted) = match self.sample {
            Sample::Curve { style, fitted } => (style, fitted),
            Sample::Band { joined } => {
                return band::sample(drawing, (x, y), SAMPLE, self.look, joined);
            }
            Sample::Front => return front::sample(drawing, (x, y), SAMPLE),
            Sample::Open => return band::sample_of_open(drawing, (x, y), SAMPLE),
        };
        if matches!(style, Style::Bars | Style::WhiskerBars) {
            return curve::sample_of_bars(drawing, (x, y), SAMPLE, self.look);
        }
        if !matches!(style, Style::Markers | Style::Dots) || fitted {
            let width = if matches!(style, Style::Markers | Style::Dots) { 1.0 } else { 1.5 };
            drawing.push(&format!(
                r#"<path d="M{} {}h{SAMPLE}" fill="none" stroke="{}" stroke-width="{width}"{}/>"#,
                n(x),
                n(y),
                self.look.color,
                self.look.dash_attribute()
            ));
        }
        match style {
            Style::Line | Style::Bars | Style::WhiskerBars => {}
            Style::Dots => drawing.push(&self.look.dot(x + SAMPLE / 2.0, y)),
            Style::Path => drawing.push(&self.look.marker(x + SAMPLE, y)),
            Style::LineAndMarkers | Style::Markers => {
                drawing.push(&self.look.marker(x + SAMPLE / 2.0, y))
            }
        }
    }
}

/// An entry with its text in lines.
#[derive(Clone)]
struct EntryLines<'a> {
    /// The index of the entry among all.
    index: usize,
    entry: &'a LegendEntry<'a>,
    lines: Vec<String>,
}

impl EntryLines<'_> {
    fn height(&self) -> f64 {
        ENTRY + LINE * (self.lines.len() as f64 - 1.0)
    }
}

/// The entries in columns.
pub(super) struct Legend<'a> {
    heading: Vec<String>,
    columns: Vec<Vec<EntryLines<'a>>>,
    /// The width of the longest line, in pixels.
    text: f64,
}

impl<'a> Legend<'a> {
    /// Sets the entries in as few columns as `height` pixels allow, about equally long.
    pub(super) fn new(heading: &str, entries: &'a [LegendEntry<'a>], height: f64) -> Legend<'a> {
        let entries: Vec<EntryLines<'_>> = entries
            .iter()
            .enumerate()
            .map(|(index, entry)| EntryLines { index, entry, lines: entry.lines() })
            .filter(|entry| !entry.lines.is_empty())
            .collect();
        let heading =
            if entries.is_empty() { Vec::new() } else { wrap(heading, WIDEST_ENTRY, TICK_SIZE, 3) };
        let text = entries
            .iter()
            .flat_map(|entry| &entry.lines)
            .map(|line| text_width(line, TICK_SIZE))
            .fold(0.0, f64::max);
        let whole: f64 = entries.iter().map(EntryLines::height).sum();
        let room = (height - heading.len() as f64 * ENTRY).max(ENTRY);
        let count = (whole / room).ceil().max(1.0);
        let mut limit = whole / count;
        loop {
            let columns = filled(&entries, limit);
            if columns.len() as f64 <= count {
                return Legend { heading, columns, text };
            }
            // As an entry cannot be parted, there is one column more than was counted: all columns
            // become a little longer.
            limit += LINE / 2.0;
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    fn column_width(&self) -> f64 {
        SAMPLE + 7.0 + self.text + 12.0
    }

    /// Returns the width in pixels.
    pub(super) fn width(&self) -> f64 {
        let heading =
            self.heading.iter().map(|line| text_width(line, TICK_SIZE)).fold(0.0, f64::max);
        (self.columns.len() as f64 * self.column_width() - 12.0).max(heading)
    }

    /// Returns the height in pixels.
    pub(super) fn height(&self) -> f64 {
        let column = |column: &Vec<EntryLines<'_>>| column.iter().map(EntryLines::height).sum();
        self.heading.len() as f64 * ENTRY + self.columns.iter().map(column).fold(0.0, f64::max)
    }

    /// Draws the legend with its upper left corner at `(left, top)`.
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
            for entry in column {
                let middle = y + ENTRY / 2.0;
                drawing.begin(format_args!("data-legend=\"{}\"", entry.index));
                let (width, height) = (self.column_width() - 12.0, entry.height());
                drawing.target(Rect { x, y, width, height });
                entry.entry.draw_sample(drawing, (x, middle));
                for (i, line) in entry.lines.iter().enumerate() {
                    let baseline = middle + TICK_SIZE * 0.36 + i as f64 * LINE;
                    drawing.text((x + SAMPLE + 7.0, baseline), TICK_SIZE, Anchor::Start, line);
                }
                drawing.end();
                y += entry.height();
            }
        }
    }
}

/// Fills columns of at most a height with entries; an entry that is higher gets a column to itself.
fn filled<'a>(entries: &[EntryLines<'a>], limit: f64) -> Vec<Vec<EntryLines<'a>>> {
    let mut columns: Vec<Vec<EntryLines<'a>>> = Vec::new();
    let mut used = 0.0;
    for entry in entries {
        let height = entry.height();
        match columns.last_mut() {
            // A hair of rounding is no new column.
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
