//! The results of a study as a command reads them: from the table that is kept of it where that has
//! what is asked, else from its records.

use std::cell::OnceCell;
use std::path::Path;

use answers::{
    AnswerError, POINTS_IN_MEMORY, RecordMap, Records, RecordsError, Results, RowSource, Selection,
    TabledRows,
};
use anyhow::Result;
use contact::model::Fields;
use identity::JobKey;
use store::{Glance, StoreReader, StudyLabels};
use study::{Column, Record, RunAccount, Study};

use crate::stored::{StoreSource, read_store, stored_large_study, too_large};
use crate::study_table::{StudyTable, TableKeeper};

/// The records of a store, which is opened when they are first asked for.
struct RecordsWhenAsked<'a> {
    directory: &'a Path,
    reader: OnceCell<StoreReader>,
}

impl RecordsWhenAsked<'_> {
    fn reader(&self) -> Result<&StoreReader> {
        if let Some(reader) = self.reader.get() {
            return Ok(reader);
        }
        let reader = read_store(self.directory)?;
        Ok(self.reader.get_or_init(|| reader))
    }
}

impl Records for RecordsWhenAsked<'_> {
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError> {
        StoreSource::Reader(self.reader()?).select(keys)
    }

    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
        StoreSource::Reader(self.reader()?).matching(is_wanted)
    }

    fn fields(&self, record: &Record) -> Result<Fields, RecordsError> {
        StoreSource::Reader(self.reader()?).fields(record)
    }

    fn account(&self, run: &[u8; 32]) -> Option<RunAccount> {
        StoreSource::Reader(self.reader().ok()?).account(run)
    }
}

/// A study of a store with the place from which its results are read.
pub(crate) struct StoredResults<'a> {
    study: Study,
    labels: StudyLabels,
    /// The table, if it has what the results of the study say.
    table: Option<StudyTable>,
    records: RecordsWhenAsked<'a>,
}

impl<'a> StoredResults<'a> {
    /// Finds a study in a store. A table of many points that are compared with nothing is made if
    /// there is none, so that not all of their results are in memory.
    pub(crate) fn of(directory: &'a Path, name: &str) -> Result<Self> {
        Self::found(directory, name, Study::is_listed)
    }

    fn found(directory: &'a Path, name: &str, is_small: fn(&Study) -> bool) -> Result<Self> {
        let known = || Self::known(directory, name).filter(|known| is_small(&known.study));
        if let Some(known) = known() {
            return Ok(known);
        }
        let records = RecordsWhenAsked { directory, reader: OnceCell::new() };
        let reader = records.reader()?;
        let study = stored_large_study(reader, name)?;
        if !is_small(&study) {
            return Err(too_large(reader, &study));
        }
        if study.has_independent_points() && study.point_count() > POINTS_IN_MEMORY {
            TableKeeper::make(reader, &study)?;
            if let Some(known) = known() {
                // The store is open already.
                return Ok(StoredResults { records, ..known });
            }
        }
        let labels = reader.labels()?.remove(name).unwrap_or_default();
        Ok(StoredResults { study, labels, table: None, records })
    }

    /// Finds a study in a store like [`of`](StoredResults::of), for a reader that goes over every
    /// column of every point, some of them several times. The study may have as many points as one
    /// run takes.
    pub(crate) fn with_every_column(directory: &'a Path, name: &str) -> Result<Self> {
        let is_small = |study: &Study| {
            study.is_listed() || study.is_one_run() && study.has_independent_points()
        };
        let mut stored = Self::found(directory, name, is_small)?;
        let columns = stored.study.columns();
        let has_all = |table: &StudyTable| {
            let has = |column: &Column| table.columns().iter().any(|has| has.name == column.name);
            columns.iter().all(has) && table.verify(&columns).is_ok()
        };
        stored.table = stored.table.filter(has_all);
        Ok(stored)
    }

    /// Finds a study of which there is a table that has what its results say.
    fn known(directory: &'a Path, name: &str) -> Option<Self> {
        let glance = Glance::at(directory)?;
        let (table, study) = StudyTable::at_a_glance(&glance, name)?;
        table.notes()?;
        let (labels, table) = (glance.labels(name), Some(table));
        let records = RecordsWhenAsked { directory, reader: OnceCell::new() };
        Some(StoredResults { study, labels, table, records })
    }

    /// Returns the study.
    pub(crate) fn study(&self) -> &Study {
        &self.study
    }

    /// Returns the labels of the study.
    pub(crate) fn labels(&self) -> &StudyLabels {
        &self.labels
    }

    /// Returns whether the rows of all points are more than a command has in memory.
    pub(crate) fn are_long(&self) -> bool {
        self.study.has_independent_points() && self.study.point_count() > POINTS_IN_MEMORY
    }

    /// Returns the results.
    pub(crate) fn read(&self) -> Result<Results<'_>, AnswerError> {
        let study = self.study.clone();
        match &self.table {
            Some(table) => {
                let notes = table.notes().cloned().unwrap_or_default();
                Ok(Results::of_table(study, notes, table, &self.records))
            }
            None => Results::in_blocks(study, &self.records),
        }
    }

    /// Returns the source of the rows and columns of a selection.
    pub(crate) fn rows_of(&self, selection: &Selection) -> RowSource<'_> {
        match selection.steps {
            true => RowSource::Records { records: &self.records, keeper: None },
            false => self.rows(&selection.columns),
        }
    }

    /// Returns the source of the rows of some columns.
    pub(crate) fn rows(&self, columns: &[String]) -> RowSource<'_> {
        let is_meant = |column: &Column| columns.iter().any(|name| *name == column.name);
        let columns: Vec<_> = self.study.columns().into_iter().filter(is_meant).collect();
        // What was written to a pipe cannot be taken back.
        if let Some(table) = self.table.as_ref().filter(|table| table.verify(&columns).is_ok()) {
            return RowSource::Table(table);
        }
        RowSource::Records { records: &self.records, keeper: None }
    }
}
