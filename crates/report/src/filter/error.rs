//! Why a filter is refused.

use thiserror::Error;

use crate::table::UnknownColumn;

/// The longest expression, in bytes.
pub(super) const LONGEST: usize = 4096;

/// Why a filter was refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FilterError {
    /// There is no expression.
    #[error("the expression is empty; write a condition such as `mu > 0.3 && mesh == 64`")]
    Empty,
    /// The expression is longer than any that a person writes.
    #[error("the expression has {length} bytes; at most {} are allowed", LONGEST)]
    TooLong {
        /// Its length in bytes.
        length: usize,
    },
    /// The expression does not follow the grammar.
    #[error(
        "{message} at character {position}\n  {expression}\n  {caret:>position$}{hint}",
        caret = '^'
    )]
    Syntax {
        /// What was wrong.
        message: String,
        /// The whole expression, on one line.
        expression: String,
        /// Where, counted in characters from 1.
        position: usize,
        /// What would be right, if that can be guessed: empty, or a line that begins with a line
        /// end.
        hint: String,
    },
    /// A name is not that of a column.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
    /// Two values of different kinds meet, or a value of the wrong kind.
    #[error("{0}")]
    Mismatch(String),
    /// The grammar allows it, filters do not.
    #[error(
        "{0} cannot be used in a filter; there are == != < <= > >=, && || !, + - * / %, ?:, in [..], abs(), and contains, \
         startsWith, endsWith on text"
    )]
    Unsupported(String),
}
