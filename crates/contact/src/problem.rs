//! A scene bound to a grid, in units of its own: the equation of one increment, the effects that it
//! has, and the operators kept for it.
//!
//! Knows bodies, punch, influence and what is below them; no solver.

mod equation;
mod friction;
mod layout;
mod operators;
mod reduction;
mod scale;

pub use equation::{OperatorKey, Problem};
pub use friction::{g_mu, h, h_u, q};
pub(crate) use layout::Layout;
pub use operators::{Operator, Operators};
pub use reduction::{Decision, Effects, Stage};
pub use scale::Scale;
