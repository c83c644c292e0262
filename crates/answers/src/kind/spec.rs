//! The description of a kind of study.

use study::{Column, Study, StudyPoint};

use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::evidence::Evidence;

/// An answer of the points of a sample about some columns of numbers.
pub(crate) type SampleAnswer =
    fn(&Evidence<'_>, &[Column]) -> Result<Vec<AnswerTable>, AnswerError>;

/// Everything that this crate knows of one kind of study. A kind that shares most of this with the
/// solving of scenes takes it from there.
pub(crate) struct KindAnswers {
    /// Refuses a study that asks its scenes for something that they do not have, before anything is
    /// solved.
    pub(crate) check: fn(&Study, &[StudyPoint]) -> Result<(), AnswerError>,
    /// Compares the points, and answers.
    pub(crate) compare: fn(&Evidence<'_>) -> Result<Comparison, AnswerError>,
    /// Tells what the points of a sample say of some columns of numbers; `None` if the points are
    /// compared with each other in another way.
    pub(crate) about: Option<SampleAnswer>,
    /// The table of findings, if points were chosen, stands before the answers.
    pub(crate) tells_choice: bool,
    /// The jobs are timed, so that nothing else may run beside them.
    pub(crate) is_timed: bool,
}
