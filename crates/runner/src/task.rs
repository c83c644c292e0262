//! This file holds the jobs of a run as the caller gives them.

use std::borrow::Cow;
use std::error::Error;

use identity::JobKey;

/// The jobs of a run by their numbers, which count from 0. The runner asks for what it needs when
/// it needs it, and gets the same answer every time, so that a caller of a million jobs has in
/// memory no more of each than it takes to make the rest.
pub trait Jobs {
    /// Returns the number of jobs.
    fn count(&self) -> usize;

    /// Returns the key of a job. No two jobs of a run share one.
    fn key(&self, job: usize) -> JobKey;

    /// Returns the number of the group of a job. Jobs of one group share something costly and go to
    /// one worker one after another.
    fn group(&self, job: usize) -> u64;

    /// Returns the rank of a job, by which a run serves early answers: within a group, and between
    /// groups by their first jobs, those of lower rank go first.
    fn rank(&self, job: usize) -> u32;

    /// Returns the predicted time of a job \[s\]. It orders jobs within a group and stretches
    /// deadlines, and it is corrected by the real times of the jobs.
    fn cost(&self, job: usize) -> f64;

    /// Returns the predicted memory of a job while it runs, on top of what every worker needs
    /// \[bytes\].
    fn memory(&self, job: usize) -> u64;

    /// Returns the number of bytes of the payload of a job, or about that.
    fn size(&self, job: usize) -> usize;

    /// Makes the payload of a job: the bytes that [`Executor::run`](crate::Executor::run) receives.
    ///
    /// # Errors
    /// The bytes cannot be made. The error ends the run.
    fn payload(&self, job: usize) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>>;
}

/// A job of a list in memory. Its fields are what the methods of [`Jobs`] of the same names return.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // They are said at the methods.
pub struct Task {
    pub key: JobKey,
    pub payload: Vec<u8>,
    pub group: u64,
    pub rank: u32,
    pub cost: f64,
    pub memory: u64,
}

impl Jobs for Vec<Task> {
    fn count(&self) -> usize {
        self.len()
    }

    fn key(&self, job: usize) -> JobKey {
        self[job].key
    }

    fn group(&self, job: usize) -> u64 {
        self[job].group
    }

    fn rank(&self, job: usize) -> u32 {
        self[job].rank
    }

    fn cost(&self, job: usize) -> f64 {
        self[job].cost
    }

    fn memory(&self, job: usize) -> u64 {
        self[job].memory
    }

    fn size(&self, job: usize) -> usize {
        self[job].payload.len()
    }

    fn payload(&self, job: usize) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>> {
        Ok(Cow::Borrowed(&self[job].payload))
    }
}

impl<J: Jobs> Jobs for &J {
    fn count(&self) -> usize {
        (**self).count()
    }

    fn key(&self, job: usize) -> JobKey {
        (**self).key(job)
    }

    fn group(&self, job: usize) -> u64 {
        (**self).group(job)
    }

    fn rank(&self, job: usize) -> u32 {
        (**self).rank(job)
    }

    fn cost(&self, job: usize) -> f64 {
        (**self).cost(job)
    }

    fn memory(&self, job: usize) -> u64 {
        (**self).memory(job)
    }

    fn size(&self, job: usize) -> usize {
        (**self).size(job)
    }

    fn payload(&self, job: usize) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>> {
        (**self).payload(job)
    }
}
