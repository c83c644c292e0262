//! The points of a study together with what their jobs have left.

use contact::model::{Fields, StepOutcome};
use study::{Case, Record, Study, StudyPoint};

use crate::error::AnswerError;
use crate::records::{RecordMap, Records};

/// The points of a study together with what their jobs have left.
#[derive(Clone, Copy)]
pub(crate) struct Evidence<'a> {
    pub(crate) study: &'a Study,
    pub(crate) points: &'a [StudyPoint],
    pub(crate) records: &'a RecordMap,
    pub(crate) source: &'a dyn Records,
}

impl<'a> Evidence<'a> {
    /// Returns the record of a point if it is certified.
    pub(crate) fn certified(&self, point: usize) -> Option<&'a Record> {
        self.records.get(&self.points[point].key).filter(|record| record.is_certified())
    }

    /// Returns the scene and the numerics of a point.
    pub(crate) fn case(&self, point: usize) -> Option<&'a Case> {
        self.points[point].job.case()
    }

    /// Reads the fields that a record has left.
    pub(crate) fn fields(&self, record: &Record) -> Result<Fields, AnswerError> {
        self.source.fields(record).map_err(AnswerError::Records)
    }
}

/// Returns the last increment of a record's path.
pub(crate) fn end_of(record: &Record) -> Option<&StepOutcome> {
    record.outcome()?.last()
}
