//! Rolling into a steady state along a path, for a start from which Newton's method finds it.
//!
//! In each increment the material comes from where it was a rolled distance ahead, under the
//! tractions of the increment before. That problem has the symmetric operator A, on which Newton's
//! method does not fail. The path comes nearer to the steady state with each of its increments, but
//! slowly, so that it is no way to the state itself.

use super::iterate::{Conditions, Iterate, Start, Stop, StopRule};
use super::newton;
use crate::common::Cancellation;
use crate::model::{Control, PerDof, Route};
use crate::problem::{Operator, Problem};

/// The number of rounds, each of some increments and an attempt by Newton's method.
const ROUNDS: u32 = 4;
/// The number of increments of a round.
const INCREMENTS: u32 = 10;
/// The relative residual to which an increment is solved.
const LOOSE: f64 = 1e-4;

/// Solves a `problem` that rolls steadily, at prescribed motions, with its `operator`.
pub(super) fn solve(
    problem: &mut Problem,
    operator: &Operator,
    start: &Start,
    rule: &StopRule<'_>,
) -> Iterate {
    let controls = start.motion.map(Control::Motion);
    let mut iterate =
        newton::solve(problem, operator, &Conditions { controls: &controls, start, rule });
    let still = operator.still(problem.mirror);
    let mut p = start.p.clone();
    for _ in 0..ROUNDS {
        if iterate.stop == Stop::Converged || rule.is_cancelled() {
            break;
        }
        let path = PassingPath { still: &still, steady: operator, cancellation: rule.cancellation };
        let applications = path.follow(problem, &mut p, &start.motion);
        let nearer = Start::new(p.clone(), start.motion);
        let conditions = Conditions { controls: &controls, start: &nearer, rule };
        let tried = newton::solve(problem, operator, &conditions);
        iterate = Iterate {
            iterations: iterate.iterations + tried.iterations,
            operator_applications: iterate.operator_applications
                + tried.operator_applications
                + applications,
            route: Route::NewtonAndRolling,
            ..tried
        };
    }
    iterate
}

/// A path that leads into a steady state.
struct PassingPath<'a> {
    /// The operator A.
    still: &'a Operator,
    /// The operator of steady rolling.
    steady: &'a Operator,
    /// The request to give up, if somebody can make one.
    cancellation: Option<&'a Cancellation>,
}

impl PassingPath<'_> {
    /// Rolls on from the tractions `p` at prescribed motions; returns the number of applications
    /// spent. The `problem` is the steady one.
    fn follow(&self, problem: &Problem, p: &mut Vec<f64>, motion: &PerDof<f64>) -> u64 {
        let controls = motion.map(Control::Motion);
        let rule =
            StopRule { tolerance: LOOSE, max_iterations: 100, cancellation: self.cancellation };
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
            let conditions = Conditions { controls: &controls, start: &start, rule: &rule };
            let solved = newton::solve(&mut passing, self.still, &conditions);
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

    /// After two lengths of the contact the tractions are within a few per cent of the steady ones.
    #[test]
    fn a_path_leads_into_the_steady_state() {
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
        let steady = Operators::default().of(&problem);
        let rule = StopRule { tolerance: 1e-9, max_iterations: 100, cancellation: None };
        let nothing = Start::new(vec![0.0; problem.f.len()], motion);
        let exact = solve(&mut problem, &steady, &nothing, &rule);
        assert_eq!((exact.stop, exact.route), (Stop::Converged, Route::Newton));
        let still = steady.still(problem.mirror);
        let path = PassingPath { still: &still, steady: &steady, cancellation: None };
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
}
