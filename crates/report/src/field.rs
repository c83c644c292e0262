//! Fields: quantities on a grid, as maps, as characters and as files for other programs.
//!
//! The files read downwards: `cut`, `quantity`, `color`, `key`, then one file for each form of
//! output, `codes` for pages.
//! They know axes, units and SVG, and neither tables nor charts.

mod codes;
mod color;
mod cut;
mod export;
mod key;
mod map;
mod quantity;
mod terminal;

pub(crate) use codes::{FieldCodes, scales};
pub use cut::CutPlane;
pub use export::{SeriesFile, VtiError, field_csv, pvd, vti};
pub use quantity::{Field, FieldError, FieldGrid, Values};
pub use terminal::TerminalInk;
