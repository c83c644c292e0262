//! The frame around a picture: its ticks, their numbers, and the labels of its axes.

use super::scale::AxisScale;
use super::ticks::Ticks;
use crate::font::{text_width, wrap};
use crate::number::power_of_ten;
use crate::svg::{Anchor, Drawing, Rect, n};
use crate::text::escape;

/// The font size of the numbers at ticks, in pixels as all lengths here.
pub(crate) const TICK_SIZE: f64 = 11.0;
/// The font size of the label of an axis.
pub(crate) const LABEL_SIZE: f64 = 12.0;
/// The font size of the title of a picture.
pub(crate) const TITLE_SIZE: f64 = 13.0;
/// The colour of frames, ticks and marks.
pub(crate) const INK: &str = "#1a1a1a";
/// The colour of the lines behind the curves.
const GRID: &str = "#e4e4e4";
/// The distance from the frame to the numbers at its ticks.
const GAP: f64 = 6.0;

/// An axis that is ready to be drawn.
#[derive(Clone, Debug)]
pub(crate) struct DrawnAxis {
    pub(crate) scale: AxisScale,
    pub(crate) ticks: Ticks,
    pub(crate) label: String,
}

impl DrawnAxis {
    /// Makes an axis called `label [unit]`, or `label [10⁻⁶ unit]` when the ticks leave out a power
    /// of ten.
    pub(crate) fn new(scale: AxisScale, ticks: Ticks, label: &str, unit: &str) -> DrawnAxis {
        let unit = match (ticks.exponent, unit) {
            (0, "") => String::new(),
            (0, unit) => format!("[{unit}]"),
            (power, "" | "1") => format!("[{}]", power_of_ten(power)),
            (power, unit) => format!("[{} {unit}]", power_of_ten(power)),
        };
        let label = if label.is_empty() || unit.is_empty() {
            format!("{label}{unit}")
        } else {
            format!("{label} {unit}")
        };
        DrawnAxis { scale, ticks, label }
    }

    /// Returns the width of the widest number at a tick.
    fn widest_tick(&self) -> f64 {
        self.ticks.major.iter().map(|(_, label)| text_width(label, TICK_SIZE)).fold(0.0, f64::max)
    }

    /// Breaks the label of a vertical axis of a height into lines.
    fn upright_label(&self, height: f64) -> Vec<String> {
        wrap(&self.label, (height * 1.1).max(70.0), LABEL_SIZE, 3)
    }

    /// Returns the room that a vertical axis of a height needs beside its frame.
    pub(crate) fn room_beside(&self, height: f64) -> f64 {
        GAP + self.widest_tick()
            + 8.0
            + self.upright_label(height).len() as f64 * (LABEL_SIZE + 3.0)
    }

    /// Makes a horizontal axis of a width, with as many ticks as have room for their numbers.
    pub(crate) fn across(scale: AxisScale, width: f64, label: &str, unit: &str) -> DrawnAxis {
        let most = (width / 45.0) as usize;
        let candidates = (2..=most.max(3))
            .rev()
            .map(|target| DrawnAxis::new(scale, scale.ticks(target), label, unit));
        let mut fewest = None;
        for drawn in candidates {
            if !drawn.slanted(width) {
                return drawn;
            }
            fewest = Some(drawn);
        }
        fewest.unwrap_or_else(|| DrawnAxis::new(scale, scale.ticks(2), label, unit))
    }

    /// Says whether the numbers of a horizontal axis of a width have to be set at a slant to fit.
    fn slanted(&self, width: f64) -> bool {
        let mut places: Vec<(f64, f64)> = self
            .ticks
            .major
            .iter()
            .map(|(x, label)| (self.scale.fraction(*x) * width, text_width(label, TICK_SIZE)))
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.windows(2).any(|pair| pair[1].0 - pair[0].0 < (pair[0].1 + pair[1].1) / 2.0 + 4.0)
    }

    /// Returns the room that a horizontal axis of a width needs below its frame.
    pub(crate) fn room_below(&self, width: f64) -> f64 {
        let ticks = if self.slanted(width) {
            self.widest_tick() * SLANT.sin() + TICK_SIZE
        } else {
            TICK_SIZE
        };
        GAP + ticks
            + 6.0
            + wrap(&self.label, width * 1.1, LABEL_SIZE, 2).len() as f64 * (LABEL_SIZE + 3.0)
    }
}

/// The angle of slanted numbers, in radians.
const SLANT: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// Draws the light lines behind the curves.
pub(crate) fn grid(drawing: &mut Drawing, frame: Rect, x: &DrawnAxis, y: &DrawnAxis) {
    for (value, _) in &x.ticks.major {
        let x = frame.x + x.scale.fraction(*value) * frame.width;
        drawing.line((x, frame.y), (x, frame.bottom()), GRID, 0.7);
    }
    for (value, _) in &y.ticks.major {
        let y = frame.bottom() - y.scale.fraction(*value) * frame.height;
        drawing.line((frame.x, y), (frame.right(), y), GRID, 0.7);
    }
}

/// Draws the horizontal axis below a frame; `inward` says whether its ticks point into the frame.
pub(crate) fn below(drawing: &mut Drawing, frame: Rect, axis: &DrawnAxis, inward: bool) {
    let toward = if inward { -1.0 } else { 1.0 };
    let place = |value: f64| frame.x + axis.scale.fraction(value) * frame.width;
    for value in &axis.ticks.minor {
        drawing.line(
            (place(*value), frame.bottom()),
            (place(*value), frame.bottom() + toward * 2.5),
            INK,
            0.7,
        );
    }
    let slanted = axis.slanted(frame.width);
    for (value, label) in &axis.ticks.major {
        let x = place(*value);
        drawing.line((x, frame.bottom()), (x, frame.bottom() + toward * 4.5), INK, 0.8);
        let baseline = frame.bottom() + GAP + TICK_SIZE - 1.0;
        if slanted {
            let (x, y) = (n(x + 3.0), n(baseline - 1.0));
            let text = escape(label);
            drawing.push(&format!(
                r#"<text x="{x}" y="{y}" font-size="{TICK_SIZE}" text-anchor="end" transform="rotate(-35 {x} {y})">{text}</text>"#
            ));
        } else {
            drawing.text((x, baseline), TICK_SIZE, Anchor::Middle, label);
        }
    }
    let lines = wrap(&axis.label, frame.width * 1.1, LABEL_SIZE, 2);
    let first = frame.bottom() + axis.room_below(frame.width)
        - (lines.len() as f64 - 1.0) * (LABEL_SIZE + 3.0)
        - 3.0;
    for (i, line) in lines.iter().enumerate() {
        let middle = (frame.x + frame.width / 2.0, first + i as f64 * (LABEL_SIZE + 3.0));
        drawing.text(middle, LABEL_SIZE, Anchor::Middle, line);
    }
}

/// Draws the vertical axis at the left of a frame. `inward` says whether its ticks point into the
/// frame, `labelled` whether it has numbers and a label.
pub(crate) fn left(
    drawing: &mut Drawing,
    frame: Rect,
    axis: &DrawnAxis,
    inward: bool,
    labelled: bool,
) {
    let toward = if inward { 1.0 } else { -1.0 };
    let place = |value: f64| frame.bottom() - axis.scale.fraction(value) * frame.height;
    for value in &axis.ticks.minor {
        drawing.line((frame.x, place(*value)), (frame.x + toward * 2.5, place(*value)), INK, 0.7);
    }
    for (value, label) in &axis.ticks.major {
        let y = place(*value);
        drawing.line((frame.x, y), (frame.x + toward * 4.5, y), INK, 0.8);
        if labelled {
            drawing.text((frame.x - GAP, y + TICK_SIZE * 0.36), TICK_SIZE, Anchor::End, label);
        }
    }
    if labelled {
        let lines = axis.upright_label(frame.height);
        for (i, line) in lines.iter().enumerate() {
            let x = frame.x
                - GAP
                - axis.widest_tick()
                - 8.0
                - (lines.len() - 1 - i) as f64 * (LABEL_SIZE + 3.0);
            drawing.text_upwards((x, frame.y + frame.height / 2.0), LABEL_SIZE, line);
        }
    }
}
