//! A job as the caller gives it.

use identity::JobKey;

/// One job to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Its identity; no two tasks of a run share one.
    pub key: JobKey,
    /// What [`Executor::run`] receives.
    pub payload: Vec<u8>,
    /// Tasks of one group share something costly and go to one worker one after another.
    pub group: u64,
    /// Predicted seconds. Orders jobs within a group and stretches deadlines; corrected by what
    /// jobs really take.
    pub cost: f64,
    /// Predicted bytes while it runs, on top of what every worker needs.
    pub memory: u64,
}
