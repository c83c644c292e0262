//! The coordinator hears inputs, and its driver must carry out actions.

use std::time::Duration;

use crate::event::Event;
use crate::lease::{LeaseId, WorkerId};
use crate::ledger::Done;
use crate::loss::Loss;
use crate::protocol::Report;

/// An input of the coordinator.
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
    /// A busy worker gives a sign of life.
    Heartbeat { worker: WorkerId },
    /// A worker process is gone. `running` is the lease that it began last.
    Exited { worker: WorkerId, loss: Loss, running: Option<LeaseId> },
    /// The last [`Action::Commit`] is durable.
    Committed,
    /// The ledger wants no further job to be begun.
    Enough,
    /// Somebody asked once more to stop.
    Interrupt,
    /// Somebody asked once more for an end in time.
    End,
    /// The process stood still for so long, which `now` leaves out and the end of time does not.
    StoodStill(Duration),
    /// Everything up to now was heard, and the coordinator should look at the clock.
    Clock,
    /// There is nothing more to hear at the moment, and the coordinator should hand out jobs,
    /// commit and recruit.
    Settled,
}

/// An action that the driver must carry out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Action {
    /// The driver must start a worker process.
    Start(WorkerId),
    /// The driver must kill a worker process.
    Kill(WorkerId),
    /// The driver must answer a worker with these jobs. The reply acknowledges everything that the
    /// worker reported.
    Assign(WorkerId, Vec<(LeaseId, usize)>),
    /// The driver must tell a worker to leave.
    Dismiss(WorkerId),
    /// The driver must make these results durable and then say [`Input::Committed`].
    Commit(Vec<Done>),
    /// The driver must tell the listener.
    Emit(Event),
    /// The driver must give up.
    GiveUp(Hopeless),
}

/// The reason why a run cannot go on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Hopeless {
    /// Workers cannot be started.
    Start(String),
    /// Workers are lost again and again, and nothing gets done.
    Losses(String),
    /// Jobs or results cannot be handed over.
    Delivery(String),
}
