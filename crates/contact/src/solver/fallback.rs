//! Newton's method with ways back. Where it does not converge, the motions that forces govern are
//! found in an outer iteration; where it does not converge with all motion prescribed, it takes
//! turns with Seidel sweeps, which always bring the iterate nearer, and in the end these are left
//! alone.

use super::iterate::{Conditions, Iterate, Start, Stop, StopRule};
use super::{load_control, newton, seidel};
use crate::influence::{Direction, Mirror};
use crate::model::{Control, Dof, Way};
use crate::problem::{Operator, Operators, Problem, Stage};

/// Rounds of Seidel sweeps that may bring a start within Newton's reach, and the sweeps of each.
const ROUNDS: u32 = 6;
const SWEEPS: u32 = 25;

/// Solves `problem` under `controls` from `start`: stage by stage, and where a stage fails as a
/// whole.
pub(super) fn solve(
    problem: &mut Problem,
    operators: &mut Operators,
    stages: &[Stage],
    conditions: &Conditions<'_>,
) -> Iterate {
    let direct = staged(problem, operators, stages, conditions);
    if matches!(direct.stop, Stop::Converged | Stop::OutOfIterations { .. }) {
        return direct;
    }
    let operator = operators.of(problem);
    let second = load_control::solve(problem, &operator, conditions, prescribed);
    adding_work(&direct, second)
}

/// Newton's method on one stage after the other.
fn staged(
    problem: &mut Problem,
    operators: &mut Operators,
    stages: &[Stage],
    conditions: &Conditions<'_>,
) -> Iterate {
    let Conditions { controls, start, rule } = *conditions;
    let mut total = Iterate {
        p: vec![0.0; problem.f.len()],
        motion: start.motion,
        stop: Stop::Converged,
        iterations: 0,
        operator_applications: 0,
        route: Way::Newton,
    };
    for (motion, control) in total.motion.iter_mut().zip(controls) {
        if let Control::Motion(value) = control {
            *motion = *value;
        }
    }
    let k = problem.grid.len();
    for stage in stages {
        let given = (!stage.components.contains(Direction::N)).then(|| &total.p[..k]);
        let reduced = problem.reduced(stage.components, stage.mirror, given);
        // a coarse grid may have no plane of elements' edges in its middle
        let whole = || {
            problem
                .reduced(stage.components, Mirror::NONE, given)
                .expect("without a mirror plane there is nothing to refuse")
        };
        let mut reduced = reduced.unwrap_or_else(|_| whole());
        let operator = operators.of(&reduced);
        // what the stage has no components for, or what a mirror plane forbids, stays where it is
        let mut stage_controls = *controls;
        for dof in Dof::ALL {
            if !reduced.moves(dof) {
                stage_controls[dof] = Control::Motion(total.motion[dof]);
            }
        }
        let stage_start = Start {
            p: problem.part(reduced.components, reduced.mirror, &start.p),
            motion: total.motion,
        };
        let conditions = Conditions { controls: &stage_controls, start: &stage_start, rule };
        let solved = newton::solve(&mut reduced, &operator, &conditions);
        total.iterations += solved.iterations;
        total.operator_applications += solved.operator_applications;
        problem.extend(&reduced, &solved.p, &mut total.p);
        total.motion = solved.motion;
        total.stop = solved.stop;
        if solved.stop != Stop::Converged {
            break;
        }
    }
    problem.place(&total.motion);
    total
}

/// All motion prescribed: Newton's method and Seidel sweeps in turn, in the end the latter alone.
fn prescribed(
    problem: &mut Problem,
    operator: &Operator,
    start: &Start,
    rule: &StopRule,
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
        let swept = adding_work(&iterate, swept);
        if swept.stop == Stop::Converged {
            return Iterate { motion: start.motion, route: Way::NewtonAndSeidel, ..swept };
        }
        let swept_start = Start { p: swept.p.clone(), motion: start.motion };
        let conditions = Conditions { controls: &controls, start: &swept_start, rule };
        let tried = newton::solve(problem, operator, &conditions);
        iterate = Iterate { route: Way::NewtonAndSeidel, ..adding_work(&swept, tried) };
        if iterate.stop != Stop::Converged {
            iterate.p = swept.p;
        }
    }
    iterate
}

/// The second of two attempts, with the work of both.
fn adding_work(first: &Iterate, second: Iterate) -> Iterate {
    Iterate {
        iterations: first.iterations + second.iterations,
        operator_applications: first.operator_applications + second.operator_applications,
        route: first.route.max(second.route),
        ..second
    }
}
