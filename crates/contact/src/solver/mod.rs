//! One entry point for all methods: a problem and its operator in, an iterate with figures out.

pub mod seidel;

/// What a solver hands over. Whether it is a solution is for the certificate to say.
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// Tractions, three blocks [n | x | y], in the problem's units.
    pub p: Vec<f64>,
    /// Why the solver stopped.
    pub stop: Stop,
    /// Iterations of the method.
    pub iterations: u64,
    /// Operator applications (a Seidel sweep counts as one).
    pub operator_applications: u64,
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
}

/// When a solver may stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Relative natural-map residual to reach.
    pub tolerance: f64,
    /// Iterations after which to give up.
    pub max_iterations: u32,
}
