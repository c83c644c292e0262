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
    /// The depths of planes \[m\]. A search for the largest stresses goes down to the deepest one,
    /// or farther.
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

/// The distance from the middle of Ω, in its diameters, within which places are known. Beyond it
/// stresses are 1e-18 of those in the contact.
const FARTHEST: f64 = 1e9;

/// The smallest depth below the surface, in elements, at which stresses differ from those on it.
const SHALLOWEST: f64 = 1e-12;

impl InteriorQuestion {
    /// Refuses places so far from Ω, or so near to the surface, that doubles do not tell them.
    pub(crate) fn check_places(
        &self,
        middle: [f64; 2],
        size: [f64; 2],
        element: f64,
    ) -> Result<(), SceneError> {
        let farthest = FARTHEST * size[0].hypot(size[1]);
        let shallowest = SHALLOWEST * element;
        let check = |key: &str, distance: f64, depth: f64| {
            if distance.max(depth) > farthest {
                let words = format!(
                    "must be within {farthest:.3e} m of the middle of Ω, 1e9 times its diameter"
                );
                return Err(refuse(key, format!("{:e} m", distance.max(depth)), &words));
            }
            if depth > 0.0 && depth < shallowest {
                let words = format!(
                    "must be 0, or at least {shallowest:.3e} m, 1e-12 of an element: nearer to \
                     the surface there is no difference"
                );
                return Err(refuse(key, format!("{depth:e} m"), &words));
            }
            Ok(())
        };
        self.depths.iter().try_for_each(|depth| check("interior.depths", 0.0, *depth))?;
        self.points.iter().try_for_each(|[x, y, z]| {
            check("interior.points", (x - middle[0]).hypot(y - middle[1]), *z)
        })
    }

    /// Returns the question that asks for the same, with each plane once, from the surface down,
    /// each point once, and no −0.
    pub fn normalised(&self) -> Self {
        let mut depths: Vec<f64> = self.depths.iter().map(|depth| depth + 0.0).collect();
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        let mut points: Vec<[f64; 3]> = Vec::new();
        for point in self.points.iter().map(|point| point.map(|x| x + 0.0)) {
            if !points.contains(&point) {
                points.push(point);
            }
        }
        Self { maximum: self.maximum, depths, points }
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
    /// The largest local maximum below the surface, between the depths that were searched; `None`
    /// if there is none. Depths at which the steps of traction from element to element would be
    /// felt are not searched.
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
    /// The residual, relative and 0 for exact stresses; `None` if there was nothing to check. It is
    /// the largest difference between a plane by transforms and direct sums, between the forces
    /// and moments that a plane at depth carries and those on the surface, between points and
    /// sums over quarters of elements, or between stresses and tractions on the surface.
    pub residual: Option<f64>,
}
