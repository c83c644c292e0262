//! These rules must hold between any two steps.

use super::state::{Coordinator, JobState, Phase};
use crate::event::Counts;
use crate::task::Jobs;

impl<J: Jobs> Coordinator<J> {
    /// Checks every rule that must hold between two steps and returns the first broken one in
    /// words.
    pub(crate) fn check(&self) -> Result<(), String> {
        let mut tally = Counts {
            failures: self.counts.failures,
            workers: self.workers.len(),
            ..Counts::default()
        };
        for (number, &state) in self.states.iter().enumerate() {
            let mishaps = self.mishaps_of(number);
            let is_tried = matches!(state, JobState::Waiting | JobState::Leased);
            let queued = self.queue.contains(number);
            let saved = self.unsaved.iter().map(|(saving, _)| saving).chain(&self.committing);
            // The check is quadratic, so it is made only for studies of the size that tests have.
            if self.states.len() <= 100
                && saved.filter(|saving| saving.job == number).count()
                    != usize::from(state == JobState::Saving)
            {
                return Err(format!(
                    "job {number} is {:?} but that is not what is being saved",
                    state
                ));
            }
            if queued != (state == JobState::Waiting) {
                return Err(format!("job {number} is {:?}, in the queue: {queued}", state));
            }
            for (times, what) in [(mishaps.failures, "failures"), (mishaps.returns, "losses")] {
                if is_tried && times >= self.options.attempts {
                    return Err(format!("job {number} is tried again after {times} {what}"));
                }
            }
            match state {
                JobState::Waiting => tally.waiting += 1,
                JobState::Saving => tally.saving += 1,
                JobState::Done => tally.done += 1,
                JobState::Quarantined => tally.quarantined += 1,
                JobState::Postponed => tally.postponed += 1,
                JobState::Leased => {
                    tally.running += 1;
                    let mut leases = self.leases.of_job(number);
                    let is_held = leases.next().is_some_and(|(lease, worker)| {
                        let worker = self.workers.get(&worker);
                        worker.is_some_and(|worker| worker.leases.contains(&lease))
                    });
                    if !is_held || leases.next().is_some() {
                        return Err(format!("job {number} is not in the hands of one live worker"));
                    }
                }
            }
        }
        if tally != self.counts {
            return Err(format!("counted {tally:?}, kept {:?}", self.counts));
        }
        let held: usize = self.workers.values().map(|worker| worker.leases.len()).sum();
        if held != self.leases.len()
            || held != self.counts.running
            || self.queue.len() != self.counts.waiting
        {
            return Err(format!(
                "{held} leases held, {} granted, {} jobs queued, {:?}",
                self.leases.len(),
                self.queue.len(),
                self.counts
            ));
        }
        if let Some((id, worker)) =
            self.workers.iter().find(|(_, worker)| worker.load != self.load_of(worker))
        {
            return Err(format!("worker {id} has another load than {:?}", worker.load));
        }
        let memory: u64 = self.workers.values().map(|worker| worker.load.memory).sum();
        if memory > self.options.memory_limit {
            return Err(format!(
                "{memory} bytes of memory are promised, the limit is {}",
                self.options.memory_limit
            ));
        }
        let held_by =
            |group| self.workers.values().filter(|worker| worker.group == Some(group)).count();
        if let Some((group, holders)) = self
            .queue
            .holders()
            .into_iter()
            .enumerate()
            .find(|&(group, holders)| holders != held_by(group))
        {
            return Err(format!(
                "group {group} has {holders} holders, but {} workers hold it",
                held_by(group)
            ));
        }
        for (id, worker) in &self.workers {
            if worker.awaits_reply && worker.phase != Phase::Ready {
                return Err(format!("worker {id} asks and is {:?}", worker.phase));
            }
            if worker.phase == Phase::Leaving && !worker.leases.is_empty() {
                return Err(format!("worker {id} was dismissed with jobs in its hands"));
            }
        }
        Ok(())
    }

    /// Returns the jobs that are durable.
    #[cfg(test)]
    pub(super) fn durable(&self) -> Vec<usize> {
        (0..self.states.len())
            .filter(|&job| matches!(self.states[job], JobState::Done | JobState::Quarantined))
            .collect()
    }
}
