//! Elastic contact with Coulomb friction: scenes, influence operators, solvers, certificates.
//!
//! [`solve`] follows the loading path of a scene. A rigid sphere that is pressed into steel carries
//! the load of Hertz's theory:
//!
//! ```
//! use contact::{Operators, model::*, punch::Surfaces, solve, theory::hertz_sphere};
//!
//! let steel = Material { shear_modulus: 80e9, poisson: 0.3 };
//! let scene = Scene {
//!     foundation: Foundation::half_space(steel),
//!     punch: Punch { shape: Shape::Sphere { radius: 0.01 }, material: None },
//!     friction: Friction { mu: 0.0 },
//!     wear: None,
//!     domain: None,
//!     loading: Loading::path(vec![Step { approach: Some(1e-6), ..Step::default() }]),
//!     interior: None,
//! };
//! let numerics: Numerics = serde_json::from_str(r#"{"mesh": 32}"#)?;
//! let (outcome, _) = solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default())?;
//! let load = outcome.steps[0].observables.load;
//! let hertz = hertz_sphere(2.0 * steel.shear_modulus / (1.0 - steel.poisson), 0.01, 1e-6);
//! assert_eq!(outcome.status, Status::Certified);
//! assert!((load / hertz.load - 1.0).abs() < 0.01, "{load} N");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! - Everything public is in SI units. The plane of contact is z = 0, and z points **into** the
//!   foundation.
//! - Vector fields have three components per element in the order (n, x, y), with the normal first
//!   as in Alexandrov's (p₁, p₂, p₃). The pressure p₁ ≥ 0 is compressive; (p₂, p₃) is the traction
//!   that the punch exerts on the foundation.
//! - `A p` is the displacement of the foundation's surface relative to the punch's, with both
//!   bodies' compliances summed; component 1 is positive into the foundation. f₁ is δ + tilt terms
//!   − g₀, and (f₂, f₃) is the tangential rigid shift.
//! - w is A p − f: w₁ ≥ 0 is the gap, and (w₂, w₃) is the slip.
//! - Ω is a rectangle of nx × ny equal elements hx × hy; element (i, j) has index j·nx + i (x
//!   fastest).
//! - G is the shear modulus, ν Poisson's ratio, μ the friction coefficient, ε the regularisation, u
//!   the pressure ceiling, c = Σ(1−ν)/G, and ℓ half the diameter of Ω.
//!
//! # Layers
//! Every module uses only modules before it in this list, which is in reading order:
//! - [`model`]: the data that go into a solve and come out of it;
//! - [`literature`]: the works that the method and the effects are taken from;
//! - [`theory`]: classical formulas, and the laws that a ladder of values follows;
//! - `common`: tools that every layer may use;
//! - [`foundation`]: the elasticity of the bodies as seen from the plane of contact;
//! - [`grid`]: the uniform grid on Ω;
//! - [`punch`]: the geometry of the punch, its gap g₀ and its Ω;
//! - [`influence`]: the operator A from tractions to displacements;
//! - [`problem`]: a scene that is bound to a grid, in units of its own;
//! - [`solver`]: the methods, which find the tractions of one increment;
//! - [`assess`]: the worth of a solution: observables, certificate, errors and estimates;
//! - [`interior`]: the stresses below the surface, from the tractions on it;
//! - `path`: the loading path, each increment of it solved and certified ([`solve`]);
//! - [`uniqueness`]: the bracket of μ*, the friction below which solutions are unique;
//! - [`multiplicity`]: the search for several solutions of one increment;
//! - `forecast`: the time and the memory of a solve before it runs ([`forecast()`]).
//!
//! The crate touches no files, starts no processes, reads no clock and prints nothing.
#![forbid(unsafe_code)]

pub mod assess;
mod common;
mod forecast;
pub mod foundation;
pub mod grid;
pub mod influence;
pub mod interior;
pub mod literature;
pub mod model;
pub mod multiplicity;
mod path;
pub mod problem;
pub mod punch;
pub mod solver;
pub mod theory;
pub mod uniqueness;

pub use common::{Cancellation, SplitMix64};
pub use forecast::{Forecast, forecast, forecast_bracket, forecast_branch, forecast_search};
pub use path::{
    FrictionProblem, FrictionProblemError, SolvedIncrement, Watch, solve, solve_watched,
};
pub use problem::{Operator, Operators};
