//! What the results of a study say together.
//!
//! A [`Study`](study::Study) and the [`Records`] that its jobs have left give [`Results`]: rows of a
//! table, and the answers that no single row holds. Nothing here opens a store, starts a process or
//! prints: whoever has the records hands them over, and gets tables.
//!
//! - [`choice`] says which points a study wants next, by the results that it has.
//! - [`convergence`] compares the rungs of a ladder with their limit: orders and limits.
//! - [`cost`] holds the error of every rung against the time it took.
//! - [`effects`] says which effects the jobs of a study call for, and what leaving out the others
//!   saves.
//! - [`perform`] does a job; [`solutions`] and [`patches`] read what one job has left.
#![forbid(unsafe_code)]

pub mod choice;
pub mod comparison;
pub mod convergence;
pub mod cost;
pub mod effects;
pub mod error;
pub mod ladders;
pub mod patches;
pub mod perform;
pub mod records;
pub mod results;
pub mod rows;
pub mod solutions;

pub use comparison::AnswerTable;
pub use error::AnswerError;
pub use records::{RecordMap, Records, RecordsError};
pub use results::{Progress, Results};
