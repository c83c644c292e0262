//! The answers of studies, from the results of their jobs.
//!
//! A [`Study`](study::Study) and the [`Records`] that its jobs have left give [`Results`]: the rows
//! of a table, and the answers that no single row holds. Nothing here opens a store, starts a
//! process or prints: the caller hands over records and gets tables.
//!
//! From the bottom to the top:
//!
//! - [`records`](Records), [`Accounts`], places, [`rows`] and comparisons are what everything else
//!   is made of.
//! - [`choice`] finds the points that a study wants next, by the results that it has.
//! - `statistics` and `sensitivity` are about numbers alone; `described` says what the points of a
//!   sample say of a column, `influence` how much each key moves it.
//! - `convergence` compares the rungs of a ladder with their limit, `cost` holds their errors
//!   against their times.
//! - [`effects`] tells which effects jobs call for, and what leaving out the others saves;
//!   [`patches`] and `solutions` read what one job has left.
//! - `kind` says of each kind of study what is done with its jobs ([`perform`], [`forecast`]) and
//!   how it answers.
//! - [`SubjectCounts`] say what of the method and of the effects the jobs of a study use, for a
//!   list of references.
//! - [`shards`] cuts a study into parts for machines that do not know of each other.
//! - [`Results`] puts these together, a [`Selection`] of it is a table, and two of them have a
//!   [`Difference`]. Rows that were made once can be kept ([`RowKeeper`]) and chosen from again
//!   ([`TabledRows`]).
#![forbid(unsafe_code)]

mod accounts;
mod block;
pub mod choice;
mod citations;
mod comparison;
mod convergence;
mod cost;
mod described;
mod difference;
pub mod effects;
mod error;
mod evidence;
mod influence;
mod interior;
mod kind;
pub mod patches;
mod path;
mod perform;
mod place;
mod progress;
mod records;
mod results;
pub mod rows;
mod selection;
mod sensitivity;
pub mod shards;
mod solutions;
mod statistics;
mod study_rows;
mod survey;
mod tabled;
#[cfg(test)]
mod testing;
mod undrawn;
mod variation;
mod warnings;

pub use accounts::{Accounts, ComputingRun};
pub use citations::{SubjectCounts, UsedSubject};
pub use comparison::AnswerTable;
pub use difference::Difference;
pub use error::AnswerError;
pub use kind::{
    Proof, RecordSize, bracket_ends, check, forecast, is_timed, perform, proof, tables_of,
    too_large,
};
pub use path::path_columns;
pub use perform::Performed;
pub use place::StudyPlace;
pub use progress::{FailedResult, Failures, Progress};
pub use records::{RecordMap, Records, RecordsError};
pub use results::{FigureRows, POINTS_IN_MEMORY, Results};
pub use selection::{RowSource, Selection};
pub use study_rows::StudyRows;
pub use survey::survey;
pub use tabled::{
    ROWS_OF_A_BLOCK, RowKeeper, SurveyNotes, TabledColumn, TabledRows, cells_of_account,
    tabled_columns,
};
pub use undrawn::Undrawn;
pub use warnings::{Warning, warnings};
