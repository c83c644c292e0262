//! Rolling into a steady state along a path, for a start from which Newton's method finds it.
//!
//! In each increment the material comes from where it was a rolled distance ahead, under the
//! tractions of the increment before. That problem has the symmetric operator A, on which Newton's
//! method does not fail. The path comes nearer to the steady state with each of its increments, but
//! slowly, so that it is no way to the state itself.

use super::iterate::{Conditions, Iterate, Start, Stop, StopRule};
use super::{newton, prescribed};
use crate::model::{Control, PerDof, Route};
use crate::problem::{Operator, Problem};

/// The number of rounds, each of some increments and an attempt by Newton's method.
const ROUNDS: u32 = 4;
/// The number of increments of a round.
const INCREMENTS: u32 = 10;
/// The relative residual to which an increment is solved.
const LOOSE: f64 = 1e-4;
/// The number of iterations of a method after which an increment is left as it is.
const ITERATIONS: u32 = 100;

/// Solves a `problem` that rolls steadily, at prescribed motions, with its `operator`. If no
/// attempt finds a solution, the result is the one nearest to one.
pub(super) fn solve(
    problem: &mut Problem,
    operator: &Operator,
    start: &Start,
    rule: &StopRule<'_>,
) -> Iterate {
    let controls = start.motion.map(Control::Motion);
    let mut iterate =
        newton::solve(problem, operator, &Conditions { controls: &controls, start, rule });
    if iterate.stop == Stop::Converged {
        return iterate;
    }
    let still = operator.still(problem.mirror);
    let mut p = start.p.clone();
    let mut nearest = distance(problem, operator, &iterate.p);
    iterate.operator_applications += 1;
    for _ in 0..ROUNDS {
        if iterate.stop == Stop::Converged || rule.is_cancelled() {
            break;
        }
        let path = PassingPath { still: &still, steady: operator, rule };
        let applications = path.follow(problem, &mut p, &start.motion);
        let nearer = Start::new(p.clone(), start.motion);
        let conditions = Conditions { controls: &controls, start: &nearer, rule };
        let tried = newton::solve(problem, operator, &conditions);
        let reached = distance(problem, operator, &tried.p);
        let route = Route::NewtonAndRolling;
        // The distance took an application too.
        let work = tried.operator_applications + applications + 1;
        let tried = Iterate { route, operator_applications: work, ..tried };
        if tried.stop == Stop::Converged || reached < nearest {
            (iterate, nearest) = (tried.after(&iterate), reached);
        } else {
            let Iterate { p, motion, stop, .. } = iterate.clone();
            iterate = Iterate { p, motion, stop, ..tried.after(&iterate) };
        }
    }
    iterate
}

/// Returns how far tractions are from a solution of `problem` as it is placed: the larger of the
/// residual and of what violates the law on an element, or infinity for what is no number.
fn distance(problem: &Problem, operator: &Operator, p: &[f64]) -> f64 {
    let mut w = vec![0.0; p.len()];
    operator.apply(&mut w, p, &mut operator.scratch());
    w.iter_mut().zip(&problem.f).for_each(|(w, f)| *w -= f);
    let residual = problem.residual(p, &w, operator.diagonals());
    if residual.is_nan() { f64::INFINITY } else { residual.max(problem.violation(p)) }
}

/// A path that leads into a steady state.
struct PassingPath<'a> {
    /// The operator A.
    still: &'a Operator,
    /// The operator of steady rolling.
    steady: &'a Operator,
    /// The rule of the steady state.
    rule: &'a StopRule<'a>,
}

impl PassingPath<'_> {
    /// Rolls on from the tractions `p` at prescribed motions; returns the number of applications
    /// spent. The `problem` is the steady one. Seidel sweeps, which know no steady state, help
    /// where Newton's method fails, for one on the pressures.
    fn follow(&self, problem: &Problem, p: &mut Vec<f64>, motion: &PerDof<f64>) -> u64 {
        let max_iterations = self.rule.max_iterations.min(ITERATIONS);
        let rule = StopRule { tolerance: LOOSE, max_iterations, ..*self.rule };
        let mut passing = problem.clone();
        passing.steady = None;
        let (mut here, mut rolled) = (vec![0.0; p.len()], vec![0.0; p.len()]);
        let (mut still_scratch, mut scratch) = (self.still.scratch(), self.steady.scratch());
        let mut applications = 0;
        for _ in 0..INCREMENTS {
            self.still.apply(&mut here, p, &mut still_scratch);
            self.steady.apply(&mut rolled, p, &mut scratch);
            here.iter_mut().zip(&rolled).for_each(|(ahead, rolled)| *ahead -= rolled);
            passing.remember(&here, &PerDof::all(0.0));
            let start = Start::new(std::mem::take(p), *motion);
            let solved = prescribed::solve(&mut passing, self.still, &start, &rule);
            applications += solved.operator_applications + 2;
            *p = solved.p;
        }
        applications
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{
        ImposedCreepages, Loading, Material, Mesh, Numerics, Projection, Rolling, RollingDirection,
        RollingHistory, Step, sphere_on_half_space,
    };
    use crate::problem::Operators;
    use crate::punch::Surfaces;

    /// Returns a problem of a sphere that rolls steadily, and the motion of an increment.
    fn rolling_sphere() -> (Problem, PerDof<f64>) {
        let mut scene = sphere_on_half_space();
        scene.punch.material = Some(Material { shear_modulus: 80e9, poisson: 0.3 });
        let rolling = Rolling {
            creepage_x: Some(1e-3),
            creepage_y: None,
            spin: Some(1.0),
            spin_center: 0.0,
            direction: RollingDirection::Forward,
            dq: None,
            distance: None,
            history: RollingHistory::Steady,
            imposed: ImposedCreepages::default(),
        };
        let step = Step { approach: Some(1e-6), rolling: Some(rolling), ..Step::default() };
        scene.loading = Loading::path(vec![step]);
        let numerics = Numerics {
            mesh: Mesh::Across(16),
            projection: Projection::Midpoint,
            ..serde_json::from_str(r#"{"mesh": 16}"#).unwrap()
        };
        let mut problem = Problem::new(&scene, &numerics, &Surfaces::new()).unwrap();
        let distance = problem.grid.hx();
        problem.steady = Some(distance);
        let approach = 1e-6 / problem.scale.length;
        let turn = distance * problem.scale.length;
        let motion = PerDof::new([approach, -1e-3 * distance, 0.0, 0.0, 0.0, -turn]);
        (problem, motion)
    }

    /// After two lengths of the contact the tractions are within a few per cent of the steady ones.
    #[test]
    fn a_path_leads_into_the_steady_state() {
        let (mut problem, motion) = rolling_sphere();
        let steady = Operators::default().of(&problem);
        let rule = StopRule { tolerance: 1e-9, max_iterations: 100, cancellation: None };
        let nothing = Start::new(vec![0.0; problem.f.len()], motion);
        let exact = solve(&mut problem, &steady, &nothing, &rule);
        assert_eq!((exact.stop, exact.route), (Stop::Converged, Route::Newton));
        let still = steady.still(problem.mirror);
        let path = PassingPath { still: &still, steady: &steady, rule: &rule };
        let mut p = nothing.p.clone();
        let mut distances = Vec::new();
        for _ in 0..3 {
            path.follow(&problem, &mut p, &motion);
            let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
            let difference = square(&mut p.iter().zip(&exact.p).map(|(a, b)| a - b));
            distances.push((difference / square(&mut exact.p.iter().copied())).sqrt());
        }
        assert!(distances[0] < 0.1 && distances[2] < 0.1 * distances[0], "{distances:?}");
    }

    /// Returns the operator applications of an attempt and its rounds by [`unreachable`], each with
    /// one application for the distance that it ends at.
    fn applications(problem: &Problem, steady: &Operator, start: &Start) -> u64 {
        let (mut problem, rule) = (problem.clone(), unreachable());
        let controls = start.motion.map(Control::Motion);
        let mut spent = 0;
        let attempt = |problem: &mut Problem, start: &Start| {
            let conditions = Conditions { controls: &controls, start, rule: &rule };
            newton::solve(problem, steady, &conditions).operator_applications + 1
        };
        spent += attempt(&mut problem, start);
        let still = steady.still(problem.mirror);
        let mut p = start.p.clone();
        for _ in 0..ROUNDS {
            let path = PassingPath { still: &still, steady, rule: &rule };
            spent += path.follow(&problem, &mut p, &start.motion);
            spent += attempt(&mut problem, &Start::new(p.clone(), start.motion));
        }
        spent
    }

    /// Returns a rule that nothing meets.
    fn unreachable() -> StopRule<'static> {
        StopRule { tolerance: 1e-18, max_iterations: 1, cancellation: None }
    }

    /// The nearest attempt goes out where none finds a solution: here the first one, from a
    /// start to which a path of loose increments does not come back.
    #[test]
    fn the_nearest_attempt_goes_out() {
        let (mut problem, motion) = rolling_sphere();
        let steady = Operators::default().of(&problem);
        let rule = StopRule { tolerance: 1e-9, max_iterations: 100, cancellation: None };
        let nothing = Start::new(vec![0.0; problem.f.len()], motion);
        let exact = solve(&mut problem, &steady, &nothing, &rule);
        let near = distance(&problem, &steady, &exact.p);
        let start = Start::new(exact.p, motion);
        let left = solve(&mut problem, &steady, &start, &unreachable());
        assert_eq!(left.route, Route::NewtonAndRolling);
        assert!(left.stop != Stop::Converged, "{:?}", left.stop);
        assert_eq!(left.operator_applications, applications(&problem, &steady, &start));
        let reached = distance(&problem, &steady, &left.p);
        assert!(reached <= near, "{reached:e} after {near:e}");
    }

    /// One step of Newton's method does not find pressures from nothing; the sweeps do.
    #[test]
    fn sweeps_find_the_pressures_that_newtons_method_does_not() {
        let (mut problem, motion) = rolling_sphere();
        let steady = Operators::default().of(&problem);
        let rule = StopRule { tolerance: 1e-9, max_iterations: 100, cancellation: None };
        let nothing = Start::new(vec![0.0; problem.f.len()], motion);
        let exact = solve(&mut problem, &steady, &nothing, &rule);
        let one_step = StopRule { max_iterations: 1, ..rule };
        let still = steady.still(problem.mirror);
        let path = PassingPath { still: &still, steady: &steady, rule: &one_step };
        let mut p = nothing.p;
        path.follow(&problem, &mut p, &motion);
        let pressures = exact.p[..problem.grid.len()].iter().zip(&p);
        let largest = exact.p.iter().fold(0.0, |a: f64, p| a.max(*p));
        let apart = pressures.fold(0.0, |a: f64, (exact, p)| a.max((exact - p).abs()));
        assert!(apart < 1e-2 * largest, "{apart:e} of {largest:e}");
    }
}
