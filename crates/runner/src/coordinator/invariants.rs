//! These rules must hold between any two steps.

use super::state::{Coordinator, JobState, Phase};
use crate::event::Counts;

impl Coordinator {
    /// Checks every rule that must hold between two steps and returns the first broken one in
    /// words.
    pub(crate) fn check(&self) -> Result<(), String> {
        let mut tally = Counts {
            failures: self.counts.failures,
            workers: self.workers.len(),
            ..Counts::default()
        };
        for (number, job) in self.jobs.iter().enumerate() {
            let queued = self.queue.contains(number);
            let saved = self.unsaved.iter().map(|(saving, _)| saving).chain(&self.committing);
            // The check is quadratic, so it is made only for studies of the size that tests have.
            if self.jobs.len() <= 100
                && saved.filter(|saving| saving.job == number).count()
                    != usize::from(job.state == JobState::Saving)
            {
                return Err(format!(
                    "job {number} is {:?} but that is not what is being saved",
                    job.state
                ));
            }
            if queued != (job.state == JobState::Waiting) {
                return Err(format!("job {number} is {:?}, in the queue: {queued}", job.state));
            }
            if matches!(job.state, JobState::Waiting | JobState::Leased(_))
                && job.failures >= self.options.attempts
            {
                return Err(format!("job {number} is tried again after {} failures", job.failures));
            }
            if matches!(job.state, JobState::Waiting | JobState::Leased(_))
                && job.returns >= self.options.attempts
            {
                return Err(format!("job {number} is tried again after {} losses", job.returns));
            }
            match job.state {
                JobState::Waiting => tally.waiting += 1,
                JobState::Saving => tally.saving += 1,
                JobState::Done => tally.done += 1,
                JobState::Quarantined => tally.quarantined += 1,
                JobState::Postponed => tally.postponed += 1,
                JobState::Leased(lease) => {
                    tally.running += 1;
                    let holder = self
                        .leases
                        .get(lease)
                        .filter(|lease| lease.job == number)
                        .and_then(|lease| self.workers.get(&lease.worker));
                    if !holder.is_some_and(|worker| worker.leases.contains(&lease)) {
                        return Err(format!(
                            "lease {lease} of job {number} is in the hands of no live worker"
                        ));
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
        (0..self.jobs.len())
            .filter(|&job| matches!(self.jobs[job].state, JobState::Done | JobState::Quarantined))
            .collect()
    }
}
