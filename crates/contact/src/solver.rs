//! The methods that solve one increment: a problem, its operators and the conditions go in, an
//! iterate with its figures comes out.
//!
//! The folder uses [`problem`](crate::problem) and what is below it; it knows no certificate. In
//! reading order:
//! - `iterate`: a solver's start, its conditions, the iterate that it hands over ([`Iterate`]), and
//!   why it stops ([`Stop`]);
//! - `controls`: forces that no contact can have, the imbalance of an iterate, and a first
//!   approach;
//! - `vector`: sums of long vectors;
//! - `gmres`: the Krylov method for linear systems;
//! - `free`: the free components of a contact, the unknowns of Newton's method;
//! - `trail`: tractions of a contact that rolls, summed from its leading edge;
//! - `newton`: the semismooth Newton method;
//! - `seidel`: Alexandrov's Seidel iteration;
//! - `prescribed`: Newton's method and Seidel sweeps at prescribed motions;
//! - `rolling_in`: a path that leads into a steady state of rolling;
//! - `load_control`: forces for a method that only knows prescribed motions;
//! - `fallback`: Newton's method, and what is tried where it fails.

use crate::model::{Method, Route};
use crate::problem::{Operators, Problem, Stage};

mod controls;
mod fallback;
mod free;
mod gmres;
mod iterate;
mod load_control;
pub(crate) mod newton;
mod prescribed;
mod rolling_in;
pub mod seidel;
mod trail;
mod vector;

pub(crate) use iterate::{Conditions, Start};
pub use iterate::{Iterate, Stop, StopRule};

/// Solves one increment. `method` must not be `Auto`. The controls and the start are in the
/// problem's units. Newton's method works through `stages` in order; Seidel's iteration ignores
/// them. Afterwards `problem` is at the motion found.
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
            route: Route::default(),
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
