//! The reasons why a table cannot be drawn.

use condition::UnknownColumn;
use thiserror::Error;

/// The largest number of panels that can be read.
pub(super) const MOST_PANELS: usize = 16;
/// The largest number of series that can be told apart, by colour and marker.
pub(super) const MOST_SERIES: usize = 56;

/// A reason why a table cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FigureError {
    /// A column that was asked for is not in the table.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
    /// No column is drawn along the vertical axis.
    #[error("the figure has no column along y; name at least one column of numbers")]
    NoY,
    /// The vertical axis has columns of different units.
    #[error(
        "columns `{a}` [{a_unit}] and `{b}` [{b_unit}] cannot share an axis; choose columns of one \
         unit"
    )]
    DifferentUnits {
        /// The name of the first column.
        a: String,
        /// The unit of `a`; `1` for a pure number.
        a_unit: String,
        /// The name of the first column with another unit.
        b: String,
        /// The unit of `b`; `1` for a pure number.
        b_unit: String,
    },
    /// There is nothing to draw.
    #[error(
        "no row has a value in both `{x}` and `{y}`, so there is nothing to draw ({rows} rows)"
    )]
    NothingToDraw {
        /// The name of the column along x.
        x: String,
        /// The names of the columns along y, separated by commas.
        y: String,
        /// The number of rows of the table.
        rows: usize,
    },
    /// There is nothing to count.
    #[error("no row has a value in `{column}`, so there is nothing to count ({rows} rows)")]
    NothingToCount {
        /// The name of the column.
        column: String,
        /// The number of rows of the table.
        rows: usize,
    },
    /// A column along the vertical axis has text.
    #[error(
        "column `{column}` has text, such as {example:?}, and cannot be drawn along y; choose a \
         column of numbers"
    )]
    TextOnY {
        /// The name of the column.
        column: String,
        /// One of the texts in the column.
        example: String,
    },
    /// A column with text, which has no logarithm, is on a logarithmic axis.
    #[error(
        "column `{column}` has text, such as {example:?}, so that its axis cannot be logarithmic"
    )]
    TextOnLog {
        /// The name of the column.
        column: String,
        /// One of the texts in the column.
        example: String,
    },
    /// A mark needs points with numbers along x, in any order, and the figure has none.
    #[error(
        "{what} cannot be shown along `{x}`, {why}; leave it out or choose another column for x"
    )]
    NotAlong {
        /// The mark, e.g. a fitted line.
        what: &'static str,
        /// The name of the column along x.
        x: String,
        /// The reason.
        why: String,
    },
    /// Every value is zero or negative on a logarithmic axis.
    #[error("column `{column}` has no positive value, so that its axis cannot be logarithmic")]
    NothingPositive {
        /// The name of the column.
        column: String,
    },
    /// There are more panels than can be read.
    #[error(
        "column `{column}` has {count} values, too many for a panel each; at most {MOST_PANELS} \
         are drawn: filter the rows or make it a series"
    )]
    TooManyPanels {
        /// The name of the column.
        column: String,
        /// The number of distinct values of the column.
        count: usize,
    },
    /// There are more series than can be told apart.
    #[error(
        "{columns} would make {count} series, too many to tell apart; at most {MOST_SERIES} are \
         drawn: filter the rows or leave a column out"
    )]
    TooManySeries {
        /// The names of the columns that tell the series apart.
        columns: String,
        /// The number of series that they would make.
        count: usize,
    },
}
