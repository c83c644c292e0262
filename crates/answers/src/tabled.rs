//! The rows of a study as a table that is kept beside its records.

use identity::JobKey;
use report::{Cell, CellType, DataTable};
use serde::{Deserialize, Serialize};
use study::{Column, RunAccount, Study};

use crate::accounts::Accounts;
use crate::error::AnswerError;
use crate::records::RecordsError;
use crate::rows::{cell, heads};
use crate::warnings::Warning;

/// The number of rows that are kept at once.
pub const ROWS_OF_A_BLOCK: usize = 1024;

/// A column of a table that was kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TabledColumn {
    /// The name.
    pub name: String,
    /// The type of its cells; `None` if they are of several types, or all missing.
    pub cells: Option<CellType>,
}

/// The knowledge of the results of a study whose points are compared with nothing that its rows do
/// not have, or that it takes long to read from them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurveyNotes {
    /// The number of points that are solved.
    pub(crate) done: usize,
    /// The number of points whose job has ended without a solution.
    pub(crate) failed: usize,
    /// The number of points without a result.
    pub(crate) left: usize,
    pub(crate) warnings: Vec<Warning>,
    /// The relative change below which a quantity counts as constant.
    pub(crate) noise: f64,
    /// Some record has its fields in a file.
    pub(crate) has_files: bool,
    /// The number of points that are solved and whose record has no fields.
    pub(crate) fieldless: usize,
    /// Some loading path has several increments.
    pub(crate) has_paths: bool,
    /// The usual columns of the points, and of their increments.
    pub(crate) usual: [Vec<String>; 2],
}

impl SurveyNotes {
    /// Returns the columns that answer the question at a glance, of the points or of their
    /// increments (`steps`).
    pub fn usual_columns(&self, steps: bool) -> &[String] {
        &self.usual[usize::from(steps)]
    }
}

/// A table of every point of a study, in their order, that was made of its records.
pub trait TabledRows {
    /// Returns the number of rows.
    fn row_count(&self) -> usize;

    /// Returns the columns that the table has.
    fn columns(&self) -> &[TabledColumn];

    /// Returns the cells that some rows have in some columns, both by their numbers. The numbers of
    /// the rows ascend.
    ///
    /// # Errors
    /// The table is damaged, or cannot be read.
    fn rows(&self, columns: &[usize], rows: &[usize]) -> Result<Vec<Vec<Cell>>, RecordsError>;

    /// Returns the numbers of the rows of a job in ascending order.
    ///
    /// # Errors
    /// The table is damaged, or cannot be read.
    fn rows_of(&self, key: &JobKey) -> Result<Vec<usize>, RecordsError>;

    /// Returns the accounts of the runs that computed the results.
    fn accounts(&self) -> Accounts;
}

/// A place that keeps the rows of a study as they are made of its records.
pub trait RowKeeper {
    /// Begins a table with these columns, in place of what was begun before.
    fn begin(&self, columns: &[Column]);

    /// Returns whether rows are kept; they are not if they cannot be.
    fn is_keeping(&self) -> bool;

    /// Keeps the rows of the next points, given with the keys of their jobs: [`ROWS_OF_A_BLOCK`] of
    /// them, or fewer at the end.
    fn keep(&self, keys: &[JobKey], rows: &[Vec<Cell>]);

    /// Ends the table, which has all points, with the accounts of the runs that computed them, and
    /// with what is known of the results beside.
    fn end(&self, accounts: &Accounts, notes: Option<&SurveyNotes>);
}

/// Reads some rows of a table, with some of its columns.
pub(crate) fn rows_of_table(
    table: &dyn TabledRows,
    columns: &[Column],
    rows: &[usize],
) -> Result<DataTable, AnswerError> {
    let number = |column: &Column| table.columns().iter().position(|has| has.name == column.name);
    let numbers: Option<Vec<usize>> = columns.iter().map(number).collect();
    let numbers = numbers.ok_or(AnswerError::Inconsistent("the table lacks a column"))?;
    let rows = table.rows(&numbers, rows).map_err(AnswerError::Records)?;
    Ok(DataTable::new(heads(columns), rows)?)
}

/// Returns the columns of a study that a table has: those whose values follow from a point and its
/// record alone.
pub fn tabled_columns(study: &Study) -> Vec<Column> {
    let mut columns = study.columns();
    columns.retain(|column| !column.is_compared() && !column.is_of_account());
    columns
}

/// Returns the columns of a study that say by whom a result was computed, with their cells in the
/// rows of a run with this account.
pub fn cells_of_account(study: &Study, account: Option<&RunAccount>) -> Vec<(String, Cell)> {
    let columns = study.columns().into_iter().filter(Column::is_of_account);
    columns
        .map(|column| (column.name.to_string(), cell(column.value_of_account(account))))
        .collect()
}
