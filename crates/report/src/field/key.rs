//! The key to the colours of a map.

use super::color::{Shade, state_color};
use super::quantity::Field;
use crate::axis::{AxisScale, DrawnAxis, INK, LABEL_SIZE, TICK_SIZE};
use crate::font::{shorten, text_width, wrap};
use crate::svg::{Anchor, Drawing, Rect};
use crate::unit::PrefixedUnit;

/// The width of the colour bar, in pixels as all lengths here.
const BAR: f64 = 14.0;

/// The key to the colours, to the right of the map.
pub(super) enum ColorKey {
    Bar { shade: Shade, axis: DrawnAxis, height: f64 },
    States(Vec<(usize, String)>),
}

impl ColorKey {
    /// Makes the colour bar of a field of numbers, beside a map of a height.
    pub(super) fn bar(shade: Shade, field: &Field, height: f64) -> ColorKey {
        let unit = PrefixedUnit::fitting(&field.unit, shade.low.abs().max(shade.high.abs()));
        let scale =
            AxisScale { low: unit.of_si(shade.low), high: unit.of_si(shade.high), log: false };
        let height = height.max(120.0);
        let axis = DrawnAxis::new(scale, scale.ticks(6), &field.title(), &unit.name);
        ColorKey::Bar { shade, axis, height }
    }

    /// Makes the list of the states that occur, in their order.
    pub(super) fn states(states: &[u8], names: &[String]) -> ColorKey {
        let occurs = |state: usize| states.iter().any(|&s| usize::from(s) == state);
        let present = names.iter().enumerate().filter(|(state, _)| occurs(*state));
        ColorKey::States(
            present.map(|(state, name)| (state, shorten(name, 160.0, TICK_SIZE))).collect(),
        )
    }

    pub(super) fn width(&self) -> f64 {
        match self {
            ColorKey::Bar { axis, height, .. } => BAR + axis.room_beside(*height) + 4.0,
            ColorKey::States(states) => {
                20.0 + states
                    .iter()
                    .map(|(_, name)| text_width(name, TICK_SIZE))
                    .fold(0.0, f64::max)
            }
        }
    }

    pub(super) fn height(&self) -> f64 {
        match self {
            ColorKey::Bar { height, .. } => *height,
            ColorKey::States(states) => states.len() as f64 * 18.0,
        }
    }

    /// Draws the key from `left` on, beside the frame of the map.
    pub(super) fn draw(&self, drawing: &mut Drawing, left: f64, frame: Rect) {
        match self {
            ColorKey::Bar { shade, axis, height } => {
                let bar = Rect { x: left, y: frame.y, width: BAR, height: *height };
                draw_bar(drawing, bar, shade, axis);
            }
            ColorKey::States(states) => {
                for (i, (state, name)) in states.iter().enumerate() {
                    let y = frame.y + i as f64 * 18.0;
                    let [r, g, b] = state_color(*state);
                    let swatch = Rect { x: left, y, width: 13.0, height: 13.0 };
                    drawing.rect(swatch, &format!("#{r:02x}{g:02x}{b:02x}"), INK, 0.7);
                    drawing.text((left + 20.0, y + 10.5), TICK_SIZE, Anchor::Start, name);
                }
            }
        }
    }
}

/// Draws the colour bar with its axis to the right.
fn draw_bar(drawing: &mut Drawing, bar: Rect, shade: &Shade, axis: &DrawnAxis) {
    drawing.push("<defs><linearGradient id=\"shade\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">");
    for i in 0..=32 {
        let [r, g, b] = shade.color(f64::from(i) / 32.0);
        drawing.push(&format!(
            "<stop offset=\"{}\" stop-color=\"#{r:02x}{g:02x}{b:02x}\"/>",
            f64::from(i) / 32.0
        ));
    }
    drawing.push("</linearGradient></defs>");
    drawing.rect(bar, "url(#shade)", INK, 0.9);
    let mut widest: f64 = 0.0;
    for (value, label) in &axis.ticks.major {
        let y = bar.bottom() - axis.scale.fraction(*value) * bar.height;
        drawing.line((bar.right(), y), (bar.right() + 4.0, y), INK, 0.8);
        let beside = (bar.right() + 7.0, y + TICK_SIZE * 0.36);
        drawing.text(beside, TICK_SIZE, Anchor::Start, label);
        widest = widest.max(text_width(label, TICK_SIZE));
    }
    for (i, line) in wrap(&axis.label, bar.height * 1.1, LABEL_SIZE, 3).iter().enumerate() {
        let x = bar.right() + 7.0 + widest + LABEL_SIZE + 4.0 + i as f64 * (LABEL_SIZE + 3.0);
        drawing.text_upwards((x, bar.y + bar.height / 2.0), LABEL_SIZE, line);
    }
}
