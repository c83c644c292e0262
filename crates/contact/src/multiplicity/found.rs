//! The effort of a search for several solutions, and the solutions that it finds.

use serde::{Deserialize, Serialize};

use crate::common::random;
use crate::model::{
    Certificate, Fields, Method, Motion, Observables, SceneError, Status, StepOutcome, WorkDone,
};

/// The effort of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// The number of random starts, beside those that are always tried, at most
    /// [`MOST_STARTS`](Self::MOST_STARTS). Up to four times as many are tried while the solutions'
    /// indices do not add up.
    #[serde(default = "Search::default_starts")]
    pub starts: u32,
    /// The seed of the random starts. The same seed gives the same starts, and more starts keep the
    /// first ones.
    #[serde(default)]
    pub seed: u64,
}

impl Search {
    /// The largest number of random starts.
    pub const MOST_STARTS: u32 = random::MOST_STARTS;

    /// Checks the number of starts.
    ///
    /// # Errors
    /// A [`SceneError`] says that there are more than [`MOST_STARTS`](Self::MOST_STARTS).
    pub fn validate(&self) -> Result<(), SceneError> {
        random::validate_starts(self.starts)
    }

    /// Returns the default number of random starts, 60.
    pub(crate) fn default_starts() -> u32 {
        60
    }
}

impl Default for Search {
    fn default() -> Self {
        Self { starts: Self::default_starts(), seed: 0 }
    }
}

/// The result of a search. It is plain and deterministic: the same scene, numerics and search give
/// the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multiplicity {
    /// The status. It is failed if the path could not be followed to the last increment, or if no
    /// start led to a certified solution.
    pub status: Status,
    /// The increments before the one searched. The last of them is the one at which the path
    /// failed, if it did.
    pub before: Vec<StepOutcome>,
    /// The distinct certified solutions, in the order in which they were found; at most
    /// [`Multiplicity::MOST_SOLUTIONS`].
    pub solutions: Vec<Solution>,
    /// The number of starts tried, counted once for each method.
    pub starts: u64,
    /// The number of starts that led to no certified solution.
    pub failed: u64,
    /// The number of starts that led to certified solutions beyond the ones kept. If it is above 0,
    /// the solutions are likely a continuum.
    pub beyond: u64,
    /// The sum of the solutions' indices. It is 1 if none is missing, and `None` if one has no
    /// index.
    pub index_sum: Option<i64>,
    /// The work that the search took.
    pub work: WorkDone,
    /// The number of dense matrices factored.
    pub factorisations: u64,
}

impl Multiplicity {
    /// The largest number of solutions that are kept.
    pub const MOST_SOLUTIONS: usize = 64;

    /// The largest number of elements of Ω, for dense matrices are factored.
    pub const MOST_ELEMENTS: usize = 1024;

    /// Returns the indices of the two solutions furthest apart, or `None` if there are fewer than
    /// two.
    pub fn furthest(&self) -> Option<[usize; 2]> {
        let pairs = (0..self.solutions.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
        pairs.max_by(|a, b| self.distance(*a).total_cmp(&self.distance(*b)))
    }

    fn distance(&self, [i, j]: [usize; 2]) -> f64 {
        self.solutions[i].distances[j]
    }
}

/// A solution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// The motion of the punch.
    pub motion: Motion,
    /// The observables in SI units.
    pub observables: Observables,
    /// The certificate: residuals that are independent of the solver.
    pub certificate: Certificate,
    /// The start that first led to the solution.
    pub origin: Origin,
    /// The method that first led to the solution, Newton or Seidel.
    pub method: Method,
    /// The number of starts that led to the solution.
    pub reached: u64,
    /// The relative distance ‖J⁻¹F‖/‖p‖ from the exact solution, to first order. It is infinite if
    /// J is singular.
    pub error: f64,
    /// The sign of det J. It is 0 if J is singular to rounding or an element is between two states.
    /// It is `None` if a force governs a motion, or in the midpoint projection, for then the
    /// indices need not add up to 1.
    pub index: Option<i64>,
    /// The L₂ distance of its tractions to those of every solution, including itself, over the
    /// larger of the two norms.
    pub distances: Vec<f64>,
    /// The fields of the solution.
    pub fields: Fields,
}

/// The origin of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// The start has no tractions, or those at the end of the increment before.
    Before,
    /// The start has no tractions.
    Nothing,
    /// The start is a half ellipsoid of pressure.
    Hertz,
    /// All of the sole sticks.
    Stick,
    /// All of the sole slips, with the traction at so many eighths of a turn from x.
    Slip(u32),
    /// The start has random tractions inside the friction cone; the number is that of the start.
    Tractions(u32),
    /// The start is a random pattern of states; the number is that of the start.
    Pattern(u32),
    /// The friction μ is followed down from a large value.
    FrictionFromAbove,
    /// The friction μ is followed up from zero.
    FrictionFromBelow,
    /// The start is the image of a solution under a symmetry of the grid.
    Image(u32),
    /// The start is a disturbed solution.
    Disturbed(u32),
    /// A solution is followed to a larger μ and back.
    FrictionLoopAbove(u32),
    /// A solution is followed to a smaller μ and back.
    FrictionLoopBelow(u32),
    /// Newton's method is deflated by all solutions up to this one.
    Deflated(u32),
    /// The start lies between two solutions.
    Between([u32; 2]),
}
