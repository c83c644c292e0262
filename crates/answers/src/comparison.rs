//! The comparison of the points of a study.

use std::borrow::Cow;

use report::DataTable;
use serde::{Deserialize, Serialize};
use study::columns::Compared;

/// The comparison of the points of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Comparison {
    /// The distance of each point from its reference, an entry for each point.
    pub(crate) compared: Vec<Option<Compared>>,
    /// The answers of the study beyond its rows.
    pub(crate) answers: Vec<AnswerTable>,
}

/// An answer of a study beyond its rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AnswerTable {
    /// The title.
    pub title: Cow<'static, str>,
    /// The rows; a table of one cell is a sentence.
    pub table: DataTable,
}

impl Comparison {
    /// Returns the comparison of so many points, none of which is compared yet.
    pub(crate) fn of_points(count: usize) -> Self {
        Self { compared: vec![None; count], answers: Vec::new() }
    }
}
