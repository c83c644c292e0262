//! The way from a scene to a certified outcome, along the scene's loading path.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::increment::{
    Certifying, Departure, Increment, certify_increment, in_units, largest_tangential,
};
use super::watched::SolvedIncrement;
use super::wearing::{MaterialMotion, Wearing};
use crate::assess::AheadSums;
use crate::assess::estimate::{self, PathSolution};
use crate::common::Cancellation;
use crate::foundation::surface_compliance;
use crate::influence::{Components, Mirror};
use crate::interior;
use crate::model::{
    Dof, Effect, Estimate, Fields, Further, Hertz, Leg, Level, Mesh, Method, Motion, Numerics,
    Outcome, PerDof, RailContact, RollingDirection, Scene, SceneError, Status, StepOutcome,
    WorkDone, Worn,
};
use crate::problem::{Effects, Operator, Operators, Problem, Stage, on_grid};
use crate::punch::{Gap, PlacedWheel, Surfaces};
use crate::solver::{self, Conditions, Start, StopRule};
use crate::theory::hertz_ellipse;

/// Solves a scene: binds it to its grid, follows its loading path and derives the observables. The
/// fields are those of the last increment, in SI units.
///
/// Every increment is certified by code that shares nothing with the solver: the operator acts on
/// the full grid, and its transform is compared with direct sums on a few elements. A path that
/// cannot be followed, or not to the tolerance, is an [`Outcome`] with [`Status::Failed`], which
/// keeps the increments before.
///
/// # Errors
///
/// A scene, numerics or surfaces without a meaning are a [`SceneError`].
pub fn solve(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> Result<(Outcome, Fields), SceneError> {
    solve_watched(scene, numerics, surfaces, operators, &mut |_| ControlFlow::Continue(()))
}

/// Looks at an increment and says whether the path is to be followed further.
pub type Watch<'w> = &'w mut (dyn FnMut(&SolvedIncrement<'_>) -> ControlFlow<()> + Send);

/// Solves a scene as [`solve`] does and shows each increment of its path, as soon as it is solved
/// and certified, to `watch`. The last one of a path that cannot be followed is the solver's last
/// iterate. A path that the watcher ends is a failed one.
///
/// # Errors
///
/// A scene, numerics or surfaces without a meaning are a [`SceneError`].
pub fn solve_watched(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
    operators: &mut Operators,
    watch: Watch<'_>,
) -> Result<(Outcome, Fields), SceneError> {
    // The work is on a thread of the pool from the start: from outside, each of the many loops
    // would be handed over and waited for.
    rayon::scope(|_| follow(scene, numerics, surfaces, operators, watch))
}

fn follow(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
    operators: &mut Operators,
    watch: Watch<'_>,
) -> Result<(Outcome, Fields), SceneError> {
    scene.validate()?;
    numerics.validate()?;
    let scene = &*on_grid(scene, numerics, surfaces)?;
    let gap = Gap::new(scene, surfaces)?;
    let problem = Problem::under(scene, numerics, &gap)?;
    problem.check_distances(scene)?;
    let elements = [problem.grid.nx(), problem.grid.ny()];
    let effects = Effects::of(scene, numerics, elements, surfaces)?;
    let cancellation = operators.cancellation().clone();
    let setup = PathSetup {
        scene,
        numerics,
        gap: &gap,
        stages: effects.stages(scene),
        certified: certified(&effects),
        increments: increments(scene),
        element: problem.grid.hx() * problem.scale.length,
        cancellation: &cancellation,
    };
    let method = numerics.method.chosen(&scene.loading, elements).method;
    let mut ladder = Vec::new();
    let start = match method {
        Method::Newton => {
            coarse_start(&setup, operators, &problem, estimate::TOLERANCE, &mut ladder)
        }
        Method::Seidel | Method::Auto => nothing(&problem),
    };
    let rule = setup.rule(numerics.tolerance);
    let mut path = Path::new(&setup, problem, start, operators);
    let mut status = Status::Certified;
    for increment in &setup.increments {
        status = path.advance(&setup, method, increment, &rule, operators);
        let is_wanted = !cancellation.is_requested()
            && path.solved(&status).is_none_or(|solved| watch(&solved).is_continue());
        if !is_wanted {
            status = Status::Failed { reason: "given up".to_owned() };
        }
        if let Status::Failed { reason } = &status {
            status =
                Status::Failed { reason: with_place(reason, scene, path.steps.last(), increment) };
            break;
        }
    }
    let estimate = if status == Status::Certified {
        estimate(&setup, &path, &mut ladder, operators)
    } else {
        None
    };
    let last = path.steps.last();
    let (hertz, rail) = (
        last.and_then(|step| hertz(scene, &gap, step)),
        last.and_then(|step| rail_contact(&gap, step)),
    );
    let mut levels: Vec<Level> = ladder.iter().map(Path::level).collect();
    levels.sort_by_key(|level| level.elements.map(u64::from).iter().product::<u64>());
    let wanted = scene.interior.as_ref().filter(|_| status == Status::Certified);
    let mut interior = None;
    if let Some(question) = wanted {
        interior = interior::examine(
            &scene.foundation,
            &question.normalised(),
            &path.fields,
            &cancellation,
        );
        if interior.is_none() {
            status = Status::Failed { reason: "given up".to_owned() };
        }
    }
    let (wear, leading_edges) = (path.wear(), path.leading_edges);
    let further = Further { wear, interior, leading_edges };
    let outcome = Outcome { status, levels, steps: path.steps, hertz, rail, estimate, further };
    Ok((outcome, path.fields))
}

/// The data that the solutions on all grids have in common.
struct PathSetup<'a> {
    scene: &'a Scene,
    numerics: &'a Numerics,
    gap: &'a Gap<'a>,
    /// The stages of Newton's method.
    stages: Vec<Stage>,
    /// The components of the operator that certifies.
    certified: Components,
    /// The increments of the path, in order.
    increments: Vec<LegIncrement>,
    /// The length of an element along x on the grid that was asked for \[m\].
    element: f64,
    /// The request to give up.
    cancellation: &'a Cancellation,
}

impl PathSetup<'_> {
    /// Returns the rule by which solvers stop at a residual.
    fn rule(&self, tolerance: f64) -> StopRule<'_> {
        StopRule {
            tolerance,
            max_iterations: self.numerics.max_iterations,
            cancellation: Some(self.cancellation),
        }
    }

    /// Returns the way that an increment of a leg rolls on the grid of `problem`, if it rolls. On
    /// coarser grids it goes as far. Only what is steady goes an element of each grid unless it is
    /// told how far. The grids below the one that estimates errors, which are there to begin from,
    /// are not to roll by small parts of an element: that is hard to solve.
    fn roll(&self, leg: &Leg, problem: &Problem) -> Option<Roll> {
        let rolling = leg.rolling?;
        let is_steady = leg.is_steady();
        let element = problem.grid.hx() * problem.scale.length;
        let distance = match rolling.dq {
            None if is_steady => element,
            None => self.element,
            Some(dq) if is_steady && element > self.element => {
                estimate::coarser_distance(dq, self.element, element)
            }
            Some(dq) => dq,
        };
        Some(Roll { distance, direction: rolling.direction, is_steady })
    }
}

/// The way that an increment rolls.
#[derive(Clone, Copy)]
struct Roll {
    /// The distance \[m\].
    distance: f64,
    direction: RollingDirection,
    is_steady: bool,
}

impl Roll {
    /// Returns the way that the material goes through Ω.
    fn material(self) -> MaterialMotion {
        let distance = self.direction.sign() * self.distance;
        if self.is_steady {
            MaterialMotion::Steady(distance)
        } else {
            MaterialMotion::Transient(distance)
        }
    }
}

/// The operator and the past of an increment that is about to roll.
#[derive(Default)]
struct Prepared {
    /// The operator that certifies it, if it rolls steadily with tangential tractions.
    steady: Option<Operator>,
    /// The relative error of the displacements that its material has had, if it comes from ahead.
    history: f64,
}

/// One increment of a leg.
struct LegIncrement {
    leg: Leg,
    /// The number of the increment in the leg, counted from 1.
    number: u32,
}

/// Returns the components of the operator that certifies.
fn certified(effects: &Effects) -> Components {
    if effects.has(Effect::Friction) { Components::ALL } else { Components::NORMAL }
}

/// Returns every increment of the path, in order.
fn increments(scene: &Scene) -> Vec<LegIncrement> {
    scene
        .loading
        .legs()
        .into_iter()
        .flat_map(|leg| (1..=leg.increments).map(move |number| LegIncrement { leg, number }))
        .collect()
}

/// The path on one grid, as far as it has been followed.
struct Path {
    problem: Problem,
    /// The operator that certifies. It knows no mirror planes.
    operator: Operator,
    /// The end of the path so far, from which the next increment begins, in the problem's units.
    start: Start,
    /// The motion of the last increment, in the problem's units: its creepages times its distance,
    /// if it rolls.
    reached: PerDof<f64>,
    /// The displacements A p at the end of the path so far, if it rolls on.
    left: Vec<f64>,
    /// The distance \[m\] of the last increment, if it rolls.
    rolled: Option<f64>,
    /// The sums that certify the distance rolled last.
    ahead: Option<AheadSums>,
    /// The end of the path so far, in SI units.
    departure: Departure,
    /// The end of the leg before, in SI units.
    leg_departure: Departure,
    /// The outcomes of the increments so far.
    steps: Vec<StepOutcome>,
    /// The fields of the last increment.
    fields: Fields,
    /// The leading edges of the increments so far, of a scene that rolls.
    leading_edges: Vec<Option<f64>>,
    /// The wear so far, of a scene that wears.
    wearing: Option<Wearing>,
}

impl Path {
    fn new(
        setup: &PathSetup<'_>,
        problem: Problem,
        start: Start,
        operators: &mut Operators,
    ) -> Self {
        let without_mirror = problem
            .reduced(setup.certified, Mirror::NONE, None)
            .expect("without a mirror plane there is nothing to refuse");
        let operator = operators.of(&without_mirror);
        let (departure, leg_departure) = (Departure::default(), Departure::default());
        let elements = [problem.grid.nx(), problem.grid.ny()];
        Self {
            problem,
            operator,
            reached: start.motion,
            start,
            left: Vec::new(),
            rolled: None,
            ahead: None,
            departure,
            leg_departure,
            steps: Vec::new(),
            fields: Fields::default(),
            leading_edges: Vec::new(),
            wearing: setup.scene.wear.map(|wear| Wearing::new(wear, elements)),
        }
    }

    /// Solves and certifies the next increment, and remembers its end.
    fn advance(
        &mut self,
        setup: &PathSetup<'_>,
        method: Method,
        LegIncrement { leg, number }: &LegIncrement,
        rule: &StopRule<'_>,
        operators: &mut Operators,
    ) -> Status {
        if *number == 1 {
            self.leg_departure = self.departure;
        }
        let roll = setup.roll(leg, &self.problem);
        self.rolled = roll.map(|roll| roll.distance);
        let Prepared { steady, history } =
            roll.map_or_else(Prepared::default, |roll| self.roll(roll, operators));
        if roll.is_none() {
            self.problem.steady = None;
        }
        let target = leg.increment(
            *number,
            &self.leg_departure.motion,
            &self.leg_departure.resultants,
            roll.map_or(0.0, |roll| roll.distance),
        );
        let controls = in_units(&target, &self.problem);
        let iterate = solver::solve(
            method,
            &mut self.problem,
            operators,
            &setup.stages,
            &Conditions { controls: &controls, start: &self.start, rule },
        );
        let Increment { mut status, mut outcome, mut fields, left, w } = certify_increment(
            &self.problem,
            Certifying {
                elastic: &self.operator,
                steady: steady.as_ref().zip(self.ahead.as_mut()),
                history,
            },
            &iterate,
            &target,
            &self.departure,
            rule.tolerance,
        );
        (outcome.step, outcome.cycle) = (leg.step, leg.cycle);
        self.departure =
            Departure { motion: outcome.motion, resultants: outcome.observables.resultants() };
        self.steps.push(outcome);
        if setup.increments.iter().any(|increment| increment.leg.rolling.is_some()) {
            let edge = roll.and_then(|roll| fields.leading_edge(roll.direction));
            self.leading_edges.push(edge);
        }
        if let Some(wearing) = &mut self.wearing {
            let motion = roll.map_or(MaterialMotion::Still, Roll::material);
            let least = self.operator.circulant.least_normal();
            let added = wearing.add(&mut self.problem, &fields, leg.cycle, motion, least);
            if let (Err(reason), Status::Certified) = (added, &status) {
                status = Status::Failed { reason };
            }
            fields.further.wear_depth = wearing.depth();
        }
        self.fields = fields;
        self.reached = iterate.motion;
        // Where the contact rolls on, most elements stay in the states that they are in.
        let next = setup.increments.get(self.steps.len());
        let rolls_on = next.is_some_and(|next| next.leg.rolling.is_some());
        let w = rolls_on.then_some(w);
        self.start = Start { p: iterate.p, motion: iterate.motion, w };
        if roll.is_some() {
            self.count_anew();
        }
        self.problem.remember(&left, &self.start.motion);
        self.left = if rolls_on { left } else { Vec::new() };
        status
    }

    /// Prepares the next increment for rolling.
    fn roll(&mut self, roll: Roll, operators: &mut Operators) -> Prepared {
        // A path that begins by rolling has the creepages of a coarser grid to begin with.
        if !self.steps.is_empty() {
            self.count_anew();
        }
        let distance = roll.direction.sign() * roll.distance / self.problem.scale.length;
        let components = self.operator.influence.components();
        let mut before = vec![0.0; self.start.p.len()];
        let mut prepared = Prepared::default();
        let has_past = roll.is_steady || !self.steps.is_empty();
        if components != Components::NORMAL && has_past {
            self.problem.steady = Some(distance);
            let without_mirror = self
                .problem
                .reduced(components, Mirror::NONE, None)
                .expect("without a mirror plane there is nothing to refuse");
            let rolling = operators.of(&without_mirror);
            let kept = self.ahead.take().filter(|ahead| ahead.distance() == distance);
            let mut ahead = kept.or_else(|| {
                let kernels = Arc::clone(&rolling.rolled.as_ref()?.kernels);
                Some(AheadSums::new(kernels, self.problem.projection, distance))
            });
            if roll.is_steady {
                prepared.steady = Some(rolling);
            } else {
                // The material was ahead of where it is, under the tractions that the path has
                // left.
                let p = &self.start.p;
                let mut rolled = before.clone();
                rolling.apply(&mut rolled, p, &mut rolling.scratch());
                let still = self.left.iter().zip(rolled);
                before.iter_mut().zip(still).for_each(|(before, (still, rolled))| {
                    *before = still - rolled;
                });
                let unit = largest_tangential(&self.problem, components, &before);
                let fields = [&p[..], &before[..]];
                if let Some(ahead) = &mut ahead {
                    prepared.history = ahead.error(&self.problem.grid, components, fields, unit);
                }
            }
            self.ahead = ahead;
        }
        self.problem.steady = roll.is_steady.then_some(distance);
        self.problem.remember(&before, &PerDof::all(0.0));
        prepared
    }

    /// Lets the shifts and the twist of the punch count from where it is.
    fn count_anew(&mut self) {
        let mut motion = self.departure.motion.per_dof();
        for dof in Dof::TANGENTIAL {
            (motion[dof], self.start.motion[dof]) = (0.0, 0.0);
        }
        self.departure.motion = Motion::from_per_dof(motion);
    }

    /// Returns the last increment with its `status`, as it is shown to a watcher.
    fn solved(&self, status: &Status) -> Option<SolvedIncrement<'_>> {
        Some(SolvedIncrement {
            number: self.steps.len() as u64,
            is_certified: *status == Status::Certified,
            outcome: self.steps.last()?,
            fields: &self.fields,
            problem: &self.problem,
            tractions: &self.start.p,
        })
    }

    /// Returns the wear of each increment, of a scene that wears.
    fn wear(&self) -> Vec<Worn> {
        self.wearing.as_ref().map_or_else(Vec::new, |wearing| wearing.increments.clone())
    }

    /// Returns the outcomes, the last fields and the distance rolled last.
    fn solution(&self) -> PathSolution<'_> {
        PathSolution { steps: &self.steps, fields: &self.fields, rolled: self.rolled }
    }

    /// Returns the numbers of elements along x and y.
    fn elements(&self) -> [u32; 2] {
        [self.problem.grid.nx(), self.problem.grid.ny()].map(|n| n as u32)
    }

    /// Returns the path's grid and the work that it took.
    fn level(&self) -> Level {
        let sum =
            |figure: fn(&WorkDone) -> u64| self.steps.iter().map(|step| figure(&step.work)).sum();
        let work = WorkDone {
            iterations: sum(|work| work.iterations),
            operator_applications: sum(|work| work.operator_applications),
        };
        Level { elements: self.elements(), work }
    }
}

/// The number of elements along a side below which a grid is coarse enough to begin from nothing.
const COARSEST: u32 = 12;

/// Returns a start without tractions and motions.
fn nothing(problem: &Problem) -> Start {
    Start::new(vec![0.0; problem.f.len()], PerDof::all(0.0))
}

/// Returns a start for the first increment, found on grids of half as many elements each way, from
/// the coarsest up. Newton's method from nothing finds its way on few elements; on many it does
/// not. The paths on these grids, as far as the first increment, are added to `ladder`; on the
/// finest of them the increment is solved to `tolerance`.
fn coarse_start(
    setup: &PathSetup<'_>,
    operators: &mut Operators,
    fine: &Problem,
    tolerance: f64,
    ladder: &mut Vec<Path>,
) -> Start {
    let elements = [fine.grid.nx(), fine.grid.ny()].map(|n| n as u32);
    let halved = elements.map(|n| if n > COARSEST { n.div_ceil(2) } else { n });
    if halved == elements {
        return nothing(fine);
    }
    let Some(coarse) = first_increment(setup, operators, halved, tolerance, ladder) else {
        return nothing(fine);
    };
    let usable = coarse.steps.iter().all(|step| step.certificate.meets(START_TOLERANCE));
    let mut motion = coarse.reached;
    if let Some(increment) = setup.increments.first() {
        let distance = |problem| setup.roll(&increment.leg, problem).map(|roll| roll.distance);
        if let (Some(here), Some(there)) = (distance(fine), distance(&coarse.problem)) {
            carry_creepages(setup, fine, &mut motion, here / there);
        }
    }
    let start = Start::new(coarse.problem.grid.sample(&coarse.start.p, &fine.grid), motion);
    ladder.push(coarse);
    if usable { start } else { nothing(fine) }
}

/// Makes the motion of a rolling increment on a coarser grid one on the grid of `fine`. The
/// creepages are the same on both, while the distances have this `ratio`. A motion that a mirror
/// plane forbids is none: a coarser grid may have no plane, and rounding in its place.
fn carry_creepages(setup: &PathSetup<'_>, fine: &Problem, motion: &mut PerDof<f64>, ratio: f64) {
    for dof in Dof::TANGENTIAL {
        let moves = |stage: &Stage| {
            fine.reduced(stage.components, stage.mirror, None)
                .map_or(true, |reduced| reduced.moves(dof))
        };
        motion[dof] *= if setup.stages.iter().any(moves) { ratio } else { 0.0 };
    }
}

/// Solves the first increment on a grid of so many elements to `tolerance`, by way of coarser ones.
fn first_increment(
    setup: &PathSetup<'_>,
    operators: &mut Operators,
    elements: [u32; 2],
    tolerance: f64,
    ladder: &mut Vec<Path>,
) -> Option<Path> {
    let numerics = Numerics { mesh: Mesh::Exact(elements), ..setup.numerics.clone() };
    let problem = Problem::under(setup.scene, &numerics, setup.gap).ok()?;
    let increment = setup.increments.first()?;
    let start = coarse_start(setup, operators, &problem, START_TOLERANCE, ladder);
    let mut path = Path::new(setup, problem, start, operators);
    let rule = setup.rule(tolerance);
    path.advance(setup, Method::Newton, increment, &rule, operators);
    Some(path)
}

/// The relative residual at which a coarse solution is good enough to begin from.
const START_TOLERANCE: f64 = 1e-3;

/// Estimates the errors at the end of `path` from the same path on a grid of half as many elements
/// each way. That path is the one of `ladder`; if there is none, it is added.
fn estimate(
    setup: &PathSetup<'_>,
    path: &Path,
    ladder: &mut Vec<Path>,
    operators: &mut Operators,
) -> Option<Estimate> {
    let elements = estimate::coarser(path.elements())?;
    let position = match ladder.iter().position(|coarse| coarse.elements() == elements) {
        Some(position) => position,
        None => {
            let coarse = first_increment(setup, operators, elements, estimate::TOLERANCE, ladder)?;
            ladder.push(coarse);
            ladder.len() - 1
        }
    };
    let coarse = &mut ladder[position];
    if !coarse.steps.iter().all(|step| step.certificate.meets(estimate::TOLERANCE)) {
        return None;
    }
    let rule = setup.rule(estimate::TOLERANCE);
    for increment in &setup.increments[coarse.steps.len()..] {
        let status = coarse.advance(setup, Method::Newton, increment, &rule, operators);
        if status != Status::Certified {
            return None;
        }
    }
    estimate::estimate(setup.scene, setup.numerics, path.solution(), coarse.solution())
}

/// Returns the figures of Hertz's theory for an increment's load. The theory knows no layers, no
/// tilt and no moment, and not the shape that wear leaves.
fn hertz(scene: &Scene, gap: &Gap<'_>, step: &StepOutcome) -> Option<Hertz> {
    let load = step.observables.load;
    let is_worn = scene.wear.is_some_and(|wear| wear.changes_shape());
    let is_theirs = scene.foundation.layers.is_empty() && load > 0.0 && !is_worn;
    let curvatures = gap.curvatures().filter(|_| is_theirs)?;
    let compliance = surface_compliance(scene);
    let ellipse = hertz_ellipse(2.0 / compliance, 0.5 * curvatures[0], 0.5 * curvatures[1], load);
    let (a, b) = (ellipse.semi_axis_x, ellipse.semi_axis_y);
    Some(Hertz {
        semi_axis_a: a.max(b),
        semi_axis_b: a.min(b),
        area: std::f64::consts::PI * a * b,
        peak_pressure: ellipse.peak_pressure,
        approach: ellipse.approach,
    })
}

/// Returns the place where a wheel meets its rail after an increment.
fn rail_contact(gap: &Gap<'_>, step: &StepOutcome) -> Option<RailContact> {
    let PlacedWheel { pair, plane, .. } = gap.wheel_on_rail()?;
    let observables = &step.observables;
    let depth = plane.depth(step.motion.approach);
    let reference = pair.overlap_frame(depth.max(0.0));
    let load = observables.load;
    let center = [-observables.moment_y / load, observables.moment_x / load];
    // The point lies on the rail's surface, which the plane of contact only touches.
    let pressure_center = if load > 0.0 {
        pair.onto_rail(plane.to_track(center[0], center[1]))
    } else {
        reference.origin
    };
    Some(RailContact {
        track: reference.origin,
        rail: pair.to_rail(reference.origin),
        angle: reference.angle,
        pressure_center,
        wheelset_height: pair.height() + depth,
    })
}

/// Returns a reason with the place on the path where it holds, if the path has more than one
/// increment.
fn with_place(
    reason: &str,
    scene: &Scene,
    last: Option<&StepOutcome>,
    LegIncrement { leg, number }: &LegIncrement,
) -> String {
    let Some(last) = last else { return reason.to_owned() };
    if scene.loading.steps.len() == 1 && leg.increments == 1 {
        return reason.to_owned();
    }
    let mut place = format!("loading.steps[{}]", last.step);
    if leg.increments > 1 {
        place += &format!(", increment {number} of {}", leg.increments);
    }
    if last.cycle > 0 {
        place += &format!(", cycle {}", last.cycle);
    }
    format!("{place}: {reason}")
}
