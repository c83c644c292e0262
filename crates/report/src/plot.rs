//! Line charts.
//!
//! The files read downwards: `figure` says what a chart is; `error`, `spec`, `value_text`,
//! `groups`, `histogram`, `from_table` and `bars_from_table` make one from a table; `canvas`, what
//! is drawn on it (`band`, `bars`, `front`, `level`, `slope`, `curve`, `names`), `legend`, `panel`
//! and `layout` turn it into SVG, and `sketch` says where its points are. They know tables, fits,
//! axes and SVG, and neither fields nor filters.

mod band;
mod bars;
mod bars_from_table;
mod canvas;
mod curve;
mod error;
mod figure;
mod from_table;
mod front;
mod groups;
mod histogram;
mod layout;
mod legend;
mod level;
mod names;
mod panel;
mod sketch;
mod slope;
mod spec;
mod value_text;

pub use bars_from_table::{BarColumns, BarsSpec};
pub use error::FigureError;
pub use figure::{BandPoint, PlotAxis, PlotBand, PlotFigure, PlotPanel, Series, Style};
pub use sketch::{FigureSketch, FigureSpot, SketchAxis};
pub use spec::{FigureForm, FigureSpec};
