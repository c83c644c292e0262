//! The step hears one input and decides what to do.

use std::collections::VecDeque;
use std::time::Duration;

use super::messages::{Action, Hopeless, Input};
use super::state::{Coordinator, Load, Phase, Worker};
use crate::error::Want;
use crate::event::EventKind;
use crate::lease::{Lease, LeaseId, WorkerId};
use crate::limits::size;
use crate::loss::{Cause, Loss};
use crate::options::Options;
use crate::protocol::{AttemptOutcome, Report};
use crate::task::Jobs;

/// The number of workers in a row that die before asking for a job after which starting more is
/// hopeless.
const MOST_FAILED_STARTS: u32 = 10;
/// The number of workers, beyond twice those of the run, that may be lost in a row by circumstances
/// that no job has to do with.
const MOST_MISFORTUNES: usize = 10;
/// The time that a worker may take to leave once it was told to.
const LEAVING: Duration = Duration::from_secs(10);

/// The time until which the coordinator waits for a worker.
struct Deadline {
    /// The time since the start of the run.
    time: Duration,
    /// The fault of a worker that lets the time pass.
    reason: String,
}

impl<J: Jobs> Coordinator<J> {
    /// Returns the time at which [`Input::Clock`] would change something if nothing else happens.
    pub(crate) fn alarm(&self) -> Option<Duration> {
        let deadlines =
            self.workers.values().filter_map(|worker| Some(self.deadline(worker)?.time));
        deadlines.chain(self.time_limit()).chain(self.gathers_until()).min()
    }

    /// Hears `input` at the time `now` since the start of the run and returns the actions to carry
    /// out.
    pub(crate) fn step(&mut self, input: Input, now: Duration) -> Vec<Action> {
        self.now = self.now.max(now);
        match input {
            Input::Begin => self.begin(),
            Input::Spawned { worker, pid } => {
                if let Some(worker) = self.workers.get_mut(&worker) {
                    worker.pid = Some(pid);
                }
            }
            Input::SpawnFailed { worker, reason } => {
                if self.workers.remove(&worker).is_some() {
                    self.counts.workers -= 1;
                    self.not_started(reason);
                }
            }
            Input::Request { worker, idle, reports } => self.request(worker, idle, reports),
            Input::Nonsense { worker, reason } => {
                self.kill(worker, Loss { how: reason, cause: Cause::Circumstances });
            }
            Input::Heartbeat { worker } => {
                if let Some(worker) = self.workers.get_mut(&worker) {
                    worker.heard = self.now;
                }
            }
            Input::Exited { worker, loss, running } => self.exited(worker, loss, running),
            Input::Committed => self.committed(),
            Input::Enough => self.enough = true,
            Input::Interrupt => self.interrupt(),
            Input::End => self.end(),
            Input::StoodStill(lost) => self.stood_still(lost),
            Input::Clock => self.look_at_the_clock(),
            Input::Settled => self.settle(),
        }
        std::mem::take(&mut self.actions)
    }

    fn begin(&mut self) {
        self.emit(EventKind::RunStarted);
        for job in 0..self.states.len() {
            let (needed, limit) = (self.memory(job), self.options.memory_limit);
            if needed > limit && self.queue.take_this(job) {
                self.counts.waiting -= 1;
                let (needed, limit) = (size(needed), size(limit));
                self.postpone(
                    job,
                    format!("needs {needed} of memory by prediction, and the run may use {limit}"),
                    Want::Memory,
                );
            }
        }
    }

    fn request(&mut self, id: WorkerId, idle: bool, reports: Vec<Report<Vec<u8>>>) {
        let Some(worker) = self.workers.get_mut(&id) else {
            self.tally.stale += reports.len();
            return;
        };
        (worker.heard, worker.progress, worker.has_asked) = (self.now, self.now, true);
        let starts = worker.phase == Phase::Starting;
        if starts {
            worker.phase = Phase::Ready;
        }
        worker.awaits_reply = worker.phase == Phase::Ready;
        if starts {
            let pid = worker.pid.unwrap_or(0);
            self.failed_starts = 0;
            self.emit(EventKind::WorkerStarted { worker: id, pid });
        }
        for report in reports {
            self.report(id, report);
        }
        self.weigh(id);
        if idle && self.workers.get(&id).is_some_and(|worker| !worker.leases.is_empty()) {
            let how = "lost track of the jobs it was given".into();
            self.kill(id, Loss { how, cause: Cause::Circumstances });
        }
    }

    fn report(&mut self, id: WorkerId, report: Report<Vec<u8>>) {
        let Some(lease) = self.leases.end(report.lease, id) else {
            self.tally.stale += 1;
            return;
        };
        if let Some(worker) = self.workers.get_mut(&id)
            // It is the first, as a rule.
            && let Some(place) = worker.leases.iter().position(|&held| held == report.lease)
        {
            worker.leases.remove(place);
        }
        self.counts.running -= 1;
        let seconds = report.seconds.max(0.0);
        self.tally.busy += seconds;
        match report.outcome {
            AttemptOutcome::Completed(bytes) => {
                self.misfortunes = 0;
                const MEMORY: f64 = 0.95;
                self.took = MEMORY * self.took + seconds;
                self.predicted = MEMORY * self.predicted + self.queue.cost(lease.job);
                self.save(lease.job, Some(id), seconds, Ok(bytes));
            }
            AttemptOutcome::Failed(reason) => self.failed(lease.job, Some(id), seconds, reason),
            AttemptOutcome::Undelivered(reason) => {
                self.give_back(lease.job, reason.clone());
                self.give_up(Hopeless::Delivery(reason));
                self.halted = true;
                self.kill_all("the run was stopped");
            }
        }
    }

    fn give_up(&mut self, reason: Hopeless) {
        if !self.given_up {
            self.given_up = true;
            self.actions.push(Action::GiveUp(reason));
        }
    }

    fn exited(&mut self, id: WorkerId, loss: Loss, running: Option<LeaseId>) {
        let Some(worker) = self.workers.remove(&id) else { return };
        self.queue.hold(worker.group, None);
        self.counts.workers -= 1;
        let expected = matches!(worker.phase, Phase::Leaving) && worker.leases.is_empty();
        let Loss { how, cause } = match worker.phase {
            Phase::Killed(why) => Loss { how: format!("{} ({})", why.how, loss.how), ..why },
            _ => loss,
        };
        // The marker may name a lease that was reported since. Then the next one was about to
        // begin.
        let culprit = running
            .filter(|lease| worker.leases.contains(lease))
            .or(worker.leases.front().copied());
        for lease in worker.leases {
            let Some(Lease { job, .. }) = self.leases.end(lease, id) else { continue };
            self.counts.running -= 1;
            let is_culprit = Some(lease) == culprit && !self.stopping_now();
            let reason = format!("its worker was lost: {how}");
            match cause {
                Cause::Job if is_culprit => self.failed(job, None, 0.0, reason),
                Cause::Memory if is_culprit => self.starved(job, reason),
                Cause::Circumstances if is_culprit => self.bereaved(job, reason),
                _ => self.put_back(job),
            }
        }
        if expected || self.stopping_now() {
            return;
        }
        self.tally.lost += 1;
        self.emit(EventKind::WorkerLost { worker: id, pid: worker.pid, how: how.clone() });
        self.vacancies.push_back(id);
        if !worker.has_asked {
            self.not_started(how);
        } else if cause == Cause::Circumstances || cause == Cause::Memory && culprit.is_none() {
            // Want of memory has an end of its own for each job that feels it.
            self.misfortunes += 1;
            if self.misfortunes
                >= self.options.workers.saturating_mul(2).saturating_add(MOST_MISFORTUNES)
            {
                self.give_up(Hopeless::Losses(how));
            }
        }
    }

    fn not_started(&mut self, reason: String) {
        self.failed_starts += 1;
        self.last_failure = reason;
    }

    fn interrupt(&mut self) {
        self.interrupts += 1;
        if self.requests() <= 2 {
            self.emit(EventKind::Interrupted { now: self.requests() == 2 });
        }
        if self.requests() >= 2 {
            self.kill_all("the run was interrupted");
        }
    }

    pub(super) fn kill_all(&mut self, reason: &str) {
        for id in self.workers.keys().copied().collect::<Vec<_>>() {
            self.kill(id, Loss { how: reason.into(), cause: Cause::Circumstances });
        }
    }

    fn kill(&mut self, id: WorkerId, why: Loss) {
        let Some(worker) = self.workers.get_mut(&id) else { return };
        if !matches!(worker.phase, Phase::Killed(_)) {
            worker.phase = Phase::Killed(why);
            worker.awaits_reply = false;
            self.actions.push(Action::Kill(id));
        }
    }

    fn look_at_the_clock(&mut self) {
        self.keep_time();
        let late = |(&id, worker): (&WorkerId, &Worker)| {
            let Deadline { time, reason } = self.deadline(worker)?;
            (time <= self.now).then_some((id, reason))
        };
        for (id, reason) in self.workers.iter().filter_map(late).collect::<Vec<_>>() {
            self.kill(id, Loss { how: reason, cause: Cause::Job });
        }
    }

    /// Returns the time until which this worker is waited for and the reason for killing it
    /// afterwards.
    fn deadline(&self, worker: &Worker) -> Option<Deadline> {
        let Options { start_timeout, silence, grace, patience, .. } = self.options;
        match worker.phase {
            Phase::Killed(_) => None,
            Phase::Starting => Some(Deadline {
                time: worker.heard.saturating_add(start_timeout),
                reason: format!("asked for no job within {start_timeout:?} of its start"),
            }),
            Phase::Leaving => Some(Deadline {
                time: worker.heard + LEAVING,
                reason: "did not leave when told to".into(),
            }),
            Phase::Ready if worker.leases.is_empty() => None,
            Phase::Ready => {
                let predicted = worker.load.cost * self.calibration().unwrap_or(1.0).max(1.0);
                let allowed = grace.saturating_add(
                    Duration::try_from_secs_f64(predicted * patience).unwrap_or(Duration::MAX),
                );
                let (silent, late) =
                    (worker.heard.saturating_add(silence), worker.progress.saturating_add(allowed));
                Some(if silent < late {
                    Deadline {
                        time: silent,
                        reason: format!("gave no sign of life for {silence:?}"),
                    }
                } else {
                    let seconds = allowed.as_secs_f64();
                    Deadline {
                        time: late,
                        reason: format!("finished nothing within its deadline of {seconds:.1} s"),
                    }
                })
            }
        }
    }

    fn settle(&mut self) {
        let gathers = self.gathers_until().is_some_and(|time| self.now < time);
        if self.committing.is_empty() && !self.unsaved.is_empty() && !gathers {
            let (saving, done) = std::mem::take(&mut self.unsaved).into_iter().unzip();
            self.committing = saving;
            self.actions.push(Action::Commit(done));
        }
        self.keep_time();
        if self.stopping_now() {
            return;
        }
        let asking = self
            .workers
            .iter()
            .filter(|(_, worker)| worker.awaits_reply && worker.unsaved == 0)
            .map(|(&id, _)| id);
        for id in asking.collect::<Vec<_>>() {
            self.answer(id);
        }
        self.recruit();
    }

    fn recruit(&mut self) {
        let usable = |worker: &&Worker| matches!(worker.phase, Phase::Starting | Phase::Ready);
        let mut present = self.workers.values().filter(usable).count();
        let wanted = self.options.workers.min(self.counts.waiting + self.counts.running);
        if self.failed_starts >= MOST_FAILED_STARTS {
            // The workers that did start go on. Without any, there is no hope.
            if present == 0 && wanted > 0 && !self.stopping() {
                let last = &self.last_failure;
                self.give_up(Hopeless::Start(format!(
                    "{MOST_FAILED_STARTS} in a row ended before asking for a job, the last: {last}"
                )));
            }
            return;
        }
        while !self.stopping() && present < wanted {
            self.hired += 1;
            present += 1;
            let id = self.hired;
            let worker = Worker {
                phase: Phase::Starting,
                pid: None,
                has_asked: false,
                awaits_reply: false,
                leases: VecDeque::new(),
                load: Load::default(),
                unsaved: 0,
                group: None,
                heard: self.now,
                progress: self.now,
            };
            self.workers.insert(id, worker);
            self.counts.workers += 1;
            self.actions.push(Action::Start(id));
            if let Some(lost) = self.vacancies.pop_front() {
                self.emit(EventKind::WorkerReplaced { lost, by: id });
            }
        }
    }
}
