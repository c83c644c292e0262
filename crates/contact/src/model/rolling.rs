//! The rolling of a step: creepages and spin, the way that the contact travels, and the history
//! that it meets (J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990,
//! doi:10.1007/978-94-015-7889-9, whose signs these are).

use serde::{Deserialize, Serialize};

use super::error::{SceneError, finite, is_zero, positive, refuse};
use super::rigid::{Dof, Motion};

/// The rolling of a step. In each increment the contact travels along x over both surfaces, and the
/// punch moves sideways by the creepages times the distance travelled. The tractions of the
/// increment before stay in the frame that moves along, while the material passes through it.
///
/// Creepages and spin are the velocity of the foundation relative to the punch, as rigid bodies,
/// over the rolling speed, so that the foundation slips by W = q (ξ − φy, η + φ(x − x₀)) over a
/// distance q if nothing deforms. A component that is not given is governed by its force or moment,
/// if the step or one before prescribes that; otherwise it is what the motion of a wheelset
/// imposes, or 0. The shifts and the twist of an increment that rolls count from its beginning, and
/// those after it from its end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rolling {
    /// The longitudinal creepage ξ \[1\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub creepage_x: Option<f64>,
    /// The lateral creepage η \[1\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub creepage_y: Option<f64>,
    /// The spin φ \[rad/m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<f64>,
    /// The x about which the given spin turns, x₀ \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spin_center: f64,
    /// The way that the contact travels.
    #[serde(default)]
    pub direction: RollingDirection,
    /// The distance q > 0 that the contact travels in an increment \[m\]; `None` is the length of
    /// one element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dq: Option<f64>,
    /// The distance of the whole step \[m\], in place of `dq`: the step is then taken in the least
    /// number of equal increments that are no longer than an element.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// The history that the material has which enters the contact.
    pub history: RollingHistory,
    /// The creepages that hold where none is given and no force governs. A scene does not say them:
    /// they follow from the motion of its wheelset as it is solved.
    #[serde(skip)]
    pub imposed: ImposedCreepages,
}

/// The creepages and the spin that the motion of a wheelset imposes on the contact of a wheel with
/// its rail; 0 for another punch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImposedCreepages {
    /// The longitudinal creepage ξ \[1\].
    pub creepage_x: f64,
    /// The lateral creepage η \[1\].
    pub creepage_y: f64,
    /// The spin φ \[rad/m\].
    pub spin: f64,
}

/// The way that the contact travels over both surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RollingDirection {
    /// The contact travels towards +x, where its leading edge is.
    #[default]
    Forward,
    /// The contact travels towards −x.
    Backward,
}

/// The tractions of the increment before a rolling one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RollingHistory {
    /// The tractions are the same as after the increment, which is the limit of a long way.
    Steady,
    /// The tractions are those that the path has left.
    Transient,
}

impl RollingDirection {
    /// Returns the sign of the way along x.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }

    /// Returns the word for the direction in a study file.
    pub fn words(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Backward => "backward",
        }
    }
}

/// The distance and the creepages of an increment that has rolled: the given ones, and those of the
/// motion that a force or a wheelset has made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolled {
    /// The distance \[m\].
    pub distance: f64,
    /// The longitudinal creepage ξ \[1\].
    pub creepage_x: f64,
    /// The lateral creepage η where the spin has its centre \[1\].
    pub creepage_y: f64,
    /// The lateral creepage at the origin \[1\].
    pub creepage_y_at_origin: f64,
    /// The spin φ \[rad/m\].
    pub spin: f64,
}

/// The part of an increment that a distance may lack or have in excess and still be a whole number
/// of them.
const ROUNDING: f64 = 1e-12;

impl Rolling {
    /// The names of the creepages and the spin, in the order of [`Dof::TANGENTIAL`].
    pub(super) const NAMES: [&str; 3] = ["creepage_x", "creepage_y", "spin"];

    /// Returns the name of the creepage or the spin that stands for a degree of freedom in rolling.
    pub fn name(dof: Dof) -> Option<&'static str> {
        let index = Dof::TANGENTIAL.into_iter().position(|tangential| tangential == dof)?;
        Some(Self::NAMES[index])
    }

    /// Returns the creepages and the spin that are given, in the order of [`Dof::TANGENTIAL`].
    pub(super) fn given(&self) -> [Option<f64>; 3] {
        [self.creepage_x, self.creepage_y, self.spin]
    }

    /// Returns the motion of the punch in a tangential degree of freedom per distance travelled
    /// that the creepages prescribe: `None` if none is given for it.
    pub(super) fn rate(&self, dof: Dof) -> Option<f64> {
        let index = Dof::TANGENTIAL.into_iter().position(|tangential| tangential == dof)?;
        self.given()[index].map(|_| self.default_rate(dof))
    }

    /// Returns the motion of the punch in a tangential degree of freedom per distance travelled,
    /// with what is imposed for a creepage that is not given.
    pub(super) fn default_rate(&self, dof: Dof) -> f64 {
        let ImposedCreepages { creepage_x, creepage_y, spin } = self.imposed;
        let creepage_x = self.creepage_x.unwrap_or(creepage_x);
        let creepage_y = self.creepage_y.unwrap_or(creepage_y);
        let spin = self.spin.unwrap_or(spin);
        // The punch moves against the foundation. A zero is to be a positive one.
        0.0 - match dof {
            Dof::ShiftX => creepage_x,
            Dof::ShiftY => creepage_y - spin * self.spin_center,
            Dof::Twist => spin,
            Dof::Approach | Dof::TiltX | Dof::TiltY => 0.0,
        }
    }

    /// Returns the number of equal increments in which the step is taken on elements of this length
    /// along x \[m\]; `None` if the grid has no say in it.
    pub fn parts(&self, element: f64) -> Option<f64> {
        self.distance.map(|distance| Self::parts_of(distance, element))
    }

    /// Returns the least number of equal parts of a distance that are no longer than `longest`.
    /// Quotients of decimal numbers are rounded: a distance may lack or have in excess the last
    /// digits of a part.
    pub fn parts_of(distance: f64, longest: f64) -> f64 {
        (distance / longest * (1.0 - ROUNDING)).ceil().max(1.0)
    }

    /// Returns the distance that an increment travels on elements of this length along x \[m\].
    pub fn travelled(&self, element: f64) -> f64 {
        match (self.dq, self.distance, self.parts(element)) {
            (Some(dq), ..) => dq,
            (None, Some(distance), Some(parts)) => distance / parts,
            _ => element,
        }
    }

    /// Returns what an increment has rolled that has left the punch at `motion`, on elements of
    /// this length along x \[m\].
    pub fn rolled(&self, motion: &Motion, element: f64) -> Rolled {
        let distance = self.travelled(element);
        // The motion of the punch over the distance is against that of the foundation.
        let rate = |motion: f64| 0.0 - motion / distance;
        let spin = self.spin.unwrap_or_else(|| rate(motion.twist));
        let turned = spin * self.spin_center;
        let (creepage_y, creepage_y_at_origin) = match self.creepage_y {
            Some(creepage_y) => (creepage_y, creepage_y - turned),
            None => (turned + rate(motion.shift_y), rate(motion.shift_y)),
        };
        let creepage_x = self.creepage_x.unwrap_or_else(|| rate(motion.shift_x));
        Rolled { distance, creepage_x, creepage_y, creepage_y_at_origin, spin }
    }

    /// Returns the same rolling with 0 in place of −0, and without the creepages and the spin of 0
    /// of those degrees of freedom, in the order of [`Dof::TANGENTIAL`], that are 0 unless given.
    pub(super) fn normalised(&self, zero_unless_given: [bool; 3]) -> Self {
        let [creepage_x, creepage_y, spin] = std::array::from_fn(|index| {
            let given = self.given()[index].map(|value| value + 0.0);
            given.filter(|value| *value != 0.0 || !zero_unless_given[index])
        });
        let spin_center = if self.spin == Some(0.0) { 0.0 } else { self.spin_center + 0.0 };
        Self { creepage_x, creepage_y, spin, spin_center, ..*self }
    }

    /// Refuses what cannot roll, for the step of this key with these `given` motions and forces in
    /// the order of [`Dof::TANGENTIAL`].
    pub(super) fn validate(
        &self,
        step: &str,
        increments: u32,
        given: [[Option<f64>; 2]; 3],
        names: [[&str; 2]; 3],
    ) -> Result<(), SceneError> {
        let key = |name: &str| format!("{step}.{name}");
        for (value, name) in self.given().into_iter().zip(Self::NAMES) {
            if let Some(value) = value {
                finite(&key(name), value)?;
            }
        }
        finite(&key("spin_center"), self.spin_center)?;
        if let Some(dq) = self.dq {
            positive(&key("dq"), dq)?;
        }
        if let Some(distance) = self.distance {
            positive(&key("distance"), distance)?;
            let expected = match (self.dq, self.history) {
                (Some(_), _) => Some("cannot stand beside `dq`"),
                (None, RollingHistory::Steady) => Some("cannot stand in steady rolling"),
                (None, RollingHistory::Transient) if increments > 1 => {
                    Some("cannot stand beside `increments`")
                }
                _ => None,
            };
            if let Some(expected) = expected {
                return Err(refuse(&key("distance"), distance, expected));
            }
        }
        for (index, ([motion, force], [motion_name, force_name])) in
            given.into_iter().zip(names).enumerate()
        {
            let name = Self::NAMES[index];
            if let Some(value) = motion {
                let expected = format!("cannot stand in a step that rolls: give `{name}`");
                return Err(refuse(&format!("{step}.{motion_name}"), value, &expected));
            }
            if let (Some(value), Some(_)) = (force, self.given()[index]) {
                let expected = format!("cannot stand beside `{name}`: give one of the two");
                return Err(refuse(&format!("{step}.{force_name}"), value, &expected));
            }
        }
        if self.history == RollingHistory::Steady && increments > 1 {
            return Err(refuse(
                &format!("{step}.increments"),
                increments,
                "must be 1 in a step that rolls steadily, which has no way to divide",
            ));
        }
        Ok(())
    }
}
