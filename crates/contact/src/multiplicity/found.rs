//! How to search for several solutions, and what a search finds.

use serde::{Deserialize, Serialize};

use crate::common::random;
use crate::model::{
    Certificate, Fields, Method, Motion, Observables, SceneError, Status, StepOutcome, WorkDone,
};

/// What to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// Random starts, beside those that are always tried, at most
    /// [`MOST_STARTS`](Self::MOST_STARTS); up to four times as many while the solutions' indices do
    /// not add up.
    #[serde(default = "Search::default_starts")]
    pub starts: u32,
    /// Seed of the random starts; the same seed, the same starts, and more starts keep the first
    /// ones.
    #[serde(default)]
    pub seed: u64,
}

impl Search {
    /// The most random starts.
    pub const MOST_STARTS: u32 = random::MOST_STARTS;

    /// Refuses more than these.
    pub fn validate(&self) -> Result<(), SceneError> {
        random::validate_starts(self.starts)
    }

    /// The default number of random starts, 60.
    pub fn default_starts() -> u32 {
        60
    }
}

impl Default for Search {
    fn default() -> Self {
        Self { starts: Self::default_starts(), seed: 0 }
    }
}

/// What a search found. Plain and deterministic: same scene, numerics and search, same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multiplicity {
    /// Failed if the path could not be followed to the last increment, or no start led to a
    /// certified solution.
    pub status: Status,
    /// The increments before the one searched; the last one is where the path failed, if it did.
    pub before: Vec<StepOutcome>,
    /// The distinct certified solutions, in the order in which they were found; at most
    /// [`Multiplicity::MOST_SOLUTIONS`].
    pub solutions: Vec<Solution>,
    /// Starts tried, one for each method.
    pub starts: u64,
    /// Those that led to no certified solution.
    pub failed: u64,
    /// Those that led to certified solutions beyond the ones kept; above 0 the solutions are likely
    /// a continuum.
    pub beyond: u64,
    /// Sum of the solutions' indices: 1 if none is missing; `None` where one has no index.
    pub index_sum: Option<i64>,
    /// What the search took.
    pub work: WorkDone,
    /// Dense matrices factored.
    pub factorisations: u64,
}

impl Multiplicity {
    /// The most solutions that are kept.
    pub const MOST_SOLUTIONS: usize = 64;

    /// The most elements of Ω, for dense matrices are factored.
    pub const MOST_ELEMENTS: usize = 1024;

    /// The two solutions furthest apart.
    pub fn furthest(&self) -> Option<[usize; 2]> {
        let pairs = (0..self.solutions.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
        pairs.max_by(|a, b| self.distance(*a).total_cmp(&self.distance(*b)))
    }

    fn distance(&self, [i, j]: [usize; 2]) -> f64 {
        self.solutions[i].distances[j]
    }
}

/// One of the solutions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// Where the punch is.
    pub motion: Motion,
    /// Quantities in SI units.
    pub observables: Observables,
    /// Solver-independent residuals.
    pub certificate: Certificate,
    /// The start that first led to it.
    pub origin: Origin,
    /// The method that first led to it, Newton or Seidel.
    pub method: Method,
    /// Starts that led to it.
    pub reached: u64,
    /// Relative distance ‖J⁻¹F‖/‖p‖ from the exact solution, to first order; infinite where J is
    /// singular.
    pub error: f64,
    /// sign det J, 0 where J is singular to rounding or an element is between two states; `None`
    /// where a force governs a motion, or in the midpoint projection, for then the indices need not
    /// add up to 1.
    pub index: Option<i64>,
    /// L₂ distance of its tractions to those of every solution, this one too, over the larger of
    /// the two norms.
    pub distances: Vec<f64>,
    /// Its fields.
    pub fields: Fields,
}

/// Where a start comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Origin {
    /// No tractions, or those at the end of the increment before.
    Before,
    /// No tractions.
    Nothing,
    /// A half ellipsoid of pressure.
    Hertz,
    /// All of the sole sticks.
    Stick,
    /// All of the sole slips, the traction at so many eighths of a turn from x.
    Slip(u32),
    /// Random tractions inside the friction cone; the number of the start.
    Tractions(u32),
    /// A random pattern of states; the number of the start.
    Pattern(u32),
    /// μ followed down from a large value.
    FrictionFromAbove,
    /// μ followed up from zero.
    FrictionFromBelow,
    /// The image of a solution under a symmetry of the grid.
    Image(u32),
    /// A disturbed solution.
    Disturbed(u32),
    /// A solution followed to a larger μ and back.
    FrictionLoopAbove(u32),
    /// A solution followed to a smaller μ and back.
    FrictionLoopBelow(u32),
    /// Newton's method deflated by all solutions up to this one.
    Deflated(u32),
    /// Between two solutions.
    Between([u32; 2]),
}
