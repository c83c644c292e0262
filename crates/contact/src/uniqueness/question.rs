//! The question of a bracket: the data that μ* depends on, and the effort of the search for a
//! witness.

use serde::{Deserialize, Serialize};

use crate::common::random;
use crate::model::{
    Foundation, Friction, Loading, Material, Mesh, Method, Numerics, Projection, Punch, Scene,
    SceneError, Shape, Step,
};

/// The largest number of elements of a strip. Its 5ⁿ cases take tens of seconds.
pub(super) const MOST_STRIP_ELEMENTS: usize = 12;

/// The largest number of elements whose cases are looked at.
pub(super) const MOST_CASE_ELEMENTS: usize = 16;

/// The data that μ* depends on, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// The body below the plane of contact.
    pub foundation: Foundation,
    /// The elastic half-space material of the body above it; `None` is a rigid body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub punch: Option<Material>,
    /// The region Ω in which the two can touch.
    pub sole: Sole,
    /// The mesh that cuts Ω into elements.
    pub mesh: Mesh,
    /// The projection that makes a matrix of A.
    #[serde(default)]
    pub projection: Projection,
    /// The regularisation ε ≥ 0 \[1\]: the operator gets ε·c·ℓ·I.
    #[serde(default)]
    pub epsilon: f64,
    /// True if μ* is that of a strip: tractions are in the plane of x and z
    /// ([`strip`](super::strip)). Ω is one row of elements then.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub plane: bool,
}

impl Question {
    /// Checks that the question has a meaning.
    ///
    /// # Errors
    /// A [`SceneError`] names the key that has none.
    pub fn validate(&self) -> Result<(), SceneError> {
        let (scene, numerics) = self.flat_punch();
        scene.validate()?;
        numerics.validate()?;
        if self.plane { self.validate_strip() } else { Ok(()) }
    }

    /// Refuses a strip that is not one row of a few elements.
    fn validate_strip(&self) -> Result<(), SceneError> {
        let [nx, ny] = self.mesh.sides();
        let error = |key: &str, value: String, expected: String| {
            Err(SceneError { key: key.to_owned(), value, expected })
        };
        if !is_strip([nx as usize, ny as usize]) {
            let expected = format!(
                "must be [n, 1], one row of 1 to {} elements along x, where the search is of \
                 tractions in a plane",
                MOST_STRIP_ELEMENTS
            );
            return error("numerics.mesh", format!("[{nx}, {ny}]"), expected);
        }
        match self.sole {
            Sole::Rectangle { .. } => Ok(()),
            Sole::Disk { .. } => error(
                "search.plane",
                "true".to_owned(),
                "must be false for a disk, which is no strip of equal elements".to_owned(),
            ),
        }
    }

    /// Returns the contact problem of a flat punch with this sole, whose operator is the one in
    /// question.
    pub(crate) fn flat_punch(&self) -> (Scene, Numerics) {
        let shape = match self.sole {
            Sole::Rectangle { width_x, width_y } => Shape::FlatRectangle { width_x, width_y },
            Sole::Disk { radius } => Shape::FlatDisk { radius },
        };
        let scene = Scene {
            foundation: self.foundation.clone(),
            punch: Punch { shape, material: self.punch },
            friction: Friction { mu: 0.0 },
            wear: None,
            domain: None,
            loading: Loading::path(vec![Step { approach: Some(0.0), ..Step::default() }]),
            interior: None,
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

/// The region in which the bodies can touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Sole {
    /// A rectangle.
    Rectangle {
        /// The extent along x > 0 \[m\].
        width_x: f64,
        /// The extent along y > 0 \[m\].
        width_y: f64,
    },
    /// A disk. It consists of the elements with their centre inside it, sized so that their areas
    /// add up to the area of the disk where the mesh is square.
    Disk {
        /// The radius > 0 \[m\].
        radius: f64,
    },
}

/// The effort of a search for a witness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WitnessSearch {
    /// The number of random starts on meshes of up to 36 elements, at most
    /// [`MOST_STARTS`](Self::MOST_STARTS). Finer meshes have fewer in inverse proportion to the
    /// elements, and meshes of more than 100 elements have none.
    pub starts: u32,
    /// The number of stripes that a mesh of more than 100 elements starts from, at least one. They
    /// are those that serve best on 8 × 8 elements.
    pub kept: u32,
    /// The seed of all random numbers.
    pub seed: u64,
    /// True if the lower end is shown by [`cases`](super::cases), on few elements.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cases: bool,
    /// The relative width that the bracket is to have, within [`WIDTHS`](Self::WIDTHS): the lower
    /// end is shown by [`cones`](super::cones) in its cases. `None` takes what the cases alone
    /// show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
}

impl WitnessSearch {
    /// The largest number of random starts.
    pub const MOST_STARTS: u32 = random::MOST_STARTS;

    /// The least and the largest relative width that can be asked for.
    pub const WIDTHS: [f64; 2] = [1e-3, 0.5];

    /// Checks the number of starts.
    ///
    /// # Errors
    /// A [`SceneError`] says that there are more than [`MOST_STARTS`](Self::MOST_STARTS).
    pub fn validate(&self) -> Result<(), SceneError> {
        random::validate_starts(self.starts)
    }

    /// Refuses cases of more elements than are looked at, and of a strip, whose end is exact, and a
    /// width that has no meaning or no cases.
    ///
    /// # Errors
    /// A [`SceneError`] names the key.
    pub fn suits(&self, question: &Question) -> Result<(), SceneError> {
        let [nx, ny] = question.mesh.sides();
        let elements = u64::from(nx) * u64::from(ny);
        let most = MOST_CASE_ELEMENTS;
        let refuse = |key: &str, value: String, expected: String| {
            Err(SceneError { key: key.to_owned(), value, expected })
        };
        match self.width {
            Some(width) if !(Self::WIDTHS[0]..=Self::WIDTHS[1]).contains(&width) => {
                let [least, most] = Self::WIDTHS;
                let expected = format!("must be from {least} to {most}");
                return refuse("search.width", width.to_string(), expected);
            }
            Some(width) if !self.cases => {
                let expected =
                    "must be left out without `cases = true`, whose cases it narrows".to_owned();
                return refuse("search.width", width.to_string(), expected);
            }
            _ => {}
        }
        let expected = if self.cases && question.plane {
            "must be false in a plane, where the end is exact".to_owned()
        } else if self.cases && elements > most as u64 {
            format!("must be false for {nx} x {ny} elements: cases are of at most {most}")
        } else {
            return Ok(());
        };
        refuse("search.cases", "true".to_owned(), expected)
    }
}

impl Default for WitnessSearch {
    fn default() -> Self {
        Self { starts: 24, kept: 2, seed: 1, cases: false, width: None }
    }
}

/// Says if the elements are one row of at most [`MOST_STRIP_ELEMENTS`] along x.
pub(super) fn is_strip([nx, ny]: [usize; 2]) -> bool {
    ny == 1 && nx <= MOST_STRIP_ELEMENTS
}
