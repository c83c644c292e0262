//! A scene: two bodies, the friction between them, and the path along which they are moved. These
//! are plain data in SI units, without a grid.
//!
//! Every `validate` refuses data that have no mechanical meaning, and names the key, the value and
//! the condition that a right value meets. Keys are spelled as in a study file
//! (`foundation.base.poisson`).

use serde::{Deserialize, Serialize};

use super::error::{SceneError, finite, is_zero, positive, refuse};
use super::interior::InteriorQuestion;
use super::loading::Loading;
use super::rigid::Dof;
use super::rolling::Rolling;
use super::wear::Wear;
use super::wheelset::WheelsetMotion;

/// A contact scene in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// The body below the plane of contact.
    pub foundation: Foundation,
    /// The body above it.
    pub punch: Punch,
    /// The Coulomb friction between the two.
    pub friction: Friction,
    /// The wear of the surfaces; `None` is a scene that says nothing of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wear: Option<Wear>,
    /// The rectangle Ω that is meshed; `None` lets the punch and its approach choose it
    /// ([`domain`](crate::punch::domain)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<Domain>,
    /// The path along which the punch is moved.
    pub loading: Loading,
    /// The stresses below the surface that are wanted at the end of the path. They are no part of
    /// the scene's text: a job writes them beside it.
    #[serde(skip)]
    pub interior: Option<InteriorQuestion>,
}

/// The foundation: bonded layers on a half-space or on a rigid base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foundation {
    /// The layers from the surface down; without any, the foundation is a homogeneous half-space.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
    /// The base on which the layers rest.
    pub base: Base,
}

/// A layer of a foundation, bonded to what is above and below it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// The shear modulus G > 0 \[Pa\].
    pub shear_modulus: f64,
    /// Poisson's ratio ν, 0 ≤ ν ≤ ½ \[1\].
    pub poisson: f64,
    /// The thickness > 0 \[m\].
    pub thickness: f64,
}

impl Layer {
    /// Returns the material of the layer.
    pub fn material(&self) -> Material {
        Material { shear_modulus: self.shear_modulus, poisson: self.poisson }
    }
}

/// The base on which a foundation's layers rest. It is written `"rigid"` or as the material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "BaseText", into = "BaseText")]
pub enum Base {
    /// A rigid base, to which the layers are bonded.
    Rigid,
    /// An elastic half-space.
    Elastic(Material),
}

/// A [`Base`] in the form in which it is written.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum BaseText {
    Word(BaseWord),
    Elastic(Material),
}

/// The base that is written as a word.
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
    /// Makes a homogeneous half-space.
    pub fn half_space(material: Material) -> Self {
        Self { layers: Vec::new(), base: Base::Elastic(material) }
    }

    /// Returns the material at the surface, or `None` for a rigid base without layers, which
    /// [`Scene::validate`] refuses.
    pub(crate) fn surface(&self) -> Option<Material> {
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
    /// The shear modulus G > 0 \[Pa\].
    pub shear_modulus: f64,
    /// Poisson's ratio ν, 0 ≤ ν ≤ ½ \[1\]; ½ (incompressible) is an ordinary value.
    pub poisson: f64,
}

/// The punch: its shape, and its material if it is elastic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Punch {
    /// The shape of the surface.
    #[serde(flatten)]
    pub shape: Shape,
    /// The material of the punch, an elastic half-space; `None` is a rigid punch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<Material>,
}

/// The closed list of punch shapes. Each gives an initial gap g₀(x, y) ≥ 0 \[m\] and a sole, on
/// which alone it can touch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case")]
pub enum Shape {
    /// The paraboloid of Hertz's theory, g₀ = (x² + y²)/2R.
    Sphere {
        /// The radius R > 0 \[m\].
        radius: f64,
    },
    /// The elliptic paraboloid g₀ = x²/2Rx + y²/2Ry.
    Ellipsoid {
        /// The principal radius of curvature in the x–z plane, Rx > 0 \[m\].
        radius_x: f64,
        /// The principal radius of curvature in the y–z plane, Ry > 0 \[m\].
        radius_y: f64,
    },
    /// The rectangle with g₀ = 0, the only part of Ω that can touch.
    FlatRectangle {
        /// The extent along x > 0 \[m\].
        width_x: f64,
        /// The extent along y > 0 \[m\].
        width_y: f64,
    },
    /// The disk with g₀ = 0, the only part of Ω that can touch.
    FlatDisk {
        /// The radius > 0 \[m\].
        radius: f64,
    },
    /// The cone g₀ = r tan(angle).
    Cone {
        /// The angle between the cone's surface and the plane of contact, 0 < angle < π/2 \[rad\].
        angle: f64,
    },
    /// A sampled surface, g₀ = max(h) − h, where h is the smooth surface through the heights at the
    /// centres of the pixels, positive towards the foundation.
    HeightMap {
        /// The name of the surface in [`Surfaces`](crate::punch::Surfaces); in a stored job, the
        /// hash of its heights.
        surface: String,
        /// The extent of the map along x > 0 \[m\]; the map is the sole.
        width_x: f64,
        /// The extent of the map along y > 0 \[m\].
        width_y: f64,
    },
    /// A wheel that is pressed onto a rail, seen from the plane that touches both where they first
    /// meet, with x along the track and y across. The rail is the foundation; the wheel's material
    /// is the punch's. The approach is along the normal of that plane.
    WheelOnRail(WheelRail),
}

/// The profiles of a wheel and a rail, their positions in the track, and that of the wheelset.
/// Profiles are given as they are on the right-hand side. In track coordinates x goes along the
/// track, y to the right and z down.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelRail {
    /// The name of the wheel's profile in [`Surfaces`](crate::punch::Surfaces); in a stored job,
    /// the profile's hash.
    pub wheel: String,
    /// The name of the rail's profile; in a stored job, the profile's hash.
    pub rail: String,
    /// The side of the wheelset on which the wheel sits.
    pub side: Side,
    /// The radius of the wheel at its profile's z = 0, > 0 \[m\].
    pub rolling_radius: f64,
    /// The distance between the rails' gauge faces > 0 \[m\].
    pub gauge: f64,
    /// The depth below the rails' tops down to which the gauge is measured, ≥ 0 \[m\].
    pub gauge_depth: f64,
    /// The distance between the backs of the flanges > 0 \[m\].
    pub flange_back_distance: f64,
    /// The distance from the back of a flange to its profile's y = 0 \[m\].
    pub flange_back_to_origin: f64,
    /// The lateral displacement of the wheelset along y \[m\].
    pub lateral: f64,
    /// The yaw of the wheelset about z \[rad\]; a positive one turns x towards y.
    pub yaw: f64,
    /// The roll of the wheelset about x after the yaw \[rad\]; a positive one lowers the right
    /// wheel.
    pub roll: f64,
    /// The motion of the wheelset, from which the creepages of steps that roll follow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<WheelsetMotion>,
}

impl WheelRail {
    /// The standard gauge \[m\].
    pub const GAUGE: f64 = 1.435;
    /// The depth at which the gauge is measured \[m\].
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
    /// The coefficient of friction μ ≥ 0 \[1\].
    pub mu: f64,
}

/// The rectangle Ω in the plane of contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// The extent along x > 0 \[m\].
    pub width_x: f64,
    /// The extent along y > 0 \[m\].
    pub width_y: f64,
    /// The x of the centre \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub center_x: f64,
    /// The y of the centre \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub center_y: f64,
}

impl Material {
    /// Makes the material of Young's modulus E \[Pa\] and Poisson's ratio ν, with G = E/(2(1+ν)). A
    /// ratio that no material has is kept, and does not spoil the modulus.
    pub fn with_youngs_modulus(youngs_modulus: f64, poisson: f64) -> Self {
        let shear_modulus = youngs_modulus / (2.0 * (1.0 + poisson.clamp(0.0, 0.5)));
        Self { shear_modulus, poisson }
    }

    /// Returns the compliance (1−ν)/G \[1/Pa\].
    pub(crate) fn compliance(&self) -> f64 {
        (1.0 - self.poisson) / self.shear_modulus
    }

    /// Refuses constants that no material has; `key` is that of the material.
    fn validate(&self, key: &str) -> Result<(), SceneError> {
        positive(&format!("{key}.shear_modulus"), self.shear_modulus)?;
        if (0.0..=0.5).contains(&self.poisson) {
            Ok(())
        } else {
            Err(refuse(&format!("{key}.poisson"), self.poisson, "must lie between 0 and 0.5"))
        }
    }
}

impl Scene {
    /// Refuses a scene that has no mechanical meaning.
    ///
    /// # Errors
    /// A [`SceneError`] reports the first offence in the order of the fields.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (i, layer) in self.foundation.layers.iter().enumerate() {
            layer.material().validate(&format!("foundation.layers[{i}]"))?;
            positive(&format!("foundation.layers[{i}].thickness"), layer.thickness)?;
        }
        let layers = self.foundation.layers.len();
        if layers > Foundation::MAX_LAYERS {
            return Err(refuse(
                "foundation.layers",
                format!("{layers} layers"),
                "must be at most 64 layers",
            ));
        }
        match &self.foundation.base {
            Base::Elastic(material) => material.validate("foundation.base")?,
            Base::Rigid if layers == 0 => {
                return Err(refuse(
                    "foundation.base",
                    "\"rigid\"",
                    "needs at least one layer on it: something must be elastic",
                ));
            }
            Base::Rigid => {}
        }
        match &self.punch.shape {
            Shape::Sphere { radius } | Shape::FlatDisk { radius } => {
                positive("punch.radius", *radius)?
            }
            Shape::Ellipsoid { radius_x, radius_y } => {
                positive("punch.radius_x", *radius_x)?;
                positive("punch.radius_y", *radius_y)?;
            }
            Shape::FlatRectangle { width_x, width_y }
            | Shape::HeightMap { width_x, width_y, .. } => {
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
                    return Err(refuse(
                        "punch.angle",
                        angle,
                        "must be below a right angle (π/2 rad)",
                    ));
                }
            }
        }
        if let Some(material) = &self.punch.material {
            material.validate("punch.material")?;
        }
        if !(self.friction.mu.is_finite() && self.friction.mu >= 0.0) {
            return Err(refuse(
                "friction.mu",
                self.friction.mu,
                "must be a finite number, 0 or above",
            ));
        }
        if let Some(domain) = &self.domain {
            positive("domain.width_x", domain.width_x)?;
            positive("domain.width_y", domain.width_y)?;
            finite("domain.center_x", domain.center_x)?;
            finite("domain.center_y", domain.center_y)?;
        }
        self.loading.validate()?;
        self.punch.shape.validate_rolling(&self.loading)?;
        self.check_spin_centers()?;
        if let Some(wear) = &self.wear {
            wear.validate(self.friction.mu, &self.loading)?;
        }
        if let Some(question) = &self.interior {
            question.validate(self.foundation.depth())?;
        }
        match &self.punch.shape {
            Shape::WheelOnRail(WheelRail { motion: Some(motion), .. }) => {
                motion.validate(&self.loading)
            }
            _ => Ok(()),
        }
    }
}

impl Scene {
    /// Returns whether the path moves a rigid degree of freedom, or prescribes its force.
    pub fn moves(&self, dof: Dof) -> bool {
        self.loading.steps.iter().any(|step| {
            step.given()[dof] != [None, None]
                || step.creeps(dof)
                || dof == Dof::ShiftY && step.rolling.is_some_and(|it| it.spin_center != 0.0)
                || Dof::TANGENTIAL.contains(&dof)
                    && self.imposes_creepages()
                    && step.rolling.is_some()
        })
    }

    /// Returns whether the motion of a wheelset imposes creepages and spin.
    fn imposes_creepages(&self) -> bool {
        matches!(&self.punch.shape, Shape::WheelOnRail(wheel) if wheel.motion.is_some())
    }

    /// Refuses the place of a spin in a step that neither gives a spin nor has one imposed.
    fn check_spin_centers(&self) -> Result<(), SceneError> {
        let steps = self.loading.steps.iter().enumerate();
        for (i, rolling) in steps.filter_map(|(i, step)| Some((i, step.rolling?))) {
            let Rolling { spin, spin_center, .. } = rolling;
            if spin_center != 0.0 && spin.is_none() && !self.imposes_creepages() {
                return Err(refuse(
                    &format!("loading.steps[{i}].spin_center"),
                    spin_center,
                    "needs `spin` in the same step: a spin that is not given turns about x = 0",
                ));
            }
        }
        Ok(())
    }
}

impl Shape {
    /// Refuses a punch that cannot roll where the path `loading` does. The gap stays as it is in
    /// the frame that moves along, and an edge or a tip of the punch is one of its material, which
    /// passes.
    fn validate_rolling(&self, loading: &Loading) -> Result<(), SceneError> {
        let (name, end) = match self {
            Self::FlatRectangle { .. } => ("flat-rectangle", "edge"),
            Self::FlatDisk { .. } => ("flat-disk", "edge"),
            Self::Cone { .. } => ("cone", "tip"),
            Self::Sphere { .. }
            | Self::Ellipsoid { .. }
            | Self::HeightMap { .. }
            | Self::WheelOnRail(_) => return Ok(()),
        };
        let Some(index) = loading.steps.iter().position(|step| step.rolling.is_some()) else {
            return Ok(());
        };
        let expected = format!(
            "cannot roll, as loading.steps[{index}] says: its {end} would stay in the contact \
             while its material passes through; let a sphere, an ellipsoid, a wheel on its rail \
             or a height map roll, or shift this punch with `shift_x`"
        );
        Err(refuse("punch.shape", name, &expected))
    }
}

impl Foundation {
    /// The largest number of layers.
    pub const MAX_LAYERS: usize = 64;

    /// Returns the depth at which a rigid base begins \[m\]; `None` if the base is elastic.
    pub fn depth(&self) -> Option<f64> {
        (self.base == Base::Rigid).then(|| self.layers.iter().map(|layer| layer.thickness).sum())
    }
}

/// The side of the track, seen along x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The side y < 0.
    Left,
    /// The side y > 0.
    Right,
}

impl Side {
    /// Returns −1 on the left and 1 on the right.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::model::loading::Step;
    use crate::model::rolling::{ImposedCreepages, Rolling, RollingDirection, RollingHistory};

    /// Makes a scene: a rigid sphere with a radius of 10 mm is pressed 1 µm into a half-space of
    /// steel; μ = 0.3.
    pub(crate) fn sphere_on_half_space() -> Scene {
        Scene {
            foundation: Foundation::half_space(Material { shear_modulus: 80e9, poisson: 0.3 }),
            punch: Punch { shape: Shape::Sphere { radius: 0.01 }, material: None },
            friction: Friction { mu: 0.3 },
            wear: None,
            domain: None,
            loading: Loading::path(vec![Step { approach: Some(1e-6), ..Step::default() }]),
            interior: None,
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
        let half_space = |s: &mut Scene, shear_modulus, poisson| {
            s.foundation = Foundation::half_space(Material { shear_modulus, poisson })
        };
        assert_eq!(refused(&|s| half_space(s, 1.0, 0.51)), "foundation.base.poisson");
        assert_eq!(refused(&|s| half_space(s, 1.0, f64::NAN)), "foundation.base.poisson");
        assert_eq!(refused(&|s| half_space(s, 0.0, 0.3)), "foundation.base.shear_modulus");
        assert_eq!(refused(&|s| s.foundation.base = Base::Rigid), "foundation.base");
        let layer = Layer { shear_modulus: 1.0, poisson: 0.3, thickness: 0.0 };
        assert_eq!(
            refused(&|s| s.foundation.layers = vec![layer]),
            "foundation.layers[0].thickness"
        );
        assert_eq!(refused(&|s| s.punch.shape = Shape::Cone { angle: 1.6 }), "punch.angle");
        assert_eq!(
            refused(&|s| s.punch.material = Some(Material { shear_modulus: 1.0, poisson: -0.1 })),
            "punch.material.poisson"
        );
        assert_eq!(refused(&|s| s.friction.mu = -0.1), "friction.mu");
        assert_eq!(refused(&|s| s.loading.steps.clear()), "loading.steps");
        assert_eq!(
            refused(&|s| s.loading.steps[0].twist = Some(f64::INFINITY)),
            "loading.steps[0].twist"
        );
        assert_eq!(refused(&|s| s.loading.steps[0].approach = None), "loading.steps[0].approach");
        assert_eq!(
            refused(&|s| s.loading.steps[0].normal_force = Some(1.0)),
            "loading.steps[0].normal_force"
        );
        assert_eq!(
            refused(&|s| s.loading.steps.push(Step { normal_force: Some(0.0), ..Step::default() })),
            "loading.steps[1].normal_force"
        );
        assert_eq!(refused(&|s| s.loading.steps[0].increments = 0), "loading.steps[0].increments");
        assert_eq!(refused(&|s| s.loading.steps[0].increments = 1001), "loading.steps");
        assert_eq!(refused(&|s| s.loading.cycles = 2), "loading.cycles");
        assert_eq!(refused(&|s| s.loading.cycle_from = Some(1)), "loading.cycle_from");
    }

    /// A punch with an edge or a tip can be pressed and shifted, and cannot roll, now or later.
    #[test]
    fn punches_with_an_edge_or_a_tip_do_not_roll() {
        let rolling = |history| Rolling {
            creepage_x: Some(1e-3),
            creepage_y: None,
            spin: None,
            spin_center: 0.0,
            direction: RollingDirection::Forward,
            dq: None,
            distance: None,
            history,
            imposed: ImposedCreepages::default(),
        };
        for history in [RollingHistory::Steady, RollingHistory::Transient] {
            for (shape, name) in [
                (Shape::FlatRectangle { width_x: 1e-3, width_y: 1e-3 }, "flat-rectangle"),
                (Shape::FlatDisk { radius: 1e-3 }, "flat-disk"),
                (Shape::Cone { angle: 0.1 }, "cone"),
            ] {
                let mut scene = sphere_on_half_space();
                let rolls = Step { rolling: Some(rolling(history)), ..Step::default() };
                scene.loading.steps.push(rolls);
                assert_eq!(scene.validate(), Ok(()));
                scene.punch.shape = shape;
                let error = scene.validate().unwrap_err();
                assert_eq!((&*error.key, &*error.value), ("punch.shape", name));
                assert!(error.expected.contains("cannot roll, as loading.steps[1]"), "{error}");
                scene.loading.steps[1].rolling = None;
                assert_eq!(scene.validate(), Ok(()));
            }
        }
    }
}
