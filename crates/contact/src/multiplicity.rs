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

use self::seeker::Seeker;
use crate::influence::{Components, Mirror};
use crate::model::{Control, Numerics, PerDof, Scene, SceneError, Status};
use crate::path::in_units;
use crate::problem::{Operators, Problem};
use crate::punch::Surfaces;
use crate::solver::Start;

mod found;
mod natural_map;
mod seeker;
mod start;

pub use found::{Multiplicity, Origin, Search, Solution};

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
    asked: &PerDof<Control>,
    numerics: &Numerics,
    operators: &mut Operators,
    search: &Search,
) -> Result<Multiplicity, SceneError> {
    assert!(
        problem.components == Components::ALL && problem.mirror == Mirror::NONE,
        "a search needs the full problem"
    );
    let nothing = Start { p: vec![0.0; problem.f.len()], motion: PerDof::all(0.0) };
    let mut seeker = Seeker::new(problem, numerics, operators)?;
    seeker.asked = *asked;
    seeker.controls = in_units(asked, &seeker.problem);
    seeker.seek(&nothing, search);
    Ok(seeker.conclude())
}
