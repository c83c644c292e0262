//! What the bodies are made of, as seen from the plane of contact: displacement under a loaded
//! boundary element.

mod bodies;
mod coefficient;
mod half_space;
mod hankel;
pub mod kernel;
mod layered;
mod radial;

pub use bodies::{Bodies, Kernels};
pub(crate) use bodies::{contact_size, relative_bodies, surface, surface_compliance};
pub use coefficient::Coefficient;
pub use half_space::HalfSpace;
pub use layered::{Compliance, Layered};
