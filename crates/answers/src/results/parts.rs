//! The points, rows and records of a study a few at a time, wherever they are held.

use contact::model::Fields;
use identity::JobKey;
use report::{Cell, DataTable};
use study::{Figure, Record, StudyPoint};

use super::{HeldResults, Results};
use crate::block::POINTS_AT_ONCE;
use crate::error::AnswerError;
use crate::records::{RecordMap, RecordsError};
use crate::study_rows::{HeldRows, StudyRows};
use crate::survey::leaves_fields;
use crate::tabled::ROWS_OF_A_BLOCK;

impl Results<'_> {
    /// Visits the points of the study in their order, a block of them at a time.
    ///
    /// # Errors
    /// The visitor fails.
    pub fn visit_points<E>(
        &self,
        visitor: &mut dyn FnMut(&[StudyPoint]) -> Result<(), E>,
    ) -> Result<(), E> {
        if let HeldResults::Whole { points, .. } = &self.held {
            return visitor(points);
        }
        self.study.point_blocks(POINTS_AT_ONCE).try_for_each(|points| visitor(&points))
    }

    /// Returns the rows of the points for which a condition holds. Where a table or records are
    /// read in blocks, one block is in memory at a time.
    ///
    /// # Errors
    /// The condition cannot be evaluated, or the rows cannot be read.
    pub fn rows(&self, filter: Option<&str>) -> Result<StudyRows<'_>, AnswerError> {
        let held = match &self.held {
            HeldResults::Whole { .. } => {
                let columns = self.study.columns();
                let names: Vec<&str> = columns.iter().map(|column| column.name.as_ref()).collect();
                HeldRows::Whole(self.table(&names)?)
            }
            HeldResults::Survey(survey) => survey.held(self.source),
        };
        StudyRows::of(&self.study, held, filter)
    }

    /// Returns the keys of the jobs in the rows that a figure is drawn from, which are those of
    /// `table`.
    ///
    /// # Errors
    /// The filter cannot be evaluated, or the rows cannot be read.
    pub fn figure_keys(
        &self,
        figure: &Figure,
        filter: Option<&str>,
        table: &DataTable,
    ) -> Result<Vec<Cell>, AnswerError> {
        let keys = if table.column("key").is_ok() {
            table.select(&["key"])?
        } else {
            let filter = figure.filtered(filter);
            let names: Vec<&str> = ["key"].into_iter().chain(filter.as_deref()).collect();
            let keys = self.table(&names)?;
            match &filter {
                Some(filter) => keys.filter(filter)?,
                None => keys,
            }
            .select(&["key"])?
        };
        Ok(keys.rows().iter().flatten().cloned().collect())
    }

    /// Returns the records of some jobs of the study, as far as they have left some.
    ///
    /// # Errors
    /// A record cannot be read.
    pub fn records_of(&self, keys: &[JobKey]) -> Result<RecordMap, AnswerError> {
        match &self.held {
            HeldResults::Whole { records, .. } => {
                let record = |key: &JobKey| Some((*key, records.get(key)?.clone()));
                Ok(keys.iter().filter_map(record).collect())
            }
            HeldResults::Survey(_) => self.source.select(keys).map_err(AnswerError::Records),
        }
    }

    /// Returns the fields that the job of a record has left.
    ///
    /// # Errors
    /// It has left none, or they cannot be read.
    pub fn fields_of(&self, record: &Record) -> Result<Fields, RecordsError> {
        self.source.fields(record)
    }

    /// Says of some jobs of the study whether they have left fields.
    ///
    /// # Errors
    /// A record cannot be read.
    pub fn have_fields(&self, keys: &[JobKey]) -> Result<Vec<bool>, AnswerError> {
        if let HeldResults::Whole { records, .. } = &self.held {
            return Ok(keys
                .iter()
                .map(|key| records.get(key).is_some_and(leaves_fields))
                .collect());
        }
        let mut have = Vec::with_capacity(keys.len());
        for keys in keys.chunks(ROWS_OF_A_BLOCK) {
            let records = self.source.select(keys).map_err(AnswerError::Records)?;
            have.extend(keys.iter().map(|key| records.get(key).is_some_and(leaves_fields)));
        }
        Ok(have)
    }

    /// Returns whether some loading path has several increments.
    pub fn have_paths(&self) -> bool {
        let is_path =
            |record: &Record| record.outcome().is_some_and(|outcome| outcome.steps.len() > 1);
        match &self.held {
            HeldResults::Whole { .. } => self.of_points().any(is_path),
            HeldResults::Survey(survey) => survey.notes.has_paths,
        }
    }

    /// Returns whether every job that is solved is known to have left fields.
    pub fn all_have_fields(&self) -> bool {
        match &self.held {
            HeldResults::Whole { .. } => false,
            HeldResults::Survey(survey) => survey.notes.fieldless == 0,
        }
    }
}
