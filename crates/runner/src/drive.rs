//! The driver hears for the coordinator, acts for it and keeps its clock.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::coordinator::{Action, Coordinator, Input, Tally};
use crate::error::RunError;
use crate::event::{Counts, Event, EventKind};
use crate::interrupt::Interrupt;
use crate::ledger::Ledger;
use crate::options::Options;
use crate::protocol::{Assignment, Reply};
use crate::task::Task;
use crate::transport::Transport;

/// The outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The number of jobs with a durable result.
    pub done: usize,
    /// The number of jobs that were set aside.
    pub quarantined: usize,
    /// The number of jobs that were not run because the run was interrupted.
    pub unfinished: usize,
    /// The number of failed attempts.
    pub failures: usize,
    /// The number of workers that died or were killed.
    pub workers_lost: usize,
    /// The number of results that were dropped because their lease was no longer valid.
    pub stale_results: usize,
    /// The sum of the times that workers spent in jobs \[s\].
    pub worker_seconds: f64,
    /// The time that the run took \[s\].
    pub seconds: f64,
    /// It is true if somebody asked to stop.
    pub interrupted: bool,
}

/// Runs the tasks over a transport, as [`crate::run`] does over shared memory.
pub(crate) fn drive(
    tasks: &[Task],
    ledger: &mut dyn Ledger,
    options: &Options,
    transport: &mut impl Transport,
    interrupt: &Interrupt,
    on_event: &mut dyn FnMut(&Event),
) -> Result<Summary, RunError> {
    let clock = Instant::now();
    let mut coordinator = Coordinator::new(tasks, options);
    let mut inbox = VecDeque::from([Input::Begin]);
    let mut interrupts = interrupt.raised();
    inbox.extend((0..interrupts).map(|_| Input::Interrupt));
    let mut hopeless = None;
    loop {
        let input = inbox.pop_front().unwrap_or(Input::Settled);
        let settled = input == Input::Settled;
        for action in coordinator.step(input, clock.elapsed()) {
            match action {
                Action::Start(worker) => inbox.push_back(match transport.start(worker) {
                    Ok(pid) => Input::Spawned { worker, pid },
                    Err(reason) => Input::SpawnFailed { worker, reason },
                }),
                Action::Kill(worker) => transport.kill(worker),
                Action::Assign(worker, jobs) => {
                    let payload = |(lease, job): (_, usize)| Assignment {
                        lease,
                        payload: tasks[job].payload.as_slice(),
                    };
                    transport
                        .reply(worker, Reply::Jobs(jobs.into_iter().map(payload).collect()))?;
                }
                Action::Dismiss(worker) => transport.reply(worker, Reply::Stop)?,
                Action::Commit(done) => {
                    ledger.commit(done).map_err(RunError::Ledger)?;
                    inbox.push_back(Input::Committed);
                }
                Action::Emit(event) => on_event(&event),
                Action::GiveUp(reason) => hopeless = Some(reason),
            }
        }
        #[cfg(debug_assertions)]
        if tasks.len() <= 100
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
        let timeout = coordinator.alarm().map(|alarm| alarm.saturating_sub(clock.elapsed()));
        inbox.extend(transport.wait(timeout)?);
        interrupt.rearm();
        let raised = interrupt.raised();
        inbox.extend((interrupts..raised).map(|_| Input::Interrupt));
        interrupts = raised.max(interrupts);
        inbox.push_back(Input::Clock);
    }
    let summary = summary(coordinator.counts(), coordinator.tally, clock.elapsed(), interrupts > 0);
    on_event(&Event {
        seconds: summary.seconds,
        kind: EventKind::Finished,
        counts: coordinator.counts(),
    });
    match hopeless {
        Some(reason) => Err(RunError::Start { command: options.command_line(), reason }),
        None => Ok(summary),
    }
}

fn summary(counts: Counts, tally: Tally, elapsed: Duration, interrupted: bool) -> Summary {
    Summary {
        done: counts.done,
        quarantined: counts.quarantined,
        unfinished: counts.waiting + counts.running,
        failures: counts.failures,
        workers_lost: tally.lost,
        stale_results: tally.stale,
        worker_seconds: tally.busy,
        seconds: elapsed.as_secs_f64(),
        interrupted,
    }
}
