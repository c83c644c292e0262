//! What a result is worth: what it shows, its certificate, and how far it is from a closed form,
//! from another solution, or from what a finer mesh would give.
//!
//! Knows [`problem`](crate::problem) and what is below it; no solver, so that nothing here shares a
//! solver's mistakes.

mod certificate;
mod closed_form;
mod errors;
pub(crate) mod estimate;
pub mod norms;
mod observables;
mod quadrature;

pub use certificate::certify;
pub(crate) use certificate::transform_error;
pub use closed_form::{ClosedForm, closed_form};
pub use errors::Errors;
pub(crate) use observables::fields;
pub use observables::{observables, patches, states};
