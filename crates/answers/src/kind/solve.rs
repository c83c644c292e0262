//! Studies that solve every point.

use contact::model::SceneError;
use contact::punch::Surfaces;
use contact::{Forecast, Operators};
use study::{Case, Ending};

use super::spec::KindAnswers;
use crate::comparison::Comparison;
use crate::described;
use crate::perform::{PerformResult, Performed};

/// The kind. Its rows are its answer.
pub(super) const ANSWERS: KindAnswers = KindAnswers {
    check: |_, _| Ok(()),
    compare: |evidence| Ok(Comparison::of_points(evidence.points.len())),
    about: Some(described::tables),
    tells_choice: true,
    is_timed: false,
};

/// Predicts what solving a scene will take.
pub(super) fn forecast(
    Case { scene, numerics }: &Case,
    surfaces: &Surfaces,
) -> Result<Forecast, SceneError> {
    contact::forecast(scene, numerics, surfaces)
}

/// Solves a scene.
pub(super) fn perform(
    Case { scene, numerics }: &Case,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> PerformResult {
    let (outcome, fields) = contact::solve(scene, numerics, surfaces, operators)?;
    let fields = Some(fields);
    Ok(Performed { ending: Ending::Finished(outcome), fields, times: Vec::new() })
}
