//! Why a table cannot be drawn.

use thiserror::Error;

use crate::table::UnknownColumn;

pub(super) const MOST_PANELS: usize = 16;
pub(super) const MOST_SERIES: usize = 56;

/// Why a table could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FigureError {
    /// A column was asked for that is not there.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
    /// No column is drawn along the vertical axis.
    #[error("the figure has no column along y; name at least one column of numbers")]
    NoY,
    /// The vertical axis has columns of different units.
    #[error(
        "columns `{a}` [{a_unit}] and `{b}` [{b_unit}] cannot share an axis; choose columns of one unit"
    )]
    DifferentUnits {
        /// The first column.
        a: String,
        /// Its unit, `1` for a pure number.
        a_unit: String,
        /// The first column with another unit.
        b: String,
        /// Its unit.
        b_unit: String,
    },
    /// There is nothing to draw.
    #[error(
        "no row has a value in both `{x}` and `{y}`, so there is nothing to draw ({rows} rows)"
    )]
    NothingToDraw {
        /// The column along x.
        x: String,
        /// The columns along y, separated by commas.
        y: String,
        /// The number of rows looked at.
        rows: usize,
    },
    /// The vertical axis has text.
    #[error(
        "column `{column}` has text, such as {example:?}, and cannot be drawn along y; choose a column of numbers"
    )]
    TextOnY {
        /// The column.
        column: String,
        /// One of its values.
        example: String,
    },
    /// Text has no logarithm.
    #[error(
        "column `{column}` has text, such as {example:?}, so that its axis cannot be logarithmic"
    )]
    TextOnLog {
        /// The column.
        column: String,
        /// One of its values.
        example: String,
    },
    /// What needs points with numbers along x, in any order, was asked for without them.
    #[error(
        "{what} cannot be shown along `{x}`, {why}; leave it out or choose another column for x"
    )]
    NotAlong {
        /// What was asked for.
        what: &'static str,
        /// The column along x.
        x: String,
        /// Why not.
        why: String,
    },
    /// Every value is zero or negative on a logarithmic axis.
    #[error("column `{column}` has no positive value, so that its axis cannot be logarithmic")]
    NothingPositive {
        /// The column.
        column: String,
    },
    /// More panels than can be read.
    #[error(
        "column `{column}` has {count} values, too many for a panel each; at most {MOST_PANELS} are drawn: filter the rows or make it a series"
    )]
    TooManyPanels {
        /// The column.
        column: String,
        /// Its number of distinct values.
        count: usize,
    },
    /// More series than can be told apart.
    #[error(
        "{columns} would make {count} series, too many to tell apart; at most {MOST_SERIES} are drawn: filter the rows or leave a column out"
    )]
    TooManySeries {
        /// The columns that tell the series apart.
        columns: String,
        /// Their number of distinct combinations.
        count: usize,
    },
}
