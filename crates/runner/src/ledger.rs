//! The ledger keeps the results of a run.

use std::error::Error;

use identity::JobKey;

/// The final result of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The job was completed with this result of [`Executor::run`](crate::Executor::run).
    Completed(Vec<u8>),
    /// The job was set aside.
    Quarantined {
        /// The reason why its last attempt failed.
        reason: String,
    },
}

/// A job that ended for good.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// The index of the job among the tasks of the run.
    pub task: usize,
    /// The key of the job.
    pub key: JobKey,
    /// The final result of the job.
    pub verdict: Verdict,
    /// The number of the worker that ran it, or `None` if its worker was lost or it was never run.
    pub worker: Option<u32>,
    /// The wall-clock time of the last attempt that came to an end, or 0 if there was none \[s\].
    pub seconds: f64,
    /// The number of attempts, including a successful one.
    pub attempts: u32,
}

/// A place where results are kept.
pub trait Ledger {
    /// Makes these results durable before it returns.
    ///
    /// # Errors
    /// The results cannot be kept. The error ends the run.
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>>;

    /// Returns true if the results so far are reason enough to begin no further job. Those in
    /// flight are waited for and kept. It is asked after every commit.
    fn is_enough(&self) -> bool {
        false
    }
}
