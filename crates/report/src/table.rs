//! A table of named columns, which every output is made from, and its texts.
//!
//! The files read downwards: `cell`, `error`, `rows`, then one file for each form of output. They
//! know numbers and units, and neither charts nor filters.

mod cell;
mod csv;
mod error;
mod json;
mod packed;
mod parquet;
mod rows;
mod setting;
mod terminal;

pub use cell::Cell;
pub use error::TableError;
pub use packed::{packed_cells, picked_cells, unpacked_cells};
pub use parquet::{CellType, ParquetFault, ParquetFile, TypedColumn, WiderCell};
pub use rows::{DataTable, TableColumn};
pub use setting::TerminalLayout;
pub use terminal::set_in_blocks;
