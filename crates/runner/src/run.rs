//! This file holds the way in.

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
use crate::task::{Payload, Task};

/// Runs the tasks in worker processes until each is done or set aside, or until `interrupt` is
/// raised.
///
/// It must be called on a thread that outlives the run, because workers die when the thread that
/// started them does. `on_event` is called on that thread, between the coordinator's steps, and
/// should not block.
///
/// # Errors
/// [`RunError`] if the run could not go on. Results committed before stay committed.
pub fn run<P: Payload>(
    tasks: Vec<Task<P>>,
    ledger: &mut dyn Ledger,
    options: &Options,
    interrupt: &Interrupt,
    on_event: &mut dyn FnMut(&Event),
) -> Result<Summary, RunError> {
    options.checked()?;
    let mut keys: Vec<_> = tasks.iter().map(|task| task.key).collect();
    keys.sort_unstable();
    if let Some(pair) = keys.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(RunError::Duplicate(pair[0]));
    }
    drop(keys);
    sweep_leftovers();
    let mut options = options.clone();
    if let Some(Room { workers, reason }) = room(options.workers.min(tasks.len()), options.threads)
    {
        if workers == 0 {
            return Err(RunError::Room { reason });
        }
        options.workers = workers;
        let counts = Counts { waiting: tasks.len(), ..Counts::default() };
        let kind = EventKind::WorkersLimited { workers, reason };
        on_event(&Event { seconds: 0.0, kind, counts });
    }
    explain_missing_memory().map_err(TransportError::when("cannot prepare for full memory"))?;
    let mut transport = Processes::new(&options, interrupt.clone())?;
    drive(tasks, ledger, &options, &mut transport, interrupt, on_event)
}
