//! Both ends of a channel share its names, its services and the limits of a message.

use std::fs::{File, Permissions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;
use rustix::fs::FallocateFlags;

use crate::error::TransportError;
use crate::lease::LeaseId;
use crate::limits::RESERVE;
use crate::protocol::{Body, encode};
use crate::root::{SHARED_MEMORY, bodies, entries};
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

/// The names of a channel.
#[derive(Clone, Debug)]
pub(super) struct ChannelNames {
    root: PathBuf,
    prefix: String,
    /// The directory of bodies that are too large for a message.
    bodies: PathBuf,
}

impl ChannelNames {
    pub(super) fn new(root: &std::path::Path, prefix: &str) -> ChannelNames {
        ChannelNames { root: root.into(), prefix: prefix.into(), bodies: bodies(root) }
    }

    pub(super) fn node(&self) -> Result<Node<Shm>, TransportError> {
        let what = "cannot set up shared memory";
        let mut config = Config::default();
        let root = Path::new(self.root.as_os_str().as_encoded_bytes())
            .map_err(TransportError::when(what))?;
        config.global.set_root_path(&root);
        config.global.prefix =
            FileName::new(self.prefix.as_bytes()).map_err(TransportError::when(what))?;
        config.global.creation_timeout = Duration::from_secs(10);
        // The path of a socket is short, and this is the end of it.
        config.global.service.event_connection_suffix =
            FileName::new(b".e").map_err(TransportError::when(what))?;
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
            .map_err(self.when(what))
    }

    /// Returns a function for `map_err` that adds to an error of iceoryx2 what was attempted and
    /// what is wrong with the places that a channel needs. The error itself names neither.
    pub(super) fn when<E: std::fmt::Display>(
        &self,
        doing: &'static str,
    ) -> impl Fn(E) -> TransportError {
        let places = [self.file("trial"), self.shared_memory("trial")];
        move |error| {
            let fault = places.iter().find_map(|place| Some((place, try_out(place).err()?)));
            let why = match fault {
                Some((place, fault)) => format!("{fault}, in {}", parent(place).display()),
                None => format!(
                    "iceoryx2 says {error}, although {} and {SHARED_MEMORY} can be written to",
                    parent(&places[0]).display()
                ),
            };
            TransportError { doing, why }
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.root.join(format!("{}{name}", self.prefix))
    }

    fn shared_memory(&self, name: &str) -> PathBuf {
        std::path::Path::new(SHARED_MEMORY).join(format!("{}{name}", self.prefix))
    }

    pub(super) fn body(&self, lease: LeaseId, direction: &str) -> PathBuf {
        self.bodies.join(format!("{}{lease}-{direction}", self.prefix))
    }

    /// Makes the system keep room for all shared memory of this channel, which it otherwise gives
    /// page by page, and with SIGBUS when there is none. Also takes from others the right to write
    /// to it, which iceoryx2 gives for some of it.
    pub(super) fn reserve(&self) -> Result<(), TransportError> {
        let reserve = |path: &std::path::Path| -> std::io::Result<()> {
            let file = File::options().write(true).open(path)?;
            let metadata = file.metadata()?;
            if metadata.mode() & 0o077 != 0 {
                file.set_permissions(Permissions::from_mode(0o600))?;
            }
            if metadata.len() > 0 {
                rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, metadata.len())?;
            }
            Ok(())
        };
        for (_, path) in entries(std::path::Path::new(SHARED_MEMORY), &self.prefix) {
            match reserve(&path) {
                // The other end may just have removed a segment.
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(TransportError {
                        doing: "cannot reserve shared memory",
                        why: format!("{error}, in {SHARED_MEMORY}"),
                    });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the path of the file in which the worker notes the lease that it began last.
    pub(super) fn marker(&self) -> PathBuf {
        self.file("begun")
    }
}

/// Creates a small file and removes it.
fn try_out(path: &std::path::Path) -> std::io::Result<()> {
    let written = File::create_new(path).and_then(|mut file| file.write_all(&[1; 8192]));
    let _ = std::fs::remove_file(path);
    written
}

fn parent(path: &std::path::Path) -> &std::path::Path {
    path.parent().unwrap_or(path)
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

/// The shared memory of a port.
#[derive(Debug)]
pub(super) struct PortMemory {
    /// The largest size of a message for which its segments have room \[bytes\].
    largest: usize,
}

/// A message that can be written into the shared memory of a port.
#[derive(Debug)]
pub(super) struct EncodedMessage {
    pub(super) bytes: Vec<u8>,
    /// It is true if the message needs a new segment, for which the system must keep room.
    pub(super) grows: bool,
}

impl PortMemory {
    pub(super) fn new(largest: usize) -> PortMemory {
        PortMemory { largest }
    }

    /// Admits a message if it can be written without running out of shared memory. Segments grow by
    /// powers of two, old ones stay, and each holds a handful of messages.
    fn admit(
        &mut self,
        bytes: Vec<u8>,
        free: impl FnOnce() -> Option<u64>,
    ) -> Option<EncodedMessage> {
        let grows = bytes.len() > self.largest;
        if grows {
            let size = bytes.len().next_power_of_two();
            if free().is_some_and(|free| free < 8 * size as u64 + RESERVE) {
                return None;
            }
            self.largest = size;
        }
        Some(EncodedMessage { bytes, grows })
    }

    /// Encodes a message. Small bodies are inside it; if shared memory is short, none is.
    pub(super) fn encode<M: bincode::Encode>(
        &mut self,
        free: impl Fn() -> Option<u64>,
        build: impl Fn(usize) -> Result<M, TransportError>,
    ) -> Result<EncodedMessage, TransportError> {
        let doing = "cannot encode a message";
        for largest in [LARGEST_INLINE, 0] {
            let bytes = encode(&build(largest)?).map_err(TransportError::when(doing))?;
            if let Some(message) = self.admit(bytes, &free) {
                return Ok(message);
            }
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
            let EncodedMessage { bytes, grows } = memory.encode(|| Some(free), build).unwrap();
            (decode::<Body>(&bytes).unwrap(), grows)
        };
        let mut memory = PortMemory::new(INITIAL);
        assert!(matches!(sent(&mut memory, RESERVE), (Body::File { length: 100_000, .. }, false)));
        assert_eq!(sent(&mut memory, 1 << 30), (Body::Inline(bytes.clone()), true));
        assert_eq!(
            sent(&mut memory, 0),
            (Body::Inline(bytes.clone()), false),
            "the memory that it grew to is there"
        );
        let none = PortMemory::new(4).encode(|| Some(0), build).unwrap_err().to_string();
        assert_eq!(none, "cannot send a message: /dev/shm is full");
    }
}
