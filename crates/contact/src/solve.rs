//! From a scene to a certified outcome.

use crate::certificate::certify;
use crate::influence::{Influence, Scratch};
use crate::observables::{fields, observables, states};
use crate::operators::Operators;
use crate::outcome::{Fields, Outcome, Status, WorkDone};
use crate::problem::Problem;
use crate::punch::Surfaces;
use crate::scene::{Method, Numerics, Scene, SceneError};
use crate::solver::{Iterate, Limits, Stop, seidel};

/// Solves a scene: binds it to its grid, runs the method, certifies the result with code and an operator that the
/// method does not use, and derives the observables. What cannot mean anything is an error; a solve that does not meet
/// its tolerance is an [`Outcome`] with [`Status::Failed`].
pub fn solve(scene: &Scene, numerics: &Numerics, surfaces: &Surfaces, operators: &mut Operators) -> Result<(Outcome, Fields), SceneError> {
    let problem = Problem::new(scene, numerics, surfaces)?;
    let operator = operators.of(&problem);
    let limits = Limits { tolerance: numerics.tolerance, max_iterations: numerics.max_iterations };
    let iterate = match numerics.method {
        Method::Seidel => seidel::solve(&problem, &operator.table, vec![0.0; problem.f.len()], &limits),
    };
    Ok(conclude(&problem, &*operator.toeplitz, operator.table.largest_diagonal(), &iterate, numerics.tolerance))
}

/// Certifies an iterate with `operator` and derives what goes out.
pub fn conclude(problem: &Problem, operator: &dyn Influence, diagonal: f64, iterate: &Iterate, tolerance: f64) -> (Outcome, Fields) {
    let p = &iterate.p;
    let mut displacement = vec![0.0; p.len()];
    operator.apply(&mut displacement, p, &mut Scratch::new(operator));
    let k = problem.grid.len();
    let mut w = vec![0.0; p.len()];
    for e in problem.grid.active() {
        for at in [e, k + e, 2 * k + e] {
            w[at] = displacement[at] - problem.f[at];
        }
    }
    let states = states(problem, p, &w, diagonal);
    let observables = observables(problem, p, &w, &states);
    let certificate = certify(problem, p, &displacement, diagonal, &observables);
    let status = if certificate.meets(tolerance) {
        Status::Certified
    } else {
        let stop = match iterate.stop {
            Stop::Converged => "the solver took it for converged".to_owned(),
            Stop::OutOfIterations { residual } => format!("not converged in {} iterations (residual {residual:.1e})", iterate.iterations),
            Stop::Stalled { residual } => format!("stalled after {} iterations (smallest residual {residual:.1e})", iterate.iterations),
            Stop::Diverged => format!("diverged after {} iterations", iterate.iterations),
        };
        Status::Failed {
            reason: format!(
                "{stop}; the certificate has residual {:.1e}, tension {:.1e}, cone violation {:.1e}, force imbalance {:.1e} where {tolerance:.1e} was asked",
                certificate.residual, certificate.tension, certificate.cone_violation, certificate.force_imbalance
            ),
        }
    };
    let work = WorkDone { iterations: iterate.iterations, operator_applications: iterate.operator_applications };
    (Outcome { status, observables, certificate, work }, fields(problem, p, &w, &states))
}
