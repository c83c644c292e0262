//! Records to tables, figures and files.
//!
//! Everything here is a pure function from plain data to text or bytes: no files are opened, no
//! terminal is asked for its width, and the same input gives the same bytes on every machine.
//!
//! - [`DataTable`] holds the results of a study: named columns with units and rows of [`Cell`]s. It
//!   can be narrowed with [`select`](DataTable::select), [`sort`](DataTable::sort) and
//!   [`filter`](DataTable::filter) and written as text for a terminal, CSV or
//!   JSON, and block by block as Parquet ([`ParquetFile`]).
//! - [`PlotFigure`] is a row of line charts, made by hand or from a table, drawn as SVG, with bands
//!   between bounds, fitted lines ([`fit`]) and the front of the cheapest points
//!   ([`pareto_front`]).
//! - [`Field`] is a quantity on a uniform grid, drawn as a map or written as NPY, VTK or CSV.
//! - [`Page`] is a page of HTML that holds words, tables, figures and fields, and asks nobody for
//!   anything.
//! - [`png`](fn@png) turns either kind of SVG into a PNG with a font of its own, so that it looks
//!   the same everywhere.
//!
//! Values are SI throughout; prefixes (GPa, µm) are chosen only where a person reads them.
//!
//! # Why the charts are our own
//!
//! A kept library is better than our own code outside our purpose, and charts are outside it. They
//! are our own all the same, for three reasons. A figure must be the same bytes on every machine,
//! so that a test can hold it and a diff can show it; that needs one embedded font, measured here,
//! and coordinates rounded here. Figures of this field need bands between proved bounds that may be
//! open upwards, Pareto fronts with names beside their points where there is room, and fitted
//! slopes with their errors in the legend; a plotting library has lines and areas, and the arrows,
//! stairs, rings, names and slopes would be drawn by us on top of it. And a point that cannot be
//! drawn must be counted in the figure, not dropped silently.
//!
//! The price is about 2500 lines of code, 3200 with their comments, a fifth of which draws the maps
//! of fields too, and their upkeep: every kind of chart that a library has for nothing, such as
//! error bars, histograms or contours, would have to be written. If byte-stable figures are no
//! longer wanted, or if charts of many kinds are, the decision should be taken anew.
#![forbid(unsafe_code)]

mod axis;
mod delimited;
mod field;
mod filter;
pub mod fit;
mod font;
mod number;
mod page;
mod palette;
mod pareto;
mod plot;
mod png;
mod svg;
mod table;
mod text;
mod unit;

pub use condition::{FilterError, UnknownColumn};
pub use field::{
    CutPlane, Field, FieldError, FieldGrid, SeriesFile, TerminalInk, Values, VtiError, field_csv,
    pvd, vti,
};
pub use filter::{FilteredColumn, sought_texts};
pub use page::{
    ColumnRoom, FittedTable, JobColumn, JobMaps, JobTable, Page, PageBlock, PageFigure,
    PageSection, quantity_words,
};
pub use pareto::{NoisyPoint, pareto_front, pareto_front_within};
pub use plot::{
    BandPoint, BarColumns, BarsSpec, FigureError, FigureForm, FigureSketch, FigureSpec, FigureSpot,
    PlotAxis, PlotBand, PlotFigure, PlotPanel, Series, SketchAxis, Style,
};
pub use png::{PngError, png};
pub use table::{
    Cell, CellType, DataTable, ParquetFault, ParquetFile, TableColumn, TableError, TerminalLayout,
    TypedColumn, WiderCell, packed_cells, picked_cells, set_in_blocks, unpacked_cells,
};
