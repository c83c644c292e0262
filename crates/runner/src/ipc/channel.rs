//! Both ends of a channel share its names, its services and the limits of a message.

use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;

use crate::error::TransportError;
use crate::lease::LeaseId;
use crate::protocol::{Body, encode};
use crate::root::SHARED_MEMORY;
use crate::spill;

/// The thread-safe variant of shared memory, so that a worker's heart can beat on a thread of its
/// own.
pub(super) type Shm = ipc_threadsafe::Service;

pub(super) const JOBS: &str = "jobs";
/// The name of the event service from the worker to the coordinator.
pub(super) const UP: &str = "up";
/// The name of the event service from the coordinator to the worker.
pub(super) const DOWN: &str = "down";

pub(super) const TALK: EventId = EventId::new(0);
pub(super) const HEARTBEAT: EventId = EventId::new(1);

/// The size of a message for which shared memory is reserved from the start \[bytes\].
pub(super) const INITIAL: usize = 16 << 10;
/// The largest body that travels in a message \[bytes\]. Larger ones travel as files.
const LARGEST_INLINE: usize = 256 << 10;
/// The shared memory that must stay free after growing \[bytes\], so that others do not meet SIGBUS
/// either.
pub(super) const RESERVE: u64 = 16 << 20;

/// The names of a channel.
#[derive(Clone, Debug)]
pub(super) struct ChannelNames {
    pub(super) root: PathBuf,
    pub(super) prefix: String,
}

impl ChannelNames {
    pub(super) fn node(&self) -> Result<Node<Shm>, TransportError> {
        let what = "cannot set up shared memory";
        let mut config = Config::default();
        let root = Path::new(self.root.as_os_str().as_encoded_bytes())
            .map_err(TransportError::when(what))?;
        config.global.set_root_path(&root);
        config.global.prefix =
            FileName::new(self.prefix.as_bytes()).map_err(TransportError::when(what))?;
        config.global.creation_timeout = Duration::from_secs(10);
        // The leftovers of a dead worker are removed by their prefix, whatever state they are in.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        // The complaints of iceoryx2 would mix with the output, and every error comes back as a
        // value.
        set_log_level(LogLevel::Fatal);
        // Signals are the business of the caller.
        NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create()
            .map_err(TransportError::when(what))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.root.join(format!("{}{name}", self.prefix))
    }

    pub(super) fn body(&self, lease: LeaseId, direction: &str) -> PathBuf {
        self.file(&format!("{lease}-{direction}"))
    }

    /// Returns the path of the file in which the worker notes the lease that it began last.
    pub(super) fn marker(&self) -> PathBuf {
        self.file("begun")
    }
}

pub(super) fn service(name: &str) -> Result<ServiceName, TransportError> {
    ServiceName::new(name).map_err(TransportError::when("cannot name a service"))
}

/// Decides what to do when a buffer is full. With one open request per client that never happens;
/// should it happen, the message is given up rather than waiting for the dead.
pub(super) fn backpressure(info: &BackpressureInfo) -> BackpressureAction {
    if info.elapsed_time < Duration::from_secs(1) {
        BackpressureAction::Retry
    } else {
        BackpressureAction::DiscardDataAndFail
    }
}

/// Puts a body into the message, or into a file if it has more than `largest` bytes.
pub(super) fn pack(
    bytes: &[u8],
    largest: usize,
    file: impl FnOnce() -> PathBuf,
) -> Result<Body, String> {
    if bytes.len() <= largest {
        Ok(Body::Inline(bytes.to_vec()))
    } else {
        spill::store(&file(), bytes)
    }
}

/// The shared memory of a port, as the largest size that a message through it may have \[bytes\].
#[derive(Debug)]
pub(super) struct PortMemory(pub(super) usize);

impl PortMemory {
    /// Returns true if a message of `length` bytes can be written without running out of shared
    /// memory. Segments grow by powers of two, old ones stay, and each holds a handful of messages.
    fn admits(&mut self, length: usize, free: impl FnOnce() -> Option<u64>) -> bool {
        let needed = 8 * (length as u64).next_power_of_two() + RESERVE;
        if length > self.0 {
            if free().is_some_and(|free| free < needed) {
                return false;
            }
            self.0 = length.next_power_of_two();
        }
        true
    }

    /// Encodes a message. Small bodies are inside it; if shared memory is short, none is.
    pub(super) fn encode<M: bincode::Encode>(
        &mut self,
        free: impl Fn() -> Option<u64>,
        build: impl Fn(usize) -> Result<M, TransportError>,
    ) -> Result<Vec<u8>, TransportError> {
        let doing = "cannot encode a message";
        let message = encode(&build(LARGEST_INLINE)?).map_err(TransportError::when(doing))?;
        if self.admits(message.len(), &free) {
            return Ok(message);
        }
        let message = encode(&build(0)?).map_err(TransportError::when(doing))?;
        if self.admits(message.len(), &free) {
            return Ok(message);
        }
        Err(TransportError {
            doing: "cannot send a message",
            why: format!("{SHARED_MEMORY} is full"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::decode;

    #[test]
    fn when_shared_memory_is_short_bodies_travel_as_files() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("body");
        let bytes = vec![7; 100_000];
        let build = |largest| Ok(pack(&bytes, largest, || path.clone()).unwrap());
        let sent = |memory: &mut PortMemory, free| {
            decode::<Body>(&memory.encode(|| Some(free), build).unwrap()).unwrap()
        };
        let mut memory = PortMemory(INITIAL);
        assert!(matches!(sent(&mut memory, RESERVE), Body::File { length: 100_000, .. }));
        assert_eq!(sent(&mut memory, 1 << 30), Body::Inline(bytes.clone()));
        assert_eq!(
            sent(&mut memory, 0),
            Body::Inline(bytes.clone()),
            "the memory that it grew to is there"
        );
        let none = PortMemory(4).encode(|| Some(0), build).unwrap_err().to_string();
        assert_eq!(none, "cannot send a message: /dev/shm is full");
    }
}
