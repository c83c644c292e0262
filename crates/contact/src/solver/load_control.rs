//! Load control for a method that only knows prescribed motions: an outer iteration.

use faer::linalg::solvers::Solve;

use super::controls::{first_approach, free, imbalances, value};
use super::iterate::{Iterate, Start, Stop, StopRule};
use super::newton;
use crate::model::{Control, Way};
use crate::problem::{Operator, Problem};

/// Outer iterations after which load control gives up.
const MAX_ROUNDS: u64 = 40;

/// A solver for prescribed motions: solves the problem as it is placed, from these tractions.
pub(super) type Inner = fn(&mut Problem, &Operator, &Start, &StopRule) -> Iterate;

/// The motions that a force governs by Newton's method on the resultants: their derivative is that
/// of the linearised map, each evaluation a solve by `inner` from the last one's tractions.
pub(super) fn solve(
    problem: &mut Problem,
    operator: &Operator,
    controls: &[Control; 6],
    start: &Start,
    rule: &StopRule,
    inner: Inner,
) -> Iterate {
    let free = free(controls);
    let asked = controls.map(value);
    let mut motion: [f64; 6] =
        std::array::from_fn(
            |which| if free.contains(&which) { start.motion[which] } else { asked[which] },
        );
    let mut p = start.p.clone();
    if free.contains(&0) && p.iter().all(|p| *p == 0.0) {
        motion[0] = first_approach(problem, &motion, asked[0]);
    }
    let mut total = Iterate {
        p: Vec::new(),
        motion,
        stop: Stop::Diverged,
        iterations: 0,
        operator_applications: 0,
        way: if free.is_empty() { Way::Newton } else { Way::NewtonWithinForces },
    };
    let mut scratch = operator.scratch();
    // the step that led here, and the imbalance before it
    let mut last: Option<([f64; 6], Vec<f64>, f64)> = None;
    for round in 0.. {
        problem.place(&motion);
        let solved = inner(problem, operator, &Start { p, motion }, rule);
        total.iterations += solved.iterations;
        total.operator_applications += solved.operator_applications;
        p = solved.p;
        total.stop = solved.stop;
        total.way = total.way.max(solved.way);
        let worst = imbalances(problem, &p, &asked, &free).into_iter().fold(0.0, f64::max);
        if solved.stop != Stop::Converged || worst <= 0.5 * rule.tolerance {
            break;
        }
        if round >= MAX_ROUNDS {
            total.stop = Stop::OutOfIterations { residual: worst };
            break;
        }
        if let Some((before, way, was)) = &mut last
            && worst >= *was
        {
            // too far: halfway back
            way.iter_mut().for_each(|way| *way *= 0.5);
            motion = *before;
            free.iter().zip(way.iter()).for_each(|(&which, way)| motion[which] += way);
            continue;
        }
        let mut w = vec![0.0; p.len()];
        operator.apply(&mut w, &p, &mut scratch);
        w.iter_mut().zip(&problem.f).for_each(|(w, f)| *w -= f);
        let (stiffness, applications) = newton::stiffness(problem, operator, &p, &w, &free);
        total.operator_applications += applications + 1;
        let resultants = problem.resultants(&p);
        let mut way =
            faer::Mat::from_fn(free.len(), 1, |i, _| asked[free[i]] - resultants[free[i]]);
        stiffness.full_piv_lu().solve_in_place(way.as_mut());
        let way: Vec<f64> = (0..free.len()).map(|i| way[(i, 0)]).collect();
        last = Some((motion, way.clone(), worst));
        free.iter().zip(&way).for_each(|(&which, way)| motion[which] += way);
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
