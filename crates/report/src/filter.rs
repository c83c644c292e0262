//! Rows of a table by an expression: `mu > 0.3 && mesh == 64 && status == "certified"`.
//!
//! The crate `condition` says what the expression may be, and what it means; here the cells of a
//! row are its values.

use std::borrow::Cow;

use condition::{Condition, ConditionNames, FilterError, FilterValue, UnknownColumn, ValueKind};

use crate::table::{Cell, CellType, DataTable};

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
        Ok(self.keep(&self.holding(expression)?))
    }

    /// Says for each row whether an expression holds for it.
    ///
    /// # Errors
    /// Those of [`filter`](DataTable::filter).
    pub fn holding(&self, expression: &str) -> Result<Vec<bool>, FilterError> {
        self.truths(expression, |truth| truth == Some(true))
    }

    /// Returns the rows for which an expression may hold, in their order: those for which it holds,
    /// and those for which it is unknown because a value is missing.
    ///
    /// # Errors
    /// Those of [`filter`](DataTable::filter).
    pub fn filter_possible(&self, expression: &str) -> Result<DataTable, FilterError> {
        Ok(self.keep(&self.truths(expression, |truth| truth != Some(false))?))
    }

    /// Says for each row whether the truth of an expression, `None` where it is unknown, is
    /// wanted.
    fn truths(
        &self,
        expression: &str,
        is_wanted: impl Fn(Option<bool>) -> bool,
    ) -> Result<Vec<bool>, FilterError> {
        let condition = Condition::new(expression, self)?;
        self.rows()
            .iter()
            .enumerate()
            .map(|(i, row)| match condition.truth(&|column| value(&row[column])) {
                Ok(truth) => Ok(is_wanted(truth)),
                Err(message) => Err(FilterError::Mismatch(format!("{message} (in row {})", i + 1))),
            })
            .collect()
    }
}

impl ConditionNames for DataTable {
    fn find(&self, name: &str) -> Result<usize, UnknownColumn> {
        self.column(name)
    }

    fn kind(&self, index: usize) -> ValueKind {
        let mut kinds = self.cells(index).filter_map(|cell| match cell {
            Cell::Number(_) | Cell::Integer(_) => Some(ValueKind::Number),
            Cell::Flag(_) => Some(ValueKind::Truth),
            Cell::Text(_) => Some(ValueKind::Text),
            Cell::Missing => None,
        });
        match kinds.next() {
            Some(first) if kinds.all(|kind| kind == first) => first,
            _ => ValueKind::Unknown,
        }
    }
}

/// A column whose cells are all of one type, where they are not missing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilteredColumn<'c> {
    /// The name.
    pub name: &'c str,
    /// The type; `None` if the column mixes types, or if every cell is missing.
    pub cells: Option<CellType>,
}

/// Returns the texts of which a column of texts has one in each row for which an expression holds;
/// `None` if it may hold for other rows as well, or if it is not known to have a meaning for every
/// row of a table with these columns.
pub fn sought_texts(
    expression: &str,
    columns: &[FilteredColumn<'_>],
    column: &str,
) -> Option<Vec<String>> {
    let condition = Condition::new(expression, &TypedNames(columns)).ok()?;
    // In a row of another type the condition could be a mistake.
    if (0..columns.len()).any(|index| columns[index].cells.is_none() && condition.uses(index)) {
        return None;
    }
    let sought = columns.iter().position(|typed| typed.name == column)?;
    let texts = condition.texts_of(sought)?;
    Some(texts.into_iter().map(str::to_owned).collect())
}

/// The names of columns whose types are known.
struct TypedNames<'c>(&'c [FilteredColumn<'c>]);

impl ConditionNames for TypedNames<'_> {
    fn find(&self, name: &str) -> Result<usize, UnknownColumn> {
        self.0.iter().position(|column| column.name == name).ok_or_else(UnknownColumn::default)
    }

    fn kind(&self, index: usize) -> ValueKind {
        match self.0[index].cells {
            Some(CellType::Flag) => ValueKind::Truth,
            Some(CellType::Integer | CellType::Number) => ValueKind::Number,
            Some(CellType::Text) => ValueKind::Text,
            None => ValueKind::Unknown,
        }
    }
}

/// Returns the value of a cell in a condition.
fn value(cell: &Cell) -> FilterValue<'_> {
    match cell {
        Cell::Number(x) => FilterValue::Number(*x),
        Cell::Integer(i) => FilterValue::Integer(*i),
        Cell::Flag(yes) => FilterValue::Truth(*yes),
        Cell::Text(text) => FilterValue::Text(Cow::Borrowed(text)),
        Cell::Missing => FilterValue::Missing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_condition_says_which_texts_it_seeks() {
        let column = |name, cells| FilteredColumn { name, cells };
        let columns = [
            column("key", Some(CellType::Text)),
            column("mu", Some(CellType::Number)),
            column("mesh", None),
        ];
        let sought = |expression: &str| sought_texts(expression, &columns, "key");
        let texts = |texts: &[&str]| Some(texts.iter().map(|text| (*text).to_owned()).collect());
        assert_eq!(sought("key == \"a\""), texts(&["a"]));
        assert_eq!(sought("\"a\" == key && mu > 0.1"), texts(&["a"]));
        assert_eq!(sought("mu > 0.1 && key in [\"a\", \"b\"]"), texts(&["a", "b"]));
        assert_eq!(sought("key == \"a\" || key == \"b\" && mu > 0"), texts(&["a", "b"]));
        let others = [
            "mu > 0.1",
            "key == \"a\" || mu > 0.1",
            "key != \"a\"",
            "!(key == \"a\")",
            "key > \"a\"",
            "key.startsWith(\"a\")",
            "mu > 0.1 ? key == \"a\" : key == \"b\"",
            // Of these the meaning is not known.
            "key == \"a\" && mesh > 3",
            "key == \"a\" && mu == \"b\"",
            "key == \"a\" && other > 3",
            "key ==",
        ];
        for other in others {
            assert_eq!(sought(other), None, "{other}");
        }
    }
}
