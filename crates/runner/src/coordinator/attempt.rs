//! The end of an attempt, and what becomes of its job.

use std::time::Duration;

use super::state::{Coordinator, JobState, Postponement, Saving, Worker};
use crate::error::Want;
use crate::event::EventKind;
use crate::lease::WorkerId;
use crate::ledger::{Done, Verdict};
use crate::task::Jobs;

/// The time for which results gather while their workers have enough to do. A commit costs as much
/// for one result as for many.
const GATHERING: Duration = Duration::from_millis(20);

impl<J: Jobs> Coordinator<J> {
    /// Notes that one attempt failed. The job is held by nobody.
    pub(super) fn failed(
        &mut self,
        job: usize,
        worker: Option<WorkerId>,
        seconds: f64,
        reason: String,
    ) {
        let mishaps = self.mishaps.entry(job).or_default();
        mishaps.failures += 1;
        let attempt = mishaps.failures;
        self.counts.failures += 1;
        if attempt < self.options.attempts {
            self.put_back(job);
            self.emit(EventKind::Retried { key: self.jobs.key(job), attempt, reason });
        } else {
            self.save(job, worker, seconds, Err(reason));
        }
    }

    /// Notes that an attempt came to nothing by no fault of the job. The job is held by nobody.
    pub(super) fn give_back(&mut self, job: usize, reason: String) {
        self.put_back(job);
        self.emit(EventKind::Returned { key: self.jobs.key(job), reason });
    }

    /// Notes that a job had too little memory. It is tried again with all memory for itself, and
    /// left for another run if it had that.
    pub(super) fn starved(&mut self, job: usize, reason: String) {
        if self.memory(job) < self.options.memory_limit {
            self.mishaps.entry(job).or_default().starved = true;
            self.give_back(job, format!("{reason}; it will run while no other job does"));
        } else {
            self.postpone(job, reason, Want::Memory);
        }
    }

    /// Notes that a job lost its worker by no fault of the job. It is left for another run when
    /// that has happened as often as it may be tried, so that others go on.
    pub(super) fn bereaved(&mut self, job: usize, reason: String) {
        let mishaps = self.mishaps.entry(job).or_default();
        mishaps.returns += 1;
        let returns = mishaps.returns;
        if returns < self.options.attempts {
            self.give_back(job, reason);
        } else {
            let times = if returns == 1 { String::new() } else { format!(" ({returns} times)") };
            self.postpone(job, format!("{reason}{times}"), Want::Luck);
        }
    }

    /// Leaves a job, which is held by nobody, for another run.
    pub(super) fn postpone(&mut self, job: usize, reason: String, want: Want) {
        self.states[job] = JobState::Postponed;
        self.counts.postponed += 1;
        self.postponed_for = Some(Postponement { reason: reason.clone(), want });
        let (key, predicted) = (self.jobs.key(job), self.queue.cost(job));
        self.emit(EventKind::Postponed { key, predicted, reason });
    }

    pub(super) fn put_back(&mut self, job: usize) {
        self.states[job] = JobState::Waiting;
        self.queue.put(job);
        self.counts.waiting += 1;
    }

    /// Notes that the job has its final result, which must be made durable.
    pub(super) fn save(
        &mut self,
        job: usize,
        worker: Option<WorkerId>,
        seconds: f64,
        result: Result<Vec<u8>, String>,
    ) {
        self.states[job] = JobState::Saving;
        let key = self.jobs.key(job);
        let attempts = self.mishaps_of(job).failures + u32::from(result.is_ok());
        let saving = Saving {
            job,
            key,
            worker,
            seconds,
            attempts,
            quarantine: result.as_ref().err().cloned(),
        };
        let verdict = match result {
            Ok(bytes) => Verdict::Completed(bytes),
            Err(reason) => Verdict::Quarantined { reason },
        };
        if self.unsaved.is_empty() {
            self.gathers_since = self.now;
        }
        self.unsaved.push((saving, Done { task: job, key, verdict, worker, seconds, attempts }));
        self.counts.saving += 1;
        if let Some(worker) = worker.and_then(|id| self.workers.get_mut(&id)) {
            worker.unsaved += 1;
        }
    }

    /// Returns the time until which results gather before they are committed; `None` if there are
    /// none, or if they are committed at once, because the worker of one of them would soon have
    /// nothing to do.
    pub(super) fn gathers_until(&self) -> Option<Duration> {
        let ratio = self.calibration()?;
        let is_pressed = |worker: &Worker| {
            worker.unsaved > 0 && worker.load.cost * ratio < GATHERING.as_secs_f64()
        };
        let waits = !self.unsaved.is_empty()
            && self.committing.is_empty()
            && !self.stopping()
            && !self.workers.values().any(is_pressed);
        waits.then(|| self.gathers_since.saturating_add(GATHERING))
    }

    pub(super) fn committed(&mut self) {
        let saved = std::mem::take(&mut self.committing);
        let jobs = saved.len();
        for Saving { job, key, worker, seconds, attempts, quarantine } in saved {
            if let Some(worker) = worker.and_then(|id| self.workers.get_mut(&id)) {
                worker.unsaved -= 1;
            }
            self.counts.saving -= 1;
            match quarantine {
                None => {
                    self.states[job] = JobState::Done;
                    self.counts.done += 1;
                    self.emit(EventKind::Done {
                        key,
                        worker: worker.unwrap_or(0),
                        seconds,
                        attempts,
                    });
                }
                Some(reason) => {
                    self.states[job] = JobState::Quarantined;
                    self.counts.quarantined += 1;
                    self.emit(EventKind::Quarantined { key, reason, attempts });
                }
            }
        }
        if jobs > 0 {
            self.emit(EventKind::Committed { jobs });
        }
    }
}
