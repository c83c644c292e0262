//! Results in memory.

use std::cell::Cell;
use std::collections::HashMap;

use answers::choice::{PointChoice, gather};
use answers::{Performed, RecordMap, Records, RecordsError, perform};
use contact::Operators;
use contact::model::{Fields, Status};
use identity::JobKey;
use study::job::PHYSICS_VERSION;
use study::{Ending, Job, Provenance, Record, RunAccount, Study};

/// A place in memory that keeps results and counts how often fields are read.
#[derive(Default)]
pub(crate) struct Shelf {
    results: HashMap<JobKey, (Record, Option<Fields>)>,
    pub(crate) fields_read: Cell<usize>,
}

impl Shelf {
    /// Does the jobs of a study until its results determine no further point.
    pub(crate) fn run(&mut self, study: &Study) -> PointChoice {
        loop {
            let choice = gather(study, self).unwrap().choice;
            let left = choice.points.iter().filter(|point| !self.results.contains_key(&point.key));
            let left: Vec<Job> = left.map(|point| point.job.clone()).collect();
            if left.is_empty() {
                return choice;
            }
            left.iter().for_each(|job| self.perform(study, job));
        }
    }

    /// Sets a job aside that has been done, as if it had killed its workers.
    pub(crate) fn set_aside(&mut self, key: &JobKey) {
        let (record, fields) = self.results.get_mut(key).unwrap();
        record.ending = Ending::Quarantined { reason: "killed".to_owned(), attempts: 3 };
        *fields = None;
    }

    /// Puts a record under the key of another physics, where nothing asks for it.
    pub(crate) fn make_older(&mut self, key: &JobKey) {
        let (mut record, fields) = self.results.remove(key).unwrap();
        record.physics -= 1;
        self.results.insert(record.key(), (record, fields));
    }

    /// Lets a result fail that has been certified.
    pub(crate) fn fail(&mut self, key: &JobKey) {
        let (record, _) = self.results.get_mut(key).unwrap();
        let status = Status::Failed { reason: "not converged".to_owned() };
        match &mut record.ending {
            Ending::Finished(outcome) => outcome.status = status,
            Ending::Searched(found) => found.status = status,
            Ending::Bracketed(found) => found.status = status,
            Ending::Branched(found) => found.status = status,
            Ending::Quarantined { .. } => panic!("it was set aside"),
        }
    }

    /// Does a job and keeps its result. The times are those of a machine that takes a microsecond
    /// for an element.
    fn perform(&mut self, study: &Study, job: &Job) {
        let mut operators = Operators::default();
        let performed = perform(job, study.surfaces(), &mut operators).unwrap();
        let Performed { ending, fields, times } = performed;
        let elements = fields.as_ref().map_or(1, |fields| fields.state.len());
        let times = times.iter().map(|_| 1e-6 * elements as f64).collect();
        let provenance = Provenance::timed("test", 1.0, times);
        let (physics, job) = (PHYSICS_VERSION, job.canonical());
        let record = Record { physics, job, ending, fields: None, provenance };
        self.results.insert(record.key(), (record, fields));
    }
}

impl Records for Shelf {
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError> {
        let record = |key: &JobKey| Some((*key, self.results.get(key)?.0.clone()));
        Ok(keys.iter().filter_map(record).collect())
    }

    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
        let all = self.results.iter().map(|(key, (record, _))| (*key, record.clone()));
        Ok(all.filter(|(_, record)| is_wanted(&record.job)).collect())
    }

    fn fields(&self, record: &Record) -> Result<Fields, RecordsError> {
        self.fields_read.set(self.fields_read.get() + 1);
        let fields = self.results.get(&record.key()).and_then(|(_, fields)| fields.clone());
        fields.ok_or_else(|| format!("job {} has left no fields", record.key()).into())
    }

    fn account(&self, _: &[u8; 32]) -> Option<RunAccount> {
        None
    }
}
