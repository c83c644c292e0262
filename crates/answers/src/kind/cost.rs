//! Studies that hold the error of every point against its time.

use std::time::Instant;

use contact::model::{Fields, Outcome, SceneError};
use contact::punch::Surfaces;
use contact::{Forecast, Operators};
use study::{Case, Ending};

use super::solve;
use super::spec::KindAnswers;
use crate::comparison::Comparison;
use crate::cost;
use crate::perform::{PerformResult, Performed};

/// The kind.
pub(super) const ANSWERS: KindAnswers = KindAnswers {
    check: |study, points| match &study.cost() {
        Some(cost) => cost::check(study, cost, points),
        None => Ok(()),
    },
    compare: |evidence| match &evidence.study.cost() {
        Some(cost) => cost::compare(evidence, cost),
        None => Ok(Comparison::of_points(evidence.points.len())),
    },
    about: None,
    tells_choice: false,
    is_timed: true,
};

/// Predicts what solving a scene `repeat` times will take.
pub(super) fn forecast(
    case: &Case,
    repeat: u32,
    surfaces: &Surfaces,
) -> Result<Forecast, SceneError> {
    let once = solve::forecast(case, surfaces)?;
    Ok(Forecast { seconds: once.seconds * f64::from(repeat), assembly: 0.0, ..once })
}

/// Solves a scene `repeat` times on so many threads, each time from the scene to the result:
/// nothing is kept from one time to the next.
pub(super) fn perform(
    Case { scene, numerics }: &Case,
    repeat: u32,
    threads: u32,
    surfaces: &Surfaces,
) -> PerformResult {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build();
    let pool = pool.map_err(|error| SceneError {
        key: "cost.threads".to_owned(),
        value: threads.to_string(),
        expected: format!("must be so many threads as can be started: {error}"),
    })?;
    let mut times = Vec::new();
    let mut once = || -> Result<(Outcome, Fields), SceneError> {
        let start = Instant::now();
        let solved =
            pool.install(|| contact::solve(scene, numerics, surfaces, &mut Operators::default()));
        times.push(start.elapsed().as_secs_f64());
        solved
    };
    for _ in 1..repeat {
        once()?;
    }
    let (outcome, fields) = once()?;
    Ok(Performed { ending: Ending::Finished(outcome), fields: Some(fields), times })
}
