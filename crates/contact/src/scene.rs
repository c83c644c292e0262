//! A scene: two bodies, friction between them, and how they are moved. Plain data in SI units, no grid.
//!
//! Every `validate` refuses a scene that has no mechanical meaning and names the key, the value and what would
//! be right; keys are spelled as in a study file (`foundation.base.poisson`).

use serde::{Deserialize, Serialize};

use crate::effect::Effect;
use crate::loading::Control;
use crate::punch::Side;

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

/// The foundation: bonded layers on a half-space or on a rigid base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foundation {
    /// Layers from the surface down; none is a homogeneous half-space.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
    /// What they rest on.
    pub base: Base,
}

/// A layer of a foundation, bonded to what is above and below it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// Shear modulus G > 0 \[Pa\].
    pub shear_modulus: f64,
    /// Poisson's ratio ν, 0 ≤ ν ≤ ½ \[1\].
    pub poisson: f64,
    /// Thickness > 0 \[m\].
    pub thickness: f64,
}

impl Layer {
    /// Its material.
    pub fn material(&self) -> Material {
        Material { shear_modulus: self.shear_modulus, poisson: self.poisson }
    }
}

/// What a foundation's layers rest on; written `"rigid"` or as the material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "BaseText", into = "BaseText")]
pub enum Base {
    /// Nothing moves below the layers, which are bonded to it.
    Rigid,
    /// An elastic half-space.
    Elastic(Material),
}

/// A [`Base`] as it is written.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum BaseText {
    Word(BaseWord),
    Elastic(Material),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum BaseWord {
    Rigid,
}

impl From<BaseText> for Base {
    fn from(text: BaseText) -> Self {
        match text {
            BaseText::Word(BaseWord::Rigid) => Base::Rigid,
            BaseText::Elastic(material) => Base::Elastic(material),
        }
    }
}

impl From<Base> for BaseText {
    fn from(base: Base) -> Self {
        match base {
            Base::Rigid => BaseText::Word(BaseWord::Rigid),
            Base::Elastic(material) => BaseText::Elastic(material),
        }
    }
}

impl Foundation {
    /// A homogeneous half-space.
    pub fn half_space(material: Material) -> Self {
        Self { layers: Vec::new(), base: Base::Elastic(material) }
    }

    /// The material at the surface; `None` for a rigid base without layers, which [`Scene::validate`] refuses.
    pub fn surface(&self) -> Option<Material> {
        match (self.layers.first(), self.base) {
            (Some(layer), _) => Some(layer.material()),
            (None, Base::Elastic(material)) => Some(material),
            (None, Base::Rigid) => None,
        }
    }
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
    /// A wheel pressed onto a rail, seen from the plane that touches both where they first meet: x along the track, y across. The
    /// rail is the foundation; the wheel's material is the punch's. The approach is along the normal of that plane.
    WheelOnRail(WheelRail),
}

/// Which profiles, how they lie in the track, and where the wheelset stands. Profiles are given as they are on the
/// right-hand side. Track coordinates: x along the track, y to the right, z down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelRail {
    /// Name of the wheel's profile in [`Surfaces`](crate::punch::Surfaces); in a stored job, its hash.
    pub wheel: String,
    /// Name of the rail's profile.
    pub rail: String,
    /// Which of the two wheels of the wheelset.
    pub side: Side,
    /// Radius of the wheel at its profile's z = 0 > 0 \[m\].
    pub rolling_radius: f64,
    /// Distance between the rails' gauge faces > 0 \[m\].
    pub gauge: f64,
    /// Depth below the rails' tops down to which the gauge is measured ≥ 0 \[m\].
    pub gauge_depth: f64,
    /// Distance between the backs of the flanges > 0 \[m\].
    pub flange_back_distance: f64,
    /// From the back of a flange to its profile's y = 0 \[m\].
    pub flange_back_to_origin: f64,
    /// Lateral displacement of the wheelset along y \[m\].
    pub lateral: f64,
    /// Yaw of the wheelset about z \[rad\]: positive turns x towards y.
    pub yaw: f64,
    /// Roll of the wheelset about x \[rad\], after the yaw: positive lowers the right wheel.
    pub roll: f64,
}

impl WheelRail {
    /// The standard gauge \[m\].
    pub const GAUGE: f64 = 1.435;
    /// The depth at which it is measured \[m\].
    pub const GAUGE_DEPTH: f64 = 0.014;
    /// The usual distance between the backs of the flanges \[m\].
    pub const FLANGE_BACK_DISTANCE: f64 = 1.360;
    /// The usual distance from the back of a flange to the middle of the tread \[m\].
    pub const FLANGE_BACK_TO_ORIGIN: f64 = 0.070;
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

/// The loading path: steps one after the other, the last ones over and over if they make a cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// Load steps, in order, from zero traction.
    pub steps: Vec<Step>,
    /// Index of the step with which a cycle begins; it ends with the last step. `None` is a path without cycles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_from: Option<u32>,
    /// How often the cycle is run through.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub cycles: u32,
}

impl Loading {
    /// A path of these steps, without cycles.
    pub fn path(steps: Vec<Step>) -> Self {
        Self { steps, cycle_from: None, cycles: 1 }
    }
}

/// One load step. Each of the punch's six rigid degrees of freedom is either prescribed or governed by its force or
/// moment; one that is not mentioned stays under the control, and at the value, of the step before. Before the first
/// step the punch just touches at the origin, unshifted and untilted, and nothing is mentioned: the first step must
/// give the approach or the normal force.
///
/// A rotation vector (tilt_x, tilt_y, twist) moves a point (x, y, 0) of the punch by
/// (−twist·y, twist·x, tilt_x·y − tilt_y·x), z into the foundation. Forces and moments are those of the punch on the
/// foundation, with the signs of [`Observables`](crate::outcome::Observables).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Approach δ, positive into the foundation \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub approach: Option<f64>,
    /// Normal force P > 0 \[N\] instead of the approach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_force: Option<f64>,
    /// Shift along x \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift_x: Option<f64>,
    /// Tangential force along x \[N\] instead of the shift.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_x: Option<f64>,
    /// Shift along y \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift_y: Option<f64>,
    /// Tangential force along y \[N\] instead of the shift.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_y: Option<f64>,
    /// Tilt about the x axis \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_x: Option<f64>,
    /// Moment about the x axis \[N m\] instead of the tilt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_x: Option<f64>,
    /// Tilt about the y axis \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_y: Option<f64>,
    /// Moment about the y axis \[N m\] instead of the tilt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_y: Option<f64>,
    /// Twist φ about the z axis \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twist: Option<f64>,
    /// Moment about the z axis \[N m\] instead of the twist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_z: Option<f64>,
    /// Equal parts in which the step is taken, each solved after the one before: what is prescribed moves evenly from
    /// its value at the end of the step before to its value here.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub increments: u32,
}

impl Default for Step {
    /// A step that changes nothing.
    fn default() -> Self {
        Self {
            approach: None,
            normal_force: None,
            shift_x: None,
            force_x: None,
            shift_y: None,
            force_y: None,
            tilt_x: None,
            moment_x: None,
            tilt_y: None,
            moment_y: None,
            twist: None,
            moment_z: None,
            increments: 1,
        }
    }
}

impl Step {
    /// Names of the rigid degrees of freedom in the order approach, shift x, y, tilt x, y, twist: as a motion and as the
    /// force that is its work-conjugate.
    pub const NAMES: [[&'static str; 2]; 6] = [
        ["approach", "normal_force"],
        ["shift_x", "force_x"],
        ["shift_y", "force_y"],
        ["tilt_x", "moment_x"],
        ["tilt_y", "moment_y"],
        ["twist", "moment_z"],
    ];

    /// What the step says about each degree of freedom, as a motion and as a force, in the order of [`Step::NAMES`].
    pub fn given(&self) -> [[Option<f64>; 2]; 6] {
        [
            [self.approach, self.normal_force],
            [self.shift_x, self.force_x],
            [self.shift_y, self.force_y],
            [self.tilt_x, self.moment_x],
            [self.tilt_y, self.moment_y],
            [self.twist, self.moment_z],
        ]
    }
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
    /// Iterations of one increment, on the grid itself, after which the solver gives up.
    #[serde(default = "Numerics::default_max_iterations")]
    pub max_iterations: u32,
    /// Effects that are simulated although the scene does not call for them ([`Effect::OPTIONAL`]).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub simulate: Vec<Effect>,
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
    /// What suits the scene ([`Method::chosen`]).
    #[default]
    Auto,
    /// Alexandrov's nonlinear Seidel iteration, the reference.
    Seidel,
    /// Semismooth Newton from coarse grids to fine ones, with Seidel sweeps where it does not converge.
    Newton,
}

impl Method {
    /// The method that solves a problem of this many elements under these loads, and why: itself, unless it is left to the scene.
    pub fn chosen(self, loading: &Loading, elements: [usize; 2]) -> (Method, &'static str) {
        let legs = loading.legs();
        let prescribed = || legs.iter().flat_map(|leg| leg.target).all(|control| matches!(control, Control::Motion(_)));
        match self {
            Method::Auto if elements[0] * elements[1] <= 36 && prescribed() => {
                (Method::Seidel, "so few elements are swept through faster than a linear system is set up")
            }
            Method::Auto if prescribed() => (Method::Newton, "its time grows little faster than the number of elements"),
            Method::Auto => (Method::Newton, "it has the forces' motions among its unknowns"),
            Method::Seidel | Method::Newton => (self, "asked for"),
        }
    }
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

fn one() -> u32 {
    1
}

fn is_one(n: &u32) -> bool {
    *n == 1
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
    /// Compliance (1−ν)/G \[1/Pa\].
    pub fn compliance(&self) -> f64 {
        (1.0 - self.poisson) / self.shear_modulus
    }

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
        for (i, layer) in self.foundation.layers.iter().enumerate() {
            layer.material().validate(&format!("foundation.layers[{i}]"))?;
            positive(&format!("foundation.layers[{i}].thickness"), layer.thickness)?;
        }
        let layers = self.foundation.layers.len();
        if layers > Foundation::MAX_LAYERS {
            return Err(refuse("foundation.layers", format!("{layers} layers"), "must be at most 64 layers"));
        }
        match &self.foundation.base {
            Base::Elastic(material) => material.validate("foundation.base")?,
            Base::Rigid if layers == 0 => {
                return Err(refuse("foundation.base", "\"rigid\"", "needs at least one layer on it: something must be elastic"));
            }
            Base::Rigid => {}
        }
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
            Shape::WheelOnRail(rail) => {
                positive("punch.rolling_radius", rail.rolling_radius)?;
                positive("punch.gauge", rail.gauge)?;
                finite("punch.gauge_depth", rail.gauge_depth)?;
                positive("punch.flange_back_distance", rail.flange_back_distance)?;
                finite("punch.flange_back_to_origin", rail.flange_back_to_origin)?;
                finite("punch.lateral", rail.lateral)?;
                finite("punch.yaw", rail.yaw)?;
                finite("punch.roll", rail.roll)?;
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
        self.loading.validate()
    }
}

impl Foundation {
    /// The largest number of layers.
    pub const MAX_LAYERS: usize = 64;
}

impl Loading {
    /// The largest number of increments of a path, cycles counted as often as they are run through.
    pub const MAX_INCREMENTS: u32 = 1000;

    fn validate(&self) -> Result<(), SceneError> {
        let steps = &self.steps;
        let Some(first) = steps.first() else {
            return Err(refuse("loading.steps", "no steps", "needs at least one load step"));
        };
        for (i, step) in steps.iter().enumerate() {
            for (given, [motion, force]) in step.given().iter().zip(Step::NAMES) {
                let at = |name: &str| format!("loading.steps[{i}].{name}");
                for (value, name) in given.iter().zip([motion, force]) {
                    if let Some(value) = value {
                        finite(&at(name), *value)?;
                    }
                }
                if let [Some(_), Some(value)] = given {
                    return Err(refuse(&at(force), value, &format!("cannot stand beside `{motion}`: give one of the two")));
                }
            }
            if let Some(force) = step.normal_force {
                positive(&format!("loading.steps[{i}].normal_force"), force)?;
            }
            if step.increments == 0 {
                return Err(refuse(&format!("loading.steps[{i}].increments"), 0, "must be at least 1"));
            }
        }
        if first.approach.is_none() && first.normal_force.is_none() {
            return Err(refuse("loading.steps[0].approach", "missing", "the first step needs `approach` or `normal_force`"));
        }
        if self.cycles == 0 {
            return Err(refuse("loading.cycles", 0, "must be at least 1"));
        }
        match self.cycle_from {
            Some(from) if from as usize >= steps.len() => {
                let last = steps.len() - 1;
                return Err(refuse("loading.cycle_from", from, &format!("must be the index of a step, 0 to {last}")));
            }
            None if self.cycles > 1 => {
                return Err(refuse("loading.cycles", self.cycles, "needs `cycle_from`, the index of the step with which a cycle begins"));
            }
            _ => {}
        }
        let count = |steps: &[Step]| steps.iter().map(|step| u64::from(step.increments)).sum::<u64>();
        let (lead, cycle) = steps.split_at(self.cycle_from.map_or(steps.len(), |from| from as usize));
        let total = count(lead).saturating_add(count(cycle).saturating_mul(u64::from(self.cycles)));
        if total > u64::from(Self::MAX_INCREMENTS) {
            return Err(refuse("loading.steps", format!("{total} increments in all"), "must be at most 1000"));
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
        if let Some(effect) = self.simulate.iter().find(|effect| !Effect::OPTIONAL.contains(effect)) {
            return Err(refuse("simulate", effect.name(), "is simulated when the scene's own keys ask for it"));
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
            foundation: Foundation::half_space(Material { shear_modulus: 80e9, poisson: 0.3 }),
            punch: Punch { shape: Shape::Sphere { radius: 0.01 }, material: None },
            friction: Friction { mu: 0.3 },
            domain: None,
            loading: Loading::path(vec![Step { approach: Some(1e-6), ..Step::default() }]),
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
        let half_space = |s: &mut Scene, shear_modulus, poisson| s.foundation = Foundation::half_space(Material { shear_modulus, poisson });
        assert_eq!(refused(&|s| half_space(s, 1.0, 0.51)), "foundation.base.poisson");
        assert_eq!(refused(&|s| half_space(s, 1.0, f64::NAN)), "foundation.base.poisson");
        assert_eq!(refused(&|s| half_space(s, 0.0, 0.3)), "foundation.base.shear_modulus");
        assert_eq!(refused(&|s| s.foundation.base = Base::Rigid), "foundation.base");
        let layer = Layer { shear_modulus: 1.0, poisson: 0.3, thickness: 0.0 };
        assert_eq!(refused(&|s| s.foundation.layers = vec![layer]), "foundation.layers[0].thickness");
        assert_eq!(refused(&|s| s.punch.shape = Shape::Cone { angle: 1.6 }), "punch.angle");
        assert_eq!(refused(&|s| s.punch.material = Some(Material { shear_modulus: 1.0, poisson: -0.1 })), "punch.material.poisson");
        assert_eq!(refused(&|s| s.friction.mu = -0.1), "friction.mu");
        assert_eq!(refused(&|s| s.loading.steps.clear()), "loading.steps");
        assert_eq!(refused(&|s| s.loading.steps[0].twist = Some(f64::INFINITY)), "loading.steps[0].twist");
        assert_eq!(refused(&|s| s.loading.steps[0].approach = None), "loading.steps[0].approach");
        assert_eq!(refused(&|s| s.loading.steps[0].normal_force = Some(1.0)), "loading.steps[0].normal_force");
        assert_eq!(
            refused(&|s| s.loading.steps.push(Step { normal_force: Some(0.0), ..Step::default() })),
            "loading.steps[1].normal_force"
        );
        assert_eq!(refused(&|s| s.loading.steps[0].increments = 0), "loading.steps[0].increments");
        assert_eq!(refused(&|s| s.loading.steps[0].increments = 1001), "loading.steps");
        assert_eq!(refused(&|s| s.loading.cycles = 2), "loading.cycles");
        assert_eq!(refused(&|s| s.loading.cycle_from = Some(1)), "loading.cycle_from");
    }
}
