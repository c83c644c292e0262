//! The proof of a table by the records.

use std::cell::RefCell;
use std::io;

use answers::{Accounts, RowKeeper, SurveyNotes, TabledRows};
use identity::JobKey;
use report::{Cell, packed_cells};
use store::KeptTable;
use study::Column;

use crate::study_table::{CellsSoFar, StudyTable};

/// The comparison of a table with the rows that are made of the records anew.
pub(crate) struct TableProof<'t> {
    table: &'t StudyTable,
    seen: RefCell<SeenRows>,
}

/// The rows that were compared so far.
#[derive(Default)]
struct SeenRows {
    rows: usize,
    columns: Vec<CellsSoFar>,
    differ: bool,
    is_ended: bool,
}

impl<'t> TableProof<'t> {
    /// Begins to compare a table.
    pub(crate) fn of(table: &'t StudyTable) -> Self {
        TableProof { table, seen: RefCell::default() }
    }

    /// Returns whether all rows were seen, and the table has these and no others.
    pub(crate) fn holds(&self) -> bool {
        let seen = self.seen.borrow();
        seen.is_ended && !seen.differ
    }

    /// Returns whether the table has some rows, of which the first has the number `start`.
    fn has(&self, start: usize, keys: &[JobKey], rows: &[Vec<Cell>]) -> io::Result<bool> {
        let table = &self.table.table;
        for column in 0..table.column_count() {
            let packed = packed_cells(rows.iter().map(|row| &row[column]));
            if packed != Some(table.piece(column, start / KeptTable::BLOCK)?) {
                return Ok(false);
            }
        }
        for (row, key) in (start..).zip(keys) {
            if !table.rows_of(key)?.contains(&row) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl RowKeeper for TableProof<'_> {
    fn begin(&self, columns: &[Column]) {
        let columns = vec![CellsSoFar::Missing; columns.len()];
        self.seen.replace(SeenRows { columns, ..SeenRows::default() });
    }

    fn is_keeping(&self) -> bool {
        !self.seen.borrow().differ
    }

    fn keep(&self, keys: &[JobKey], rows: &[Vec<Cell>]) {
        let mut seen = self.seen.borrow_mut();
        seen.differ |= !self.has(seen.rows, keys, rows).unwrap_or(false);
        seen.rows += rows.len();
        for row in rows {
            seen.columns.iter_mut().zip(row).for_each(|(cells, cell)| *cells = cells.with(cell));
        }
    }

    fn end(&self, accounts: &Accounts, notes: Option<&SurveyNotes>) {
        let mut seen = self.seen.borrow_mut();
        let of_table = self.table.columns().iter().take(seen.columns.len());
        let types = of_table.map(|column| column.cells);
        let runs = accounts.listed().into_iter().map(|(run, _)| run);
        seen.differ |= seen.rows != self.table.row_count()
            || !seen.columns.iter().map(|cells| cells.all()).eq(types)
            || !runs.eq(&self.table.runs)
            || notes != self.table.notes();
        seen.is_ended = true;
    }
}
