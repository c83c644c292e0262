//! This file decides how much work a worker gets when it asks.

use super::messages::Action;
use super::state::{Coordinator, JobState, Phase};
use crate::event::EventKind;
use crate::lease::WorkerId;
use crate::task::Jobs;

/// The predicted work that a worker may hold beyond the job that it is running \[s\].
const AHEAD: f64 = 0.1;
/// The largest number of jobs that one worker may hold.
const MOST_JOBS: usize = 512;
/// The largest size of the payloads in one reply \[bytes\].
const MOST_BYTES: usize = 512 << 10;

/// The ratio of the time of a job to that of the next one in turn by which it may go first.
const MUCH_LONGER: f64 = 2.0;
/// The factor by which a long job goes earlier than it must by prediction, which may be wrong by as
/// much.
const EARLIER: f64 = 2.0;

impl<J: Jobs> Coordinator<J> {
    /// Answers a worker that asks, if there is something to say.
    pub(super) fn answer(&mut self, id: WorkerId) {
        let jobs = if self.stopping() { Vec::new() } else { self.choose(id) };
        let nothing_left = self.stopping() || self.counts.waiting + self.counts.running == 0;
        let Some(worker) = self.workers.get_mut(&id) else { return };
        let idle = worker.leases.is_empty();
        if jobs.is_empty() && idle {
            // A job of another worker may still come back, so the worker stays unless nothing is
            // out.
            if nothing_left {
                (worker.phase, worker.awaits_reply, worker.heard) =
                    (Phase::Leaving, false, self.now);
                self.actions.push(Action::Dismiss(id));
            }
            return;
        }
        if idle {
            (worker.heard, worker.progress) = (self.now, self.now);
        }
        worker.awaits_reply = false;
        let mut assigned = Vec::with_capacity(jobs.len());
        for &job in &jobs {
            let lease = self.leases.grant(job, id);
            worker.leases.push_back(lease);
            self.states[job] = JobState::Leased;
            assigned.push((lease, job));
        }
        self.weigh(id);
        self.actions.push(Action::Assign(id, assigned));
        for job in jobs {
            self.counts.waiting -= 1;
            self.counts.running += 1;
            self.emit(EventKind::Leased {
                key: self.jobs.key(job),
                worker: id,
                attempt: self.mishaps_of(job).failures + 1,
                predicted: self.queue.cost(job),
            });
        }
    }

    /// Takes jobs for a worker out of the queue.
    fn choose(&mut self, id: WorkerId) -> Vec<usize> {
        let Some(worker) = self.workers.get(&id) else { return Vec::new() };
        let others: u64 = self
            .workers
            .iter()
            .filter(|&(&other, _)| other != id)
            .map(|(_, other)| other.load.memory)
            .sum();
        let mut memory = worker.load.memory;
        let calibration = self.calibration();
        let mut ahead = match worker.leases.is_empty() {
            true => 0.0,
            false => worker.load.cost * calibration.unwrap_or(f64::INFINITY),
        };
        let (held, mut group, mut bytes) = (worker.leases.len(), worker.group, 0);
        // The last jobs are dealt out in ever smaller portions, so that all workers end together.
        let share = (self.queue.len() / 2 / self.options.workers).max(1);
        let mut chosen = Vec::new();
        while held + chosen.len() < MOST_JOBS && chosen.len() < share {
            let fits = |job: usize| {
                others.saturating_add(memory.max(self.memory(job))) <= self.options.memory_limit
            };
            let longest = self.longest_that_fits(ahead);
            let Some((first, group_of_first)) = self.queue.next(group, longest, fits) else {
                break;
            };
            let may_go = |late: &usize| self.queue.cost(*late) <= longest && fits(*late);
            let (job, of) = match self.overdue(first).filter(may_go) {
                Some(late) => (late, self.queue.group(late)),
                None => (first, group_of_first),
            };
            let seconds = self.queue.cost(job) * calibration.unwrap_or(f64::INFINITY);
            let size = self.jobs.size(job);
            let behind = held + chosen.len() > 0;
            if behind && (ahead + seconds > AHEAD || bytes + size > MOST_BYTES) {
                break;
            }
            ahead += seconds;
            memory = memory.max(self.memory(job));
            bytes += size;
            self.queue.take_this(job);
            self.queue.hold(group, Some(of));
            group = Some(of);
            chosen.push(job);
        }
        if let Some(job) = self.queue.shortest().filter(|_| self.owes_job && chosen.is_empty()) {
            // Nothing is leased yet, so it fits into the memory.
            self.queue.take_this(job);
            self.queue.hold(group, Some(self.queue.group(job)));
            group = Some(self.queue.group(job));
            chosen.push(job);
        }
        self.owes_job &= chosen.is_empty();
        if let Some(worker) = self.workers.get_mut(&id) {
            worker.group = group;
        }
        chosen
    }

    /// Returns the longest job that waits if it should not wait any longer behind one that is to
    /// be taken: it takes about as long as everything else on all workers, and the others would
    /// be idle while the last one does it. It must be much longer than the other: for a small gain
    /// no worker leaves its group.
    fn overdue(&self, taken: usize) -> Option<usize> {
        let late = self.queue.longest()?;
        let cost = self.queue.cost(late);
        let rest = (self.queue.seconds() - self.queue.cost(taken)) / self.options.workers as f64;
        (cost >= MUCH_LONGER * self.queue.cost(taken) && EARLIER * cost >= rest).then_some(late)
    }
}
