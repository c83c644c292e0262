//! What solutions are held against: closed forms of whole scenes, and errors against those or
//! against finer solutions.

mod closed_form;
mod errors;
mod quadrature;

pub use closed_form::{ClosedForm, Pressure, Traction, closed_form};
pub use errors::Errors;
