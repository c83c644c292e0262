//! What can go wrong.

use std::error::Error;

use identity::JobKey;

use crate::root::{RootError, SHARED_MEMORY};

/// Why a run could not go on. What was committed before stays committed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// An option makes no sense.
    #[error("cannot run with these options: {what}")]
    Options {
        /// Which one, and what would be right.
        what: &'static str,
    },
    /// Two tasks have one key.
    #[error("job {0} is given twice, but a key stands for one job")]
    Duplicate(JobKey),
    /// No place for the run's files.
    #[error("no directory for the run's files")]
    Root(#[from] RootError),
    /// Shared memory is nearly full; going on would end in SIGBUS.
    #[error("{path} has {free} bytes free, but {workers} workers need {needed}: free some, or use fewer workers", path = SHARED_MEMORY)]
    SharedMemory {
        /// Bytes that are free.
        free: u64,
        /// Bytes that are needed.
        needed: u64,
        /// For so many workers.
        workers: usize,
    },
    /// Workers do not start.
    #[error("workers cannot be started with `{command}`: {reason}")]
    Start {
        /// The command.
        command: String,
        /// What happened to the last one tried.
        reason: String,
    },
    /// The ledger did not take results.
    #[error("results could not be kept")]
    Ledger(#[source] Box<dyn Error + Send + Sync>),
    /// The coordinator lost its means to hear workers.
    #[error("communication with the workers failed")]
    Transport(#[from] TransportError),
    /// A rule of the coordinator is broken; only checked in debug builds.
    #[error("the coordinator contradicts itself: {0}")]
    Inconsistent(String),
}

/// The connection broke.
#[derive(Debug, thiserror::Error)]
#[error("{doing}: {why}")]
pub struct TransportError {
    /// What was tried.
    pub(crate) doing: &'static str,
    /// What went wrong.
    pub(crate) why: String,
}

impl TransportError {
    /// For `map_err`: what was tried, and then what went wrong.
    pub(crate) fn when<E: std::fmt::Display>(doing: &'static str) -> impl Fn(E) -> TransportError {
        move |error| TransportError { doing, why: error.to_string() }
    }
}
