//! Newton's method with ways back. Where it does not converge, the motions that forces govern are found in an outer iteration;
//! where it does not converge with all motion prescribed, it takes turns with Seidel sweeps, which always bring the iterate
//! nearer, and in the end these are left alone.

use super::{Iterate, Limits, Start, Stop, balance, newton, seidel};
use crate::loading::Control;
use crate::operators::Operator;
use crate::problem::Problem;

/// Rounds of Seidel sweeps that may bring a start within Newton's reach, and the sweeps of each.
const ROUNDS: u32 = 6;
const SWEEPS: u32 = 25;

/// Solves `problem` under `controls` from `start`.
pub(super) fn solve(problem: &mut Problem, operator: &Operator, controls: &[Control; 6], start: &Start, limits: &Limits) -> Iterate {
    let direct = newton::solve(problem, operator, controls, start, limits);
    if matches!(direct.stop, Stop::Converged | Stop::OutOfIterations { .. }) {
        return direct;
    }
    let second = balance::solve(problem, operator, controls, start, limits, prescribed);
    after(&direct, second)
}

/// All motion prescribed: Newton's method and Seidel sweeps in turn, in the end the latter alone.
fn prescribed(problem: &mut Problem, operator: &Operator, start: &Start, limits: &Limits) -> Iterate {
    let controls = start.motion.map(Control::Motion);
    let mut iterate = newton::solve(problem, operator, &controls, start, limits);
    for round in 0..=ROUNDS {
        if iterate.stop == Stop::Converged {
            break;
        }
        let from = if round == 0 { start.p.clone() } else { iterate.p.clone() };
        let sweeps = if round < ROUNDS { SWEEPS } else { limits.max_iterations };
        let swept = seidel::solve(problem, &operator.table, from, &Limits { max_iterations: sweeps, ..*limits });
        let swept = after(&iterate, swept);
        if swept.stop == Stop::Converged {
            return Iterate { motion: start.motion, ..swept };
        }
        let tried = newton::solve(problem, operator, &controls, &Start { p: swept.p.clone(), motion: start.motion }, limits);
        iterate = after(&swept, tried);
        if iterate.stop != Stop::Converged {
            iterate.p = swept.p;
        }
    }
    iterate
}

/// The second of two attempts, with the work of both.
fn after(first: &Iterate, second: Iterate) -> Iterate {
    Iterate {
        iterations: first.iterations + second.iterations,
        operator_applications: first.operator_applications + second.operator_applications,
        ..second
    }
}
