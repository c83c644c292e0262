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
    /// What is to be computed.
    pub job: Job,
    /// Its identity; points whose jobs coincide share it, and the result.
    pub key: JobKey,
}

impl StudyPoint {
    /// The point of a record by itself, without a study.
    pub fn of_record(record: &Record) -> Result<StudyPoint, JobError> {
        Ok(StudyPoint { values: Vec::new(), job: record.parse_job()?, key: record.key() })
    }
}
