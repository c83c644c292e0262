//! A worker process gets these arguments when it is started.

use std::path::PathBuf;
use std::time::Duration;

use crate::error::TransportError;

/// The arguments that the coordinator gives a worker process: one word of its command line of the
/// form `prefix,coordinator,address-space,heartbeat,root`.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkerArguments {
    pub(super) prefix: String,
    pub(super) coordinator: u32,
    pub(super) address_space: u64,
    pub(super) heartbeat: Duration,
    pub(super) root: PathBuf,
}

/// The reason why a worker ended without being told to.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The command line is not one that the runner made.
    #[error("`{0}` does not describe a worker; workers are started by a run, not by hand")]
    Arguments(String),
    /// The process could not be set up.
    #[error("the worker could not set itself up: {0}")]
    Setup(String),
    /// The coordinator cannot be reached any more.
    #[error("the worker lost its coordinator")]
    Transport(#[from] TransportError),
}

impl WorkerArguments {
    /// Reads the argument that the runner appended to the worker command.
    ///
    /// # Errors
    /// [`WorkerError::Arguments`] if the argument is not one that the runner made.
    pub fn parse(argument: &str) -> Result<WorkerArguments, WorkerError> {
        let read = || {
            let mut parts = argument.splitn(5, ',');
            Some(WorkerArguments {
                prefix: parts.next().filter(|prefix| !prefix.is_empty())?.into(),
                coordinator: parts.next()?.parse().ok()?,
                address_space: parts.next()?.parse().ok()?,
                heartbeat: Duration::from_nanos(parts.next()?.parse().ok()?),
                root: parts.next().filter(|root| !root.is_empty())?.into(),
            })
        };
        read().ok_or_else(|| WorkerError::Arguments(argument.into()))
    }
}

impl std::fmt::Display for WorkerArguments {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let WorkerArguments { prefix, coordinator, address_space, heartbeat, root } = self;
        write!(
            f,
            "{prefix},{coordinator},{address_space},{},{}",
            heartbeat.as_nanos(),
            root.display()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_read_as_they_were_written() {
        let arguments = WorkerArguments {
            prefix: "tribo0_".into(),
            coordinator: 42,
            address_space: 1 << 33,
            heartbeat: Duration::from_millis(1500),
            root: "/tmp/a, b".into(),
        };
        assert_eq!(WorkerArguments::parse(&arguments.to_string()).unwrap(), arguments);
        for wrong in ["", "p", "p,1,2,3", "p,1,2,3,", ",1,2,3,/r", "p,-1,2,3,/r", "p,1,2,x,/r"] {
            assert!(WorkerArguments::parse(wrong).is_err(), "{wrong}");
        }
    }
}
