//! The depth to which a scene lowers its wheel, and the plane of contact that belongs to it.
//!
//! A wheelset keeps its lateral position, yaw and roll, so that a wheel is lowered vertically. The
//! plane of contact and the gap along its normal are those of the lowered wheel. A scene that
//! prescribes a load does not say how deep it lowers the wheel. Its depth is estimated before it is
//! solved: each region of the overlap is taken for an elliptic paraboloid, which carries what
//! Hertz's theory says, and lowers the surface under the others as a point load does.

use std::f64::consts::PI;

use super::contact_plane::ContactPlane;
use super::gap::Gap;
use super::overlap::{Overlap, Patch};
use super::surface::Surfaces;
use super::wheel_rail::WheelOnRail;
use crate::foundation::{contact_size, layered_margin, surface_compliance};
use crate::model::{Control, Dof, Scene, SceneError};
use crate::theory::{HertzEllipse, hertz_ellipse};

/// The greatest depth to which a wheel is lowered \[m\]. No rail is elastic so far.
const DEEPEST: f64 = 0.02;

/// Returns the plane of contact of a wheel, lowered as deep as the path of `scene` asks for. It is
/// `None` if no depth up to 20 mm does.
pub(super) fn contact_plane(scene: &Scene, pair: &WheelOnRail) -> Option<ContactPlane> {
    let deepest = scene.loading.legs().iter().try_fold(0.0_f64, |deepest, leg| {
        let depth = match leg.target[Dof::Approach] {
            Control::Motion(approach) => depth_of_approach(pair, approach),
            Control::Force(force) => depth_of_load(scene, pair, force),
        };
        depth.map(|depth| deepest.max(depth))
    })?;
    let mut patches = pair.patches(deepest);
    if patches.len() > 1 {
        let bearing = Bearing::of(scene, &patches);
        let mut bears = bearing.regions.iter().map(Region::may_bear);
        patches.retain(|patch| {
            patch.overlaps.iter().fold(false, |any, _| bears.next().unwrap_or(true) || any)
        });
    }
    Some(ContactPlane::of_patches(pair, &patches, deepest))
}

/// Returns the depth at which the plane of contact has the prescribed `approach` \[m\].
fn depth_of_approach(pair: &WheelOnRail, approach: f64) -> Option<f64> {
    if approach <= 0.0 {
        return Some(0.0);
    }
    root(|depth| {
        let patches = pair.patches(depth);
        let reached = patches
            .iter()
            .flat_map(|patch| {
                patch.overlaps.iter().map(|overlap| along_normal(patch, overlap) * overlap.depth)
            })
            .fold(0.0, f64::max);
        reached / approach
    })
}

/// Returns the depth at which the regions carry the normal force `force` \[N\].
fn depth_of_load(scene: &Scene, pair: &WheelOnRail, force: f64) -> Option<f64> {
    if force <= 0.0 {
        return Some(0.0);
    }
    // The depth goes as the load to the power of 2/3.
    root(|depth| {
        let patches = pair.patches(depth);
        let bearing = Bearing::of(scene, &patches);
        (bearing.load() / (force * bearing.softening(scene, force).powi(3))).powf(2.0 / 3.0)
    })
}

/// Finds where a function that rises from 0, nearly in proportion to its argument, reaches 1. It is
/// `None` if it does not up to the deepest depth.
fn root(of: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut low, mut high, mut high_value) = (0.0, 1e-5, of(1e-5));
    let mut low_value = 0.0;
    while high_value < 1.0 {
        (low, low_value) = (high, high_value);
        high *= 4.0;
        if high > DEEPEST {
            return None;
        }
        high_value = of(high);
    }
    for _ in 0..60 {
        // The secant is held a little within the bracket, so that both ends move.
        let secant = low + (high - low) * (1.0 - low_value) / (high_value - low_value);
        let inset = 1e-3 * (high - low);
        let middle = secant.clamp(low + inset, high - inset);
        let value = of(middle);
        if value < 1.0 {
            (low, low_value) = (middle, value);
        } else {
            (high, high_value) = (middle, value);
        }
        if (value - 1.0).abs() < 1e-6 || high - low < 1e-9 * high {
            return Some(middle);
        }
    }
    Some(0.5 * (low + high))
}

/// Returns the depth along the normal of a patch's plane over the one along z, for a region that
/// is inclined to the plane.
fn along_normal(patch: &Patch, overlap: &Overlap) -> f64 {
    overlap.angle.cos() / (overlap.angle - patch.frame.angle).cos()
}

/// A region as a Hertzian contact.
struct Region {
    /// The semi-axes of the overlap along x and s, and its height along n \[m\].
    semi_axes: [f64; 2],
    height: f64,
    /// The centre (y, z) on the rail \[m\].
    center: [f64; 2],
    /// The load that it carries \[N\].
    load: f64,
    /// The depth by which the loads on the other regions lower the surface here \[m\].
    lowering: f64,
}

impl Region {
    /// Returns the principal curvatures of the gap along x and s \[1/m\].
    fn curvatures(&self) -> [f64; 2] {
        self.semi_axes.map(|semi_axis| 2.0 * self.height / (semi_axis * semi_axis))
    }

    /// Returns whether the region may carry load, with room for the error of the estimate.
    fn may_bear(&self) -> bool {
        self.height > 0.5 * self.lowering
    }
}

/// The regions of a lowered wheel with the loads that they carry, on the half-space of the surface.
struct Bearing {
    regions: Vec<Region>,
}

impl Bearing {
    /// Estimates the loads on all regions of `patches`, in their order.
    fn of(scene: &Scene, patches: &[Patch]) -> Self {
        let mut regions: Vec<Region> = patches
            .iter()
            .flat_map(|patch| {
                patch.overlaps.iter().map(|overlap| {
                    let inclined = (overlap.angle - patch.frame.angle).cos();
                    let paraboloid = &overlap.paraboloid;
                    let [[y0, z0], [y1, z1]] = overlap.ends;
                    Region {
                        semi_axes: [paraboloid.semi_axis_x, paraboloid.semi_axis_s * inclined],
                        height: paraboloid.height / inclined,
                        center: [0.5 * (y0 + y1), 0.5 * (z0 + z1)],
                        load: 0.0,
                        lowering: 0.0,
                    }
                })
            })
            .collect();
        let compliance = surface_compliance(scene);
        let stiffness: Vec<f64> = regions
            .iter()
            .map(|region| {
                let [x, s] = region.curvatures();
                hertz_ellipse(2.0 / compliance, 0.5 * x, 0.5 * s, 1.0).approach
            })
            .collect();
        // A layer on a stiff base carries the displacement less far than a half-space does.
        let far = if scene.foundation.layers.is_empty() { compliance / (2.0 * PI) } else { 0.0 };
        // The regions lower each other by a few hundredths of what they are pressed in.
        for _ in 0..20 {
            for i in 0..regions.len() {
                let lowering = (0..regions.len()).filter(|j| *j != i).map(|j| {
                    let ([a, b], [c, d]) = (regions[i].center, regions[j].center);
                    let apart = regions[i].semi_axes[1] + regions[j].semi_axes[1];
                    far * regions[j].load / (a - c).hypot(b - d).max(apart)
                });
                let lowering: f64 = lowering.sum();
                let pressed = (regions[i].height - lowering).max(0.0);
                regions[i].lowering = lowering;
                regions[i].load = (pressed / stiffness[i]).powf(1.5);
            }
        }
        Self { regions }
    }

    /// Returns the load on all regions \[N\].
    fn load(&self) -> f64 {
        self.regions.iter().map(|region| region.load).sum()
    }

    /// Returns the size of the contact under `force` \[N\] over its size on the half-space of the
    /// surface. It is 1 without layers.
    fn softening(&self, scene: &Scene, force: f64) -> f64 {
        let most = self.regions.iter().max_by(|a, b| a.load.total_cmp(&b.load));
        let Some([x, s]) = most.map(Region::curvatures) else { return 1.0 };
        let size = |compliance: f64| {
            let HertzEllipse { semi_axis_x, semi_axis_y, .. } =
                hertz_ellipse(2.0 / compliance, 0.5 * x, 0.5 * s, force);
            (semi_axis_x * semi_axis_y).sqrt()
        };
        contact_size(scene, size) / (layered_margin(scene) * size(surface_compliance(scene)))
    }
}

/// A place in the plane of contact between a wheel and a rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailPlace {
    /// The point of the rail, in track coordinates \[m\].
    pub track: [f64; 3],
    /// The inclination of the rail there \[rad\], from y towards z.
    pub rail_angle: f64,
    /// The inclination of the plane of contact there \[rad\]; patches far apart have planes of their
    /// own.
    pub plane_angle: f64,
}

/// Returns the places on the rail of `points` (x, y) \[m\] in Ω. It is `None` if the punch of
/// `scene` is no wheel, or a point is beside the rail.
///
/// # Errors
/// A [`SceneError`] says that a profile is missing or that the wheel does not meet its rail.
pub fn rail_places(
    scene: &Scene,
    surfaces: &Surfaces,
    points: &[[f64; 2]],
) -> Result<Option<Vec<RailPlace>>, SceneError> {
    let gap = Gap::new(scene, surfaces)?;
    let Some((pair, plane)) = gap.wheel_on_rail() else { return Ok(None) };
    let place = |[x, y]: &[f64; 2]| {
        let track = pair.onto_rail(plane.to_track(*x, *y));
        let rail_angle = pair.rail_angle(track[1])?;
        Some(RailPlace { track, rail_angle, plane_angle: plane.angle(*y) })
    };
    Ok(points.iter().map(place).collect())
}
