//! The reasons why a filter is refused.

use std::fmt;

use thiserror::Error;

/// The length of the longest expression, in bytes.
pub(crate) const LONGEST: usize = 16_384;

/// A column that was asked for is not in the table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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

/// A reason why a filter is refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FilterError {
    /// There is no expression.
    #[error("the expression is empty; write a condition such as `mu > 0.3 && mesh == 64`")]
    Empty,
    /// The expression is longer than any that a person writes.
    #[error("the expression has {length} bytes; at most {} are allowed", LONGEST)]
    TooLong {
        /// The length in bytes.
        length: usize,
    },
    /// The expression does not follow the grammar.
    #[error(
        "{message} at character {position}\n  {expression}\n  {caret:>position$}{hint}",
        caret = '^'
    )]
    Syntax {
        /// The fault.
        message: String,
        /// The whole expression, on one line.
        expression: String,
        /// The place of the fault, counted in characters from 1.
        position: usize,
        /// The way to write it, if that can be guessed: empty, or a line that begins with a line
        /// end.
        hint: String,
    },
    /// A name is not that of a column.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
    /// Two values of different kinds meet, or a value is of the wrong kind.
    #[error("{0}")]
    Mismatch(String),
    /// The grammar allows something that filters do not.
    #[error(
        "{0} cannot be used in a filter; there are == != < <= > >=, && || !, + - * / %, ?:, \
         in [..], abs(), and contains, startsWith, endsWith on text"
    )]
    Unsupported(String),
}
