//! A scene: two bodies, friction between them, and how they are moved. Plain data in SI units, no grid.
//!
//! Every `validate` refuses a scene that has no mechanical meaning and names the key, the value and what would
//! be right; keys are spelled as in a study file (`foundation.base.poisson`).

use serde::{Deserialize, Serialize};

/// A contact scene in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The body below the plane of contact.
    pub foundation: Foundation,
    /// The body above it.
    pub punch: Punch,
    /// Coulomb friction between the two.
    pub friction: Friction,
    /// The rectangle Ω that is meshed; `None` lets the punch and its approach choose it ([`Scene::domain`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<Domain>,
    /// How the punch is moved.
    pub loading: Loading,
}

/// The foundation: a homogeneous isotropic half-space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foundation {
    /// The half-space.
    pub base: Material,
}

/// A linear elastic isotropic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Shear modulus G > 0 \[Pa\].
    pub shear_modulus: f64,
    /// Poisson's ratio ν, 0 ≤ ν ≤ ½ \[1\]; ½ (incompressible) is an ordinary value.
    pub poisson: f64,
}

/// The punch: its shape, and its material if it is elastic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Punch {
    /// Surface shape.
    #[serde(flatten)]
    pub shape: Shape,
    /// Elastic half-space material of the punch; `None` is a rigid punch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
}

/// The closed list of punch shapes. Each gives an initial gap g₀(x, y) ≥ 0 \[m\] and a sole (where it can touch).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case")]
pub enum Shape {
    /// g₀ = (x² + y²)/2R, the paraboloid of Hertz's theory.
    Sphere {
        /// Radius R > 0 \[m\].
        radius: f64,
    },
    /// g₀ = x²/2Rx + y²/2Ry.
    Ellipsoid {
        /// Principal radius of curvature in the x–z plane, Rx > 0 \[m\].
        radius_x: f64,
        /// Principal radius of curvature in the y–z plane, Ry > 0 \[m\].
        radius_y: f64,
    },
    /// g₀ = 0 on a rectangle, the only part of Ω that can touch.
    FlatRectangle {
        /// Extent along x > 0 \[m\].
        width_x: f64,
        /// Extent along y > 0 \[m\].
        width_y: f64,
    },
    /// g₀ = 0 on a disk, the only part of Ω that can touch.
    FlatDisk {
        /// Radius > 0 \[m\].
        radius: f64,
    },
    /// g₀ = r tan(angle).
    Cone {
        /// Angle between the cone's surface and the plane of contact, 0 < angle < π/2 \[rad\].
        angle: f64,
    },
    /// A sampled surface: g₀ = max(heights) − heights, heights positive towards the foundation.
    HeightMap {
        /// Name of the surface in [`Surfaces`](crate::punch::Surfaces); in a stored job, the hash of its heights.
        surface: String,
        /// Extent of the map along x > 0 \[m\]; it is the sole.
        width_x: f64,
        /// Extent of the map along y > 0 \[m\].
        width_y: f64,
    },
}

/// Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Coefficient of friction μ ≥ 0 \[1\].
    pub mu: f64,
}

/// The rectangle Ω in the plane of contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Extent along x > 0 \[m\].
    pub width_x: f64,
    /// Extent along y > 0 \[m\].
    pub width_y: f64,
    /// x of the centre \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub center_x: f64,
    /// y of the centre \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub center_y: f64,
}

/// The loading path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// Load steps, in order. So far exactly one, from zero traction.
    pub steps: Vec<Step>,
}

/// One load step: the punch's rigid motion from the position in which it just touches at the origin.
/// A rotation vector (tilt_x, tilt_y, twist) moves a point (x, y, 0) of the punch by
/// (−twist·y, twist·x, tilt_x·y − tilt_y·x), z into the foundation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Approach δ, positive into the foundation \[m\].
    pub approach: f64,
    /// Shift along x \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shift_x: f64,
    /// Shift along y \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shift_y: f64,
    /// Tilt about the x axis \[rad\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tilt_x: f64,
    /// Tilt about the y axis \[rad\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tilt_y: f64,
    /// Twist φ about the z axis \[rad\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub twist: f64,
}

/// How a scene is discretised and solved. Nothing in here changes what is being asked, only how exactly it is answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Numerics {
    /// Elements of the grid.
    pub mesh: Mesh,
    /// How the continuous operator becomes a matrix.
    #[serde(default)]
    pub projection: Projection,
    /// Regularisation ε ≥ 0 of equation (3), dimensionless: the operator gets ε·c·ℓ·I, with c the bodies' summed
    /// (1−ν)/G and ℓ half the diameter of Ω.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub epsilon: f64,
    /// A-priori ceiling u > 0 on the pressure \[Pa\] in equation (3); `None` is no ceiling, equation (1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<f64>,
    /// The solver.
    #[serde(default)]
    pub method: Method,
    /// Largest relative natural-map residual that counts as solved, 0 < tolerance < 1.
    #[serde(default = "Numerics::default_tolerance")]
    pub tolerance: f64,
    /// Iterations after which the solver gives up.
    #[serde(default = "Numerics::default_max_iterations")]
    pub max_iterations: u32,
}

impl Numerics {
    /// The default relative residual, 1e-8.
    pub fn default_tolerance() -> f64 {
        1e-8
    }
    /// The default limit on iterations.
    pub fn default_max_iterations() -> u32 {
        20_000
    }
}

/// Numbers of elements along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Mesh {
    /// So many elements along x, and along y as many as make them nearest to square.
    Across(u32),
    /// So many elements along x and along y.
    Exact([u32; 2]),
}

/// How the continuous operator becomes a matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// Mean displacement over the receiving element (Alexandrov's averaging, equation 4; Galerkin).
    #[default]
    Average,
    /// Displacement at the receiving element's centre (collocation; CONTACT and most of the field).
    Midpoint,
}

/// The solvers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Alexandrov's nonlinear Seidel iteration, the reference.
    #[default]
    Seidel,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Why a scene or its numerics cannot mean anything.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: {expected}")]
pub struct SceneError {
    /// The key as in a study file, below `scene` or `numerics`.
    pub key: String,
    /// The offending value.
    pub value: String,
    /// What would be right.
    pub expected: String,
}

fn refuse(key: &str, value: impl ToString, expected: &str) -> SceneError {
    SceneError { key: key.to_owned(), value: value.to_string(), expected: expected.to_owned() }
}

fn finite(key: &str, x: f64) -> Result<(), SceneError> {
    if x.is_finite() { Ok(()) } else { Err(refuse(key, x, "must be a finite number")) }
}

fn positive(key: &str, x: f64) -> Result<(), SceneError> {
    if x.is_finite() && x > 0.0 { Ok(()) } else { Err(refuse(key, x, "must be a finite number above 0")) }
}

impl Material {
    fn validate(&self, at: &str) -> Result<(), SceneError> {
        positive(&format!("{at}.shear_modulus"), self.shear_modulus)?;
        if (0.0..=0.5).contains(&self.poisson) {
            Ok(())
        } else {
            Err(refuse(&format!("{at}.poisson"), self.poisson, "must lie between 0 and 0.5"))
        }
    }
}

impl Scene {
    /// Refuses what has no mechanical meaning; the first offence in the order of the fields.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.foundation.base.validate("foundation.base")?;
        match &self.punch.shape {
            Shape::Sphere { radius } | Shape::FlatDisk { radius } => positive("punch.radius", *radius)?,
            Shape::Ellipsoid { radius_x, radius_y } => {
                positive("punch.radius_x", *radius_x)?;
                positive("punch.radius_y", *radius_y)?;
            }
            Shape::FlatRectangle { width_x, width_y } | Shape::HeightMap { width_x, width_y, .. } => {
                positive("punch.width_x", *width_x)?;
                positive("punch.width_y", *width_y)?;
            }
            Shape::Cone { angle } => {
                positive("punch.angle", *angle)?;
                if *angle >= std::f64::consts::FRAC_PI_2 {
                    return Err(refuse("punch.angle", angle, "must be below a right angle (π/2 rad)"));
                }
            }
        }
        if let Some(material) = &self.punch.material {
            material.validate("punch.material")?;
        }
        if !(self.friction.mu.is_finite() && self.friction.mu >= 0.0) {
            return Err(refuse("friction.mu", self.friction.mu, "must be a finite number, 0 or above"));
        }
        if let Some(domain) = &self.domain {
            positive("domain.width_x", domain.width_x)?;
            positive("domain.width_y", domain.width_y)?;
            finite("domain.center_x", domain.center_x)?;
            finite("domain.center_y", domain.center_y)?;
        }
        if self.loading.steps.len() != 1 {
            return Err(refuse("loading.steps", format!("{} steps", self.loading.steps.len()), "must be exactly one load step"));
        }
        for (i, step) in self.loading.steps.iter().enumerate() {
            let at = |name: &str| format!("loading.steps[{i}].{name}");
            finite(&at("approach"), step.approach)?;
            finite(&at("shift_x"), step.shift_x)?;
            finite(&at("shift_y"), step.shift_y)?;
            finite(&at("tilt_x"), step.tilt_x)?;
            finite(&at("tilt_y"), step.tilt_y)?;
            finite(&at("twist"), step.twist)?;
        }
        Ok(())
    }
}

impl Mesh {
    /// The largest number of elements along one side.
    pub const MAX_SIDE: u32 = 4096;
}

impl Numerics {
    /// Refuses settings that cannot work; the first offence in the order of the fields.
    pub fn validate(&self) -> Result<(), SceneError> {
        let (sides, shown) = match self.mesh {
            Mesh::Across(n) => ([n, n], n.to_string()),
            Mesh::Exact(n) => (n, format!("[{}, {}]", n[0], n[1])),
        };
        if sides.iter().any(|n| !(1..=Mesh::MAX_SIDE).contains(n)) {
            return Err(refuse("mesh", shown, "must be 1 to 4096 elements along each side"));
        }
        if !(self.epsilon.is_finite() && self.epsilon >= 0.0) {
            return Err(refuse("epsilon", self.epsilon, "must be a finite number, 0 or above"));
        }
        if let Some(ceiling) = self.ceiling {
            positive("ceiling", ceiling)?;
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return Err(refuse("tolerance", self.tolerance, "must lie between 0 and 1, for example 1e-8"));
        }
        if self.max_iterations == 0 {
            return Err(refuse("max_iterations", 0, "must be at least 1"));
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A steel sphere of 10 mm pressed 1 µm into a like half-space's rigid counterpart; μ = 0.3.
    pub(crate) fn sphere_on_half_space() -> Scene {
        Scene {
            foundation: Foundation { base: Material { shear_modulus: 80e9, poisson: 0.3 } },
            punch: Punch { shape: Shape::Sphere { radius: 0.01 }, material: None },
            friction: Friction { mu: 0.3 },
            domain: None,
            loading: Loading { steps: vec![Step { approach: 1e-6, ..Step::default() }] },
        }
    }

    #[test]
    fn refuses_what_has_no_meaning_and_names_the_key() {
        let refused = |change: &dyn Fn(&mut Scene)| {
            let mut scene = sphere_on_half_space();
            change(&mut scene);
            scene.validate().unwrap_err().key
        };
        assert!(sphere_on_half_space().validate().is_ok());
        assert_eq!(refused(&|s| s.foundation.base.poisson = 0.51), "foundation.base.poisson");
        assert_eq!(refused(&|s| s.foundation.base.poisson = f64::NAN), "foundation.base.poisson");
        assert_eq!(refused(&|s| s.foundation.base.shear_modulus = 0.0), "foundation.base.shear_modulus");
        assert_eq!(refused(&|s| s.punch.shape = Shape::Cone { angle: 1.6 }), "punch.angle");
        assert_eq!(refused(&|s| s.punch.material = Some(Material { shear_modulus: 1.0, poisson: -0.1 })), "punch.material.poisson");
        assert_eq!(refused(&|s| s.friction.mu = -0.1), "friction.mu");
        assert_eq!(refused(&|s| s.loading.steps.clear()), "loading.steps");
        assert_eq!(refused(&|s| s.loading.steps[0].twist = f64::INFINITY), "loading.steps[0].twist");
    }
}
