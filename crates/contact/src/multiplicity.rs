//! How many solutions a contact problem has: many starting points, every candidate certified, the
//! solutions told apart.
//!
//! The search takes the last increment of a loading path. What comes before it is followed as
//! [`crate::solve`] would, with every effect simulated, and fixes the tangential right-hand side
//! f_t = shift + (A p)_t; what other histories could have led to is not looked at. Mirror planes
//! and reductions are off throughout, for solutions of a symmetric scene need not be symmetric.
//!
//! **Starts.** Nothing; the end of the increment before; a half ellipsoid of pressure; all sole
//! sticking; all of it slipping, in eight directions; then [`Search::starts`] random ones:
//! tractions inside the friction cone, and patterns of open, sticking and slipping elements
//! (independent, or in the regions between random lines) whose linear equations are solved exactly.
//! From each both a semismooth Newton method without globalisation, which can end at any solution,
//! and Alexandrov's Seidel iteration, which ends at those that attract it. The friction coefficient
//! is followed down from a large value and up from zero. Every solution found is a source of more:
//! its images under the symmetries of the grid, disturbed tractions, loops of μ, mixtures with
//! earlier solutions, and Newton's method deflated by what is known (Farrell, Birkisson and Funke
//! 2015, doi:10.1137/140984798), which cannot converge to it again.
//!
//! **Same or different.** A candidate is polished by Newton's method until its relative natural-map
//! residual is 1e-12 or rounding stops it, and must meet the certificate. F(p) = p − G(p − E(εp +
//! Ap − f)) linearised there, with Jacobian J, bounds to first order what is left:
//! [`Solution::error`] = ‖J⁻¹F‖/‖p‖. Two candidates are different solutions when the relative L₂
//! distance of their tractions exceeds 1e-5, and 100 times both errors. The first figure is what a
//! residual of 1e-12 becomes under a condition of 10⁷.
//!
//! **Is one missing?** For a solution, p·(εp + Ap − f) ≤ 0, which bounds it for every μ when A is
//! positive definite; so the degree of F does not change with μ. At μ = 0 it is that of the one
//! solution there, 1. Hence the [indices](Solution::index) sign det J of all solutions, if none is
//! singular, add up to 1: their number is odd, and a [sum](Multiplicity::index_sum) other than 1
//! says that one was missed. A sum of 1 does not say that none was.

use serde::{Deserialize, Serialize};

use self::seeker::Seeker;
use crate::common::random;
use crate::influence::{Components, Mirror};
use crate::model::{
    Certificate, Control, Fields, Method, Motion, Numerics, Observables, Scene, SceneError, Status,
    StepOutcome, WorkDone,
};
use crate::problem::{Operators, Problem};
use crate::punch::Surfaces;
use crate::solve::in_units;
use crate::solver::Start;

mod natural_map;
mod seeker;
mod start;

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

/// Searches for solutions of the last increment of a scene's path. Refuses what [`crate::solve`]
/// refuses, and more than [`Multiplicity::MOST_ELEMENTS`] elements. Certificates must meet the
/// tolerance asked for, and 1e-10.
pub fn search(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
    operators: &mut Operators,
    search: &Search,
) -> Result<Multiplicity, SceneError> {
    search.validate()?;
    let problem = Problem::new(scene, numerics, surfaces)?;
    let mut seeker = Seeker::new(problem, numerics, operators)?;
    match seeker.follow(scene) {
        Ok(start) => seeker.seek(&start, search),
        Err(reason) => seeker.result.status = Status::Failed { reason },
    }
    Ok(seeker.conclude())
}

/// The same for one increment with any past: the right-hand side is what `problem`
/// [remembers](Problem::remember) and the motions that `asked` \[SI\] prescribes. Of `numerics`
/// only the tolerance and the iterations count.
///
/// # Panics
/// If the problem is a [reduced](Problem::reduced) one.
pub fn search_from(
    problem: Problem,
    asked: &[Control; 6],
    numerics: &Numerics,
    operators: &mut Operators,
    search: &Search,
) -> Result<Multiplicity, SceneError> {
    assert!(
        problem.components == Components::ALL && problem.mirror == Mirror::NONE,
        "a search needs the full problem"
    );
    let nothing = Start { p: vec![0.0; problem.f.len()], motion: [0.0; 6] };
    let mut seeker = Seeker::new(problem, numerics, operators)?;
    seeker.asked = *asked;
    seeker.controls = in_units(asked, &seeker.problem);
    seeker.seek(&nothing, search);
    Ok(seeker.conclude())
}
