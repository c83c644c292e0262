//! The kinds of studies and of jobs: the doing of a job and the answers of a study.
//!
//! Each kind is a file below this one that says everything that this crate knows of it. This face
//! holds the one registration of each kind of study ([`answers_of`]) and the matches on the closed
//! enums [`Job`] and [`Ending`]. The files use whatever lies below them, from [`convergence`] and
//! [`cost`](crate::cost) to places and rows, but not this face.
//!
//! [`convergence`]: crate::convergence

mod convergence;
mod cost;
mod multiplicity;
mod sensitivity;
mod size;
mod solve;
mod spec;
mod uniqueness;

use contact::model::SceneError;
use contact::punch::Surfaces;
use contact::{Forecast, Operators};
use study::{Ending, Job, Kind, Record, Study, StudyPoint};

use crate::comparison::AnswerTable;
use crate::error::AnswerError;
use crate::interior;
use crate::perform::Performed;

pub use size::RecordSize;
pub(crate) use spec::KindAnswers;
pub use uniqueness::{Proof, bracket_ends, proof};

/// Returns what is known of a kind of study.
pub(crate) fn answers_of(kind: Kind) -> &'static KindAnswers {
    match kind {
        Kind::Solve => &solve::ANSWERS,
        Kind::Convergence => &convergence::ANSWERS,
        Kind::Cost => &cost::ANSWERS,
        Kind::Multiplicity => &multiplicity::ANSWERS,
        Kind::Sensitivity => &sensitivity::ANSWERS,
        Kind::Uniqueness => &uniqueness::ANSWERS,
    }
}

/// Tells whether the jobs of a kind of study are timed, so that nothing else may run beside them.
pub fn is_timed(kind: Kind) -> bool {
    answers_of(kind).is_timed
}

/// Refuses a study that asks its scenes for something that they do not have, before anything is
/// solved.
///
/// # Errors
/// [`AnswerError::Refused`].
pub fn check(study: &Study, points: &[StudyPoint]) -> Result<(), AnswerError> {
    (answers_of(study.kind()).check)(study, points)
}

/// Predicts what a job will take.
///
/// # Errors
/// The scene has no meaning, or its surfaces are missing.
pub fn forecast(job: &Job, surfaces: &Surfaces) -> Result<Forecast, SceneError> {
    match job {
        Job::Solve(case) => solve::forecast(case, surfaces),
        Job::Cost { case, repeat, .. } => cost::forecast(case, *repeat, surfaces),
        Job::Uniqueness { question, search } => contact::forecast_bracket(question, search),
        Job::Branch { question, branch } => contact::forecast_branch(question, branch),
        Job::Multiplicity { case, search } => multiplicity::forecast(case, search, surfaces),
    }
}

/// Does a job. `operators` keeps what jobs of the same operator share.
///
/// # Errors
/// The scene has no meaning, or its surfaces are missing.
pub fn perform(
    job: &Job,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> Result<Performed, SceneError> {
    match job {
        Job::Solve(case) => solve::perform(case, surfaces, operators),
        Job::Cost { case, repeat, threads } => cost::perform(case, *repeat, *threads, surfaces),
        Job::Uniqueness { question, search } => uniqueness::perform(question, search),
        Job::Branch { question, branch } => uniqueness::perform_branch(question, branch),
        Job::Multiplicity { case, search } => {
            multiplicity::perform(case, search, surfaces, operators)
        }
    }
}

/// Returns the tables that a record holds besides its figures.
///
/// # Errors
/// Rows do not fit together as a table.
pub fn tables_of(record: &Record) -> Result<Vec<AnswerTable>, AnswerError> {
    match &record.ending {
        Ending::Searched(found) => multiplicity::tables(found),
        Ending::Finished(outcome) => {
            outcome.further.interior.as_ref().map_or(Ok(Vec::new()), interior::tables)
        }
        Ending::Bracketed(_) | Ending::Branched(_) | Ending::Quarantined { .. } => Ok(Vec::new()),
    }
}

/// Returns an ending that fails for the size of its record, and says so, in place of one that makes
/// the record too large.
pub fn too_large(ending: Ending, size: RecordSize) -> Ending {
    match ending {
        Ending::Searched(found) => Ending::Searched(multiplicity::too_large(found, size)),
        Ending::Bracketed(found) => {
            Ending::Bracketed(Box::new(uniqueness::too_large(&found, size)))
        }
        // A branch has few cones. The longest path fits with all that a scene asks for, as a test
        // of records shows, and its fields are elsewhere.
        Ending::Finished(_) | Ending::Branched(_) | Ending::Quarantined { .. } => ending,
    }
}
