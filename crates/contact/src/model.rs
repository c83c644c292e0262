//! The data that go into a solve and come out of it, with their validation and no arithmetic beyond
//! that.
//!
//! The folder knows nothing of the rest of the crate, which all lies above it.
//!
//! In reading order:
//! - `error`: the refusal of a scene that has no mechanical meaning ([`SceneError`]);
//! - `rigid`: the six rigid degrees of freedom of the punch ([`Dof`], [`Motion`], [`Control`]);
//! - `rolling`: the rolling of a step ([`Rolling`]);
//! - `loading`: the loading path, step by step ([`Loading`], [`Step`], [`Leg`]);
//! - `wear`: the wear of the surfaces ([`Wear`]);
//! - `wheelset`: the motion of a wheelset, from which creepages follow ([`WheelsetMotion`]);
//! - `scene`: the bodies, the friction between them and Ω ([`Scene`]);
//! - `effect`: the closed list of effects ([`Effect`]);
//! - `numerics`: the mesh, the method and its tolerance ([`Numerics`]);
//! - `interior`: the stresses below the surface, asked for and found ([`InteriorQuestion`],
//!   [`Interior`]);
//! - `further`: the results that only some scenes ask for ([`Further`]);
//! - `outcome`: the figures, the fields and the certificate of a solution ([`Outcome`],
//!   [`Fields`]).

mod effect;
mod error;
mod further;
mod interior;
mod loading;
mod numerics;
mod outcome;
mod rigid;
mod rolling;
mod scene;
mod wear;
mod wheelset;

pub use effect::Effect;
pub use error::SceneError;
pub(crate) use error::refuse;
pub use further::{Further, FurtherFields, Worn};
pub use interior::{
    Interior, InteriorQuestion, LargestStress, PlanePeaks, PointStress, Stress, StressPeak,
};
pub use loading::{Leg, Loading, Step};
pub use numerics::{ChosenMethod, Mesh, Method, Numerics, Projection};
pub use outcome::{
    Certificate, Estimate, Fields, FigureErrors, Hertz, Level, Observables, Outcome, RailContact,
    Route, State, Status, StepOutcome, WorkDone,
};
pub use rigid::{Control, Dof, Motion, PerDof};
pub(crate) use rigid::{rigid_displacement, rigid_modes};
pub use rolling::{ImposedCreepages, Rolled, Rolling, RollingDirection, RollingHistory};
#[cfg(test)]
pub(crate) use scene::tests::sphere_on_half_space;
pub use scene::{
    Base, Domain, Foundation, Friction, Layer, Material, Punch, Scene, Shape, Side, WheelRail,
};
pub use wear::Wear;
pub use wheelset::WheelsetMotion;
