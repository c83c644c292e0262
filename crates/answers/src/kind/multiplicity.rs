//! Studies that search every point for all of its solutions.

use contact::model::SceneError;
use contact::multiplicity::{self, Multiplicity, Search};
use contact::punch::Surfaces;
use contact::{Forecast, Operators};
use study::{Case, Ending};

use super::size::RecordSize;
use super::solve;
use super::spec::KindAnswers;
use crate::comparison::AnswerTable;
use crate::error::AnswerError;
use crate::perform::{PerformResult, Performed};
use crate::solutions;

/// The kind.
pub(super) const ANSWERS: KindAnswers = solve::ANSWERS;

/// Predicts what searching a scene for solutions will take.
pub(super) fn forecast(
    Case { scene, numerics }: &Case,
    search: &Search,
    surfaces: &Surfaces,
) -> Result<Forecast, SceneError> {
    contact::forecast_search(scene, numerics, surfaces, search)
}

/// Searches a scene for solutions.
pub(super) fn perform(
    Case { scene, numerics }: &Case,
    search: &Search,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> PerformResult {
    let found = multiplicity::search(scene, numerics, surfaces, operators, search)?;
    Ok(Performed::ended(Ending::Searched(found)))
}

/// Returns the solutions that a search has found, as a table.
pub(super) fn tables(found: &Multiplicity) -> Result<Vec<AnswerTable>, AnswerError> {
    Ok(vec![AnswerTable { title: "solutions".into(), table: solutions::table(found)? }])
}

/// Returns a search that fails for the size of its solutions; its counts stay.
pub(super) fn too_large(found: Multiplicity, size: RecordSize) -> Multiplicity {
    let elements = found.solutions.first().map_or(0, |solution| solution.fields.state.len());
    let content = format!("{} solutions on {elements} elements", found.solutions.len());
    let status = size.failure(&content, elements);
    Multiplicity { status, solutions: Vec::new(), ..found }
}
