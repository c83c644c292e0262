//! The progress of a study: how many of its points are solved, and which jobs have failed.

use std::collections::HashSet;

use identity::JobKey;
use serde::Serialize;
use study::{Record, Standing, Study, StudyPoint};

use crate::choice::{Gathered, gather};
use crate::error::AnswerError;
use crate::records::{RecordMap, Records};

/// The progress of a study, in numbers of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// The points that the study has so far.
    pub points: usize,
    /// The points that are solved.
    pub done: usize,
    /// The points whose job has ended without a solution.
    pub failed: usize,
    /// The points without a result.
    pub left: usize,
    /// The points of the axes that the conditions of the study leave out.
    #[serde(skip_serializing_if = "is_zero")]
    pub excluded: usize,
}

/// Returns whether a count that is seldom needed need not be said.
fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl Progress {
    /// Reads how far a study is.
    ///
    /// # Errors
    /// A record cannot be read, or a condition cannot be evaluated.
    pub fn read(study: &Study, source: &dyn Records) -> Result<Self, AnswerError> {
        let Gathered { choice, records } = gather(study, source)?;
        Ok(Self::of(study, &choice.points, &records))
    }

    pub(crate) fn of(study: &Study, points: &[StudyPoint], records: &RecordMap) -> Self {
        let mut progress = Self { excluded: study.excluded(), ..Self::default() };
        points.iter().for_each(|point| progress.add(records.get(&point.key)));
        progress
    }

    /// Counts a point with its record, if it has one.
    pub(crate) fn add(&mut self, record: Option<&Record>) {
        self.points += 1;
        match record.map(Record::standing) {
            None => self.left += 1,
            Some(Standing::Certified) => self.done += 1,
            Some(Standing::Failed | Standing::Quarantined) => self.failed += 1,
        }
    }
}

/// A job that has ended without a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct FailedResult {
    /// The key of the job.
    pub key: JobKey,
    /// The way in which it ended.
    pub standing: Standing,
    /// The reason, if it left one.
    pub reason: Option<String>,
}

/// The jobs that have ended without a solution, in the order of their first points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Failures {
    /// The jobs; of very many the first.
    pub listed: Vec<FailedResult>,
    /// The number of all.
    pub count: usize,
    seen: HashSet<JobKey>,
}

impl Failures {
    /// Adds the failure of a job, if it is one that was not there; at most so many are listed.
    pub(crate) fn add(&mut self, record: &Record, most: usize) {
        if record.is_certified() || !self.seen.insert(record.key()) {
            return;
        }
        self.count += 1;
        if self.listed.len() < most {
            self.listed.push(FailedResult {
                key: record.key(),
                standing: record.standing(),
                reason: record.ending.reason().map(str::to_owned),
            });
        }
    }
}
