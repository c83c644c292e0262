//! Rows of tables, made of points and records.

use report::{Cell, DataTable};
use study::columns::Row;
use study::{Column, Record, StudyPoint, Value};

use crate::accounts::Accounts;
use crate::error::AnswerError;

/// Returns a table of one row.
pub(crate) fn single(
    columns: &[Column],
    point: &StudyPoint,
    record: Option<&Record>,
) -> Result<DataTable, AnswerError> {
    Ok(DataTable::new(
        heads(columns),
        vec![row(columns, &Row { point, record, compared: None, account: None })],
    )?)
}

/// Returns a table of the increments of results: a row for each, as the result would be if its path
/// ended there.
///
/// # Errors
/// Two columns share a name.
pub fn increments<'r>(
    columns: &[Column],
    accounts: &Accounts,
    results: impl IntoIterator<Item = (&'r StudyPoint, &'r Record)>,
) -> Result<DataTable, AnswerError> {
    let mut rows = Vec::new();
    for (point, record) in results {
        let account = accounts.of(record);
        record.along_path(|increment| {
            rows.push(row(
                columns,
                &Row { point, record: Some(increment), compared: None, account },
            ))
        });
    }
    Ok(DataTable::new(heads(columns), rows)?)
}

/// Returns the heads of a table with these columns.
pub(crate) fn heads(columns: &[Column]) -> Vec<report::TableColumn> {
    columns
        .iter()
        .map(|column| report::TableColumn::new(column.name.as_ref(), column.unit()))
        .collect()
}

/// Returns the cells of a row, one for each column.
pub(crate) fn row(columns: &[Column], row: &Row<'_>) -> Vec<Cell> {
    columns.iter().map(|column| cell(column.value_of(row))).collect()
}

/// Returns a value as a cell.
pub(crate) fn cell(value: Value) -> Cell {
    match value {
        Value::Number(x) => Cell::Number(x),
        Value::Integer(n) => i64::try_from(n).map_or(Cell::Number(n as f64), Cell::Integer),
        Value::Flag(yes) => Cell::Flag(yes),
        Value::Text(text) => Cell::Text(text),
        Value::Missing => Cell::Missing,
    }
}

/// Returns a number with `decimals` digits after its first one: so few digits are no noise.
pub fn digits(x: f64, decimals: usize) -> f64 {
    format!("{x:.decimals$e}").parse().unwrap_or(x)
}

/// Returns a rounded number as a cell, an empty one for none.
pub(crate) fn rounded(x: Option<f64>, decimals: usize) -> Cell {
    x.map_or(Cell::Missing, |x| Cell::Number(digits(x, decimals)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_counted_after_the_first() {
        assert_eq!([0, 1, 2].map(|decimals| digits(0.012_345, decimals)), [0.01, 0.012, 0.0123]);
        assert_eq!(digits(f64::INFINITY, 2), f64::INFINITY);
    }
}
