//! A point of a study: the values of its axes and the job that they make.

use identity::JobKey;

use crate::job::{Job, JobError};
use crate::record::Record;
use crate::value::Value;

/// One point of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPoint {
    /// The value of each axis, in the order of [`Study::axes`](crate::Study::axes), in SI units.
    pub values: Vec<Value>,
    /// The job that is to be computed.
    pub job: Job,
    /// The identity of the job. Points whose jobs coincide share it, and the result.
    pub key: JobKey,
}

impl StudyPoint {
    /// Returns the point of a record by itself, without a study.
    ///
    /// # Errors
    ///
    /// Returns an error if the text of the record's job is none.
    pub fn of_record(record: &Record) -> Result<StudyPoint, JobError> {
        Ok(StudyPoint { values: Vec::new(), job: record.parse_job()?, key: record.key() })
    }
}
