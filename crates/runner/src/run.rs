//! This file holds the way in.

use identity::JobKey;

use crate::drive::{Summary, drive};
use crate::error::{RunError, TransportError};
use crate::event::{Counts, Event, EventKind};
use crate::interrupt::Interrupt;
use crate::ipc::Processes;
use crate::ledger::Ledger;
use crate::limits::{Room, room};
use crate::options::Options;
use crate::root::sweep_leftovers;
use crate::signals::explain_missing_memory;
use crate::task::Jobs;

/// Runs the jobs in worker processes until each is done or set aside, or until `interrupt` is
/// raised.
///
/// It must be called on a thread that outlives the run, because workers die when the thread that
/// started them does. `on_event` is called on that thread, between the coordinator's steps, and
/// should not block.
///
/// # Errors
/// [`RunError`] if the run could not go on. Results committed before stay committed.
pub fn run(
    jobs: &impl Jobs,
    ledger: &mut dyn Ledger,
    options: &Options,
    interrupt: &Interrupt,
    on_event: &mut dyn FnMut(&Event),
) -> Result<Summary, RunError> {
    options.checked()?;
    if let Some(key) = duplicate(jobs) {
        return Err(RunError::Duplicate(key));
    }
    sweep_leftovers();
    let mut options = options.clone();
    if let Some(Room { workers, reason }) = room(options.workers.min(jobs.count()), options.threads)
    {
        if workers == 0 {
            return Err(RunError::Room { reason });
        }
        options.workers = workers;
        let counts = Counts { waiting: jobs.count(), ..Counts::default() };
        let kind = EventKind::WorkersLimited { workers, reason };
        on_event(&Event { seconds: 0.0, kind, counts });
    }
    explain_missing_memory().map_err(TransportError::when("cannot prepare for full memory"))?;
    let mut transport = Processes::new(&options, interrupt.clone())?;
    drive(jobs, ledger, &options, &mut transport, interrupt, on_event)
}

/// Returns a key that two jobs share, if there is one.
fn duplicate(jobs: &impl Jobs) -> Option<JobKey> {
    let mut halves: Vec<u128> = (0..jobs.count()).map(|job| jobs.key(job).half()).collect();
    halves.sort_unstable();
    let half = halves.windows(2).find(|pair| pair[0] == pair[1])?[0];
    (0..jobs.count()).map(|job| jobs.key(job)).find(|key| key.half() == half)
}
