//! A field as a coloured map.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::color::{Shade, colors};
use super::key::ColorKey;
use super::quantity::{Field, FieldGrid, Values};
use crate::axis::{self, AxisScale, DrawnAxis, INK, TICK_SIZE, TITLE_SIZE};
use crate::font::wrap;
use crate::svg::{Anchor, Drawing, Rect, n};
use crate::unit::PrefixedUnit;

/// The margin around the picture, in pixels as all lengths here.
const MARGIN: f64 = 10.0;
/// The length of the longer side of the map.
const SIDE: f64 = 300.0;
/// The least length of the shorter side. A map that needs it is out of proportion and says so.
const SHORTEST: f64 = 20.0;
/// The number of pixels that a side of the picture inside has about, so that viewers that smooth
/// pictures keep elements sharp.
const PICTURE: usize = 1024;
/// The largest number of pixels that an element has along a side.
const MOST_TIMES: usize = 64;

impl Field {
    /// Draws the field as SVG, in pixels of 1/96 inch: a map of equal scale in x and y with a
    /// colour bar or a legend.
    ///
    /// Numbers of one sign are coloured by viridis, numbers of both signs from blue through white
    /// to red with zero in the middle; elements without a value are white.
    pub fn svg(&self) -> String {
        let [length, breadth] = self.grid.lengths();
        let proportion = SIDE / length.max(breadth);
        let (width, height) =
            ((length * proportion).max(SHORTEST), (breadth * proportion).max(SHORTEST));
        let stretched = (width / height) / (length / breadth);
        let unit = {
            let ends = (0..2)
                .flat_map(|k| [self.grid.origin[k], self.grid.origin[k] + self.grid.lengths()[k]]);
            PrefixedUnit::fitting("m", ends.map(f64::abs).fold(0.0, f64::max))
        };
        let scale = |k: usize| {
            let ends = [self.grid.origin[k], self.grid.origin[k] + self.grid.lengths()[k]]
                .map(|x| unit.of_si(x));
            AxisScale { low: ends[0], high: ends[1], log: false }
        };
        let [across, down] = self.cut.names();
        let x = DrawnAxis::across(scale(0), width, across, &unit.name);
        // A section is drawn with the surface on top: its axis counts heights.
        let (upward, up) = if self.cut.is_section() {
            let AxisScale { low, high, log } = scale(1);
            (AxisScale { low: 0.0 - high, high: 0.0 - low, log }, "−z")
        } else {
            (scale(1), down)
        };
        let ticks = upward.ticks((height / 45.0) as usize);
        let y = DrawnAxis::new(upward, ticks, up, &unit.name);

        let beside = y.room_beside(height);
        let key = match &self.values {
            Values::Number(values) => ColorKey::bar(Shade::for_values(values), self, height),
            Values::Category { states, names } => ColorKey::states(states, names),
        };
        let left = MARGIN + beside;
        let total = left + width + 18.0 + key.width() + MARGIN;
        // A bar says what it shows; states need a title.
        let title = match &self.values {
            Values::Number(_) => Vec::new(),
            Values::Category { .. } => wrap(&self.title(), total - left - MARGIN, TITLE_SIZE, 2),
        };
        let top = MARGIN + 6.0 + title.len() as f64 * (TITLE_SIZE + 5.0);
        let frame = Rect { x: left, y: top, width, height };

        let mut drawing = Drawing::default();
        for (i, line) in title.iter().enumerate() {
            let baseline = MARGIN + TITLE_SIZE + i as f64 * (TITLE_SIZE + 5.0);
            drawing.text((left, baseline), TITLE_SIZE, Anchor::Start, line);
        }
        let mut colors = colors(&self.values);
        if self.cut.is_section() {
            colors = colors.chunks(self.grid.nx).rev().flatten().copied().collect();
        }
        drawing.push(&picture(frame, &self.grid, &colors));
        axis::below(&mut drawing, frame, &x, false);
        axis::left(&mut drawing, frame, &y, false, true);
        drawing.rect(frame, "none", INK, 0.9);
        key.draw(&mut drawing, frame.right() + 18.0, frame);

        let mut bottom = (frame.bottom() + x.room_below(width)).max(top + key.height());
        if !(0.99..1.01).contains(&stretched) {
            bottom += TICK_SIZE + 6.0;
            drawing.text(
                (MARGIN, bottom - 2.0),
                10.0,
                Anchor::Start,
                &format!("{across} and {down} are not drawn to the same scale"),
            );
        }
        drawing.finish(total, bottom + MARGIN, &self.title())
    }
}

/// Returns the elements as a picture inside the SVG: a file of a few kilobytes, however many
/// elements there are.
fn picture(frame: Rect, grid: &FieldGrid, colors: &[[u8; 3]]) -> String {
    let (across, down) =
        (PICTURE.div_ceil(grid.nx).min(MOST_TIMES), PICTURE.div_ceil(grid.ny).min(MOST_TIMES));
    let mut pixels = Vec::with_capacity(grid.nx * across * grid.ny * down * 3);
    for j in (0..grid.ny).rev() {
        let row: Vec<u8> = colors[j * grid.nx..(j + 1) * grid.nx]
            .iter()
            .flat_map(|c| std::iter::repeat_n(*c, across))
            .flatten()
            .collect();
        for _ in 0..down {
            pixels.extend_from_slice(&row);
        }
    }
    let size = |elements: usize, times: usize| u32::try_from(elements * times).ok();
    let (Some(width), Some(height)) = (size(grid.nx, across), size(grid.ny, down)) else {
        return String::new();
    };
    // A picture that cannot be packed (2³² pixels a side) leaves the map white; there is no smaller
    // one to draw.
    let Ok(png) = crate::png::encode(width, height, png::ColorType::Rgb, &pixels, None) else {
        return String::new();
    };
    format!(
        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
         image-rendering=\"optimizeSpeed\" xlink:href=\"data:image/png;base64,{}\"/>",
        n(frame.x),
        n(frame.y),
        n(frame.width),
        n(frame.height),
        BASE64_STANDARD.encode(png)
    )
}
