//! Shared memory carries the messages here. This is the only folder that uses iceoryx2; it knows
//! the transport, the coordinator's inputs, the worker's loop and processes.
//!
//! Every worker has a channel of its own: a request–response service in which the coordinator is
//! the server and the worker the one client, an event service for each direction, and a name
//! prefix. A worker that is killed in the middle of an operation can leave a service in a state
//! that iceoryx2 never repairs, and its slots taken. With a channel for each worker, that dies with
//! the worker: the coordinator drops its end and removes the files by their prefix.
//!
//! The coordinator waits in one poll(2) for all channels, all processes and the interrupt. A worker
//! waits for its event.

mod arguments;
mod channel;
mod processes;
mod pulse;
mod wire;

pub use arguments::{WorkerArguments, WorkerError};
pub(crate) use processes::Processes;
pub use wire::work;
