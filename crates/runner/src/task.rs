//! This file holds a job as the caller gives it.

use std::borrow::Cow;
use std::error::Error;

use identity::JobKey;

/// One job to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Task<P = Vec<u8>> {
    /// The key of the job. No two tasks of a run share one.
    pub key: JobKey,
    /// The bytes that [`Executor::run`](crate::Executor::run) receives, or what makes them.
    pub payload: P,
    /// The number of its group. Tasks of one group share something costly and go to one worker one
    /// after another.
    pub group: u64,
    /// The rank by which a run serves early answers: within a group, and between groups by their
    /// first tasks, those of lower rank go first.
    pub rank: u32,
    /// The predicted time \[s\]. It orders jobs within a group and stretches deadlines, and it is
    /// corrected by the real times of the jobs.
    pub cost: f64,
    /// The predicted memory while it runs, on top of what every worker needs \[bytes\].
    pub memory: u64,
}

/// The bytes of a job that are made when a worker gets it, so that those of a million jobs are
/// never in memory together.
pub trait Payload {
    /// Returns the number of bytes, or about that.
    fn size(&self) -> usize;

    /// Makes the bytes.
    ///
    /// # Errors
    /// The bytes cannot be made. The error ends the run.
    fn bytes(&self) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>>;
}

impl Payload for Vec<u8> {
    fn size(&self) -> usize {
        self.len()
    }

    fn bytes(&self) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>> {
        Ok(Cow::Borrowed(self))
    }
}
