//! Newton's method at prescribed motions. If it does not converge, it takes turns with Seidel
//! sweeps, which always bring the iterate nearer. In the end the sweeps run alone.

use super::iterate::{Conditions, Iterate, Start, Stop, StopRule};
use super::{newton, seidel};
use crate::model::{Control, Route};
use crate::problem::{Operator, Problem};

/// The number of rounds of Seidel sweeps that may bring a start within Newton's reach.
const ROUNDS: u32 = 6;
/// The number of sweeps of a round.
const SWEEPS: u32 = 25;

/// Solves `problem` at prescribed motions: Newton's method and Seidel sweeps take turns, and in the
/// end the sweeps run alone.
pub(super) fn solve(
    problem: &mut Problem,
    operator: &Operator,
    start: &Start,
    rule: &StopRule<'_>,
) -> Iterate {
    let controls = start.motion.map(Control::Motion);
    let mut iterate =
        newton::solve(problem, operator, &Conditions { controls: &controls, start, rule });
    for round in 0..=ROUNDS {
        if iterate.stop == Stop::Converged {
            break;
        }
        let tractions = if round == 0 { start.p.clone() } else { iterate.p.clone() };
        let sweeps = if round < ROUNDS { SWEEPS } else { rule.max_iterations };
        let swept = seidel::solve(
            problem,
            &operator.table,
            tractions,
            &StopRule { max_iterations: sweeps, ..*rule },
        );
        let swept = swept.after(&iterate);
        if swept.stop == Stop::Converged {
            return Iterate { motion: start.motion, route: Route::NewtonAndSeidel, ..swept };
        }
        let swept_start = Start::new(swept.p.clone(), start.motion);
        let conditions = Conditions { controls: &controls, start: &swept_start, rule };
        let tried = newton::solve(problem, operator, &conditions);
        iterate = Iterate { route: Route::NewtonAndSeidel, ..tried.after(&swept) };
        if iterate.stop != Stop::Converged {
            iterate.p = swept.p;
        }
    }
    iterate
}
