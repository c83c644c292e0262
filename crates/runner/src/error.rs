//! These are the errors of a run and of its connections.

use std::error::Error;

use identity::JobKey;

use crate::root::RootError;

/// The reason why a run could not go on. Everything committed before stays committed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// An option makes no sense.
    #[error("cannot run with these options: {what}")]
    Options {
        /// The name of the option and its sensible values.
        what: &'static str,
    },
    /// Two tasks have the same key.
    #[error("job {0} is given twice, but a key stands for one job")]
    Duplicate(JobKey),
    /// There is no place for the files of the run.
    #[error("no directory for the run's files")]
    Root(#[from] RootError),
    /// There is no room for a single worker.
    #[error("no worker can be started: {reason}")]
    Room {
        /// The thing that is missing.
        reason: String,
    },
    /// Jobs or results cannot be handed over.
    #[error("jobs and results cannot be handed over: {reason}")]
    Delivery {
        /// The fault in words.
        reason: String,
    },
    /// Workers are lost by no fault of the jobs, and nothing gets done.
    #[error("workers are lost again and again, the last: {reason}")]
    Losses {
        /// The end of the last of them.
        reason: String,
    },
    /// Everything that can be done is done, and some jobs are left for another run.
    #[error("{} for another run: {reason}", left(*.jobs))]
    Postponed {
        /// The number of jobs that are left.
        jobs: usize,
        /// The reason why the last of them is left.
        reason: String,
        /// The thing that the last of them did not have.
        want: Want,
    },
    /// Workers do not start.
    #[error("workers cannot be started with `{command}`: {reason}")]
    Start {
        /// The command that starts a worker.
        command: String,
        /// The failure of the last worker that was tried.
        reason: String,
    },
    /// The bytes of a job cannot be made.
    #[error("a job cannot be handed over")]
    Payload(#[source] Box<dyn Error + Send + Sync>),
    /// The ledger did not take results.
    #[error("results could not be kept")]
    Ledger(#[source] Box<dyn Error + Send + Sync>),
    /// The coordinator cannot hear the workers any more.
    #[error("communication with the workers failed")]
    Transport(#[from] TransportError),
    /// A rule of the coordinator is broken. This is checked only in debug builds.
    #[error("the coordinator contradicts itself: {0}")]
    Inconsistent(String),
}

/// The thing that a postponed job did not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Want {
    /// More memory may help it.
    Memory,
    /// Its worker was lost each time by something else than the job.
    Luck,
}

fn left(jobs: usize) -> String {
    if jobs == 1 { "1 job is left".into() } else { format!("{jobs} jobs are left") }
}

/// A failure of the connection between the coordinator and a worker.
#[derive(Debug, thiserror::Error)]
#[error("{doing}: {why}")]
pub struct TransportError {
    /// The attempted action.
    pub(crate) doing: &'static str,
    /// The reason in words.
    pub(crate) why: String,
}

impl TransportError {
    /// Returns a function for `map_err` that adds the attempted action to an error.
    pub(crate) fn when<E: std::fmt::Display>(doing: &'static str) -> impl Fn(E) -> TransportError {
        move |error| TransportError { doing, why: error.to_string() }
    }
}
