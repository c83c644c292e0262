//! What the coordinator hears, and what its driver must do.

use crate::event::Event;
use crate::lease::{LeaseId, WorkerId};
use crate::ledger::Done;
use crate::protocol::Report;

/// What the coordinator hears.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Input {
    /// The run begins.
    Begin,
    /// A worker process exists.
    Spawned { worker: WorkerId, pid: u32 },
    /// A worker process could not be made at all.
    SpawnFailed { worker: WorkerId, reason: String },
    /// A worker reports and asks for more.
    Request { worker: WorkerId, idle: bool, reports: Vec<Report<Vec<u8>>> },
    /// A worker says something that makes no sense.
    Nonsense { worker: WorkerId, reason: String },
    /// A busy worker lives.
    Heartbeat { worker: WorkerId },
    /// A worker process is gone; `running` is the lease that it began last.
    Exited { worker: WorkerId, how: String, running: Option<LeaseId> },
    /// The last [`Action::Commit`] is durable.
    Committed,
    /// Somebody asked to stop, once more.
    Interrupt,
    /// Everything that was to be heard up to now was heard: look at the clock.
    Clock,
    /// Nothing more to hear at the moment: hand out, commit, recruit.
    Settled,
}

/// What the driver must do.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Action {
    /// Start a worker process.
    Start(WorkerId),
    /// Kill a worker process.
    Kill(WorkerId),
    /// WorkerReply a worker with these jobs; the reply acknowledges everything it reported.
    Assign(WorkerId, Vec<(LeaseId, usize)>),
    /// WorkerReply a worker that it should leave.
    Dismiss(WorkerId),
    /// Make these durable, then say [`Input::Committed`].
    Commit(Vec<Done>),
    /// Tell the listener.
    Emit(Event),
    /// Give up: workers cannot be started.
    GiveUp(String),
}
