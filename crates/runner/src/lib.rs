//! Runs jobs in worker processes, over shared memory, and keeps every result.
//!
//! One **coordinator** per run, inside [`run`], starts **workers**: child processes of the caller's
//! choosing that call [`work`]. They talk through iceoryx2, with one channel per worker. The runner
//! knows neither what a job is ([`Executor`]) nor where results go ([`Ledger`]). Both are bytes
//! under a [`JobKey`](identity::JobKey) to it.
//!
//! The runner promises the following:
//! - A result is acknowledged to nobody before [`Ledger::commit`] has returned for it, and it is
//!   committed once.
//! - A worker that dies, hangs or stops is replaced, and its job is tried again. A job that fails
//!   [`Options::attempts`] times is set aside with the reason, and the rest goes on. What is no
//!   fault of the job is not counted: full disks, want of memory, limits of the process. A job that
//!   meets it again and again is left for another run.
//! - When the coordinator dies, its workers die with it. The next run removes what they left in
//!   shared memory, as soon as the kernel has released the lock that the coordinator held.
//! - Waiting costs no processor time on either side.
//!
//! The crate runs on Linux only: it needs pidfd, eventfd, `/proc`, `/dev/shm` and the parent-death
//! signal.

mod coordinator;
mod drive;
mod error;
mod event;
mod interrupt;
mod ipc;
mod lease;
mod ledger;
mod limits;
mod loss;
mod memory;
mod options;
mod protocol;
mod queue;
mod root;
mod run;
mod signals;
mod spill;
mod supervise;
mod task;
mod transport;
mod worker;

pub use coordinator::EarlyEnd;
pub use drive::Summary;
pub use error::{RunError, TransportError, Want};
pub use event::{Counts, Event, EventKind};
pub use interrupt::Interrupt;
pub use ipc::{WorkerArguments, WorkerError, work};
pub use ledger::{Done, Ledger, Verdict};
pub use limits::{
    LimitError, Room, enough_stack, free_files, keep_little, memory_within_limits, prepare_process,
    return_freed, room, shared_memory_for, thread_limit,
};
pub use memory::{available_memory, memory_of_group};
pub use options::Options;
pub use protocol::is_message;
pub use root::{
    RootError, SHARED_MEMORY, SharedMemory, remove_bodies, shared_memory, sweep_leftovers,
};
pub use run::run;
pub use signals::raise_on_signals;
pub use supervise::RUNNING_IMAGE;
pub use task::{Jobs, Task};
pub use worker::Executor;
