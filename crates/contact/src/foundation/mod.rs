//! What the bodies are made of, as seen from the plane of contact: displacement under a loaded boundary element.

mod gauss;
pub mod half_space;
pub mod kernel;
pub mod layered;
