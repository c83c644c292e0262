//! The driver hears for the coordinator, acts for it and keeps its clock.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::coordinator::{Action, Coordinator, EarlyEnd, Hopeless, Input, Postponement, Tally};
use crate::error::RunError;
use crate::event::{Counts, Event, EventKind};
use crate::interrupt::Interrupt;
use crate::ledger::Ledger;
use crate::options::Options;
use crate::protocol::{Assignment, Reply};
use crate::task::Jobs;
use crate::transport::Transport;

/// The outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The number of jobs with a durable result.
    pub done: usize,
    /// The number of jobs that were set aside.
    pub quarantined: usize,
    /// The number of jobs that were not run because the run ended early.
    pub unfinished: usize,
    /// The number of failed attempts.
    pub failures: usize,
    /// The number of workers that died or were killed.
    pub workers_lost: usize,
    /// The number of results that were dropped because their lease was no longer valid.
    pub stale_results: usize,
    /// The sum of the times that workers spent in jobs \[s\].
    pub worker_seconds: f64,
    /// The time that the run took by the clock on the wall \[s\], which goes on while the process
    /// stands still.
    pub seconds: f64,
    /// The cause for which the run ended before its jobs did, if it did.
    pub early_end: Option<EarlyEnd>,
}

/// Runs the jobs over a transport, as [`crate::run`] does over shared memory.
pub(crate) fn drive(
    jobs: &impl Jobs,
    ledger: &mut dyn Ledger,
    options: &Options,
    transport: &mut impl Transport,
    interrupt: &Interrupt,
    on_event: &mut dyn FnMut(&Event),
) -> Result<Summary, RunError> {
    let start = Instant::now();
    let mut clock = AwakeClock::new();
    let mut coordinator = Coordinator::new(jobs, options);
    let mut inbox = VecDeque::from([Input::Begin]);
    let mut heard = RequestsHeard::default();
    inbox.extend(heard.news(interrupt));
    let mut hopeless = None;
    loop {
        let input = inbox.pop_front().unwrap_or(Input::Settled);
        let settled = input == Input::Settled;
        for action in coordinator.step(input, clock.time(Duration::ZERO)) {
            match action {
                Action::Start(worker) => inbox.push_back(match transport.start(worker) {
                    Ok(pid) => Input::Spawned { worker, pid },
                    Err(reason) => Input::SpawnFailed { worker, reason },
                }),
                Action::Kill(worker) => transport.kill(worker),
                Action::Assign(worker, leased) => {
                    let payloads = leased.iter().map(|&(_, job)| jobs.payload(job));
                    let payloads: Vec<_> =
                        payloads.collect::<Result<_, _>>().map_err(RunError::Payload)?;
                    let assigned = leased.iter().zip(&payloads);
                    let assigned = assigned.map(|((lease, _), payload)| Assignment {
                        lease: *lease,
                        payload: &**payload,
                    });
                    transport.reply(worker, Reply::Jobs(assigned.collect()))?;
                }
                Action::Dismiss(worker) => transport.reply(worker, Reply::Stop)?,
                Action::Commit(done) => {
                    ledger.commit(done).map_err(RunError::Ledger)?;
                    inbox.push_back(Input::Committed);
                    if ledger.is_enough() {
                        inbox.push_back(Input::Enough);
                    }
                }
                Action::Emit(event) => on_event(&event),
                Action::GiveUp(reason) => hopeless = Some(reason),
            }
        }
        #[cfg(debug_assertions)]
        if jobs.count() <= 100
            && let Err(broken) = coordinator.check()
        {
            return Err(RunError::Inconsistent(broken));
        }
        if !settled || !inbox.is_empty() {
            continue;
        }
        if coordinator.finished() {
            break;
        }
        let alarm = coordinator.alarm();
        let left = alarm.map(|alarm| alarm.saturating_sub(clock.time(Duration::ZERO)));
        // A busy worker wakes the coordinator at every heartbeat anyway. A shorter wait shows how
        // long the coordinator itself stood still.
        let timeout = left.map(|left| left.min(options.heartbeat.max(AwakeClock::SLACK)));
        inbox.extend(transport.wait(timeout)?);
        clock.time(timeout.unwrap_or(Duration::MAX));
        interrupt.rearm();
        inbox.extend(heard.news(interrupt));
        inbox.extend(clock.lost().map(Input::StoodStill));
        inbox.push_back(Input::Clock);
    }
    let summary = Summary {
        seconds: start.elapsed().as_secs_f64(),
        early_end: coordinator.early_end(),
        ..summary(coordinator.counts(), coordinator.tally)
    };
    on_event(&Event {
        seconds: clock.time(Duration::ZERO).as_secs_f64(),
        kind: EventKind::Finished,
        counts: coordinator.counts(),
    });
    let jobs = coordinator.counts().postponed;
    match (hopeless, coordinator.postponed_for()) {
        (Some(Hopeless::Start(reason)), _) => {
            Err(RunError::Start { command: options.command_line(), reason })
        }
        (Some(Hopeless::Losses(reason)), _) => Err(RunError::Losses { reason }),
        (Some(Hopeless::Delivery(reason)), _) => Err(RunError::Delivery { reason }),
        (None, Some(Postponement { reason, want })) if summary.early_end.is_none() => {
            Err(RunError::Postponed { jobs, reason: reason.clone(), want: *want })
        }
        _ => Ok(summary),
    }
}

/// The numbers of requests to stop that the coordinator has heard of.
#[derive(Default)]
struct RequestsHeard {
    interrupts: u32,
    ends: u32,
}

impl RequestsHeard {
    /// Returns the requests since the last time.
    fn news(&mut self, interrupt: &Interrupt) -> Vec<Input> {
        let (raised, ends) = (interrupt.raised(), interrupt.ends());
        let interrupts = (self.interrupts..raised).map(|_| Input::Interrupt);
        let news = interrupts.chain((self.ends..ends).map(|_| Input::End)).collect();
        (self.interrupts, self.ends) = (raised, ends);
        news
    }
}

/// A clock that stands still while this process does, stopped by SIGSTOP or a debugger. The silence
/// of workers in such a time says nothing about them: nobody listened, and most likely they were
/// stopped as well.
struct AwakeClock {
    time: Duration,
    last: Instant,
    /// The time that it left out since it was last asked.
    lost: Duration,
}

impl AwakeClock {
    /// The time by which a step or a wait may take longer than expected and still counts.
    const SLACK: Duration = Duration::from_secs(1);

    fn new() -> AwakeClock {
        AwakeClock { time: Duration::ZERO, last: Instant::now(), lost: Duration::ZERO }
    }

    /// Returns the time since the start in which the process was awake, if it meant to be busy or
    /// to wait for at most `expected` since the last look at the clock.
    fn time(&mut self, expected: Duration) -> Duration {
        self.pass(Instant::now(), expected)
    }

    fn pass(&mut self, now: Instant, expected: Duration) -> Duration {
        let passed = now.duration_since(self.last);
        let most = expected.saturating_add(Self::SLACK);
        let awake = if passed > most { expected } else { passed };
        self.time += awake;
        self.lost += passed - awake;
        self.last = now;
        self.time
    }

    /// Returns the time that the clock has left out since the last call, if there was any.
    fn lost(&mut self) -> Option<Duration> {
        Some(std::mem::take(&mut self.lost)).filter(|lost| !lost.is_zero())
    }
}

fn summary(counts: Counts, tally: Tally) -> Summary {
    Summary {
        done: counts.done,
        quarantined: counts.quarantined,
        unfinished: counts.waiting + counts.running + counts.postponed,
        failures: counts.failures,
        workers_lost: tally.lost,
        stale_results: tally.stale,
        worker_seconds: tally.busy,
        seconds: 0.0,
        early_end: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_in_which_the_process_stood_still_does_not_count() {
        let mut clock = AwakeClock::new();
        let start = clock.last;
        let at = |seconds| start + Duration::from_secs_f64(seconds);
        assert_eq!(clock.pass(at(0.5), Duration::ZERO), Duration::from_millis(500));
        assert_eq!(clock.pass(at(1.5), Duration::from_secs(1)), Duration::from_millis(1500));
        // It wanted to wait for a second and woke after 36.
        assert_eq!(clock.pass(at(37.5), Duration::from_secs(1)), Duration::from_millis(2500));
        assert_eq!(clock.pass(at(38.0), Duration::MAX), Duration::from_secs(3));
        assert_eq!((clock.lost(), clock.lost()), (Some(Duration::from_secs(35)), None));
    }
}
