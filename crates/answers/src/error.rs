//! Why a study has no answer.

use contact::model::SceneError;
use report::{FilterError, TableError};
use study::StudyError;
use thiserror::Error;

use crate::records::RecordsError;

/// Why a study has no answer.
#[derive(Debug, Error)]
pub enum AnswerError {
    /// The study asks what cannot be asked; the error names the place in its file.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The study asks its scenes for something that they do not have.
    #[error("{0}")]
    Refused(String),
    /// A scene has no meaning.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A condition cannot be evaluated.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// Rows do not fit together as a table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// There is no such column, but one that others call so.
    #[error("there is no column `{name}`; did you mean {meant}?")]
    OtherName {
        /// The name that was given.
        name: String,
        /// The column that is probably meant.
        meant: String,
    },
    /// Two studies have no points that could be the same.
    #[error(
        "points are matched by the values of the axes of both studies, and `{study}` has no column \
         `{column}`"
    )]
    NotMatched {
        /// The column of the axis.
        column: String,
        /// The study without it.
        study: String,
    },
    /// The results cannot be read.
    #[error(transparent)]
    Records(RecordsError),
    /// The study does not hold what its reader has checked.
    #[error("{0}")]
    Inconsistent(&'static str),
}
