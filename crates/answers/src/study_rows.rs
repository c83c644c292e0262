//! The rows of a study for which a condition holds, of which some columns are read at a time.

use report::DataTable;
use study::{Column, Study, StudyPoint};

use crate::accounts::Accounts;
use crate::block::{POINTS_AT_ONCE, ResultBlock, records_of, visit};
use crate::error::AnswerError;
use crate::records::Records;
use crate::rows::heads;
use crate::tabled::{ROWS_OF_A_BLOCK, TabledRows, rows_of_table};

/// The numbers of points whose records are read at a time, and of rows of a table at least.
const AT_ONCE: [usize; 2] = [POINTS_AT_ONCE, ROWS_OF_A_BLOCK];

/// The cells of a table that are read at a time, in whole blocks of its rows.
const CELLS_AT_ONCE: usize = 1 << 17;

/// The rows of a study for which a condition holds, in the order of its points. They are counted
/// from 0, and read again whenever they are asked for, unless they are few.
pub struct StudyRows<'r> {
    study: &'r Study,
    columns: Vec<Column>,
    held: HeldRows<'r>,
    /// The numbers of the points for which the condition holds; `None` if it holds for all.
    chosen: Option<Vec<usize>>,
    count: usize,
    /// The number of points whose records are read at a time, and of rows of a table at least.
    at_once: [usize; 2],
}

/// The place where rows come from.
pub(crate) enum HeldRows<'r> {
    /// All of them are here, with every column.
    Whole(DataTable),
    /// They are made of records.
    Records(&'r dyn Records),
    /// They are those of a table.
    Table(&'r dyn TabledRows),
}

impl<'r> StudyRows<'r> {
    /// Chooses the rows for which a condition holds.
    ///
    /// # Errors
    /// The condition cannot be evaluated, or the rows cannot be read.
    pub(crate) fn of(
        study: &'r Study,
        held: HeldRows<'r>,
        filter: Option<&str>,
    ) -> Result<Self, AnswerError> {
        let columns = study.columns();
        let count = match &held {
            HeldRows::Whole(table) => table.rows().len(),
            HeldRows::Records(_) => study.point_count(),
            HeldRows::Table(table) => table.row_count(),
        };
        let mut all = StudyRows { study, columns, held, chosen: None, count, at_once: AT_ONCE };
        let Some(filter) = filter else { return Ok(all) };
        if let HeldRows::Whole(table) = &all.held {
            let table = table.filter(filter)?;
            all.count = table.rows().len();
            all.held = HeldRows::Whole(table);
            return Ok(all);
        }
        // The names in the condition are checked against all columns.
        DataTable::new(heads(&all.columns), Vec::new())?.filter(filter)?;
        let is_mentioned = |name: &&str| filter.contains(name);
        let names: Vec<&str> =
            all.columns.iter().map(|column| column.name.as_ref()).filter(is_mentioned).collect();
        let mut chosen = Vec::new();
        all.visit(&names, &mut |first, block| {
            let rows = (first..).zip(block.holding(filter)?).filter(|(_, holds)| *holds);
            chosen.extend(rows.map(|(row, _)| row));
            Ok::<bool, AnswerError>(true)
        })?;
        all.count = chosen.len();
        all.chosen = Some(chosen);
        Ok(all)
    }

    /// Returns the rows as they are read a few at a time: so many points with their records, and
    /// about a hundred times as many cells of a table.
    pub fn in_blocks_of(self, points: usize) -> Self {
        StudyRows { at_once: [points, points], ..self }
    }

    /// Returns the columns that there are.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Returns the number of rows.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns whether every visit of some rows makes them of their records, so that one visit of
    /// many columns takes less time than one of each.
    pub fn are_made_anew(&self) -> bool {
        matches!(self.held, HeldRows::Records(_))
    }

    /// Visits the rows with some columns, a block of them at a time with the number of its first
    /// row, until the visitor returns false.
    ///
    /// # Errors
    /// There is no such column, the rows cannot be read, or the visitor fails.
    pub fn visit<E: From<AnswerError>>(
        &self,
        names: &[&str],
        visitor: &mut dyn FnMut(usize, &DataTable) -> Result<bool, E>,
    ) -> Result<(), E> {
        let columns = self.named(names)?;
        match &self.held {
            HeldRows::Whole(table) => {
                visitor(0, &table.select(names).map_err(AnswerError::from)?).map(drop)
            }
            HeldRows::Table(table) => {
                let blocks = CELLS_AT_ONCE / names.len().max(1) / ROWS_OF_A_BLOCK;
                let at_once = self.at_once[1] * blocks.max(1);
                for first in (0..self.count).step_by(at_once) {
                    let rows = self.points(first..self.count.min(first + at_once));
                    if !visitor(first, &rows_of_table(*table, &columns, &rows)?)? {
                        break;
                    }
                }
                Ok(())
            }
            HeldRows::Records(records) => {
                let (mut point, mut row) = (0, 0);
                let visited = visit(self.study, *records, self.at_once[0], &mut |block| {
                    let (start, first) = (point, row);
                    point += block.points.len();
                    let mut rows = block.rows(&columns);
                    if let Some(chosen) = &self.chosen {
                        row += chosen[row..].partition_point(|chosen| *chosen < point);
                        let is_chosen =
                            |number: &usize| chosen[first..row].binary_search(number).is_ok();
                        let numbered = (start..).zip(rows).filter(|(number, _)| is_chosen(number));
                        rows = numbered.map(|(_, row)| row).collect();
                    } else {
                        row = point;
                    }
                    let rows = DataTable::new(heads(&columns), rows).map_err(AnswerError::from)?;
                    visitor(first, &rows)
                });
                visited.map(drop)
            }
        }
    }

    /// Returns some rows, whose numbers ascend, with some columns.
    ///
    /// # Errors
    /// There is no such column, or the rows cannot be read.
    pub fn at(&self, names: &[&str], rows: &[usize]) -> Result<DataTable, AnswerError> {
        let columns = self.named(names)?;
        let rows: Vec<usize> = rows.iter().copied().filter(|row| *row < self.count).collect();
        match &self.held {
            HeldRows::Whole(table) => {
                let rows = rows.iter().map(|row| table.rows()[*row].clone()).collect();
                Ok(DataTable::new(table.columns().to_vec(), rows)?.select(names)?)
            }
            HeldRows::Table(table) => {
                let rows: Vec<usize> =
                    rows.iter().flat_map(|row| self.points(*row..row + 1)).collect();
                rows_of_table(*table, &columns, &rows)
            }
            HeldRows::Records(source) => {
                let mut made = DataTable::new(heads(&columns), Vec::new())?;
                for rows in rows.chunks(ROWS_OF_A_BLOCK) {
                    let points = rows.iter().flat_map(|row| self.points(*row..row + 1));
                    let points: Vec<StudyPoint> = points
                        .filter_map(|position| self.study.point(self.study.index(position)?))
                        .collect();
                    let records = records_of(&points, *source)?;
                    let mut accounts = Accounts::default();
                    accounts.read(records.values(), *source);
                    let block =
                        ResultBlock { points: &points, records: &records, accounts: &accounts };
                    let rows = DataTable::new(heads(&columns), block.rows(&columns))?;
                    made = made.followed_by(rows);
                }
                Ok(made)
            }
        }
    }

    /// Returns the numbers of the points of some rows.
    fn points(&self, rows: std::ops::Range<usize>) -> Vec<usize> {
        match &self.chosen {
            Some(chosen) => chosen[rows].to_vec(),
            None => rows.collect(),
        }
    }

    fn named(&self, names: &[&str]) -> Result<Vec<Column>, AnswerError> {
        let none = AnswerError::Inconsistent("the study lacks a column");
        let column = |name: &&str| self.columns.iter().find(|column| column.name == *name).cloned();
        names.iter().map(column).collect::<Option<_>>().ok_or(none)
    }
}
