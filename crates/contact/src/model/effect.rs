//! The closed list of effects.

use serde::{Deserialize, Serialize};

/// An effect that a scene may call for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// Tangential tractions.
    Friction,
    /// Normal displacement by tangential tractions, and the reverse.
    Coupling,
    /// Tractions along x.
    TractionX,
    /// Tractions along y.
    TractionY,
    /// Halves x < 0 and x > 0 of Ω that are no mirror images.
    AsymmetryX,
    /// Halves y < 0 and y > 0 of Ω that are no mirror images.
    AsymmetryY,
    /// Layers under the surface.
    Layers,
    /// The regularisation ε.
    Regularisation,
    /// The ceiling u on the pressure.
    Ceiling,
    /// What earlier increments left behind.
    History,
    /// Motions governed by forces.
    LoadControl,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Effect; 11] = [
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
    ];

    /// Those that can be simulated although a scene does not call for them; the others are there
    /// when the scene's own keys ask for them.
    pub const OPTIONAL: [Effect; 6] = [
        Effect::Friction,
        Effect::Coupling,
        Effect::TractionX,
        Effect::TractionY,
        Effect::AsymmetryX,
        Effect::AsymmetryY,
    ];

    /// Its name in a study file.
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
        }
    }
}
