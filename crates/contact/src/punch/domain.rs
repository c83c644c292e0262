//! The Ω that a shape calls for, if a scene gives none.

use std::f64::consts::PI;

use super::gap::Gap;
use super::surface::Surfaces;
use crate::foundation::contact_size;
use crate::model::{Control, Dof, Domain, PerDof, Scene, SceneError, Shape};

/// Returns the Ω of a scene: the one that the scene gives, or else the one that its punch and its
/// path call for.
///
/// Under a smooth punch the contact lies inside the region where the rigid shapes would overlap,
/// provided that the normal compliance is nowhere negative. Ω is that region with a margin, over
/// all steps of the path; for a sphere it is 3a × 3a, where a is Hertz's contact radius. Where the
/// normal force is prescribed, the approach is Hertz's for the compliance that is felt at the size
/// of the contact. Under a flat sole or a height map Ω is the bounding box of the sole.
///
/// # Errors
/// A [`SceneError`] says that Ω must be given, because the tilt is as steep as the cone, wheel and
/// rail do not touch in a point with curvatures, or the wheel does not reach the rail. It may also
/// say that a surface or a profile is missing.
pub fn domain(scene: &Scene, surfaces: &Surfaces) -> Result<Domain, SceneError> {
    match scene.domain {
        Some(domain) => Ok(domain),
        None => domain_under(scene, &Gap::new(scene, surfaces)?),
    }
}

/// Returns the Ω of a scene whose `gap` is at hand, as [`domain`] does.
///
/// # Errors
/// A [`SceneError`] says that Ω must be given, for the same reasons.
pub(crate) fn domain_under(scene: &Scene, gap: &Gap<'_>) -> Result<Domain, SceneError> {
    if let Some(domain) = scene.domain {
        return Ok(domain);
    }
    let centred = |width_x, width_y| Domain { width_x, width_y, center_x: 0.0, center_y: 0.0 };
    let paraboloid =
        |radius_x: f64, radius_y: f64| {
            let radius = (radius_x * radius_y).sqrt();
            // Hertz's formulas with E* = 2/c are a³ = 3PRc/8 and δ = a²/R.
            let pressed = |force: f64| {
                let contact =
                    contact_size(scene, |compliance| (0.375 * force * radius * compliance).cbrt());
                contact * contact / radius
            };
            cover(
                scene.loading.legs().iter().map(|leg| {
                    paraboloid_domain(radius_x, radius_y, &Pose::of(&leg.target, pressed))
                }),
            )
        };
    Ok(match scene.punch.shape {
        Shape::Sphere { radius } => paraboloid(radius, radius),
        Shape::Ellipsoid { radius_x, radius_y } => paraboloid(radius_x, radius_y),
        Shape::FlatRectangle { width_x, width_y } | Shape::HeightMap { width_x, width_y, .. } => {
            centred(width_x, width_y)
        }
        Shape::FlatDisk { radius } => centred(2.0 * radius, 2.0 * radius),
        Shape::WheelOnRail(_) => wheel_domain(scene, gap)?,
        Shape::Cone { angle } => {
            // Sneddon's formula is P = 2E*δ²/(π tan β).
            let pressed = |force: f64| {
                contact_size(scene, |compliance| {
                    (0.25 * PI * force * angle.tan() * compliance).sqrt()
                })
            };
            let mut width = 0.0_f64;
            for leg in scene.loading.legs() {
                let pose = Pose::of(&leg.target, pressed);
                let slope = angle.tan() - pose.slope_x.hypot(pose.slope_y);
                if slope <= 0.0 {
                    return Err(SceneError {
                        key: "domain".to_owned(),
                        value: "not given".to_owned(),
                        expected: "must be given when the tilt is as steep as the cone".to_owned(),
                    });
                }
                // The overlap has the radius δ/slope. A punch that does not reach the foundation
                // has an empty contact on any Ω.
                width = width.max(
                    2.0 * if pose.approach == 0.0 { 1e-3 } else { pose.approach.abs() } / slope,
                );
            }
            centred(width, width)
        }
    })
}

/// Returns the rectangle around all regions in which wheel and rail would overlap after the deepest
/// approach of the path.
fn wheel_domain(scene: &Scene, gap: &Gap<'_>) -> Result<Domain, SceneError> {
    let not_given = |expected: &str| SceneError {
        key: "domain".to_owned(),
        value: "not given".to_owned(),
        expected: expected.to_owned(),
    };
    let Some(wheel) = gap.wheel_on_rail() else { unreachable!("the caller's punch is a wheel") };
    let extent = wheel
        .extent(scene)
        .ok_or_else(|| not_given("must be given, for the wheel does not reach the rail"))?;
    let span = |[low, high]: [f64; 2]| (high - low, 0.5 * (low + high));
    let ((width_x, center_x), (width_y, center_y)) = (span(extent.x), span(extent.s));
    Ok(Domain { width_x, width_y, center_x, center_y })
}

/// The position of the punch, as far as a step determines it.
struct Pose {
    /// The approach \[m\].
    approach: f64,
    /// The slope ∂f₁/∂x \[1\].
    slope_x: f64,
    /// The slope ∂f₁/∂y \[1\].
    slope_y: f64,
    /// The centre of pressure (x, y) \[m\] that a prescribed force and moment ask for, 0 where they
    /// do not.
    center: [f64; 2],
}

impl Pose {
    /// Creates the pose of these controls. `pressed` gives the approach \[m\] for a normal force
    /// \[N\].
    fn of(target: &PerDof<Control>, pressed: impl Fn(f64) -> f64) -> Self {
        let motion = |dof: Dof| match target[dof] {
            Control::Motion(value) => value,
            Control::Force(_) => 0.0,
        };
        let center = |dof: Dof| match (target[Dof::Approach], target[dof]) {
            (Control::Force(force), Control::Force(moment)) => moment / force,
            _ => 0.0,
        };
        let approach = match target[Dof::Approach] {
            Control::Motion(approach) => approach,
            Control::Force(force) => pressed(force),
        };
        Self {
            approach,
            slope_x: -motion(Dof::TiltY),
            slope_y: motion(Dof::TiltX),
            center: [-center(Dof::TiltY), center(Dof::TiltX)],
        }
    }
}

/// Returns the smallest rectangle that holds all `domains`. Of equal ones it is their common value
/// to the last bit.
fn cover(domains: impl Iterator<Item = Domain>) -> Domain {
    let mut all: Option<Domain> = None;
    for next in domains {
        all = Some(match all {
            None => next,
            Some(all) if all == next => all,
            Some(all) => {
                let span = |center: f64, width: f64, other: f64, other_width: f64| {
                    let low = (center - 0.5 * width).min(other - 0.5 * other_width);
                    let high = (center + 0.5 * width).max(other + 0.5 * other_width);
                    (0.5 * (low + high), high - low)
                };
                let (center_x, width_x) =
                    span(all.center_x, all.width_x, next.center_x, next.width_x);
                let (center_y, width_y) =
                    span(all.center_y, all.width_y, next.center_y, next.width_y);
                Domain { width_x, width_y, center_x, center_y }
            }
        });
    }
    all.unwrap_or(Domain { width_x: 1.0, width_y: 1.0, center_x: 0.0, center_y: 0.0 })
}

/// Returns the Ω of a tilted paraboloid. Such a paraboloid is the same paraboloid moved to its new
/// lowest point, with a larger approach.
fn paraboloid_domain(radius_x: f64, radius_y: f64, pose: &Pose) -> Domain {
    let (slope_x, slope_y) = (pose.slope_x, pose.slope_y);
    let approach =
        pose.approach + (slope_x * slope_x * radius_x + slope_y * slope_y * radius_y) / 2.0;
    let approach = if approach == 0.0 { 1e-6 * radius_x.min(radius_y) } else { approach.abs() };
    Domain {
        width_x: 3.0 * (radius_x * approach).sqrt(),
        width_y: 3.0 * (radius_y * approach).sqrt(),
        center_x: slope_x * radius_x + pose.center[0],
        center_y: slope_y * radius_y + pose.center[1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilted_sphere_gets_its_domain_where_it_touches() {
        let mut scene = crate::model::sphere_on_half_space();
        scene.loading.steps[0].tilt_x = Some(0.01);
        let Shape::Sphere { radius } = scene.punch.shape else { panic!() };
        let domain = domain(&scene, &Surfaces::new()).unwrap();
        // The function f₁ = δ + tilt_x y − y²/2R has its maximum at y = R tilt_x.
        assert!((domain.center_y / (0.01 * radius) - 1.0).abs() < 1e-14);
        assert_eq!(domain.center_x, 0.0);
    }
}
