//! Where a solver begins, what it hands over, and when it may stop.

use crate::model::{Control, Dof, PerDof, Way};

/// Where a solver begins, in the problem's units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Start {
    /// Tractions, zero where masked.
    pub(crate) p: Vec<f64>,
    /// Rigid motion.
    pub(crate) motion: PerDof<f64>,
}

/// What a solver hands over. Whether it is a solution is for the certificate to say.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// Tractions, three blocks [n | x | y], in the problem's units.
    pub p: Vec<f64>,
    /// Rigid motion, in the problem's units.
    pub motion: PerDof<f64>,
    /// Why the solver stopped.
    pub stop: Stop,
    /// Iterations of the method.
    pub iterations: u64,
    /// Operator applications (a Seidel sweep counts as one).
    pub operator_applications: u64,
    /// How it was found.
    pub route: Way,
}

/// Why a solver stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// Its own measure of the residual met the tolerance.
    Converged,
    /// It used up its iterations with this residual.
    OutOfIterations {
        /// Relative natural-map residual of the iterate.
        residual: f64,
    },
    /// The residual stopped falling: rounding, or iterates that go round in circles.
    Stalled {
        /// Smallest relative natural-map residual seen.
        residual: f64,
    },
    /// The iterates left the range of doubles.
    Diverged,
    /// A tangential force or twisting moment is asked that friction cannot carry: all that is in
    /// contact slips.
    Slides {
        /// Its degree of freedom.
        dof: Dof,
    },
    /// No rigid motion was found that gives a resultant that is asked.
    Unbalanced {
        /// Its degree of freedom.
        dof: Dof,
    },
    /// A moment governs a tilt about a single row of elements, which moves none of them.
    OneRow {
        /// Its degree of freedom.
        dof: Dof,
    },
}

impl Stop {
    /// Whether the solver takes its iterate for a solution, or for something the certificate may
    /// still accept.
    pub(crate) fn is_solution(&self) -> bool {
        !matches!(self, Stop::Slides { .. } | Stop::Unbalanced { .. } | Stop::OneRow { .. })
    }
}

/// When a solver may stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopRule {
    /// Relative natural-map residual to reach.
    pub tolerance: f64,
    /// Iterations after which to give up.
    pub max_iterations: u32,
}

/// What a solver is to reach, where it begins and when it may stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<'a> {
    /// What governs the punch, in the problem's units.
    pub(crate) controls: &'a PerDof<Control>,
    pub(crate) start: &'a Start,
    pub(crate) rule: &'a StopRule,
}
