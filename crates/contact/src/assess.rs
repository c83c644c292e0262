//! The worth of a result: its observables, its certificate, and its distance from a closed form,
//! from another solution, or from the limit of ever finer meshes.
//!
//! The folder uses [`problem`](crate::problem) and what is below it. It knows no solver, so that
//! nothing here shares a solver's mistakes. In reading order:
//! - `observables`: the states of the elements, integral quantities, patches and fields;
//! - `certificate`: the residuals of a claimed solution ([`certify`]);
//! - `ahead`: displacements a rolled distance ahead, by sums of their own;
//! - `norms`: norms of tractions and distances between grids ([`norms`]);
//! - `quadrature`: integrals over rectangles of functions with kinks;
//! - `closed_form`: the scenes with an exact answer ([`ClosedForm`]);
//! - `rolling_theory`: what theories of rolling foretell ([`RollingTheory`]);
//! - `errors`: errors against a closed form or a finer solution ([`Errors`]);
//! - `estimate`: the estimate of the error from a coarser grid.

mod ahead;
mod certificate;
mod closed_form;
mod errors;
pub(crate) mod estimate;
pub mod norms;
mod observables;
mod quadrature;
mod rolling_theory;

pub(crate) use ahead::AheadSums;
pub use certificate::certify;
pub(crate) use certificate::transform_error;
pub use closed_form::{ClosedForm, closed_form};
pub use errors::Errors;
pub(crate) use observables::{elastic_energy, fields};
pub use observables::{observables, patches, states};
pub use rolling_theory::RollingTheory;
