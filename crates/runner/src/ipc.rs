//! Shared memory: the only place that uses iceoryx2.
//!
//! Every worker has a channel of its own: a request–response service in which the coordinator is
//! the server and the worker the one client, an event service for each direction, and a name
//! prefix. A worker killed in the middle of an operation can leave a service in a state that
//! iceoryx2 never repairs, and its slots taken; with a channel each, that dies with the worker: the
//! coordinator drops its end and removes the files by their prefix.
//!
//! The coordinator waits in one poll(2) for all channels, all processes and the interrupt; a worker
//! waits for its event.

mod arguments;
mod channel;
mod processes;
mod pulse;
mod wire;

pub use arguments::{WorkerArguments, WorkerError};
pub(crate) use processes::Processes;
pub use wire::work;
