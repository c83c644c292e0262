//! The start of a solver, the iterate that it hands over, and the rule by which it may stop.

use crate::common::Cancellation;
use crate::model::{Control, Dof, PerDof, Route};

/// The place where a solver begins, in the problem's units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Start {
    /// The tractions, zero where masked.
    pub(crate) p: Vec<f64>,
    /// The rigid motion.
    pub(crate) motion: PerDof<f64>,
    /// The differences w = A p − f of the increment before, in whose states the elements are taken
    /// to be at first; `None` if p and the new f say in what states they are.
    pub(crate) w: Option<Vec<f64>>,
}

impl Start {
    /// Begins with these tractions at this motion.
    pub(crate) fn new(p: Vec<f64>, motion: PerDof<f64>) -> Self {
        Self { p, motion, w: None }
    }
}

/// The result of a solver. The certificate says whether it is a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// The tractions in three blocks [n | x | y], in the problem's units.
    pub p: Vec<f64>,
    /// The rigid motion, in the problem's units.
    pub motion: PerDof<f64>,
    /// The reason why the solver stopped.
    pub stop: Stop,
    /// The number of the method's iterations.
    pub iterations: u64,
    /// The number of operator applications; a Seidel sweep counts as one.
    pub operator_applications: u64,
    /// The route by which it was found.
    pub route: Route,
}

impl Iterate {
    /// Returns the iterate with the work of an attempt before it, and the longer route of both.
    pub(crate) fn after(self, before: &Self) -> Self {
        Self {
            iterations: before.iterations + self.iterations,
            operator_applications: before.operator_applications + self.operator_applications,
            route: before.route.max(self.route),
            ..self
        }
    }
}

/// The reason why a solver stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// The solver's own measure of the residual met the tolerance.
    Converged,
    /// The solver used up its iterations with this residual.
    OutOfIterations {
        /// The relative natural-map residual of the iterate.
        residual: f64,
    },
    /// The residual stopped falling, because of rounding or because the iterates go round in
    /// circles.
    Stalled {
        /// The smallest relative natural-map residual seen.
        residual: f64,
    },
    /// The iterates left the range of doubles.
    Diverged,
    /// The target is a tangential force or twisting moment that friction cannot carry: all elements
    /// in contact slip.
    Slides {
        /// The degree of freedom of that force or moment.
        dof: Dof,
    },
    /// No rigid motion was found that gives a resultant that is prescribed.
    Unbalanced {
        /// The degree of freedom of that force or moment.
        dof: Dof,
    },
    /// A moment governs a tilt about a single row of elements, which moves none of them.
    OneRow {
        /// The degree of freedom of that tilt.
        dof: Dof,
    },
}

impl Stop {
    /// Returns whether the solver takes its iterate for a solution, or for something that the
    /// certificate may still accept.
    pub(crate) fn is_solution(&self) -> bool {
        !matches!(self, Stop::Slides { .. } | Stop::Unbalanced { .. } | Stop::OneRow { .. })
    }
}

/// The rule by which a solver may stop.
#[derive(Clone, Copy, Debug)]
pub struct StopRule<'a> {
    /// The relative natural-map residual to reach.
    pub tolerance: f64,
    /// The number of iterations after which the solver gives up.
    pub max_iterations: u32,
    /// The request to give up before, if somebody can make one.
    pub cancellation: Option<&'a Cancellation>,
}

impl StopRule<'_> {
    /// Returns whether the solver is asked to give up.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancellation.is_some_and(Cancellation::is_requested)
    }
}

/// The target of a solve, its start, and the rule by which it may stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<'a> {
    /// The motions and forces that govern the punch, in the problem's units.
    pub(crate) controls: &'a PerDof<Control>,
    /// The place where the solver begins.
    pub(crate) start: &'a Start,
    /// The rule by which it may stop.
    pub(crate) rule: &'a StopRule<'a>,
}
