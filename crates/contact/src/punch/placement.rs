//! The depth to which a scene lowers its wheel, and the plane of contact that belongs to it.
//!
//! A wheelset keeps its lateral position, yaw and roll, so that a wheel is lowered vertically. The
//! plane of contact and the gap along its normal are those of the lowered wheel. A scene that
//! prescribes a load does not say how deep it lowers the wheel. Its depth is estimated before it is
//! solved: each region of the overlap is taken for an elliptic paraboloid, which carries what
//! Hertz's theory says, and lowers the surface under the others as a point load does.

use std::collections::VecDeque;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::contact_plane::ContactPlane;
use super::facet::Extent;
use super::overlap::{FEW_POINTS, Overlap, POINTS, RailPatch};
use super::profile::Profile;
use super::track::{Position, Track, Wheelset};
use super::wheel_rail::WheelOnRail;
use crate::foundation::{contact_size, layered_margin, surface_compliance};
use crate::model::{Control, Dof, ImposedCreepages, Scene, SceneError, WheelRail};
use crate::theory::{HertzEllipse, hertz_ellipse};

/// The greatest depth to which a wheel is lowered \[m\]. No rail is elastic so far.
const DEEPEST: f64 = 0.02;

/// A wheel as a scene places it.
#[derive(Debug)]
pub(crate) struct PlacedWheel {
    /// The wheel on its rail, as the two just touch.
    pub(crate) pair: WheelOnRail,
    /// The plane of contact of the lowered wheel.
    pub(crate) plane: ContactPlane,
    /// The profiles of the wheel and the rail.
    profiles: [Arc<Profile>; 2],
    extent: OnceLock<Option<Extent>>,
}

impl PlacedWheel {
    /// Returns the rectangle around all regions that overlap as deep as the path of `scene` leads,
    /// which is the scene that places the wheel.
    pub(super) fn extent(&self, scene: &Scene) -> Option<Extent> {
        let reach = self.plane.approach() * layered_margin(scene).powi(2);
        *self.extent.get_or_init(|| self.plane.overlap(reach))
    }
}

/// The wheels that were last placed. A job is forecast several times and bound before it is solved,
/// and to place a wheel takes longer than the rest of a forecast.
#[derive(Debug, Default)]
pub(super) struct PlacedWheels(Mutex<VecDeque<Kept>>);

/// A wheel that was placed, with the scene that placed it.
#[derive(Debug)]
struct Kept {
    scene: Scene,
    wheel: Arc<PlacedWheel>,
}

/// The number of placed wheels that are kept, of some 0.3 MB each.
const MOST_KEPT: usize = 64;

impl PlacedWheels {
    /// Places the wheel of `scene`, or returns it if it was placed before.
    ///
    /// # Errors
    /// A [`SceneError`] says why the wheel does not meet its rail, or does not bear the load.
    pub(super) fn place(
        &self,
        scene: &Scene,
        rail: &WheelRail,
        profiles: [&Arc<Profile>; 2],
    ) -> Result<Arc<PlacedWheel>, SceneError> {
        // The creepages do not move the wheel.
        let mut scene = scene.clone();
        for rolling in scene.loading.steps.iter_mut().filter_map(|step| step.rolling.as_mut()) {
            rolling.imposed = ImposedCreepages::default();
        }
        let is_same = |kept: &Kept| {
            let Kept { scene: other, wheel } = kept;
            (0..2).all(|i| Arc::ptr_eq(&wheel.profiles[i], profiles[i]))
                && other.punch == scene.punch
                && other.foundation == scene.foundation
                && other.loading == scene.loading
        };
        // Nothing panics under the lock, and what is kept is never half done.
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept().iter().find(|kept| is_same(kept)) {
            return Ok(known.wheel.clone());
        }
        let wheel = Arc::new(place(&scene, rail, profiles)?);
        let mut kept = kept();
        kept.push_back(Kept { scene, wheel: wheel.clone() });
        if kept.len() > MOST_KEPT {
            kept.pop_front();
        }
        Ok(wheel)
    }
}

/// Puts the wheel of `scene` on its rail and lowers it as deep as the path asks for.
fn place(
    scene: &Scene,
    rail: &WheelRail,
    profiles: [&Arc<Profile>; 2],
) -> Result<PlacedWheel, SceneError> {
    let pair = WheelOnRail::new(
        profiles[0],
        profiles[1],
        &Wheelset {
            rolling_radius: rail.rolling_radius,
            flange_back_distance: rail.flange_back_distance,
            flange_back_to_origin: rail.flange_back_to_origin,
        },
        &Track { gauge: rail.gauge, gauge_depth: rail.gauge_depth },
        rail.side,
        &Position { lateral: rail.lateral, yaw: rail.yaw, roll: rail.roll },
    );
    let pair = pair.map_err(|error| SceneError {
        key: "punch".to_owned(),
        value: format!(
            "lateral {:e} m, yaw {:e} rad, roll {:e} rad",
            rail.lateral, rail.yaw, rail.roll
        ),
        expected: error.to_string(),
    })?;
    let plane = contact_plane(scene, &pair).map_err(|control| SceneError {
        key: "loading".to_owned(),
        value: match control {
            Control::Force(force) => format!("normal_force {force:e} N"),
            Control::Motion(approach) => format!("approach {approach:e} m"),
        },
        expected: "must be one that the rail bears before the wheel is 20 mm deep in it".to_owned(),
    })?;
    Ok(PlacedWheel { pair, plane, profiles: profiles.map(Arc::clone), extent: OnceLock::new() })
}

/// Returns the plane of contact of a wheel, lowered as deep as the path of `scene` asks for. If
/// no depth up to 20 mm does, it returns what the path asks for there.
fn contact_plane(scene: &Scene, pair: &WheelOnRail) -> Result<ContactPlane, Control> {
    let deepest = scene.loading.legs().iter().try_fold(0.0_f64, |deepest, leg| {
        let control = leg.target[Dof::Approach];
        let depth = match control {
            Control::Motion(approach) => depth_of_approach(pair, approach),
            Control::Force(force) => depth_of_load(scene, pair, force),
        };
        depth.map(|depth| deepest.max(depth)).ok_or(control)
    })?;
    let mut patches = pair.patches(deepest, POINTS);
    if patches.len() > 1 {
        let bearing = Bearing::of(scene, &patches);
        let mut bears = bearing.regions.iter().map(Region::may_bear);
        patches.retain(|patch| {
            patch.overlaps.iter().fold(false, |any, _| bears.next().unwrap_or(true) || any)
        });
    }
    Ok(ContactPlane::of_patches(pair, &patches, deepest))
}

/// Returns the depth at which the plane of contact has the prescribed `approach` \[m\].
fn depth_of_approach(pair: &WheelOnRail, approach: f64) -> Option<f64> {
    if approach <= 0.0 {
        return Some(0.0);
    }
    root(|depth| {
        let patches = pair.patches(depth, FEW_POINTS);
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
        let patches = pair.patches(depth, FEW_POINTS);
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
        let middle = secant.max(low + inset).min(high - inset);
        let value = of(middle);
        if value.is_nan() {
            return None;
        }
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
fn along_normal(patch: &RailPatch, overlap: &Overlap) -> f64 {
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
    fn of(scene: &Scene, patches: &[RailPatch]) -> Self {
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
            for (i, stiffness) in stiffness.iter().enumerate() {
                let lowering = (0..regions.len()).filter(|j| *j != i).map(|j| {
                    let ([a, b], [c, d]) = (regions[i].center, regions[j].center);
                    let apart = regions[i].semi_axes[1] + regions[j].semi_axes[1];
                    far * regions[j].load / (a - c).hypot(b - d).max(apart)
                });
                let lowering: f64 = lowering.sum();
                let pressed = (regions[i].height - lowering).max(0.0);
                regions[i].lowering = lowering;
                regions[i].load = (pressed / stiffness).powf(1.5);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Material, Shape, Side};
    use crate::punch::wheel_rail::tests::placed;

    const STEEL: Material = Material { shear_modulus: 82e9, poisson: 0.28 };

    fn pressed(force: Option<f64>, approach: Option<f64>) -> Scene {
        let mut scene = crate::model::sphere_on_half_space();
        scene.foundation = crate::model::Foundation::half_space(STEEL);
        scene.punch.material = Some(STEEL);
        scene.punch.shape = Shape::Sphere { radius: 1.0 };
        (scene.loading.steps[0].normal_force, scene.loading.steps[0].approach) = (force, approach);
        scene
    }

    /// The loads and approaches are CONTACT's (tests/reference/wheel_rail.csv): on the tread, with
    /// a gap that is far from a paraboloid, on two patches, and on the flange.
    #[test]
    fn the_depth_estimated_for_a_load_is_that_of_the_solution() {
        for (side, lateral, yaw, roll, force, approach) in [
            (Side::Left, 5e-3, 1.2e-2, -3.554e-4, 1.003e4, 2.232e-5),
            (Side::Left, 0.0, 0.0, 0.0, 9997.0, 1.596e-5),
            (Side::Right, 1e-3, 2.4e-3, -5.049e-5, 9827.0, 2.448e-5),
            (Side::Right, 5e-3, 1.2e-2, -3.554e-4, 9619.0, 2.719e-5),
            (Side::Right, 5.5e-3, 1.32e-2, -4.777e-4, 9629.0, 2.926e-5),
            (Side::Right, 8e-3, 1.92e-2, -8.606e-3, 1.272e4, 3.494e-5),
        ] {
            let pair = placed(side, &Position { lateral, yaw, roll }).unwrap();
            let plane = contact_plane(&pressed(Some(force), None), &pair).unwrap();
            let off = plane.approach() / approach - 1.0;
            println!("{side:?} {lateral}: {:.2} %", 100.0 * off);
            assert!(off.abs() < 0.08, "{side:?} {lateral}: {off}");
            // An approach that is given is met.
            let plane = contact_plane(&pressed(None, Some(approach)), &pair).unwrap();
            assert!((plane.approach() / approach - 1.0).abs() < 0.01, "{}", plane.approach());
            let depth = depth_of_approach(&pair, approach).unwrap();
            assert!((plane.depth(plane.approach()) - depth).abs() < 1e-12, "{depth}");
        }
    }

    #[test]
    fn loads_from_none_to_too_much_have_a_depth_or_none() {
        let pair = placed(Side::Right, &Position::default()).unwrap();
        let mut last = 0.0;
        for exponent in -12..=6 {
            let force = 10f64.powi(exponent);
            let plane = contact_plane(&pressed(Some(force), None), &pair).unwrap();
            assert!(plane.approach() > last, "{force} N: {:e}", plane.approach());
            last = plane.approach();
        }
        assert!(contact_plane(&pressed(Some(1e12), None), &pair).is_err());
        for none in [0.0, -1e-6] {
            let plane = contact_plane(&pressed(None, Some(none)), &pair).unwrap();
            assert!(plane.approach().abs() < 1e-12);
        }
    }

    #[test]
    fn a_wheel_is_placed_once_for_one_scene() {
        let wheels = PlacedWheels::default();
        let profile = |text| Arc::new(Profile::from_simpack(text).unwrap());
        let profiles = [
            profile(include_str!("../../../../sweeps/profiles/MBench_S1002_v3.prw")),
            profile(include_str!("../../../../sweeps/profiles/MBench_UIC60_v3.prr")),
        ];
        let rail = WheelRail {
            wheel: "wheel".to_owned(),
            rail: "rail".to_owned(),
            side: Side::Left,
            rolling_radius: 0.46,
            gauge: WheelRail::GAUGE,
            gauge_depth: WheelRail::GAUGE_DEPTH,
            flange_back_distance: WheelRail::FLANGE_BACK_DISTANCE,
            flange_back_to_origin: WheelRail::FLANGE_BACK_TO_ORIGIN,
            lateral: 0.0,
            yaw: 0.0,
            roll: 0.0,
            motion: None,
        };
        let place = |scene: &Scene, profiles: [&Arc<Profile>; 2]| {
            wheels.place(scene, &rail, profiles).unwrap()
        };
        let (light, heavy) = (pressed(Some(1e3), None), pressed(Some(1e4), None));
        let [wheel, top] = &profiles;
        let first = place(&light, [wheel, top]);
        assert!(Arc::ptr_eq(&first, &place(&light, [wheel, top])));
        let other = place(&heavy, [wheel, top]);
        assert!(other.plane.approach() > first.plane.approach());
        // A profile that was read anew may be another one.
        let again = Arc::new((**top).clone());
        assert!(!Arc::ptr_eq(&first, &place(&light, [wheel, &again])));
    }
}
