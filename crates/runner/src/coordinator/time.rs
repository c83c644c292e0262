//! This file says how a run ends in time: no job is begun that does not fit into what is left of
//! it, and at last what is in flight is given up.

use std::time::Duration;

use super::state::Coordinator;
use crate::event::EventKind;
use crate::task::Jobs;

/// The least ratio of real to predicted times that is believed.
const LEAST_RATIO: f64 = 1e-9;

impl<J: Jobs> Coordinator<J> {
    /// Returns the longest predicted time of a job that ends in time behind so much other work,
    /// both in \[s\]. The predictions are corrected by the real times of the jobs.
    pub(super) fn longest_that_fits(&self, ahead: f64) -> f64 {
        let Some(until) = self.until else { return f64::INFINITY };
        let left = until.saturating_sub(self.now).as_secs_f64() - ahead;
        left.max(0.0) / self.calibration().unwrap_or(1.0).max(LEAST_RATIO)
    }

    /// Hears a request for an end in time.
    pub(super) fn end(&mut self) {
        self.ends += 1;
        self.owes_job = false;
        self.begin_to_end();
        if self.requests() == 2 {
            self.emit(EventKind::TimeUp { now: true });
        }
        if self.requests() >= 2 {
            self.kill_all("the run was asked twice to end");
        }
    }

    /// Hears that the process stood still for a time that its clock leaves out.
    pub(super) fn stood_still(&mut self, lost: Duration) {
        for time in [&mut self.until, &mut self.ending].into_iter().flatten() {
            *time = time.saturating_sub(lost);
        }
    }

    /// Begins to end when the time is up, or when nothing runs and nothing fits into what is left
    /// of it. Gives up what is in flight when its time is over as well.
    pub(super) fn keep_time(&mut self) {
        let is_over = self.until.is_some_and(|until| until <= self.now);
        let nothing_fits = || {
            let shortest = self.queue.shortest().map(|job| self.queue.cost(job));
            self.counts.running == 0
                && shortest.is_some_and(|shortest| shortest > self.longest_that_fits(0.0))
        };
        if self.until.is_some() && !self.owes_job && (is_over || nothing_fits()) {
            self.begin_to_end();
        }
        if self.give_up_time().is_some_and(|time| time <= self.now) {
            if self.counts.running > 0 {
                self.emit(EventKind::TimeUp { now: true });
            }
            self.halted = true;
            self.kill_all("the time was up");
        }
    }

    fn begin_to_end(&mut self) {
        if self.ending.is_none() {
            self.ending = Some(self.now);
            self.emit(EventKind::TimeUp { now: false });
        }
    }

    /// Returns the next time at which [`Coordinator::keep_time`] does something.
    pub(super) fn time_limit(&self) -> Option<Duration> {
        self.give_up_time().or(self.until.filter(|_| !self.owes_job && self.ending.is_none()))
    }

    /// Returns the time at which the jobs in flight are given up, once it is known and until that
    /// is done.
    fn give_up_time(&self) -> Option<Duration> {
        let ending = self.ending.filter(|_| !self.stopping_now())?;
        Some(ending.saturating_add(self.options.overtime))
    }
}
