//! Turns finished jobs into durable records.

use std::error::Error;
use std::time::{SystemTime, UNIX_EPOCH};

use answers::{RecordSize, too_large};
use identity::{JobKey, STORED_LIMIT};
use runner::{Done, Verdict};
use store::Store;
use study::job::PHYSICS_VERSION;
use study::record_format::decode_ending;
use study::{Ending, Provenance, Record, RunAccount};

use crate::exporting::Exporter;
use crate::failure_limit::FailureCount;
use crate::output;
use crate::wire::{JobReply, decode_reply};

/// Keeps results in a store: fields first, as blobs, then the records that refer to them.
pub(crate) struct StoreLedger<'a> {
    store: &'a Store,
    /// Returns the canonical text of a job, given its index among the tasks of the run.
    texts: &'a dyn Fn(usize) -> Option<String>,
    /// The export of the run, if there is one.
    exporter: Option<&'a Exporter>,
    /// The account of the run.
    account: &'a RunAccount,
    /// The digest of the account as it is kept; `None` as long as nothing was computed, and
    /// `Some(None)` if it cannot be kept.
    run: Option<Option<[u8; 32]>>,
    failures: &'a mut FailureCount,
}

impl<'a> StoreLedger<'a> {
    /// Returns the ledger of a run of some jobs, whose canonical texts it is told.
    pub(crate) fn new(
        store: &'a Store,
        texts: &'a dyn Fn(usize) -> Option<String>,
        exporter: Option<&'a Exporter>,
        account: &'a RunAccount,
        failures: &'a mut FailureCount,
    ) -> Self {
        Self { store, texts, exporter, account, run: None, failures }
    }

    /// Keeps the account of the run before the first record that names it. Results count more: if
    /// it cannot be kept, they do not name it.
    fn run(&mut self) -> Option<[u8; 32]> {
        *self.run.get_or_insert_with(|| match self.store.blobs().put(&self.account.to_bytes()) {
            Ok(digest) => Some(digest.0),
            Err(error) => {
                output::say(&format!("warning: results will not say what computed them: {error}"));
                None
            }
        })
    }

    fn record(&mut self, done: Done) -> Result<(JobKey, Vec<u8>), Box<dyn Error + Send + Sync>> {
        let attempts = done.attempts;
        let mut job_times = Vec::new();
        let (ending, fields) = match done.verdict {
            Verdict::Completed(bytes) => match decode_reply(&bytes)? {
                JobReply::Ended { ending, fields, times } => {
                    job_times = times;
                    (
                        decode_ending(&ending)?,
                        fields.map(|fields| self.store.blobs().keep(&fields)).transpose()?,
                    )
                }
                JobReply::Refused(reason) => (Ending::Quarantined { reason, attempts }, None),
            },
            Verdict::Quarantined { reason } => (Ending::Quarantined { reason, attempts }, None),
        };
        let mut record = Record {
            physics: PHYSICS_VERSION,
            job: (self.texts)(done.task).ok_or("a result came for a job that nobody gave out")?,
            ending,
            fields,
            provenance: Provenance {
                worker: done.worker.unwrap_or(0),
                attempt: done.attempts,
                run: self.run(),
                finished: SystemTime::now()
                    .duration_since(UNIX_EPOCH)
                    .map_or(0, |since| since.as_secs()),
                ..Provenance::timed(env!("CARGO_PKG_VERSION"), done.seconds, job_times)
            },
        };
        let mut bytes = record.encode();
        if bytes.len() > STORED_LIMIT {
            // The results that came with it are kept, and a resume does not compute it again in
            // vain.
            let size = RecordSize { bytes: bytes.len(), limit: STORED_LIMIT };
            (record.ending, record.fields) = (too_large(record.ending, size), None);
            bytes = record.encode();
        }
        self.failures.add(usize::from(!record.is_certified()));
        Ok((done.key, bytes))
    }
}

impl runner::Ledger for StoreLedger<'_> {
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>> {
        let records =
            results.into_iter().map(|done| self.record(done)).collect::<Result<Vec<_>, _>>()?;
        self.store.commit(&records)?;
        if let Some(exporter) = self.exporter {
            exporter.add(records);
        }
        Ok(())
    }

    fn is_enough(&self) -> bool {
        self.failures.are_too_many()
    }
}

#[cfg(test)]
mod tests {
    use contact::model::{Certificate, Fields, Method, Motion, Observables, Status, WorkDone};
    use contact::multiplicity::{Multiplicity, Origin, Solution};
    use contact::uniqueness::Bracket;
    use contact::uniqueness::lower::LowerBound;
    use contact::uniqueness::witness::Witness;
    use runner::Ledger;
    use study::record::Bracketed;
    use study::record_format::encode_ending;

    use super::*;

    fn bracketed(elements: usize) -> Ending {
        let lower = LowerBound {
            mu: 1.0,
            alpha: Vec::new(),
            beta: Vec::new(),
            tau: Vec::new(),
            verified: true,
        };
        let upper = Witness { mu: 2.0, stiffness: 1.0, x: vec![1.0; 3 * elements] };
        Ending::Bracketed(Box::new(Bracketed {
            status: Status::Certified,
            bracket: Some(Bracket::Bounded { lower, upper }),
            shown: None,
        }))
    }

    fn searched(count: usize, side: u32) -> Ending {
        let list = vec![1.0; (side * side) as usize];
        let fields = Fields {
            shape: [side; 2],
            origin: [0.0; 2],
            element: [1.0; 2],
            pressure: list.clone(),
            traction_x: list.clone(),
            traction_y: list.clone(),
            gap: list.clone(),
            slip_x: list.clone(),
            slip_y: list,
            state: vec![1; (side * side) as usize],
            ..Fields::default()
        };
        let solution = Solution {
            motion: Motion::default(),
            observables: Observables::default(),
            certificate: Certificate::default(),
            origin: Origin::Nothing,
            method: Method::Newton,
            reached: 1,
            error: 0.0,
            index: Some(1),
            distances: vec![0.0; count],
            fields,
        };
        Ending::Searched(Multiplicity {
            status: Status::Certified,
            before: Vec::new(),
            solutions: vec![solution; count],
            starts: 70,
            failed: 6,
            beyond: 0,
            index_sum: Some(1),
            work: WorkDone::default(),
            factorisations: 9,
        })
    }

    /// Otherwise it would stop the run when all the work is done, and every run after it.
    #[test]
    fn a_result_that_no_record_holds_fails_by_itself() {
        let place = tempfile::tempdir().unwrap();
        let store = Store::open(place.path()).unwrap();
        let endings = [bracketed(50_000), bracketed(4), searched(40, 32), searched(3, 32)];
        let keys: Vec<JobKey> =
            (0..).zip(&endings).map(|(number, _)| JobKey([number; 32])).collect();
        let texts = |task: usize| keys.get(task).map(JobKey::to_string);
        let done = keys.iter().zip(&endings).enumerate().map(|(task, (key, ending))| {
            let reply =
                JobReply::Ended { ending: encode_ending(ending), fields: None, times: Vec::new() };
            let bytes = bincode::serde::encode_to_vec(&reply, bincode::config::standard()).unwrap();
            Done {
                task,
                key: *key,
                verdict: Verdict::Completed(bytes),
                worker: Some(0),
                seconds: 1.0,
                attempts: 1,
            }
        });
        let mut failures = FailureCount::default();
        StoreLedger::new(&store, &texts, None, &RunAccount::default(), &mut failures)
            .commit(done.collect())
            .unwrap();
        let ends = keys
            .iter()
            .map(|key| Record::decode(&store.get(key).unwrap().unwrap()).unwrap().ending);
        let ends: Vec<Ending> = ends.collect();
        assert_eq!((&ends[1], &ends[3]), (&endings[1], &endings[3]), "what fits is kept as it is");
        let limit = STORED_LIMIT.to_string();
        for (end, what) in
            [(&ends[0], "witness on 50000 elements"), (&ends[2], "40 solutions on 1024 elements")]
        {
            let reason = end.reason().unwrap();
            assert!(
                reason.contains(what)
                    && reason.contains(&limit)
                    && reason.contains("at most about"),
                "{reason}"
            );
        }
        let Ending::Searched(found) = &ends[2] else { panic!("{:?}", ends[2]) };
        assert_eq!(
            (found.solutions.len(), found.starts, found.failed),
            (0, 70, 6),
            "the counts stay"
        );
    }
}
