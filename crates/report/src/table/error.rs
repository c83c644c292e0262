//! The reasons why a table cannot be made, selected from or sorted.

use std::fmt;

use thiserror::Error;

/// A column that was asked for is not in the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownColumn {
    /// The name that was asked for.
    pub name: String,
    /// The columns with a similar name, closest first.
    pub close: Vec<String>,
    /// The names of all columns of the table.
    pub columns: Vec<String>,
}

impl fmt::Display for UnknownColumn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is no column `{}`", self.name)?;
        if self.close.is_empty() {
            match self.columns.as_slice() {
                [] => write!(f, "; the table has no columns"),
                columns => write!(f, "; the columns are {}", columns.join(", ")),
            }
        } else {
            write!(f, "; did you mean {}?", self.close.join(" or "))
        }
    }
}

impl std::error::Error for UnknownColumn {}

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
