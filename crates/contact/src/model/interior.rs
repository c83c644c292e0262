//! Stresses below the surface: what is asked for, and what comes out.

use serde::{Deserialize, Serialize};

use super::error::{SceneError, finite, refuse};

/// The stresses below the surface that a scene asks for at the end of its path.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InteriorQuestion {
    /// The flag is true if the largest von Mises and Tresca stresses are sought.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub maximum: bool,
    /// The depths of planes \[m\]. They are the depths at which the largest stresses are sought;
    /// without any, these are chosen from the size of the contact.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depths: Vec<f64>,
    /// The points (x, y, z) at which the stress is wanted \[m\].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 3]>,
}

impl InteriorQuestion {
    /// The largest number of depths.
    pub const MOST_DEPTHS: usize = 64;

    /// The largest number of points.
    pub const MOST_POINTS: usize = 1000;

    /// Refuses what has no meaning in a foundation that is elastic down to `bottom`, if it has one.
    pub(crate) fn validate(&self, bottom: Option<f64>) -> Result<(), SceneError> {
        if !self.maximum && self.depths.is_empty() && self.points.is_empty() {
            return Err(refuse(
                "interior",
                "nothing",
                "must ask for `maximum = true`, `depths` or `points`, or be left out",
            ));
        }
        let below = |key: &str, depth: f64| {
            finite(key, depth)?;
            if depth < 0.0 {
                return Err(refuse(key, depth, "must be 0 or above: z points into the foundation"));
            }
            match bottom {
                Some(bottom) if depth > bottom * (1.0 + 1e-14) => Err(refuse(
                    key,
                    depth,
                    &format!("must be at most {bottom} m, where the rigid base begins"),
                )),
                _ => Ok(()),
            }
        };
        let at_most = |key: &str, count: usize, most: usize| {
            if count <= most {
                return Ok(());
            }
            Err(refuse(key, format!("{count} entries"), &format!("must have at most {most}")))
        };
        at_most("interior.depths", self.depths.len(), Self::MOST_DEPTHS)?;
        at_most("interior.points", self.points.len(), Self::MOST_POINTS)?;
        self.depths.iter().try_for_each(|depth| below("interior.depths", *depth))?;
        self.points.iter().try_for_each(|[x, y, z]| {
            finite("interior.points", *x)?;
            finite("interior.points", *y)?;
            below("interior.points", *z)
        })
    }
}

/// The stress at a point of the foundation \[Pa\]; tension is positive, and z points into it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stress {
    /// The normal stress along x.
    pub xx: f64,
    /// The normal stress along y.
    pub yy: f64,
    /// The normal stress along z.
    pub zz: f64,
    /// The shear stress of x and y.
    pub xy: f64,
    /// The shear stress of y and z.
    pub yz: f64,
    /// The shear stress of x and z.
    pub xz: f64,
}

/// A largest stress and its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StressPeak {
    /// The stress \[Pa\].
    pub stress: f64,
    /// The point (x, y, z) \[m\].
    pub place: [f64; 3],
}

/// The largest value of one measure of stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LargestStress {
    /// The largest one at the elements' centres on the surface.
    pub surface: StressPeak,
    /// The largest local maximum below the surface; `None` if there is none in the depths that were
    /// searched.
    pub below: Option<StressPeak>,
}

impl LargestStress {
    /// Returns the larger one of the two.
    pub fn overall(&self) -> StressPeak {
        match self.below {
            Some(below) if below.stress >= self.surface.stress => below,
            _ => self.surface,
        }
    }
}

/// The largest stresses on a plane z = const, at the elements' centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlanePeaks {
    /// The depth \[m\].
    pub depth: f64,
    /// The largest von Mises stress.
    pub von_mises: StressPeak,
    /// The largest Tresca stress.
    pub tresca: StressPeak,
}

/// The stress at a point that was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointStress {
    /// The point (x, y, z) \[m\].
    pub place: [f64; 3],
    /// The stress there.
    pub stress: Stress,
}

/// The stresses below the surface at the end of a path.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interior {
    /// The largest von Mises stress, if it was sought: √(3 J₂).
    pub von_mises: Option<LargestStress>,
    /// The largest Tresca stress, if it was sought: the largest difference of principal stresses.
    pub tresca: Option<LargestStress>,
    /// The depths between which local maxima were sought \[m\].
    pub searched: Option<[f64; 2]>,
    /// The planes that were asked for.
    pub planes: Vec<PlanePeaks>,
    /// The points that were asked for.
    pub points: Vec<PointStress>,
    /// The residual, relative and 0 for exact stresses: the largest difference between a plane by
    /// transforms and direct sums, or between the load that a plane at depth carries and the load
    /// on the surface.
    pub residual: f64,
}
