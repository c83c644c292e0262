//! Rows of tables, from points and records.

use report::{Cell, DataTable};
use study::columns::Row;
use study::{Column, Record, StudyPoint, Value};

use crate::error::AnswerError;

/// One row by itself, as a table.
pub(crate) fn table(
    columns: &[Column],
    point: &StudyPoint,
    record: Option<&Record>,
) -> Result<DataTable, AnswerError> {
    Ok(DataTable::new(heads(columns), vec![row(columns, &Row { point, record, compared: None })])?)
}

/// A table of the increments of results.
pub fn increments<'r>(
    columns: &[Column],
    results: impl IntoIterator<Item = (&'r StudyPoint, &'r Record)>,
) -> Result<DataTable, AnswerError> {
    let mut rows = Vec::new();
    for (point, record) in results {
        record.along_path(|increment| {
            rows.push(row(columns, &Row { point, record: Some(increment), compared: None }))
        });
    }
    Ok(DataTable::new(heads(columns), rows)?)
}

pub(crate) fn heads(columns: &[Column]) -> Vec<report::TableColumn> {
    columns
        .iter()
        .map(|column| report::TableColumn::new(column.name.as_ref(), column.unit()))
        .collect()
}

pub(crate) fn row(columns: &[Column], row: &Row<'_>) -> Vec<Cell> {
    columns.iter().map(|column| cell(column.value_of(row))).collect()
}

pub(crate) fn cell(value: Value) -> Cell {
    match value {
        Value::Number(x) => Cell::Number(x),
        Value::Integer(n) => i64::try_from(n).map_or(Cell::Number(n as f64), Cell::Integer),
        Value::Text(text) => Cell::Text(text),
        Value::Missing => Cell::Missing,
    }
}

/// So many digits after the first.
pub fn digits(x: f64, more: usize) -> f64 {
    format!("{x:.more$e}").parse().unwrap_or(x)
}
