//! What the coordinator knows.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use identity::JobKey;

use super::messages::Action;
use crate::event::{Counts, Event, EventKind};
use crate::lease::{LeaseId, Leases, WorkerId};
use crate::ledger::Done;
use crate::options::Options;
use crate::queue::{GroupIndex, Queue};
use crate::task::Task;

#[derive(Debug)]
pub(super) struct TrackedJob {
    pub(super) key: JobKey,
    pub(super) cost: f64,
    pub(super) memory: u64,
    pub(super) bytes: usize,
    pub(super) failures: u32,
    pub(super) state: JobState,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum JobState {
    Waiting,
    Leased(LeaseId),
    Saving,
    Done,
    Quarantined,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Phase {
    /// The process was asked for; it has not yet asked for a job.
    Starting,
    /// It works, or waits for work.
    Ready,
    /// It was told to leave.
    Leaving,
    /// It was killed by us, for this reason, and has not yet exited.
    Killed(String),
}

#[derive(Debug)]
pub(super) struct Worker {
    pub(super) phase: Phase,
    pub(super) pid: Option<u32>,
    /// It has asked for a job at least once.
    pub(super) has_asked: bool,
    /// Its request is not answered.
    pub(super) awaits_reply: bool,
    /// In the order in which it works on them.
    pub(super) leases: VecDeque<LeaseId>,
    /// Results of it that are not durable.
    pub(super) unsaved: usize,
    pub(super) group: Option<GroupIndex>,
    /// Last sign of life.
    pub(super) heard: Duration,
    /// Last request, or grant to an idle worker.
    pub(super) progress: Duration,
}

/// A result on its way to the ledger.
#[derive(Clone, Debug)]
pub(super) struct Saving {
    pub(super) job: usize,
    pub(super) worker: Option<WorkerId>,
    pub(super) seconds: f64,
    pub(super) attempts: u32,
    pub(super) quarantine: Option<String>,
}

/// Everything that the coordinator knows.
#[derive(Debug)]
pub(crate) struct Coordinator {
    pub(super) options: Options,
    pub(super) jobs: Vec<TrackedJob>,
    pub(super) queue: Queue,
    pub(super) leases: Leases,
    pub(super) workers: BTreeMap<WorkerId, Worker>,
    pub(super) hired: WorkerId,
    /// Lost workers that were not yet replaced.
    pub(super) vacancies: VecDeque<WorkerId>,
    /// Workers in a row that ended before asking for a job, and why the last one did.
    pub(super) failed_starts: u32,
    pub(super) last_failure: String,
    /// Finished, not yet given to the ledger.
    pub(super) unsaved: Vec<(Saving, Done)>,
    /// Given to the ledger.
    pub(super) committing: Vec<Saving>,
    /// Decaying sums of what jobs took and what was predicted, in seconds.
    pub(super) took: f64,
    pub(super) predicted: f64,
    pub(super) interrupts: u32,
    pub(super) given_up: bool,
    pub(super) counts: Counts,
    /// Of everything that finished, including on workers lost since.
    pub(crate) tally: Tally,
    pub(super) actions: Vec<Action>,
    pub(super) now: Duration,
}

/// What a run adds up to, beside its counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) lost: usize,
    pub(crate) stale: usize,
    pub(crate) busy: f64,
}

impl Coordinator {
    /// Knows the tasks, has done nothing.
    pub(crate) fn new(tasks: &[Task], options: &Options) -> Coordinator {
        let job = |task: &Task| TrackedJob {
            key: task.key,
            cost: sane(task.cost),
            memory: task.memory,
            bytes: task.payload.len(),
            failures: 0,
            state: JobState::Waiting,
        };
        Coordinator {
            options: options.clone(),
            jobs: tasks.iter().map(job).collect(),
            queue: Queue::new(tasks.iter().map(|task| (task.group, sane(task.cost)))),
            leases: Leases::default(),
            workers: BTreeMap::new(),
            hired: 0,
            vacancies: VecDeque::new(),
            failed_starts: 0,
            last_failure: String::new(),
            unsaved: Vec::new(),
            committing: Vec::new(),
            took: 0.0,
            predicted: 0.0,
            interrupts: 0,
            given_up: false,
            counts: Counts { waiting: tasks.len(), ..Counts::default() },
            tally: Tally::default(),
            actions: Vec::new(),
            now: Duration::ZERO,
        }
    }

    /// Where the run stands.
    pub(crate) fn counts(&self) -> Counts {
        self.counts
    }

    /// Nothing is left to do or to wait for.
    pub(crate) fn finished(&self) -> bool {
        let idle = self.workers.is_empty() && self.unsaved.is_empty() && self.committing.is_empty();
        idle && (self.stopping() || self.counts.waiting + self.counts.running == 0)
    }

    pub(super) fn stopping(&self) -> bool {
        self.interrupts > 0 || self.given_up
    }

    pub(super) fn emit(&mut self, kind: EventKind) {
        let event = Event { seconds: self.now.as_secs_f64(), kind, counts: self.counts };
        self.actions.push(Action::Emit(event));
    }

    /// What jobs take over what was predicted, once something is known.
    pub(super) fn calibration(&self) -> Option<f64> {
        (self.predicted > 0.0).then(|| self.took / self.predicted)
    }

    /// The jobs that a worker holds.
    pub(super) fn held<'a>(&'a self, worker: &'a Worker) -> impl Iterator<Item = &'a TrackedJob> {
        worker.leases.iter().filter_map(|&lease| Some(&self.jobs[self.leases.get(lease)?.job]))
    }

    /// A worker runs its jobs one after another, so it needs what the largest needs.
    pub(super) fn memory(&self, worker: &Worker) -> u64 {
        self.held(worker).map(|job| job.memory).max().unwrap_or(0)
    }
}

/// A prediction that can be added up and ordered: positive and finite.
fn sane(cost: f64) -> f64 {
    if cost.is_finite() { cost.max(1e-6) } else { 1.0 }
}
