//! Records to tables, figures and files.
//!
//! Everything here is a pure function from plain data to text or bytes: no files are opened, no
//! terminal is asked for its width, and the same input gives the same bytes on every machine.
//!
//! - [`DataTable`] is what a study left behind: named columns with units and rows of [`Cell`]s. It can
//!   be narrowed with [`select`](DataTable::select), [`sort`](DataTable::sort) and
//!   [`filter`](DataTable::filter) and written as text for a terminal, CSV or JSON.
//! - [`PlotFigure`] is a row of line charts, made by hand or from a table, drawn as SVG, with bands
//!   between bounds, fitted lines ([`fit`]) and the front of what is cheapest ([`pareto_front`]).
//! - [`Field`] is a quantity on a uniform grid, drawn as a map or written as NPY, VTK or CSV.
//! - [`png`](fn@png) turns either kind of SVG into a PNG with a font of its own, so that it looks
//!   the same everywhere.
//!
//! Values are SI throughout; prefixes (GPa, µm) are chosen only where a person reads them.
#![forbid(unsafe_code)]

mod axis;
mod delimited;
mod field;
mod filter;
pub mod fit;
mod font;
mod number;
mod palette;
mod pareto;
mod plot;
mod png;
mod svg;
mod table;
mod text;
mod unit;

pub use field::{Field, FieldError, FieldGrid, TerminalInk, Values, VtiError, field_csv, vti};
pub use filter::FilterError;
pub use pareto::pareto_front;
pub use plot::{
    BandPoint, FigureError, FigureSpec, PlotAxis, PlotBand, PlotFigure, PlotPanel, Series, Style,
};
pub use png::{PngError, png};
pub use table::{Cell, DataTable, TableColumn, TableError, TerminalLayout, UnknownColumn};
