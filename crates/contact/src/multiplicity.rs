//! The number of solutions of a contact problem: many starting points, every candidate certified,
//! the solutions told apart.
//!
//! Knows `path`, [`solver`](crate::solver) and all that is below them. In reading
//! order:
//! - `found`: the effort of a search, and the solutions that it finds;
//! - `natural_map`: the natural map, its linearisation, and what follows from dense matrices of it;
//! - `start`: starting points;
//! - `seeker`: the search itself.
//!
//! The search takes the last increment of a loading path. The increments before it are followed as
//! [`crate::solve`] would follow them, with every effect simulated, and fix the tangential
//! right-hand side f_t = shift + (A p)_t. The search does not look at what other histories could
//! have led to. Mirror planes and reductions are off throughout, for solutions of a symmetric scene
//! need not be symmetric.
//!
//! **Starts.** The starts are no tractions; the end of the increment before; a half ellipsoid of
//! pressure; all of the sole sticking; all of it slipping, in eight directions; then
//! [`Search::starts`] random ones: tractions inside the friction cone, and patterns of open,
//! sticking and slipping elements (independent, or in the regions between random lines) whose
//! linear equations are solved exactly. From each start go both a semismooth Newton method without
//! globalisation, which can end at any solution, and Alexandrov's Seidel iteration, which ends at
//! those that attract it. The friction coefficient is followed down from a large value and up from
//! zero. Every solution found is a source of more: its images under the symmetries of the grid,
//! disturbed tractions, loops of μ, mixtures with earlier solutions, and Newton's method deflated
//! by the solutions that are known (Farrell, Birkisson and Funke 2015, doi:10.1137/140984798),
//! which cannot converge to them again.
//!
//! **Same or different.** Newton's method polishes a candidate until its relative natural-map
//! residual is 1e-12 or rounding stops it, and the candidate must meet the certificate. The
//! linearisation of F(p) = p − G(p − E(εp + Ap − f)) there, with Jacobian J, bounds the remaining
//! error to first order: [`Solution::error`] = ‖J⁻¹F‖/‖p‖. Two candidates are different solutions
//! if the relative L₂ distance of their tractions exceeds 1e-5, and 100 times both errors. The
//! first figure is what a residual of 1e-12 becomes under a condition of 10⁷.
//!
//! **Is one missing?** A solution satisfies p·(εp + Ap − f) ≤ 0, which bounds it for every μ if A
//! is positive definite; so the degree of F does not change with μ. At μ = 0 it is that of the one
//! solution there, 1. Hence the [indices](Solution::index) sign det J of all solutions, if none is
//! singular, add up to 1: their number is odd, and a [sum](Multiplicity::index_sum) other than 1
//! says that one was missed. A sum of 1 does not say that none was.

use self::seeker::Seeker;
use crate::influence::{Components, Mirror};
use crate::model::{Control, Numerics, PerDof, Scene, SceneError, Status, refuse};
use crate::path::in_units;
use crate::problem::{Operators, Problem};
use crate::punch::Surfaces;
use crate::solver::Start;

mod found;
mod natural_map;
mod seeker;
mod start;

pub use found::{Multiplicity, Origin, Search, Solution};

/// Searches for solutions of the last increment of a scene's path. Certificates must meet the
/// tolerance of `numerics`, and 1e-10.
///
/// # Errors
/// A [`SceneError`] is one of [`crate::solve`], or refuses too many starts or more than
/// [`Multiplicity::MOST_ELEMENTS`] elements.
pub fn search(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
    operators: &mut Operators,
    search: &Search,
) -> Result<Multiplicity, SceneError> {
    search.validate()?;
    if let Some(wear) = scene.wear {
        return Err(refuse(
            "wear.coefficient",
            wear.coefficient,
            "cannot stand in a scene whose solutions are searched for",
        ));
    }
    if let Some(leg) = scene.loading.legs().iter().find(|leg| leg.rolling.is_some()) {
        let key = if leg.is_steady() { "steady" } else { "distance" };
        return Err(refuse(
            &format!("loading.steps[{}].{key}", leg.step),
            "given",
            "cannot stand in a path whose solutions are searched for",
        ));
    }
    let problem = Problem::new(scene, numerics, surfaces)?;
    let mut seeker = Seeker::new(problem, numerics, operators)?;
    match seeker.follow(scene) {
        Ok(start) => seeker.seek(&start, search),
        Err(reason) => seeker.result.status = Status::Failed { reason },
    }
    Ok(seeker.conclude())
}

/// Searches for solutions of one increment with any past. The right-hand side consists of what
/// `problem` [remembers](Problem::remember) and of the motions that `target` prescribes, in SI
/// units. Only the tolerance and the iterations of `numerics` count.
///
/// # Errors
/// A [`SceneError`] refuses more than [`Multiplicity::MOST_ELEMENTS`] elements.
///
/// # Panics
/// It panics if the problem is a reduced one.
pub fn search_from(
    problem: Problem,
    target: &PerDof<Control>,
    numerics: &Numerics,
    operators: &mut Operators,
    search: &Search,
) -> Result<Multiplicity, SceneError> {
    assert!(
        problem.components == Components::ALL && problem.mirror == Mirror::NONE,
        "a search needs the full problem"
    );
    let nothing = Start::new(vec![0.0; problem.f.len()], PerDof::all(0.0));
    let mut seeker = Seeker::new(problem, numerics, operators)?;
    seeker.target = *target;
    seeker.controls = in_units(target, &seeker.problem);
    seeker.seek(&nothing, search);
    Ok(seeker.conclude())
}
