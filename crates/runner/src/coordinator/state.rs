//! The knowledge of the coordinator.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use serde::Serialize;

use identity::JobKey;

use super::messages::Action;
use crate::error::Want;
use crate::event::{Counts, Event, EventKind};
use crate::lease::{LeaseId, Leases, WorkerId};
use crate::ledger::Done;
use crate::loss::Loss;
use crate::options::Options;
use crate::queue::{GroupIndex, Queue, QueuedJob};
use crate::task::Jobs;

/// The mishaps of a job.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mishaps {
    /// The number of attempts that failed.
    pub(super) failures: u32,
    /// The number of workers that it lost by no fault of its own.
    pub(super) returns: u32,
    /// It is true if the job had too little memory, so that it must run alone.
    pub(super) starved: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum JobState {
    Waiting,
    Leased,
    Saving,
    Done,
    Quarantined,
    /// The job is left for another run.
    Postponed,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phase {
    /// The process was asked for and has not yet asked for a job.
    Starting,
    /// The worker works or waits for work.
    Ready,
    /// The worker was told to leave.
    Leaving,
    /// The coordinator killed the worker, and it has not yet exited.
    Killed(Loss),
}

#[derive(Debug)]
pub(super) struct Worker {
    pub(super) phase: Phase,
    pub(super) pid: Option<u32>,
    /// It is true once the worker has asked for a job.
    pub(super) has_asked: bool,
    /// It is true while the request of the worker is not answered.
    pub(super) awaits_reply: bool,
    /// The leases in the order in which the worker works on them.
    pub(super) leases: VecDeque<LeaseId>,
    /// The predicted time and memory of the jobs that it holds.
    pub(super) load: Load,
    /// The number of its results that are not durable.
    pub(super) unsaved: usize,
    pub(super) group: Option<GroupIndex>,
    /// The time of the last sign of life.
    pub(super) heard: Duration,
    /// The time of the last request, or of the last grant to an idle worker.
    pub(super) progress: Duration,
}

/// The prediction for all the jobs that a worker holds. It is kept beside the leases: with many
/// workers, adding it up whenever one of them speaks would take longer than short jobs do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Load {
    /// The sum of their predicted times \[s\].
    pub(super) cost: f64,
    /// The memory of the largest \[bytes\]: jobs run one after another.
    pub(super) memory: u64,
}

/// A result on its way to the ledger.
#[derive(Clone, Debug)]
pub(super) struct Saving {
    pub(super) job: usize,
    pub(super) key: JobKey,
    pub(super) worker: Option<WorkerId>,
    pub(super) seconds: f64,
    pub(super) attempts: u32,
    pub(super) quarantine: Option<String>,
}

/// Everything that the coordinator knows.
#[derive(Debug)]
pub(crate) struct Coordinator<J> {
    pub(super) options: Options,
    pub(super) jobs: J,
    /// The state of each job. There may be a million, so a byte is all that is kept of most.
    pub(super) states: Vec<JobState>,
    /// The mishaps of those jobs that had any.
    pub(super) mishaps: BTreeMap<usize, Mishaps>,
    pub(super) queue: Queue,
    pub(super) leases: Leases,
    pub(super) workers: BTreeMap<WorkerId, Worker>,
    pub(super) hired: WorkerId,
    /// The lost workers that were not yet replaced.
    pub(super) vacancies: VecDeque<WorkerId>,
    /// The number of workers in a row that ended before they asked for a job.
    pub(super) failed_starts: u32,
    /// The reason why the last of them ended.
    pub(super) last_failure: String,
    /// The finished results that were not yet given to the ledger.
    pub(super) unsaved: Vec<(Saving, Done)>,
    /// The time at which the first of them came.
    pub(super) gathers_since: Duration,
    /// The results that were given to the ledger.
    pub(super) committing: Vec<Saving>,
    /// The decaying sum of the times that jobs took \[s\].
    pub(super) took: f64,
    /// The decaying sum of the times that were predicted for them \[s\].
    pub(super) predicted: f64,
    /// True once the results are reason enough to begin no further job.
    pub(super) enough: bool,
    pub(super) interrupts: u32,
    /// The number of requests for an end in time.
    pub(super) ends: u32,
    /// The time after which no further job is begun, if there is one.
    pub(super) until: Option<Duration>,
    /// The time at which the run began to end in time.
    pub(super) ending: Option<Duration>,
    /// It is true as long as one job must be begun even if there is no time for it.
    pub(super) owes_job: bool,
    /// The number of workers in a row that were lost by no fault of a job, since the last result.
    pub(super) misfortunes: usize,
    pub(super) given_up: bool,
    /// It is true if nothing in flight is waited for: it could not be handed over, or there is no
    /// time.
    pub(super) halted: bool,
    /// The reason why the last postponed job was postponed.
    pub(super) postponed_for: Option<Postponement>,
    pub(super) counts: Counts,
    /// The sums over everything that finished, including on workers lost since.
    pub(crate) tally: Tally,
    pub(super) actions: Vec<Action>,
    pub(super) now: Duration,
}

/// The reason why a job is left for another run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Postponement {
    /// The reason in words.
    pub(crate) reason: String,
    pub(crate) want: Want,
}

/// The cause for which a run ends before all its jobs do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EarlyEnd {
    /// Somebody interrupted it.
    Interrupted,
    /// Its time was up, or somebody asked for an end in time.
    InTime,
    /// The [ledger](crate::Ledger::is_enough) had enough.
    Enough,
}

/// The sums of a run beside its counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) lost: usize,
    pub(crate) stale: usize,
    pub(crate) busy: f64,
}

impl<J: Jobs> Coordinator<J> {
    /// Makes a coordinator that knows the jobs and has done nothing.
    pub(crate) fn new(jobs: J, options: &Options) -> Coordinator<J> {
        let count = jobs.count();
        let queued = |job| QueuedJob {
            group: jobs.group(job),
            rank: jobs.rank(job),
            cost: sane(jobs.cost(job)),
        };
        let queue = Queue::new((0..count).map(queued));
        Coordinator {
            options: options.clone(),
            jobs,
            states: vec![JobState::Waiting; count],
            mishaps: BTreeMap::new(),
            queue,
            leases: Leases::default(),
            workers: BTreeMap::new(),
            hired: 0,
            vacancies: VecDeque::new(),
            failed_starts: 0,
            last_failure: String::new(),
            unsaved: Vec::new(),
            gathers_since: Duration::ZERO,
            committing: Vec::new(),
            took: 0.0,
            predicted: 0.0,
            enough: false,
            interrupts: 0,
            ends: 0,
            until: options.until,
            ending: None,
            owes_job: options.until.is_some() && options.begins_one,
            misfortunes: 0,
            given_up: false,
            halted: false,
            postponed_for: None,
            counts: Counts { waiting: count, ..Counts::default() },
            tally: Tally::default(),
            actions: Vec::new(),
            now: Duration::ZERO,
        }
    }

    /// Returns the number of jobs in every state.
    pub(crate) fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns true if nothing is left to do or to wait for.
    pub(crate) fn finished(&self) -> bool {
        let idle = self.workers.is_empty() && self.unsaved.is_empty() && self.committing.is_empty();
        idle && (self.stopping() || self.counts.waiting + self.counts.running == 0)
    }

    pub(super) fn stopping(&self) -> bool {
        self.interrupts > 0 || self.enough || self.given_up || self.ending.is_some()
    }

    /// Returns how often somebody asked the run to stop.
    pub(super) fn requests(&self) -> u32 {
        self.interrupts.saturating_add(self.ends)
    }

    /// Returns true if the jobs in flight are not waited for.
    pub(super) fn stopping_now(&self) -> bool {
        self.requests() >= 2 || self.halted
    }

    /// Returns why the run ends before its jobs do, if it does.
    pub(crate) fn early_end(&self) -> Option<EarlyEnd> {
        if self.interrupts > 0 {
            Some(EarlyEnd::Interrupted)
        } else {
            let is_left = self.counts.waiting + self.counts.running > 0;
            let early = match self.ending {
                Some(_) => EarlyEnd::InTime,
                None if self.enough => EarlyEnd::Enough,
                None => return None,
            };
            is_left.then_some(early)
        }
    }

    /// Returns the reason why jobs are left for another run, if there are any.
    pub(crate) fn postponed_for(&self) -> Option<&Postponement> {
        self.postponed_for.as_ref()
    }

    /// Returns the mishaps that a job had.
    pub(super) fn mishaps_of(&self, job: usize) -> Mishaps {
        self.mishaps.get(&job).copied().unwrap_or_default()
    }

    /// Returns the memory that a job needs \[bytes\]: the prediction, or all of it once that was
    /// too little.
    pub(super) fn memory(&self, job: usize) -> u64 {
        let predicted = self.jobs.memory(job);
        match self.mishaps_of(job).starved {
            true => predicted.max(self.options.memory_limit),
            false => predicted,
        }
    }

    pub(super) fn emit(&mut self, kind: EventKind) {
        let event = Event { seconds: self.now.as_secs_f64(), kind, counts: self.counts };
        self.actions.push(Action::Emit(event));
    }

    /// Returns the ratio of the times that jobs took to the predicted ones, once something is
    /// known.
    pub(super) fn calibration(&self) -> Option<f64> {
        (self.predicted > 0.0).then(|| self.took / self.predicted)
    }

    /// Adds up the load of a worker anew, after its leases have changed.
    pub(super) fn weigh(&mut self, id: WorkerId) {
        let Some(worker) = self.workers.get(&id) else { return };
        let load = self.load_of(worker);
        if let Some(worker) = self.workers.get_mut(&id) {
            worker.load = load;
        }
    }

    /// Returns the load of a worker by its leases.
    pub(super) fn load_of(&self, worker: &Worker) -> Load {
        let mut load = Load::default();
        for lease in worker.leases.iter().filter_map(|&lease| self.leases.get(lease)) {
            load.cost += self.queue.cost(lease.job);
            load.memory = load.memory.max(self.memory(lease.job));
        }
        load
    }
}

/// Returns a predicted time that can be added up and ordered: a positive and finite one, for which
/// four bytes are enough.
fn sane(cost: f64) -> f64 {
    if cost.is_finite() { cost.clamp(1e-6, 1e12) } else { 1.0 }
}
