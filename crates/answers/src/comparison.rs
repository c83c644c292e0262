//! What the points of a study say when they are compared.

use report::DataTable;
use study::columns::Compared;

/// What the points of a study say when they are compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Comparison {
    /// How far each point is from what it is compared with, an entry for each point.
    pub(crate) compared: Vec<Option<Compared>>,
    /// What the study says beyond its rows.
    pub(crate) answers: Vec<AnswerTable>,
}

/// A table of what a study says beyond its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerTable {
    /// The title.
    pub title: &'static str,
    /// The rows; a table of one cell is a sentence.
    pub table: DataTable,
}

impl Comparison {
    /// Returns the comparison of so many points, none of which is compared yet.
    pub(crate) fn of_points(count: usize) -> Self {
        Self { compared: vec![None; count], answers: Vec::new() }
    }
}
