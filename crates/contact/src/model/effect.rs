//! The closed list of effects.

use serde::{Deserialize, Serialize};

/// An effect that a scene may call for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// The tangential tractions.
    Friction,
    /// The normal displacement by tangential tractions, and the reverse.
    Coupling,
    /// The tractions along x.
    TractionX,
    /// The tractions along y.
    TractionY,
    /// The halves x < 0 and x > 0 of Ω, if they are no mirror images.
    AsymmetryX,
    /// The halves y < 0 and y > 0 of Ω, if they are no mirror images.
    AsymmetryY,
    /// The layers under the surface.
    Layers,
    /// The regularisation ε.
    Regularisation,
    /// The ceiling u on the pressure.
    Ceiling,
    /// The tractions and displacements that earlier increments left behind.
    History,
    /// The motions that are governed by forces.
    LoadControl,
    /// The material that passes through a contact which rolls.
    Rolling,
    /// The depth that surfaces lose where they slip.
    Wear,
    /// The stresses below the surface, which the solution does not depend on.
    Interior,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Effect; 14] = [
        Effect::Friction,
        Effect::Coupling,
        Effect::TractionX,
        Effect::TractionY,
        Effect::AsymmetryX,
        Effect::AsymmetryY,
        Effect::Layers,
        Effect::Regularisation,
        Effect::Ceiling,
        Effect::History,
        Effect::LoadControl,
        Effect::Rolling,
        Effect::Wear,
        Effect::Interior,
    ];

    /// The effects that can be simulated although a scene does not call for them. The others are
    /// simulated when the scene's own keys ask for them.
    pub const OPTIONAL: [Effect; 6] = [
        Effect::Friction,
        Effect::Coupling,
        Effect::TractionX,
        Effect::TractionY,
        Effect::AsymmetryX,
        Effect::AsymmetryY,
    ];

    /// Returns the name in a study file.
    pub fn name(self) -> &'static str {
        match self {
            Effect::Friction => "friction",
            Effect::Coupling => "coupling",
            Effect::TractionX => "traction-x",
            Effect::TractionY => "traction-y",
            Effect::AsymmetryX => "asymmetry-x",
            Effect::AsymmetryY => "asymmetry-y",
            Effect::Layers => "layers",
            Effect::Regularisation => "regularisation",
            Effect::Ceiling => "ceiling",
            Effect::History => "history",
            Effect::LoadControl => "load-control",
            Effect::Rolling => "rolling",
            Effect::Wear => "wear",
            Effect::Interior => "interior",
        }
    }
}
