//! The result of doing a job.

use contact::model::{Fields, SceneError};
use study::Ending;

/// The result of doing a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Performed {
    /// The ending of the job.
    pub ending: Ending,
    /// The fields, if the job leaves some beside its ending.
    pub fields: Option<Fields>,
    /// The time that each repetition took, for a job that is timed \[s\].
    pub times: Vec<f64>,
}

impl Performed {
    /// Returns what a job has left that is not timed and leaves no fields.
    pub(crate) fn ended(ending: Ending) -> Self {
        Self { ending, fields: None, times: Vec::new() }
    }
}

/// The outcome of doing a job; a scene without a meaning is an error.
pub(crate) type PerformResult = Result<Performed, SceneError>;
