//! Load control for a method that only knows prescribed motions, as an outer iteration.

use primitives::FullPivotLu;

use super::controls::{first_approach, governed, imbalances, target};
use super::iterate::{Conditions, Iterate, Start, Stop, StopRule};
use super::newton;
use crate::model::{Dof, PerDof, Route};
use crate::problem::{Operator, Problem};

/// The number of outer iterations after which load control gives up.
const MAX_ROUNDS: u64 = 40;

/// A solver for prescribed motions. It solves the problem as it is placed, from the tractions of
/// the start.
pub(super) type Inner = fn(&mut Problem, &Operator, &Start, &StopRule<'_>) -> Iterate;

/// The outer step that led to a motion.
struct OuterStep {
    /// The motion before it.
    motion: PerDof<f64>,
    /// The changes of the motions that forces govern.
    change: Vec<f64>,
    /// The largest imbalance before it.
    imbalance: f64,
}

/// Finds the motions that forces govern by Newton's method on the resultants. Their derivative is
/// that of the linearised map; each evaluation is a solve by `inner` from the last one's tractions.
/// Afterwards `problem` is at the motion found.
pub(super) fn solve(
    problem: &mut Problem,
    operator: &Operator,
    conditions: &Conditions<'_>,
    inner: Inner,
) -> Iterate {
    let Conditions { controls, start, rule } = *conditions;
    let governed = governed(controls);
    let targets = controls.map(target);
    let initial = |dof: Dof| if governed.contains(&dof) { start.motion[dof] } else { targets[dof] };
    let mut motion = PerDof::from_fn(initial);
    let mut p = start.p.clone();
    if governed.contains(&Dof::Approach) && p.iter().all(|p| *p == 0.0) {
        motion[Dof::Approach] = first_approach(problem, &motion, targets[Dof::Approach]);
    }
    let mut total = Iterate {
        p: Vec::new(),
        motion,
        stop: Stop::Diverged,
        iterations: 0,
        operator_applications: 0,
        route: if governed.is_empty() { Route::Newton } else { Route::NewtonWithinForces },
    };
    let mut scratch = operator.scratch();
    let mut last: Option<OuterStep> = None;
    for round in 0.. {
        problem.place(&motion);
        let solved = inner(problem, operator, &Start::new(p, motion), rule);
        total.iterations += solved.iterations;
        total.operator_applications += solved.operator_applications;
        p = solved.p;
        total.stop = solved.stop;
        total.route = total.route.max(solved.route);
        let worst = imbalances(problem, &p, &targets, &governed).into_iter().fold(0.0, f64::max);
        if solved.stop != Stop::Converged || worst <= 0.5 * rule.tolerance {
            break;
        }
        if round >= MAX_ROUNDS {
            total.stop = Stop::OutOfIterations { residual: worst };
            break;
        }
        if let Some(last) = &mut last
            && worst >= last.imbalance
        {
            // The step was too far, so it is taken halfway back.
            last.change.iter_mut().for_each(|change| *change *= 0.5);
            motion = last.motion;
            governed.iter().zip(&last.change).for_each(|(&dof, change)| motion[dof] += change);
            continue;
        }
        let mut w = vec![0.0; p.len()];
        operator.apply(&mut w, &p, &mut scratch);
        w.iter_mut().zip(&problem.f).for_each(|(w, f)| *w -= f);
        let (stiffness, applications) =
            newton::stiffness(problem, operator, [&p, &w], &governed, rule);
        total.operator_applications += applications + 1;
        let resultants = problem.resultants(&p);
        let mut change = faer::Mat::from_fn(governed.len(), 1, |i, _| {
            targets[governed[i]] - resultants[governed[i]]
        });
        FullPivotLu::new(&stiffness).solve(&mut change);
        let change: Vec<f64> = (0..governed.len()).map(|i| change[(i, 0)]).collect();
        last = Some(OuterStep { motion, change: change.clone(), imbalance: worst });
        governed.iter().zip(&change).for_each(|(&dof, change)| motion[dof] += change);
        if motion.iter().any(|q| !q.is_finite()) {
            total.stop = Stop::Diverged;
            motion = total.motion;
            break;
        }
        total.motion = motion;
    }
    problem.place(&motion);
    Iterate { p, motion, ..total }
}
