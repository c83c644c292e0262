//! The loading path of a scene, followed increment by increment, each of them certified.
//!
//! The folder uses [`solver`](crate::solver), [`assess`](crate::assess) and what is below them. In
//! reading order:
//! - `increment`: one increment, from a solver's iterate to a certified outcome;
//! - `follow`: the whole path ([`solve`](fn@crate::solve)), its coarser grids and the estimate.

mod follow;
mod increment;

pub use follow::solve;
pub(crate) use increment::{Departure, Increment, certify_increment, in_units};
