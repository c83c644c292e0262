//! Rows by an expression: `mu > 0.3 && mesh == 64 && status == "certified"`.
//!
//! The grammar is that of the Common Expression Language (CEL, <https://cel.dev>), parsed by the
//! `cel` crate. The meaning is given here rather than by CEL's own interpreter, because a table of
//! measurements needs it otherwise in four places: integers and numbers mix in arithmetic, a column
//! may have a dotted name (`friction.mu`), comparing a number with text is refused instead of being
//! false, and a missing value makes a comparison unknown.

mod compile;
mod evaluate;
mod syntax;

use thiserror::Error;

use crate::table::{Table, UnknownColumn};
use compile::{LONGEST, compile};
use evaluate::{evaluate, truth};

/// Why a filter was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
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

impl Table {
    /// The rows for which an expression holds, in their order.
    ///
    /// Columns are called by their names, values are SI. Integers and numbers compare and compute
    /// with each other; a quotient is never rounded. Text stands in `"…"` or `'…'` and is compared
    /// exactly. Conditions are joined by `&&`, `||`, `!` and parentheses; there are also `in [1,
    /// 2]`, `a ? b : c`, `abs(x)`, `+ - * / %`, and `text.contains("…")`, `.startsWith`,
    /// `.endsWith`.
    ///
    /// A missing value (or NaN) makes whatever is computed from it unknown, as in SQL: neither `x >
    /// 1` nor `!(x > 1)` nor `x != 1` selects a row without `x`, but `x > 1 || y > 1` does if `y >
    /// 1`. `x == null` and `x != null` ask for it.
    ///
    /// # Errors
    /// [`FilterError`]; also for a comparison of a number with text, which could never hold.
    ///
    /// ```
    /// use report::{Cell, Column, Table};
    /// let table = Table::new(
    ///     vec![Column::new("mu", "1"), Column::new("mesh", "")],
    ///     vec![vec![0.1.into(), 64.into()], vec![0.4.into(), 64.into()], vec![0.5.into(), Cell::Missing]],
    /// )?;
    /// assert_eq!(table.filter("mu > 0.3 && mesh == 64")?.rows(), &[vec![0.4.into(), 64.into()]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn filter(&self, expression: &str) -> Result<Table, FilterError> {
        let condition = compile(expression, self)?;
        let keep = self
            .rows()
            .iter()
            .enumerate()
            .map(|(i, row)| {
                match evaluate(&condition, row) {
                    Ok(value) => truth(&condition, &value).map(|t| t == Some(true)),
                    Err(error) => Err(error),
                }
                .map_err(|message| FilterError::Mismatch(format!("{message} (in row {})", i + 1)))
            })
            .collect::<Result<Vec<bool>, _>>()?;
        Ok(self.keep(&keep))
    }
}
