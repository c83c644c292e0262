//! A scene that is bound to a grid, in units of its own: the equation of one increment, the effects
//! that it has, and the operators that are kept for it.
//!
//! The folder uses [`foundation`](crate::foundation), [`punch`](crate::punch),
//! [`influence`](crate::influence) and the layers below them; it knows no solver.
//!
//! In reading order:
//! - `friction`: Coulomb friction as a projection, the maps of equations (1) and (3);
//! - `scale`: the units, and the range in which double precision holds ([`Scale`]);
//! - `layout`: the cut of Ω into elements, and the increments that these make;
//! - `equation`: equation (3) on a grid, for one increment ([`Problem`]);
//! - `reduction`: the effects that a scene calls for ([`Effects`]), and the [`Stage`]s of a solve;
//! - `operators`: the operators that are kept between solves ([`Operators`]).

mod equation;
mod friction;
mod layout;
mod operators;
mod reduction;
mod scale;

pub use equation::Problem;
pub(crate) use friction::{g_mu, h_u};
pub(crate) use layout::{LEAST_DISTANCE, Layout, check_distances, on_grid};
pub use operators::{Operator, Operators};
pub use reduction::{Decision, Effects, Stage};
pub use scale::Scale;
