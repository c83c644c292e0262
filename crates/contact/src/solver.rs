//! One entry point for all methods: a problem, its operator and what governs the punch in, an
//! iterate with figures out.
//!
//! Knows [`problem`](crate::problem) and what is below it; no certificate.

use crate::model::{Method, Way};
use crate::problem::{Operators, Problem, Stage};

mod controls;
mod fallback;
mod free;
mod gmres;
mod iterate;
mod load_control;
pub(crate) mod newton;
pub mod seidel;
mod vector;

pub(crate) use iterate::{Conditions, Start};
pub use iterate::{Iterate, Stop, StopRule};

/// Solves `problem` by a method (one [chosen](Method::chosen) already) under `controls` (in the
/// problem's units), from `start`, in `stages` if the method can; leaves the problem placed at the
/// motion found.
pub(crate) fn solve(
    method: Method,
    problem: &mut Problem,
    operators: &mut Operators,
    stages: &[Stage],
    conditions: &Conditions<'_>,
) -> Iterate {
    let Conditions { controls, start, .. } = *conditions;
    if let Some(stop) = controls::impossible(problem, controls) {
        let motion = start.motion;
        problem.place(&motion);
        return Iterate {
            p: start.p.clone(),
            motion,
            stop,
            iterations: 0,
            operator_applications: 0,
            route: Way::default(),
        };
    }
    let iterate = match method {
        Method::Seidel => {
            let operator = operators.of(problem);
            load_control::solve(problem, &operator, conditions, |problem, operator, start, rule| {
                seidel::solve(problem, &operator.table, start.p.clone(), rule)
            })
        }
        Method::Newton | Method::Auto => fallback::solve(problem, operators, stages, conditions),
    };
    if iterate.stop == Stop::Converged {
        iterate
    } else {
        Iterate { stop: controls::explain(problem, controls, &iterate), ..iterate }
    }
}
