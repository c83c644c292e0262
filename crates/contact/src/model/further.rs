//! Results that only some scenes ask for, beside those that every scene has. They are stored apart
//! from the others, so that the bytes of the others stay what they are.

use serde::{Deserialize, Serialize};

use super::interior::Interior;

/// The figures that a scene asks for beyond those of every [`Outcome`](super::outcome::Outcome).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Further {
    /// The wear of each increment of the path, in order; empty for a scene that does not wear.
    pub wear: Vec<Worn>,
    /// The stresses below the surface at the end of the path, where they are asked for.
    pub interior: Option<Interior>,
    /// The x of the leading edge after each increment of the path, in order \[m\]: the outer side
    /// of the foremost element in contact, in the direction of rolling. It is `None` for an
    /// increment that does not roll or has no contact; the list is empty for a scene that does
    /// not roll.
    pub leading_edges: Vec<Option<f64>>,
}

impl Further {
    /// Returns whether the scene has asked for nothing of it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The wear of an increment: what both surfaces lose together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Worn {
    /// The largest depth that the path has worn away until the end of the increment \[m\], on the
    /// material that is then within Ω; after an increment that rolls steadily, that of one pass.
    pub depth: f64,
    /// The volume that is worn away in the increment \[m³\].
    pub volume: f64,
}

/// The fields that a scene asks for beyond those of all [`Fields`](super::outcome::Fields), on the
/// same grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FurtherFields {
    /// The depth that the path has worn away at each element \[m\], of both surfaces together; it
    /// is empty for a scene that does not wear. Where the path rolls it is that of the foundation's
    /// material that stands there at its end, and after an increment that rolls steadily the depth
    /// that this material has lost since it entered the contact.
    pub wear_depth: Vec<f64>,
}

impl FurtherFields {
    /// Returns whether the scene has asked for nothing of it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
