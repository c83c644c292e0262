//! Newton's method, and what is tried where it fails. If it does not converge, an outer iteration
//! finds the motions that forces govern, and with all motions prescribed it takes turns with Seidel
//! sweeps. Where the contact rolls steadily under forces, it is first solved with more friction,
//! and Newton's method takes turns with a path that leads to the steady state.

use super::iterate::{Conditions, Iterate, Start, Stop};
use super::{load_control, newton, prescribed, rolling_in};
use crate::influence::{Direction, Mirror};
use crate::model::{Control, Dof, Route};
use crate::problem::{Operators, Problem, Stage};

/// Solves `problem` under the `conditions` stage by stage; where a stage fails, as a whole.
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
    let has_force =
        |dof: &Dof| matches!(conditions.controls[*dof], Control::Force(force) if force != 0.0);
    let direct = if problem.steady.is_some() && Dof::TANGENTIAL.iter().any(has_force) {
        losing_friction(problem, operators, stages, conditions).after(&direct)
    } else {
        direct
    };
    if direct.stop == Stop::Converged {
        return direct;
    }
    let operator = operators.of(problem);
    // The sweeps know no steady rolling.
    let inner = if problem.steady.is_some() { rolling_in::solve } else { prescribed::solve };
    let second = load_control::solve(problem, &operator, conditions, inner);
    second.after(&direct)
}

/// Solves one stage after the other by Newton's method.
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
        route: Route::Newton,
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
        // A coarse grid may have no plane of elements' edges in its middle.
        let whole = || {
            problem
                .reduced(stage.components, Mirror::NONE, given)
                .expect("without a mirror plane there is nothing to refuse")
        };
        let mut reduced = reduced.unwrap_or_else(|_| whole());
        let operator = operators.of(&reduced);
        // A motion that the stage has no components for, or that a mirror plane forbids, stays as
        // it is.
        let mut stage_controls = *controls;
        for dof in Dof::ALL {
            if !reduced.moves(dof) {
                stage_controls[dof] = Control::Motion(total.motion[dof]);
            }
        }
        let part = |field: &Vec<f64>| problem.part(reduced.components, reduced.mirror, field);
        let stage_start =
            Start { p: part(&start.p), motion: total.motion, w: start.w.as_ref().map(part) };
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

/// The least friction to begin with over that of the problem, the factor by which it falls at
/// first, and the one with which it is given up.
const FRICTION: [f64; 3] = [2.0, 4.0, 1.01];

/// Solves a `problem` that rolls steadily under tangential forces with more friction, which falls
/// from solution to solution. A force grows no more once all of the contact slips, so that
/// creepages that are once too large get larger and larger; with more friction some of it sticks.
fn losing_friction(
    problem: &mut Problem,
    operators: &mut Operators,
    stages: &[Stage],
    conditions: &Conditions<'_>,
) -> Iterate {
    let Conditions { controls, start, rule } = *conditions;
    let mu = problem.mu;
    let [more, mut fall, least] = FRICTION;
    // With μ = 1 some of a contact sticks, however unlike the bodies are.
    let mut next = more.max(1.0 / mu);
    let mut from = Start::new(start.p.clone(), start.motion);
    from.p[problem.grid.len()..].fill(0.0);
    Dof::TANGENTIAL.into_iter().for_each(|dof| from.motion[dof] = 0.0);
    let (mut friction, mut before): (f64, Option<Iterate>) = (f64::INFINITY, None);
    loop {
        problem.mu = next * mu;
        let conditions = Conditions { controls, start: &from, rule };
        let solved = staged(problem, operators, stages, &conditions);
        problem.mu = mu;
        let solved = Iterate { route: Route::NewtonWithinForces, ..solved };
        let solved = match &before {
            Some(before) => solved.after(before),
            None => solved,
        };
        if solved.stop == Stop::Converged {
            if next == 1.0 {
                return solved;
            }
            from = Start::new(solved.p.clone(), solved.motion);
            friction = next;
        } else {
            fall = fall.sqrt();
            if friction.is_infinite() || fall < least || rule.is_cancelled() {
                return solved;
            }
        }
        before = Some(solved);
        next = (friction / fall).max(1.0);
    }
}
