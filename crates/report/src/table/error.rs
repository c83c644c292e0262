//! The reasons why a table cannot be made, selected from or sorted.

use condition::UnknownColumn;
use thiserror::Error;

/// A reason why a table cannot be made, selected from or sorted.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TableError {
    /// Two columns share a name, so that neither can be asked for.
    #[error("column `{0}` occurs twice; every column needs a name of its own")]
    Duplicate(String),
    /// A row is longer or shorter than the header.
    #[error("row {row} has {found} cells, but there are {expected} columns")]
    RowLength {
        /// The index of the row, from 0.
        row: usize,
        /// The number of cells of the row.
        found: usize,
        /// The number of columns.
        expected: usize,
    },
    /// A column that was asked for is not in the table.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
}
