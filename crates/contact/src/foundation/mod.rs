//! What the bodies are made of, as seen from the plane of contact: displacement under a loaded
//! boundary element.

pub mod bodies;
pub mod coefficient;
pub(crate) mod gauss;
pub mod half_space;
mod hankel;
pub mod kernel;
pub mod layered;
mod radial;
