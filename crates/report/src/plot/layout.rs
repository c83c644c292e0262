//! The layout of a figure: where its title, panels, legend and notes stand.

use super::canvas::{Canvas, PanelAxis, PlotPoint, has_place};
use super::figure::{PlotBand, PlotFigure, PlotPanel};
use super::legend::{Legend, LegendEntry, Sample};
use super::sketch::FigureSketch;
use super::slope::{SlopeKey, fitted_lines};
use super::{band, bars, panel, slope};
use crate::axis::{self, INK, LABEL_SIZE, TICK_SIZE, TITLE_SIZE};
use crate::font::{shorten, text_width, wrap};
use crate::svg::{Anchor, Drawing, Rect};

/// The margin around the picture, in pixels as all lengths here.
const MARGIN: f64 = 10.0;
/// The distance between panels that share the vertical axis.
const NARROW: f64 = 14.0;
/// The distance between the panels and the legend.
const BEFORE_LEGEND: f64 = 16.0;
/// The largest number of panels in a row.
const PANELS_PER_ROW: usize = 4;
/// The distance between the slopes above a panel.
const KEY_LINE: f64 = 14.0;
/// The distance between the lines of a panel's title.
const TITLE_LINE: f64 = LABEL_SIZE + 3.0;

impl PlotFigure {
    /// Draws the figure as SVG, in pixels of 1/96 inch. The result is always a readable picture,
    /// whatever the points are.
    pub fn svg(&self) -> String {
        self.draw(false).svg
    }

    /// Draws the figure as [`svg`](PlotFigure::svg) does, with what a page needs to answer a
    /// pointer: the parts of each legend entry are groups with the attribute `data-entry`, its
    /// place in the legend one with `data-legend`, and every point is listed.
    pub fn sketch(&self) -> FigureSketch {
        self.draw(true)
    }

    fn draw(&self, grouped: bool) -> FigureSketch {
        let size = PanelSize::new(self.panels.len());
        let axes = self.axes(size.width);
        let mut entries = self.entries();
        let heads = self.heads(&axes, &mut entries, size.width);
        let legend_height = self.panels.len().div_ceil(size.columns) as f64 * size.height;
        let legend = Legend::new(&self.legend, &entries, legend_height);
        let layout = FigureLayout::new(size, self.shares_y(), &axes, &heads);

        let total = layout.right()
            + if legend.is_empty() { 0.0 } else { BEFORE_LEGEND + legend.width() }
            + MARGIN;
        let title = wrap(&self.title, total - layout.left - MARGIN, TITLE_SIZE, 3);
        let top = MARGIN + title.len() as f64 * (TITLE_SIZE + 4.0);

        let mut drawing = Drawing::new(grouped);
        let mut spots = Vec::new();
        for (i, line) in title.iter().enumerate() {
            let baseline = MARGIN + TITLE_SIZE + i as f64 * (TITLE_SIZE + 4.0) - 2.0;
            drawing.text((layout.left, baseline), TITLE_SIZE, Anchor::Start, line);
        }
        let mut left_out = 0;
        for (i, panel) in self.panels.iter().enumerate() {
            let canvas =
                Canvas { frame: layout.frame(i, top), panel, x: &axes[i].x, y: &axes[i].y };
            heads[i].draw(&mut drawing, canvas.frame);
            let labelled = i % layout.size.columns == 0 || !layout.shared_y;
            draw_axes(&mut drawing, &canvas, labelled);
            left_out += panel::draw(&mut drawing, &canvas, &entries);
            if grouped {
                spots.extend(panel::spots(&canvas, i, &entries));
            }
        }
        legend.draw(&mut drawing, layout.right() + BEFORE_LEGEND, top + layout.above);

        let bottom = layout.bottom(self.panels.len(), top);
        let bottom = self.draw_notes(&mut drawing, left_out, bottom, total - 2.0 * MARGIN);
        let bottom = bottom.max(top + layout.above + legend.height());
        FigureSketch {
            svg: drawing.finish(total, bottom + MARGIN, &self.title),
            entries: entries.iter().map(|entry| entry.label.to_owned()).collect(),
            axes: (self.panels.iter().zip(&axes))
                .map(|(panel, axes)| [axes.x.sketched(&panel.x), axes.y.sketched(&panel.y)])
                .collect(),
            spots,
        }
    }

    fn shares_x(&self) -> bool {
        self.panels.windows(2).all(|pair| pair[0].x == pair[1].x)
    }

    fn shares_y(&self) -> bool {
        self.panels.windows(2).all(|pair| pair[0].y == pair[1].y)
    }

    /// Fits the axes of each panel, `width` pixels wide, to its points, or to those of all panels
    /// where the axis is shared.
    fn axes(&self, width: f64) -> Vec<PanelAxes> {
        let all_x = self.shares_x().then(|| coordinates(&self.panels, |p| p.0));
        let all_y = self.shares_y().then(|| coordinates(&self.panels, |p| p.1));
        let axes = self.panels.iter().map(|panel| {
            let alone = std::slice::from_ref(panel);
            let x = all_x.clone().unwrap_or_else(|| coordinates(alone, |p| p.0));
            let y = all_y.clone().unwrap_or_else(|| coordinates(alone, |p| p.1));
            PanelAxes {
                x: PanelAxis::new(&panel.x, &x, Some(width)),
                y: PanelAxis::new(&panel.y, &y, None),
            }
        });
        axes.collect()
    }

    /// Lists the legend's entries: every label once, in order of appearance; curves, then bands,
    /// then the meaning of marks.
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

    /// Makes the text above each panel. The slopes of fitted lines stand there if there are several
    /// panels, each of which has other slopes; the slopes of a single panel go to the legend.
    fn heads(
        &self,
        axes: &[PanelAxes],
        entries: &mut [LegendEntry<'_>],
        width: f64,
    ) -> Vec<PanelHead> {
        let mut heads = Vec::new();
        for (panel, axes) in self.panels.iter().zip(axes) {
            let mut keys = Vec::new();
            for line in fitted_lines(panel) {
                let slope =
                    format!("{}{}", line.end, slope::text(line.fit, &axes.x.unit, &axes.y.unit));
                let Some(entry) = entries.iter_mut().find(|e| e.is(line.of_band, line.label))
                else {
                    continue;
                };
                if self.panels.len() == 1 {
                    entry.slopes.push(slope);
                } else {
                    keys.push(SlopeKey { look: entry.look, of_band: line.of_band, text: slope });
                }
            }
            heads.push(PanelHead { title: heading(&panel.title, width), keys });
        }
        heads
    }

    /// Writes the notes below `bottom`, at most `width` pixels wide, and returns their lower end.
    fn draw_notes(
        &self,
        drawing: &mut Drawing,
        left_out: usize,
        mut bottom: f64,
        width: f64,
    ) -> f64 {
        let mut notes = self.notes.clone();
        if left_out > 0 {
            let points = if left_out == 1 { "point is" } else { "points are" };
            notes.push(format!(
                "{left_out} {points} not drawn: not positive on a logarithmic axis, of no \
                 category, or not finite"
            ));
        }
        if self.panels.iter().any(|panel| fitted_lines(panel).next().is_some()) {
            notes.push(
                "Slopes are of least squares through the points that the fitted line spans, ± \
                 their standard error."
                    .to_owned(),
            );
        }
        for note in notes {
            bottom += 4.0;
            for line in wrap(&note, width, 10.0, 2) {
                bottom += TICK_SIZE + 2.0;
                drawing.text((MARGIN, bottom), 10.0, Anchor::Start, &line);
            }
        }
        bottom
    }
}

/// The axes of a panel.
struct PanelAxes {
    x: PanelAxis,
    y: PanelAxis,
}

/// The size of a panel's frame in pixels, and the number of panels in a row.
struct PanelSize {
    columns: usize,
    width: f64,
    height: f64,
}

impl PanelSize {
    /// Chooses the size for a number of panels: the more stand in a row, the smaller they are.
    fn new(panels: usize) -> PanelSize {
        let columns = panels.clamp(1, PANELS_PER_ROW);
        let (width, height) = match columns {
            1 => (330.0, 240.0),
            2 => (250.0, 225.0),
            3 => (205.0, 205.0),
            _ => (175.0, 190.0),
        };
        PanelSize { columns, width, height }
    }
}

/// The text above a panel.
struct PanelHead {
    /// The lines of the title.
    title: Vec<String>,
    /// The slopes of the fitted lines, below the title.
    keys: Vec<SlopeKey>,
}

impl PanelHead {
    fn height(&self) -> f64 {
        self.title.len() as f64 * TITLE_LINE + self.keys.len() as f64 * KEY_LINE
    }

    fn draw(&self, drawing: &mut Drawing, frame: Rect) {
        for (line, key) in self.keys.iter().rev().enumerate() {
            key.draw(drawing, (frame.x, frame.y - 6.0 - line as f64 * KEY_LINE), frame.width);
        }
        for (line, text) in self.title.iter().rev().enumerate() {
            let baseline =
                frame.y - 6.0 - self.keys.len() as f64 * KEY_LINE - line as f64 * TITLE_LINE;
            let middle = (frame.x + frame.width / 2.0, baseline);
            drawing.text(middle, LABEL_SIZE, Anchor::Middle, text);
        }
    }
}

/// The places of the panels.
struct FigureLayout {
    size: PanelSize,
    /// True if all panels share the vertical axis, which is then written at the left alone.
    shared_y: bool,
    /// The left end of the first panel.
    left: f64,
    /// The distance between the left ends of neighbouring panels.
    pitch: f64,
    /// The room above the frame of a panel.
    above: f64,
    /// The room below the frame of a panel.
    below: f64,
}

impl FigureLayout {
    fn new(
        size: PanelSize,
        shared_y: bool,
        axes: &[PanelAxes],
        heads: &[PanelHead],
    ) -> FigureLayout {
        let beside = axes.iter().map(|a| a.y.drawn.room_beside(size.height)).fold(0.0, f64::max);
        let below = axes.iter().map(|a| a.x.drawn.room_below(size.width)).fold(0.0, f64::max);
        let above = 6.0 + heads.iter().map(PanelHead::height).fold(0.0, f64::max);
        let pitch = size.width + if shared_y { NARROW } else { NARROW + beside };
        FigureLayout { size, shared_y, left: MARGIN + beside, pitch, above, below }
    }

    /// Returns the right end of the last panel of a row.
    fn right(&self) -> f64 {
        self.left + self.pitch * (self.size.columns as f64 - 1.0) + self.size.width
    }

    fn row_height(&self) -> f64 {
        self.above + self.size.height + self.below
    }

    /// Returns the frame of the panel with an index, where the first row begins at `top`.
    fn frame(&self, panel: usize, top: f64) -> Rect {
        let (row, column) = (panel / self.size.columns, panel % self.size.columns);
        Rect {
            x: self.left + column as f64 * self.pitch,
            y: top + self.above + row as f64 * self.row_height(),
            width: self.size.width,
            height: self.size.height,
        }
    }

    /// Returns the lower end of so many panels.
    fn bottom(&self, panels: usize, top: f64) -> f64 {
        let rows = panels.div_ceil(self.size.columns).max(1) as f64;
        top + rows * self.row_height()
    }
}

/// Breaks the title of a panel into lines. A title that is too long is broken before its value, if
/// it has one, and not within.
fn heading(title: &str, width: f64) -> Vec<String> {
    match title.rsplit_once(" = ") {
        Some((name, value)) if text_width(title, LABEL_SIZE) > width => {
            [name, &format!("= {value}")].map(|line| shorten(line, width, LABEL_SIZE)).to_vec()
        }
        _ => wrap(title, width, LABEL_SIZE, 2),
    }
}

/// Collects one coordinate of everything that is drawn in some panels, in SI units.
fn coordinates(panels: &[PlotPanel], coordinate: fn(&PlotPoint) -> f64) -> Vec<f64> {
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
        let feet = panel.series.iter().flat_map(|series| bars::corners(series, panel));
        // Only points that are drawn count: a point that is a gap must not widen the axis.
        let drawn = |p: &PlotPoint| has_place(&panel.x, p.0) && has_place(&panel.y, p.1);
        // The level is looked for on the vertical axis whatever the curves do.
        let x = panel.series.iter().flat_map(|s| s.points.first()).map(|point| point.0).next();
        let level = x.zip(panel.level);
        curves
            .chain(bands)
            .chain(feet)
            .chain(level)
            .filter(drawn)
            .map(|point| coordinate(&point))
            .collect::<Vec<f64>>()
    };
    panels.iter().flat_map(drawn_in).collect()
}

/// Draws the frame of a panel with its grid and its axes; `labelled` says whether the vertical axis
/// has numbers and a label.
fn draw_axes(drawing: &mut Drawing, canvas: &Canvas<'_>, labelled: bool) {
    let Canvas { frame, x, y, .. } = *canvas;
    axis::grid(drawing, frame, &x.drawn, &y.drawn);
    axis::below(drawing, frame, &x.drawn, true);
    axis::left(drawing, frame, &y.drawn, true, labelled);
    drawing.rect(frame, "none", INK, 0.9);
}
