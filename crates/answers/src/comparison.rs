//! What points say when they are compared.

use report::DataTable;
use study::columns::Compared;

/// What the points of a study say when they are compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// How far each point is from what it is compared with; empty if nothing is compared.
    pub compared: Vec<Option<Compared>>,
    /// What the study says beyond its rows.
    pub answers: Vec<AnswerTable>,
}

/// A table of what a study says beyond its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerTable {
    /// The title.
    pub title: &'static str,
    /// The rows; a table of one cell is a sentence.
    pub table: DataTable,
}
