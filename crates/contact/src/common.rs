//! Tools that every layer may use: work shared among threads, random numbers, quadrature.
//!
//! Knows nothing of the crate above it but [`model`](crate::model), for a refusal.

pub(crate) mod gauss;
pub(crate) mod parallel;
pub(crate) mod random;
