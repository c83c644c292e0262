//! The coordinator and a worker need this from the world between them.
//!
//! There are two implementations: shared memory and child processes (`ipc.rs`), and threads with
//! channels for tests (`transport/memory.rs`).

use std::time::Duration;

use crate::coordinator::Input;
use crate::error::TransportError;
use crate::lease::{LeaseId, WorkerId};
use crate::protocol::{Reply, Request};

/// The bytes of a body in memory.
pub(crate) type Bytes = Vec<u8>;

/// The coordinator's side: workers that can be started, killed, answered and heard.
pub(crate) trait Transport {
    /// Starts a worker and returns its process number, or says why that is impossible.
    fn start(&mut self, worker: WorkerId) -> Result<u32, String>;
    /// Ends a worker by force. Its exit is heard later.
    fn kill(&mut self, worker: WorkerId);
    /// Answers the open request of a worker. A worker that is gone is no error: its exit is heard
    /// later.
    fn reply(&mut self, worker: WorkerId, reply: Reply<&[u8]>) -> Result<(), TransportError>;
    /// Blocks until there is something to hear or the timeout has passed. Everything that a worker
    /// said comes before its exit.
    fn wait(&mut self, timeout: Option<Duration>) -> Result<Vec<Input>, TransportError>;
}

/// The worker's side.
pub(crate) trait Link {
    /// Sends a request without waiting. Only one may be open.
    fn send(&mut self, request: Request<Bytes>) -> Result<(), TransportError>;
    /// Returns the reply to the open request if it is there. Otherwise it waits if `block` is true,
    /// and returns `None` if not.
    fn receive(
        &mut self,
        block: bool,
    ) -> Result<Option<Reply<Result<Bytes, String>>>, TransportError>;
    /// Leaves a mark that survives the worker: this lease is being worked on.
    fn begin(&mut self, lease: LeaseId) -> Result<(), TransportError>;
}

#[cfg(test)]
pub(crate) mod memory;
