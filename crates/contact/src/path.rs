//! The loading path of a scene, followed increment by increment, each of them certified.
//!
//! Knows [`solver`](crate::solver), [`assess`](crate::assess) and what is below them.

mod follow;
mod increment;

pub use follow::solve;
pub(crate) use increment::{Departure, Increment, certify_increment, in_units};
