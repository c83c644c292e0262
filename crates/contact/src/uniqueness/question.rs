//! What μ* depends on, and how hard to look for it.

use serde::{Deserialize, Serialize};

use crate::common::random;
use crate::model::{
    Foundation, Friction, Loading, Material, Mesh, Method, Numerics, Projection, Punch, Scene,
    SceneError, Shape, Step,
};

/// What μ* depends on, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// The body below the plane of contact.
    pub foundation: Foundation,
    /// Elastic half-space material of the body above it; `None` is a rigid one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub punch: Option<Material>,
    /// Ω, where the two can touch.
    pub sole: Sole,
    /// Elements that Ω is cut into.
    pub mesh: Mesh,
    /// How A becomes a matrix.
    #[serde(default)]
    pub projection: Projection,
    /// Regularisation ε ≥ 0 \[1\]: the operator gets ε·c·ℓ·I.
    #[serde(default)]
    pub epsilon: f64,
}

impl Question {
    /// Refuses what has no meaning.
    pub fn validate(&self) -> Result<(), SceneError> {
        let (scene, numerics) = self.flat_punch();
        scene.validate()?;
        numerics.validate()
    }

    /// The contact problem of a flat punch with this sole, whose operator it is.
    pub(crate) fn flat_punch(&self) -> (Scene, Numerics) {
        let shape = match self.sole {
            Sole::Rectangle { width_x, width_y } => Shape::FlatRectangle { width_x, width_y },
            Sole::Disk { radius } => Shape::FlatDisk { radius },
        };
        let scene = Scene {
            foundation: self.foundation.clone(),
            punch: Punch { shape, material: self.punch },
            friction: Friction { mu: 0.0 },
            domain: None,
            loading: Loading::path(vec![Step { approach: Some(0.0), ..Step::default() }]),
        };
        let numerics = Numerics {
            mesh: self.mesh,
            projection: self.projection,
            epsilon: self.epsilon,
            ceiling: None,
            method: Method::Auto,
            tolerance: Numerics::default_tolerance(),
            max_iterations: Numerics::default_max_iterations(),
            simulate: Vec::new(),
        };
        (scene, numerics)
    }
}

/// Where the bodies can touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Sole {
    /// A rectangle.
    Rectangle {
        /// Extent along x > 0 \[m\].
        width_x: f64,
        /// Extent along y > 0 \[m\].
        width_y: f64,
    },
    /// A disk: the elements with their centre inside it, sized so that their areas add up to its
    /// area where the mesh is square.
    Disk {
        /// Radius > 0 \[m\].
        radius: f64,
    },
}

/// How long to search for a witness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WitnessSearch {
    /// Random starts on meshes of up to 36 elements, at most [`MOST_STARTS`](Self::MOST_STARTS); on
    /// finer ones fewer in inverse proportion to the elements, and none on more than 100.
    pub starts: u32,
    /// How many of the stripes that serve best on 8 × 8 elements a mesh of more than 100 starts
    /// from, at least one.
    pub kept: u32,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl WitnessSearch {
    /// The most random starts.
    pub const MOST_STARTS: u32 = random::MOST_STARTS;

    /// Refuses more than these.
    pub fn validate(&self) -> Result<(), SceneError> {
        random::validate_starts(self.starts)
    }
}

impl Default for WitnessSearch {
    fn default() -> Self {
        Self { starts: 24, kept: 2, seed: 1 }
    }
}
