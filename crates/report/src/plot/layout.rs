//! Drawing a figure.

use super::canvas::{Canvas, PanelAxis, has_place};
use super::figure::{PlotBand, PlotFigure, PlotPanel};
use super::legend::{Legend, LegendEntry, Sample};
use super::slope::FIT_OF_BAND;
use super::{band, panel, slope};
use crate::axis::{self, INK, LABEL_SIZE, TICK_SIZE, TITLE_SIZE};
use crate::fit::Fit;
use crate::font::{shorten, text_width, wrap};
use crate::palette::Look;
use crate::svg::{Anchor, Drawing, Rect, n};

const MARGIN: f64 = 10.0;
/// Between panels that share the vertical axis.
const NARROW: f64 = 14.0;
const PANELS_PER_ROW: usize = 4;
/// Between the slopes above a panel.
const KEY_LINE: f64 = 14.0;
/// Between the lines of a panel's title.
const TITLE_LINE: f64 = LABEL_SIZE + 3.0;

impl PlotFigure {
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
        let axes: Vec<(PanelAxis, PanelAxis)> = self
            .panels
            .iter()
            .map(|panel| {
                let own = std::slice::from_ref(panel);
                let x = if shared_x { all_x.clone() } else { coordinates(own, |p| p.0) };
                let y = if shared_y { all_y.clone() } else { coordinates(own, |p| p.1) };
                (PanelAxis::new(&panel.x, &x, Some(width)), PanelAxis::new(&panel.y, &y, None))
            })
            .collect();

        let mut entries = self.entries();
        let mut keys: Vec<Vec<SlopeKey>> = vec![Vec::new(); self.panels.len()];
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
                    key.push(SlopeKey { look: entry.look, of_band: is_band, text: slope })
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
            left_out += panel::draw(&mut drawing, &Canvas { frame, panel, x, y }, &entries);
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
    fn entries(&self) -> Vec<LegendEntry<'_>> {
        let mut entries: Vec<LegendEntry<'_>> = Vec::new();
        for series in self.panels.iter().flat_map(|p| &p.series) {
            if !entries.iter().any(|e| e.is(false, &series.label)) {
                entries.push(LegendEntry::of_series(&entries, series));
            }
        }
        for band in self.panels.iter().flat_map(|p| &p.bands) {
            if !entries.iter().any(|e| e.is(true, &band.label)) {
                entries.push(LegendEntry::of_band(&entries, band));
            }
        }
        if self.panels.iter().any(|p| p.front) {
            entries.push(LegendEntry::of_mark(Sample::Front, "cheapest for its accuracy"));
        }
        if self.panels.iter().flat_map(|p| &p.bands).any(band::any_open) {
            entries.push(LegendEntry::of_mark(Sample::Open, "no upper end known"));
        }
        entries
    }
}

/// The fitted lines of a panel: whether they are a band's, its or their series' label, which of its
/// ends, and the line.
fn fits(panel: &PlotPanel) -> impl Iterator<Item = (bool, &str, &'static str, &Fit)> {
    let curves =
        panel.series.iter().filter_map(|s| Some((false, s.label.as_str(), "", s.fit.as_ref()?)));
    let ends = |band| -> [(&PlotBand, &'static str, usize); 2] {
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
struct SlopeKey {
    look: Look,
    of_band: bool,
    text: String,
}

impl SlopeKey {
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

fn coordinates(panels: &[PlotPanel], of: fn(&(f64, f64)) -> f64) -> Vec<f64> {
    let drawn_in = |panel: &PlotPanel| {
        let curves = panel
            .series
            .iter()
            .flat_map(|s| s.points.iter().copied().chain(s.fit.iter().flat_map(slope::ends)));
        let fitted =
            |b: &PlotBand| b.fits.iter().flatten().flat_map(slope::ends).collect::<Vec<_>>();
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
