//! Elastic contact with Coulomb friction: scenes, influence operators, solvers, certificates.
//!
//! # Conventions
//! - SI units in everything public. The plane of contact is z = 0, z points **into** the
//!   foundation.
//! - Vector fields have three components per element in the order (n, x, y): normal first, as in
//!   Alexandrov's (p₁, p₂, p₃). Pressure p₁ ≥ 0 is compressive; (p₂, p₃) is the traction that the
//!   punch exerts on the foundation.
//! - `A p` is the displacement of the foundation's surface relative to the punch's, both bodies'
//!   compliances summed; component 1 is positive into the foundation. f₁ = δ + tilt terms − g₀,
//!   (f₂, f₃) the tangential rigid shift.
//! - w = A p − f: w₁ ≥ 0 is the gap, (w₂, w₃) the slip.
//! - Ω is a rectangle of nx × ny equal elements hx × hy; element (i, j) has index j·nx + i (x
//!   fastest).
//! - G shear modulus, ν Poisson's ratio, μ friction, ε regularisation, u pressure ceiling, c =
//!   Σ(1−ν)/G, ℓ half the diameter of Ω.
//!
//! The crate touches no files, starts no processes, reads no clock and prints nothing.
#![forbid(unsafe_code)]

pub mod assess;
mod common;
mod forecast;
pub mod foundation;
pub mod grid;
pub mod influence;
pub mod model;
pub mod multiplicity;
pub mod path;
pub mod problem;
pub mod punch;
pub mod solver;
pub mod theory;
pub mod uniqueness;

pub use forecast::{Forecast, forecast, forecast_bracket, forecast_search};
pub use path::solve;
pub use problem::{Operator, Operators};
