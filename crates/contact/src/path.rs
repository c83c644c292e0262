//! The loading path of a scene, followed increment by increment, each of them certified.
//!
//! The folder uses [`solver`](crate::solver), [`assess`](crate::assess) and what is below them. In
//! reading order:
//! - `increment`: one increment, from a solver's iterate to a certified outcome;
//! - `watched`: an increment as it is shown to who watches a path ([`SolvedIncrement`]), and its
//!   discrete friction problem ([`FrictionProblem`]);
//! - `wearing`: the wear of each increment, and the shape that it leaves;
//! - `worn_material`: the depth on the material, which may pass through Ω;
//! - `follow`: the whole path ([`solve`](fn@crate::solve)), its coarser grids and the estimate.

mod follow;
mod increment;
mod watched;
mod wearing;
mod worn_material;

pub use follow::{Watch, solve, solve_watched};
pub(crate) use increment::{Certifying, Departure, Increment, certify_increment, in_units};
pub use watched::{FrictionProblem, FrictionProblemError, SolvedIncrement};
