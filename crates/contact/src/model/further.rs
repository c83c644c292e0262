//! Results that only some scenes ask for, beside those that every scene has. They are stored apart
//! from the others, so that the bytes of the others stay what they are.

use serde::{Deserialize, Serialize};

/// The figures that a scene asks for beyond those of every [`Outcome`](super::outcome::Outcome).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Further {
    /// The wear along the path, of a scene that wears.
    pub wear: Option<Wear>,
    /// The stresses below the surface at the end of the path, where they are asked for.
    pub interior: Option<Interior>,
}

impl Further {
    /// Returns whether the scene has asked for nothing of it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The wear along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wear {
    /// The largest depth \[m\].
    pub depth: f64,
    /// The volume \[m³\].
    pub volume: f64,
}

/// The stresses below the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interior {
    /// The largest von Mises stress \[Pa\].
    pub von_mises: f64,
}

/// The fields that a scene asks for beyond those of all [`Fields`](super::outcome::Fields), on the
/// same grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FurtherFields {
    /// The depth of wear \[m\]; empty for a scene that does not wear.
    pub wear_depth: Vec<f64>,
}

impl FurtherFields {
    /// Returns whether the scene has asked for nothing of it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
