//! Where results go.

use std::error::Error;

use identity::JobKey;

/// How a job ended for good.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// With what [`Executor::run`] returned.
    Completed(Vec<u8>),
    /// Set aside.
    Quarantined {
        /// Why its last attempt failed.
        reason: String,
    },
}

/// A job that ended for good.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// Which job.
    pub key: JobKey,
    /// How it ended.
    pub verdict: Verdict,
    /// Who ran it; nobody, if its worker was lost or it was never run.
    pub worker: Option<u32>,
    /// Wall-clock seconds of the last attempt that came to an end, or 0.
    pub seconds: f64,
    /// Attempts, including a successful one.
    pub attempts: u32,
}

/// Where results are kept.
pub trait Ledger {
    /// Makes these durable; they are when it returns. An error ends the run.
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>>;
}
