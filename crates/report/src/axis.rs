//! The axes of charts and maps: their range, their ticks, and the frame that they make.
//!
//! The files read downwards: `scale`, `ticks`, `frame`. They know the font, numbers and SVG, and
//! neither charts nor fields.

mod frame;
mod scale;
mod ticks;

pub(crate) use frame::{DrawnAxis, INK, LABEL_SIZE, TICK_SIZE, TITLE_SIZE, below, grid, left};
pub(crate) use scale::{AxisScale, LARGEST, drawable};
pub(crate) use ticks::Ticks;
