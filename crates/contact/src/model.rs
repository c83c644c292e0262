//! What is asked and what comes out: plain data with its validation, and no arithmetic beyond that.
//!
//! Knows nothing of the crate above it.

mod effect;
mod error;
mod loading;
mod numerics;
mod outcome;
mod rigid;
mod scene;

pub use effect::Effect;
pub use error::SceneError;
pub(crate) use error::refuse;
pub use loading::{Leg, Loading, Step};
pub use numerics::{Mesh, Method, Numerics, Projection};
pub use outcome::{
    Certificate, Estimate, Fields, FigureErrors, Hertz, Level, Observables, Outcome, RailContact,
    State, Status, StepOutcome, Way, WorkDone,
};
pub(crate) use rigid::rigid_modes;
pub use rigid::{Control, Dof, Motion, PerDof};
#[cfg(test)]
pub(crate) use scene::tests::sphere_on_half_space;
pub use scene::{
    Base, Domain, Foundation, Friction, Layer, Material, Punch, Scene, Shape, Side, WheelRail,
};
