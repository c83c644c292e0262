//! The search: the starts and their order, and the solutions that they lead to.

use std::sync::Arc;

use super::found::{Multiplicity, Origin, Search, Solution};
use super::natural_map::{ElementState, NaturalMap};
use super::start::{self, generator};
use crate::influence::{Components, Dense, Mirror};
use crate::model::{
    Control, Method, Numerics, PerDof, Projection, Scene, SceneError, Status, WorkDone, refuse,
};
use crate::path::{Certifying, Departure, Increment, certify_increment, in_units};
use crate::problem::{Operator, Operators, Problem, Stage};
use crate::solver::{self, Conditions, Iterate, Start, Stop, StopRule, newton};

/// The relative residual to which a candidate is polished, if rounding lets it.
const POLISHED: f64 = 1e-12;

/// The relative residual at which a method hands over to the polishing.
const HANDED_OVER: f64 = 1e-6;

/// The loosest tolerance of a certificate.
const LOOSEST: f64 = 1e-10;

/// The relative distance below which two candidates are one solution.
const SAME: f64 = 1e-5;

/// The number of Newton steps after which a method without globalisation is given up, for it goes
/// in circles.
const NEWTON_STEPS: u32 = 60;

/// The multiple of the random starts asked for that are tried while the indices do not add up.
const PATIENCE: u32 = 4;

/// The largest number of earlier solutions that a new one is mixed with.
const NEIGHBOURS: usize = 8;

/// The factors of μ on the way down to it.
const FROM_ABOVE: [f64; 9] = [64.0, 16.0, 6.0, 3.0, 2.0, 1.5, 1.2, 1.08, 1.0];
/// The factors of μ on the way up to it.
const FROM_BELOW: [f64; 9] = [0.0, 0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 0.95, 1.0];

/// A search under way.
pub(super) struct Seeker<'a> {
    pub(super) problem: Problem,
    operators: &'a mut Operators,
    operator: Operator,
    certifying: Operator,
    dense: Arc<Dense>,
    /// The controls of the punch in the problem's units.
    pub(super) controls: PerDof<Control>,
    /// The controls of the punch in SI units.
    pub(super) target: PerDof<Control>,
    departure: Departure,
    numerics: &'a Numerics,
    /// The tractions and motions of the solutions.
    found: Vec<Start>,
    pub(super) result: Multiplicity,
}

/// The only stage: all components and all elements.
const WHOLE: [Stage; 1] = [Stage { components: Components::ALL, mirror: Mirror::NONE }];

impl<'a> Seeker<'a> {
    pub(super) fn new(
        problem: Problem,
        numerics: &'a Numerics,
        operators: &'a mut Operators,
    ) -> Result<Self, SceneError> {
        let elements = problem.grid.active_len();
        if elements > Multiplicity::MOST_ELEMENTS {
            return Err(refuse(
                "mesh",
                format!("{elements} elements of Ω"),
                "must be at most 1024 elements for a search of all solutions",
            ));
        }
        let operator = operators.of(&problem);
        let dense = Arc::new(Dense::new(&operator.table));
        // The transforms of the solvers and the matrix of the certificate share the coefficients
        // only.
        let mut certifying = operator.clone();
        certifying.influence = Arc::clone(&dense) as _;
        Ok(Self {
            certifying,
            problem,
            operators,
            operator,
            dense,
            controls: PerDof::all(Control::Motion(0.0)),
            target: PerDof::all(Control::Motion(0.0)),
            departure: Departure::default(),
            numerics,
            found: Vec::new(),
            result: Multiplicity {
                status: Status::Certified,
                before: Vec::new(),
                solutions: Vec::new(),
                starts: 0,
                failed: 0,
                beyond: 0,
                index_sum: None,
                work: WorkDone::default(),
                factorisations: 0,
            },
        })
    }

    /// Follows the path up to its last increment. Returns the start of that one, or the reason why
    /// it cannot be reached.
    pub(super) fn follow(&mut self, scene: &Scene) -> Result<Start, String> {
        let method = self
            .numerics
            .method
            .chosen(&scene.loading, [self.problem.grid.nx(), self.problem.grid.ny()])
            .method;
        let rule = StopRule {
            tolerance: self.numerics.tolerance,
            max_iterations: self.numerics.max_iterations,
            cancellation: None,
        };
        let mut start = Start::new(vec![0.0; self.problem.f.len()], PerDof::all(0.0));
        let legs = scene.loading.legs();
        for (number, leg) in legs.iter().enumerate() {
            let leg_departure = self.departure;
            for increment in 1..=leg.increments {
                self.target =
                    leg.increment(increment, &leg_departure.motion, &leg_departure.resultants, 0.0);
                self.controls = in_units(&self.target, &self.problem);
                if number + 1 == legs.len() && increment == leg.increments {
                    return Ok(start);
                }
                let iterate = solver::solve(
                    method,
                    &mut self.problem,
                    self.operators,
                    &WHOLE,
                    &Conditions { controls: &self.controls, start: &start, rule: &rule },
                );
                self.count(&iterate);
                let Increment { status, mut outcome, left, .. } = certify_increment(
                    &self.problem,
                    Certifying { elastic: &self.certifying, steady: None, history: 0.0 },
                    &iterate,
                    &self.target,
                    &self.departure,
                    self.numerics.tolerance,
                );
                (outcome.step, outcome.cycle) = (leg.step, leg.cycle);
                self.departure = Departure {
                    motion: outcome.motion,
                    resultants: outcome.observables.resultants(),
                };
                self.result.before.push(outcome);
                if let Status::Failed { reason } = status {
                    return Err(format!(
                        "loading.steps[{}], increment {increment} of {}: {reason}",
                        leg.step, leg.increments
                    ));
                }
                self.problem.remember(&left, &iterate.motion);
                start = Start::new(iterate.p, iterate.motion);
            }
        }
        Err("the path has no increment".to_owned())
    }

    /// Tries every start.
    pub(super) fn seek(&mut self, before: &Start, search: &Search) {
        // An ordinary solve also says where a motion that a force governs will be.
        let rule = self.rule();
        let iterate = solver::solve(
            Method::Newton,
            &mut self.problem,
            self.operators,
            &WHOLE,
            &Conditions { controls: &self.controls, start: before, rule: &rule },
        );
        let motion = if iterate.motion.iter().all(|q| q.is_finite()) {
            iterate.motion
        } else {
            before.motion
        };
        self.settle(Origin::Before, Method::Newton, iterate);
        self.problem.place(&motion);

        let nothing = vec![0.0; self.problem.f.len()];
        self.both(Origin::Before, &Start::new(before.p.clone(), motion));
        self.both(Origin::Nothing, &Start::new(nothing.clone(), motion));
        let p = start::hertz(&self.problem);
        self.both(Origin::Hertz, &Start::new(p, motion));
        self.pattern(Origin::Stick, &vec![ElementState::Stick; self.problem.grid.len()], motion);
        for eighth in 0..8 {
            let (y, x) = (f64::from(eighth) * std::f64::consts::FRAC_PI_4).sin_cos();
            self.pattern(
                Origin::Slip(eighth),
                &vec![ElementState::Slip([x, y]); self.problem.grid.len()],
                motion,
            );
        }
        self.along(Origin::FrictionFromAbove, &FROM_ABOVE, Start::new(nothing.clone(), motion));
        self.along(Origin::FrictionFromBelow, &FROM_BELOW, Start::new(nothing, motion));
        let mut known = self.spread(0, search, motion);
        for number in 0..search.starts.saturating_mul(PATIENCE) {
            if number >= search.starts && self.index_sum().is_none_or(|sum| sum == 1) {
                break;
            }
            let mut generator = generator(search.seed, u64::from(number));
            if number % 3 == 0 {
                let p = start::tractions(&self.problem, &mut generator);
                self.both(Origin::Tractions(number), &Start::new(p, motion));
            } else {
                let pattern = start::pattern(&self.problem.grid, number % 3 == 1, &mut generator);
                self.pattern(Origin::Pattern(number), &pattern, motion);
            }
            known = self.spread(known, search, motion);
        }
    }

    /// Starts from the solutions with numbers from `known` on, and from those that this finds.
    /// Returns the number of solutions that there are then.
    fn spread(&mut self, mut known: usize, search: &Search, motion: PerDof<f64>) -> usize {
        while let Some(solution) = self.found.get(known).cloned() {
            let number = known as u32;
            let mut generator = generator(search.seed ^ 0x5eed, u64::from(number));
            for p in start::images(&self.problem.grid, &solution.p) {
                self.both(Origin::Image(number), &Start::new(p, solution.motion));
            }
            for size in [0.1, 0.5, 1.0] {
                let p = start::disturbed(&self.problem, &solution.p, size, &mut generator);
                self.both(Origin::Disturbed(number), &Start::new(p, solution.motion));
            }
            let there_and_back = |factors: &[f64; 9]| {
                factors.iter().rev().chain(&factors[1..]).copied().collect::<Vec<_>>()
            };
            self.along(
                Origin::FrictionLoopAbove(number),
                &there_and_back(&FROM_ABOVE),
                solution.clone(),
            );
            self.along(
                Origin::FrictionLoopBelow(number),
                &there_and_back(&FROM_BELOW),
                solution.clone(),
            );
            self.problem.place(&motion);
            let starts = [
                vec![0.0; solution.p.len()],
                start::hertz(&self.problem),
                start::tractions(&self.problem, &mut generator),
                { start::disturbed(&self.problem, &solution.p, 0.3, &mut generator) },
            ];
            for p in starts {
                self.problem.place(&motion);
                let (map, known) = (self.map(), &self.found[..=known]);
                let (p, factored) = map.deflated(&p, known.iter().map(|solution| &solution.p[..]));
                self.result.factorisations += factored;
                self.one(Origin::Deflated(number), Method::Newton, &Start::new(p, motion));
            }
            for (other, earlier) in self.earlier(known) {
                for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
                    let mix = |a: f64, b: f64| (1.0 - share) * a + share * b;
                    let p = solution.p.iter().zip(&earlier.p).map(|(a, b)| mix(*a, *b)).collect();
                    let motion =
                        PerDof::from_fn(|dof| mix(solution.motion[dof], earlier.motion[dof]));
                    self.one(
                        Origin::Between([other as u32, number]),
                        Method::Newton,
                        &Start::new(p, motion),
                    );
                }
            }
            known += 1;
        }
        known
    }

    /// Returns the last solutions before the one with the number `known`, with their numbers.
    fn earlier(&self, known: usize) -> Vec<(usize, Start)> {
        self.found[..known].iter().cloned().enumerate().rev().take(NEIGHBOURS).collect()
    }

    fn map(&self) -> NaturalMap<'_> {
        NaturalMap::new(&self.problem, self.dense.matrix(), self.operator.table.largest_diagonal())
    }

    /// Returns the rule of a start. No start takes long, so a search is given up between them.
    fn rule(&self) -> StopRule<'static> {
        StopRule {
            tolerance: HANDED_OVER,
            max_iterations: self.numerics.max_iterations,
            cancellation: None,
        }
    }

    /// Returns whether nobody wants the solutions any more.
    fn is_cancelled(&self) -> bool {
        self.operators.cancellation().is_requested()
    }

    fn count(&mut self, iterate: &Iterate) {
        self.result.work.iterations += iterate.iterations;
        self.result.work.operator_applications += iterate.operator_applications;
    }

    /// Starts both methods.
    fn both(&mut self, origin: Origin, start: &Start) {
        self.one(origin, Method::Newton, start);
        self.one(origin, Method::Seidel, start);
    }

    /// Starts both methods from the solution of the linear equations of a pattern of states.
    fn pattern(&mut self, origin: Origin, pattern: &[ElementState], motion: PerDof<f64>) {
        if self.is_cancelled() {
            return;
        }
        self.problem.place(&motion);
        let p = self.map().equilibrium(pattern);
        self.result.factorisations += 1;
        self.both(origin, &Start::new(p, motion));
    }

    /// Starts one method.
    fn one(&mut self, origin: Origin, method: Method, start: &Start) {
        if self.is_cancelled() {
            return;
        }
        let rule = self.rule();
        let iterate = match method {
            Method::Seidel => solver::solve(
                method,
                &mut self.problem,
                self.operators,
                &WHOLE,
                &Conditions { controls: &self.controls, start, rule: &rule },
            ),
            Method::Newton | Method::Auto => {
                let rule =
                    StopRule { max_iterations: rule.max_iterations.min(NEWTON_STEPS), ..rule };
                let conditions = Conditions { controls: &self.controls, start, rule: &rule };
                newton::solve(&mut self.problem, &self.operator, &conditions)
            }
        };
        self.settle(origin, method, iterate);
    }

    /// Follows μ times `factors` from a start by Newton's method, with Seidel sweeps where it
    /// fails. The last factor must be 1.
    fn along(&mut self, origin: Origin, factors: &[f64], mut start: Start) {
        let mu = self.problem.mu;
        let rule = self.rule();
        for factor in factors {
            if self.is_cancelled() {
                break;
            }
            self.problem.mu = mu * factor;
            let steps = StopRule { max_iterations: rule.max_iterations.min(NEWTON_STEPS), ..rule };
            let conditions = Conditions { controls: &self.controls, start: &start, rule: &steps };
            let mut iterate = newton::solve(&mut self.problem, &self.operator, &conditions);
            self.count(&iterate);
            if iterate.stop != Stop::Converged {
                iterate = solver::solve(
                    Method::Newton,
                    &mut self.problem,
                    self.operators,
                    &WHOLE,
                    &Conditions { controls: &self.controls, start: &start, rule: &rule },
                );
                self.count(&iterate);
            }
            if iterate.stop == Stop::Converged {
                start = Start::new(iterate.p, iterate.motion);
            }
        }
        self.problem.mu = mu;
        self.one(origin, Method::Newton, &start);
    }

    /// Polishes and certifies the iterate of a method, and enters it among the solutions.
    fn settle(&mut self, origin: Origin, method: Method, iterate: Iterate) {
        self.result.starts += 1;
        self.count(&iterate);
        let is_near = match iterate.stop {
            Stop::Converged => true,
            Stop::OutOfIterations { residual } | Stop::Stalled { residual } => {
                residual <= HANDED_OVER
            }
            Stop::Diverged
            | Stop::Slides { .. }
            | Stop::Unbalanced { .. }
            | Stop::OneRow { .. } => false,
        };
        let is_finite = iterate.p.iter().chain(&iterate.motion).all(|x| x.is_finite());
        if !(is_near && is_finite) {
            self.result.failed += 1;
            return;
        }
        let rule = StopRule { tolerance: POLISHED, max_iterations: NEWTON_STEPS, ..self.rule() };
        let start = Start::new(iterate.p, iterate.motion);
        let conditions = Conditions { controls: &self.controls, start: &start, rule: &rule };
        let polished = newton::solve(&mut self.problem, &self.operator, &conditions);
        self.count(&polished);
        let tolerance = self.numerics.tolerance.min(LOOSEST);
        let Increment { status, outcome, fields, .. } = certify_increment(
            &self.problem,
            Certifying { elastic: &self.certifying, steady: None, history: 0.0 },
            &polished,
            &self.target,
            &self.departure,
            tolerance,
        );
        if status != Status::Certified {
            self.result.failed += 1;
            return;
        }
        let distances: Vec<f64> =
            self.found.iter().map(|found| distance(&found.p, &polished.p)).collect();
        let near = (0..distances.len()).min_by(|a, b| distances[*a].total_cmp(&distances[*b]));
        if let Some(near) = near.filter(|&near| distances[near] <= SAME) {
            self.result.solutions[near].reached += 1;
            return;
        }
        let (error, sign) = self.map().error_and_index(&polished.p);
        self.result.factorisations += 1;
        if let Some(near) = near
            && [error, self.result.solutions[near].error]
                .iter()
                .any(|error| error.is_finite() && distances[near] <= 100.0 * error)
        {
            self.result.solutions[near].reached += 1;
            return;
        }
        if self.found.len() == Multiplicity::MOST_SOLUTIONS {
            self.result.beyond += 1;
            return;
        }
        let adds_up = self.controls.iter().all(|control| matches!(control, Control::Motion(_)))
            && self.problem.projection == Projection::Average;
        self.found.push(Start::new(polished.p, polished.motion));
        self.result.solutions.push(Solution {
            motion: outcome.motion,
            observables: outcome.observables,
            certificate: outcome.certificate,
            origin,
            method,
            reached: 1,
            error,
            index: adds_up.then_some(sign),
            distances: Vec::new(),
            fields,
        });
    }

    /// Returns the sum of the indices so far. It is `None` if one is missing or zero, or if there
    /// are no solutions.
    fn index_sum(&self) -> Option<i64> {
        let solutions = &self.result.solutions;
        solutions
            .iter()
            .map(|solution| solution.index.filter(|index| *index != 0))
            .sum::<Option<i64>>()
            .filter(|_| !solutions.is_empty())
    }

    /// Completes the result and returns it.
    pub(super) fn conclude(mut self) -> Multiplicity {
        for (solution, found) in self.result.solutions.iter_mut().zip(&self.found) {
            solution.distances =
                self.found.iter().map(|other| distance(&found.p, &other.p)).collect();
        }
        self.result.index_sum = self.index_sum();
        if self.result.solutions.is_empty() && self.result.status == Status::Certified {
            let reason =
                format!("none of {} starts led to a certified solution", self.result.starts);
            self.result.status = Status::Failed { reason };
        }
        self.result
    }
}

/// Returns ‖a − b‖ over the larger of the norms, and 0 between zeros.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let size = norm(&mut a.iter().copied()).max(norm(&mut b.iter().copied()));
    if size == 0.0 { 0.0 } else { norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / size }
}
