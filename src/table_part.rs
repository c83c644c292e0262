//! The rows of a part of a study in the table of the whole.

use answers::{Accounts, RecordsError, TabledColumn, TabledRows};
use identity::JobKey;
use report::Cell;
use study::Study;

use crate::study_table::StudyTable;

/// The rows of a part of a study in the table of the whole.
pub(crate) struct TablePart<'t> {
    table: &'t StudyTable,
    /// The numbers of the rows, which ascend.
    rows: Vec<usize>,
}

impl<'t> TablePart<'t> {
    /// Returns the rows of a part of the study that a table is of; `None` if it has others.
    pub(crate) fn of(table: &'t StudyTable, whole: &Study, part: &Study) -> Option<Self> {
        if whole.adaptive().is_some() {
            // Its rows are not those of the axes, and those of a part follow from its own results.
            return None;
        }
        let mut rows = Vec::with_capacity(part.point_count());
        let mut all = whole.indices().enumerate();
        for index in part.indices() {
            rows.push(all.by_ref().find(|(_, of_whole)| *of_whole == index)?.0);
        }
        rows.last()
            .is_none_or(|last| *last < table.row_count())
            .then_some(TablePart { table, rows })
    }
}

impl TabledRows for TablePart<'_> {
    fn row_count(&self) -> usize {
        self.rows.len()
    }

    fn columns(&self) -> &[TabledColumn] {
        self.table.columns()
    }

    fn rows(&self, columns: &[usize], rows: &[usize]) -> Result<Vec<Vec<Cell>>, RecordsError> {
        let none = || RecordsError::from("the part has no such row");
        let rows: Option<Vec<usize>> =
            rows.iter().map(|row| self.rows.get(*row).copied()).collect();
        self.table.rows(columns, &rows.ok_or_else(none)?)
    }

    fn rows_of(&self, key: &JobKey) -> Result<Vec<usize>, RecordsError> {
        let rows = self.table.rows_of(key)?;
        Ok(rows.iter().filter_map(|row| self.rows.binary_search(row).ok()).collect())
    }

    fn accounts(&self) -> Accounts {
        self.table.accounts()
    }
}
