//! From finished jobs to durable records.

use std::collections::HashMap;
use std::error::Error;
use std::time::{SystemTime, UNIX_EPOCH};

use runner::{Done, Verdict};
use store::Store;
use study::job::PHYSICS_VERSION;
use study::{Ending, JobKey, Provenance, Record};

use crate::measure::median;
use crate::work::{Answer, answer};

/// Keeps results in a store: fields as blobs first, then the records that refer to them.
pub(crate) struct Ledger<'a> {
    store: &'a Store,
    /// The canonical texts of the jobs that run.
    jobs: HashMap<JobKey, String>,
}

impl<'a> Ledger<'a> {
    pub(crate) fn new(store: &'a Store, jobs: HashMap<JobKey, String>) -> Self {
        Self { store, jobs }
    }

    fn record(&mut self, done: Done) -> Result<(JobKey, Vec<u8>), Box<dyn Error + Send + Sync>> {
        let attempts = done.attempts;
        let mut times = Vec::new();
        let (ending, fields) = match done.verdict {
            Verdict::Completed(bytes) => match answer(&bytes)? {
                Answer::Ended { ending, fields, times: each } => {
                    times = each;
                    (*ending, fields.map(|fields| self.store.blobs().keep(&fields)).transpose()?)
                }
                Answer::Refused(reason) => (Ending::Quarantined { reason, attempts }, None),
            },
            Verdict::Quarantined { reason } => (Ending::Quarantined { reason, attempts }, None),
        };
        let record = Record {
            physics: PHYSICS_VERSION,
            job: self.jobs.remove(&done.key).ok_or("a result came for a job that nobody gave out")?,
            ending,
            fields,
            provenance: Provenance {
                program: env!("CARGO_PKG_VERSION").to_owned(),
                seconds: if times.is_empty() { done.seconds } else { median(times.clone()) },
                times,
                worker: done.worker.unwrap_or(0),
                attempt: done.attempts,
                finished: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            },
        };
        Ok((done.key, record.encode()))
    }
}

impl runner::Ledger for Ledger<'_> {
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>> {
        let records = results.into_iter().map(|done| self.record(done)).collect::<Result<Vec<_>, _>>()?;
        Ok(self.store.commit(&records)?)
    }
}
