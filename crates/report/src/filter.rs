//! Rows of a table by an expression: `mu > 0.3 && mesh == 64 && status == "certified"`.
//!
//! The grammar is that of the Common Expression Language (CEL, <https://cel.dev>), parsed by the
//! `cel` crate. The meaning is given here rather than by CEL's own interpreter, because a table of
//! measurements needs another one in four points: integers and numbers mix in arithmetic, a column
//! may have a dotted name (`friction.mu`), comparing a number with text is refused instead of being
//! false, and a missing value makes a comparison unknown.
//!
//! The files read downwards: `error`, `syntax`, `tree`, `compile`, `evaluate`. They know tables,
//! and neither charts nor fields.

mod compile;
mod error;
mod evaluate;
mod syntax;
mod tree;

use crate::table::DataTable;
use compile::compile;
pub use error::FilterError;
use evaluate::truth;

impl DataTable {
    /// Returns the rows for which an expression holds, in their order.
    ///
    /// Columns are called by their names, and values are SI. Integers and numbers compare and
    /// compute with each other; a quotient is never rounded. Text stands in `"…"` or `'…'` and is
    /// compared exactly. Conditions are joined by `&&`, `||`, `!` and parentheses. There are also
    /// `in [1, 2]`, `a ? b : c`, `abs(x)`, `+ - * / %`, and `text.contains("…")`, `.startsWith`,
    /// `.endsWith`.
    ///
    /// A missing value (or NaN) makes everything that is computed from it unknown, as in SQL:
    /// neither `x > 1` nor `!(x > 1)` nor `x != 1` selects a row without `x`, but `x > 1 || y > 1`
    /// does if `y > 1`. `x == null` and `x != null` ask for missing values.
    ///
    /// # Errors
    /// [`FilterError`], if the expression does not follow the grammar, names an unknown column, or
    /// joins values of kinds that do not fit. A comparison of a number with text, which could never
    /// hold, is such an error.
    ///
    /// ```
    /// use report::{Cell, DataTable, TableColumn};
    /// let table = DataTable::new(
    ///     vec![TableColumn::new("mu", "1"), TableColumn::new("mesh", "")],
    ///     vec![
    ///         vec![0.1.into(), 64.into()],
    ///         vec![0.4.into(), 64.into()],
    ///         vec![0.5.into(), Cell::Missing],
    ///     ],
    /// )?;
    /// assert_eq!(table.filter("mu > 0.3 && mesh == 64")?.rows(), &[vec![0.4.into(), 64.into()]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn filter(&self, expression: &str) -> Result<DataTable, FilterError> {
        self.keep_by(expression, |truth| truth == Some(true))
    }

    /// Returns the rows for which an expression may hold, in their order: those for which it holds,
    /// and those for which it is unknown because a value is missing.
    ///
    /// # Errors
    /// Those of [`filter`](DataTable::filter).
    pub fn filter_possible(&self, expression: &str) -> Result<DataTable, FilterError> {
        self.keep_by(expression, |truth| truth != Some(false))
    }

    /// Returns the rows for which the truth of an expression, `None` where it is unknown, is
    /// wanted.
    fn keep_by(
        &self,
        expression: &str,
        is_wanted: impl Fn(Option<bool>) -> bool,
    ) -> Result<DataTable, FilterError> {
        let condition = compile(expression, self)?;
        let keep = self
            .rows()
            .iter()
            .enumerate()
            .map(|(i, row)| match truth(&condition, row) {
                Ok(truth) => Ok(is_wanted(truth)),
                Err(message) => Err(FilterError::Mismatch(format!("{message} (in row {})", i + 1))),
            })
            .collect::<Result<Vec<bool>, _>>()?;
        Ok(self.keep(&keep))
    }
}
