//! The table that a store keeps of a study's rows, so that a query need not read its records.
//!
//! A table is the study's as long as the records, the definition of the study, the physics and the
//! program are those with which it was made. It has the columns that follow from a point and its
//! record alone; those of the accounts of runs are read of these.

use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::io;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use answers::{
    Accounts, AnswerError, Progress, ROWS_OF_A_BLOCK, RecordsError, RowKeeper, SurveyNotes,
    TabledColumn, TabledRows, cells_of_account, survey, tabled_columns,
};
use anyhow::{Context, Result};
use identity::JobKey;
use rayon::prelude::*;
use report::{Cell, CellType, packed_cells, picked_cells};
use serde::{Deserialize, Serialize};
use store::{Blobs, Digest, Glance, KeptTable, StoreReader, TableBuilder};
use study::account::run_name;
use study::job::PHYSICS_VERSION;
use study::{Column, Standing, Study};

use crate::machine::build_words;
use crate::stored::{StoreSource, account};

/// The version of the form of the tables.
const FORM: u32 = 3;

/// The number of rows that are counted at once.
const ROWS_AT_ONCE: usize = 65_536;

const _: () = assert!(ROWS_OF_A_BLOCK == KeptTable::BLOCK);

/// The words at the head of a table.
#[derive(Deserialize, Serialize)]
struct TableCaption {
    /// The names of the columns with the types of their cells.
    columns: Vec<(String, CellsSoFar)>,
    /// The usual columns of the study, if they were known and follow from these rows alone.
    usual: Option<Vec<String>>,
    /// The digests of the accounts of the runs that computed the results.
    runs: Vec<[u8; 32]>,
    /// The knowledge of the results beside the rows, if the points are compared with nothing.
    notes: Option<SurveyNotes>,
}

/// The type that the cells of a column have had so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) enum CellsSoFar {
    /// All were missing.
    Missing,
    /// All had this type, or were missing.
    Alike(CellType),
    /// There were texts, numbers or flags beside each other.
    Mixed,
}

impl CellsSoFar {
    /// Returns the type of cells of which one more has come.
    pub(crate) fn with(self, cell: &Cell) -> Self {
        use CellType::{Integer, Number};
        match (self, cell.cell_type()) {
            (before, None) => before,
            (Self::Missing, Some(cells)) => Self::Alike(cells),
            (Self::Alike(before), Some(cells)) if before == cells => self,
            (Self::Alike(Integer | Number), Some(Integer | Number)) => Self::Alike(Number),
            _ => Self::Mixed,
        }
    }

    /// Returns the type of all cells that are not missing, if there is one.
    pub(crate) fn all(self) -> Option<CellType> {
        match self {
            Self::Alike(cells) => Some(cells),
            Self::Missing | Self::Mixed => None,
        }
    }
}

/// Returns the digest of all that a table depends on beside the records.
fn meaning(definition: &Digest) -> Digest {
    let words = format!("{FORM} {PHYSICS_VERSION} {definition} {}", build_words());
    Digest::of(words.as_bytes())
}

/// A table of a study that holds.
pub(crate) struct StudyTable {
    pub(crate) table: KeptTable,
    /// The columns of the table, and behind them those that say by whom a result was computed.
    columns: Vec<TabledColumn>,
    /// The cells of each column behind those of the table, by the name of the run.
    of_runs: Vec<HashMap<String, Cell>>,
    /// The column of the table with the name of the run.
    run: usize,
    usual: Option<Vec<String>>,
    pub(crate) runs: Vec<[u8; 32]>,
    notes: Option<SurveyNotes>,
    blobs: Blobs,
    /// The column of the table with the key of the job.
    key: usize,
    /// The keys of the rows that were found by them.
    found: Mutex<HashMap<usize, JobKey>>,
}

impl StudyTable {
    /// Opens the table of a study in a store that no process is writing, and reads the study;
    /// `None` if there is no table that holds.
    pub(crate) fn of(directory: &Path, name: &str) -> Option<(StudyTable, Study)> {
        Self::at_a_glance(&Glance::at(directory)?, name)
    }

    /// Opens the table of a study that a glance shows, and reads the study.
    pub(crate) fn at_a_glance(glance: &Glance, name: &str) -> Option<(StudyTable, Study)> {
        let definition = glance.definition(name)?;
        let table = glance.table(name, &meaning(definition))?;
        let decoded =
            bincode::serde::decode_from_slice(table.caption(), bincode::config::standard());
        let (TableCaption { columns, usual, runs, notes }, _) = decoded.ok()?;
        let bytes = glance.blobs().get(definition).ok()??;
        // Every point was assembled when the table was made.
        let study = Study::from_sound_definition(&bytes).ok()?;
        let names = tabled_columns(&study);
        let is_same = table.column_count() == columns.len()
            && columns.iter().map(|(name, _)| name).eq(names.iter().map(|column| &*column.name));
        if !is_same {
            return None;
        }
        let column =
            |(name, cells): (String, CellsSoFar)| TabledColumn { name, cells: cells.all() };
        let columns: Vec<TabledColumn> = columns.into_iter().map(column).collect();
        let place = |name: &str| columns.iter().position(|column| column.name == name);
        let (run, key) = (place("run")?, place("key")?);
        let (of_runs, blobs, found) = (Vec::new(), glance.blobs().clone(), Mutex::default());
        let mut table =
            StudyTable { table, columns, of_runs, run, usual, runs, notes, blobs, key, found };
        table.add_accounts(&study);
        Some((table, study))
    }

    /// Adds the columns that say by whom a result was computed, unless two runs have one name.
    fn add_accounts(&mut self, study: &Study) {
        let accounts = self.accounts();
        let listed = accounts.listed();
        let names: HashSet<String> = listed.iter().map(|(run, _)| run_name(run)).collect();
        if names.len() < listed.len() {
            return;
        }
        for (name, _) in cells_of_account(study, None) {
            self.columns.push(TabledColumn { name, cells: None });
            self.of_runs.push(HashMap::new());
        }
        for (run, account) in listed {
            let cells = cells_of_account(study, account).into_iter();
            for (of_run, (_, cell)) in self.of_runs.iter_mut().zip(cells) {
                of_run.insert(run_name(run), cell);
            }
        }
    }

    /// Returns the cells that some rows of a block of so many have in a column.
    fn cells(
        &self,
        column: usize,
        block: usize,
        count: usize,
        rows: &[usize],
    ) -> io::Result<Vec<Cell>> {
        let other = || io::Error::other("the table has other cells");
        if column == self.key
            && let Some(keys) = self.known_keys(rows)
        {
            return Ok(keys);
        }
        let start = block * KeptTable::BLOCK;
        let picked: Vec<usize> = rows.iter().map(|row| row.saturating_sub(start)).collect();
        let behind = column.checked_sub(self.table.column_count());
        let stored = if behind.is_some() { self.run } else { column };
        let piece = self.table.piece(stored, block)?;
        let mut cells = picked_cells(&piece, count, &picked).ok_or_else(other)?;
        if let Some(behind) = behind {
            let of_runs = self.of_runs.get(behind).ok_or_else(other)?;
            for cell in &mut cells {
                *cell = match cell {
                    Cell::Text(run) => of_runs.get(run).cloned().ok_or_else(other)?,
                    _ => Cell::Missing,
                };
            }
        }
        Ok(cells)
    }

    /// Returns the keys of some rows if all of them were found by their keys: those of a block are
    /// texts that take long to read.
    fn known_keys(&self, rows: &[usize]) -> Option<Vec<Cell>> {
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        rows.iter().map(|row| Some(Cell::Text(found.get(row)?.to_string()))).collect()
    }

    /// Returns the usual columns of the study, if they are known.
    pub(crate) fn usual_columns(&self) -> Option<&[String]> {
        let noted = self.notes.as_ref().map(|notes| notes.usual_columns(false));
        self.usual.as_deref().or(noted)
    }

    /// Returns what was noted of the results beside the rows, if the points of the study are
    /// compared with nothing.
    pub(crate) fn notes(&self) -> Option<&SurveyNotes> {
        self.notes.as_ref()
    }

    /// Counts the points by how their jobs have ended; `None` if the table is damaged.
    pub(crate) fn progress(&self, study: &Study) -> Option<Progress> {
        let status = self.columns.iter().position(|column| column.name == "status")?;
        let mut progress = Progress { excluded: study.excluded(), ..Progress::default() };
        let certified = Standing::Certified.to_string();
        for start in (0..self.row_count()).step_by(ROWS_AT_ONCE) {
            let end = self.row_count().min(start + ROWS_AT_ONCE);
            let rows = self.rows(&[status], &(start..end).collect::<Vec<_>>()).ok()?;
            for cell in rows.iter().flatten() {
                match cell {
                    Cell::Missing => progress.left += 1,
                    Cell::Text(status) if *status == certified => progress.done += 1,
                    _ => progress.failed += 1,
                }
            }
        }
        progress.points = self.row_count();
        Some(progress)
    }

    /// Reads all cells of some columns, and fails if some of them are damaged.
    pub(crate) fn verify(&self, columns: &[Column]) -> io::Result<()> {
        let number = |column: &Column| {
            let number = self.columns.iter().position(|has| has.name == column.name);
            number.filter(|number| *number < self.table.column_count()).unwrap_or(self.run)
        };
        let numbers: BTreeSet<usize> = columns.iter().map(number).collect();
        let numbers: Vec<usize> = numbers.into_iter().collect();
        numbers.into_par_iter().try_for_each(|number| self.table.verify_column(number))
    }

    /// Returns the rows with some numbers, all of one block.
    fn rows_of_block(&self, columns: &[usize], rows: &[usize]) -> io::Result<Vec<Vec<Cell>>> {
        let Some(block) = rows.first().map(|row| row / KeptTable::BLOCK) else {
            return Ok(Vec::new());
        };
        let start = block * KeptTable::BLOCK;
        let count = self.table.row_count().saturating_sub(start).min(KeptTable::BLOCK);
        let mut made: Vec<Vec<Cell>> =
            rows.iter().map(|_| Vec::with_capacity(columns.len())).collect();
        for column in columns {
            let cells = self.cells(*column, block, count, rows)?;
            made.iter_mut().zip(cells).for_each(|(row, cell)| row.push(cell));
        }
        Ok(made)
    }
}

impl TabledRows for StudyTable {
    fn row_count(&self) -> usize {
        self.table.row_count()
    }

    fn columns(&self) -> &[TabledColumn] {
        &self.columns
    }

    fn rows(&self, columns: &[usize], rows: &[usize]) -> Result<Vec<Vec<Cell>>, RecordsError> {
        let blocks: Vec<&[usize]> =
            rows.chunk_by(|a, b| a / KeptTable::BLOCK == b / KeptTable::BLOCK).collect();
        let made: io::Result<Vec<_>> =
            blocks.into_par_iter().map(|rows| self.rows_of_block(columns, rows)).collect();
        Ok(made?.into_iter().flatten().collect())
    }

    fn rows_of(&self, key: &JobKey) -> Result<Vec<usize>, RecordsError> {
        let rows = self.table.rows_of(key)?;
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        found.extend(rows.iter().map(|row| (*row, *key)));
        Ok(rows)
    }

    fn accounts(&self) -> Accounts {
        let mut accounts = Accounts::default();
        accounts.read_of(&self.runs, |run| account(&self.blobs, run));
        accounts
    }
}

/// The keeper of the table of a study whose records are read. What goes wrong costs the table
/// alone, which is made another time.
pub(crate) struct TableKeeper<'r> {
    reader: &'r StoreReader,
    name: String,
    meaning: Digest,
    /// The records that come later can change the table.
    is_chosen: bool,
    usual: RefCell<Option<Vec<String>>>,
    draft: RefCell<Option<TableDraft>>,
}

/// A table that is being made.
struct TableDraft {
    builder: TableBuilder,
    columns: Vec<(String, CellsSoFar)>,
    status: Option<usize>,
    /// Some point has no record.
    has_gaps: bool,
}

impl<'r> TableKeeper<'r> {
    /// Returns the keeper for a whole study in a store.
    pub(crate) fn of(reader: &'r StoreReader, study: &Study) -> Self {
        TableKeeper {
            reader,
            name: study.name().to_owned(),
            meaning: meaning(&Digest::of(&study.definition())),
            is_chosen: study.adaptive().is_some(),
            usual: RefCell::default(),
            draft: RefCell::default(),
        }
    }

    /// Notes the usual columns of the study, which follow from its rows alone.
    pub(crate) fn set_usual_columns(&self, names: Vec<String>) {
        self.usual.replace(Some(names));
    }

    /// Makes the table of a study whose points are compared with nothing, block by block, and
    /// returns what is noted of its results, whether the table can be kept or not.
    ///
    /// # Errors
    /// A record cannot be read.
    pub(crate) fn make(reader: &'r StoreReader, study: &Study) -> Result<SurveyNotes, AnswerError> {
        survey(study, &StoreSource::Reader(reader), Some(&TableKeeper::of(reader, study)))
    }

    fn finish(
        &self,
        draft: TableDraft,
        accounts: &Accounts,
        notes: Option<&SurveyNotes>,
    ) -> Result<()> {
        let TableDraft { builder, columns, has_gaps, .. } = draft;
        let runs = accounts.listed().into_iter().map(|(run, _)| *run);
        let usual = self.usual.borrow().clone();
        let (runs, notes) = (runs.collect(), notes.cloned());
        let caption = TableCaption { columns, usual, runs, notes };
        let caption = bincode::serde::encode_to_vec(caption, bincode::config::standard())?;
        Ok(builder.finish(&self.name, &self.meaning, caption, !has_gaps && !self.is_chosen)?)
    }
}

impl TableDraft {
    fn add(&mut self, keys: &[JobKey], rows: &[Vec<Cell>]) -> Result<()> {
        let pieces: Option<Vec<Vec<u8>>> = (0..self.columns.len())
            .into_par_iter()
            .map(|column| packed_cells(rows.iter().map(|row| &row[column])))
            .collect();
        for row in rows {
            for ((_, cells), cell) in self.columns.iter_mut().zip(row) {
                *cells = cells.with(cell);
            }
            self.has_gaps |= self.status.is_none_or(|status| row[status] == Cell::Missing);
        }
        Ok(self.builder.push(keys, &pieces.context("a text is too long")?)?)
    }
}

impl RowKeeper for TableKeeper<'_> {
    fn begin(&self, columns: &[Column]) {
        let draft = self.reader.table_builder(columns.len()).map(|builder| TableDraft {
            builder,
            columns: columns
                .iter()
                .map(|column| (column.name.to_string(), CellsSoFar::Missing))
                .collect(),
            status: columns.iter().position(|column| column.name == "status"),
            has_gaps: false,
        });
        self.draft.replace(draft);
    }

    fn is_keeping(&self) -> bool {
        self.draft.borrow().is_some()
    }

    fn keep(&self, keys: &[JobKey], rows: &[Vec<Cell>]) {
        let mut draft = self.draft.borrow_mut();
        if draft.as_mut().is_some_and(|draft| draft.add(keys, rows).is_err()) {
            draft.take();
        }
    }

    fn end(&self, accounts: &Accounts, notes: Option<&SurveyNotes>) {
        if let Some(draft) = self.draft.take() {
            let _ = self.finish(draft, accounts, notes);
        }
    }
}

/// Returns whether a study's usual columns follow from the rows that a table has.
pub(crate) fn has_plain_columns(study: &Study) -> bool {
    study.columns().iter().all(|column| !column.is_compared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_alike_or_mixed() {
        let of = |cells: &[Cell]| cells.iter().fold(CellsSoFar::Missing, CellsSoFar::with);
        assert_eq!(of(&[Cell::Missing]), CellsSoFar::Missing);
        assert_eq!(of(&[1.into(), Cell::Missing]), CellsSoFar::Alike(CellType::Integer));
        assert_eq!(of(&[1.into(), 0.5.into()]), CellsSoFar::Alike(CellType::Number));
        assert_eq!(of(&[0.5.into(), 1.into()]), CellsSoFar::Alike(CellType::Number));
        assert_eq!(of(&["a".into(), "b".into()]), CellsSoFar::Alike(CellType::Text));
        assert_eq!(of(&[1.into(), "b".into(), 1.into()]), CellsSoFar::Mixed);
        assert_eq!(of(&[true.into(), 1.into()]), CellsSoFar::Mixed);
    }
}
