//! Tools that every layer may use.
//!
//! The folder knows nothing of the crate above it except [`model`](crate::model), whose errors it
//! needs for one refusal.
//!
//! In reading order:
//! - `parallel`: work on many numbers, shared among threads;
//! - `random`: random numbers that are the same for ever;
//! - `gauss`: Gauss rules for the densities of a boundary element;
//! - `cancellation`: a request from outside to give up ([`Cancellation`]).

mod cancellation;
pub(crate) mod gauss;
pub(crate) mod parallel;
pub(crate) mod random;

pub use cancellation::Cancellation;
pub use random::SplitMix64;
