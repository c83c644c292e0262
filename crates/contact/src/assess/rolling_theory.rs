//! The forces that theories of rolling foretell for an increment, beside those that were computed.

use crate::foundation::surface_compliance;
use crate::model::{Hertz, Material, Rolled, RollingDirection, Scene, Shape, StepOutcome};
use crate::theory::{CreepForces, LinearCreep, hertz_curvatures, hertz_ellipse, saturated};

/// The forces of steady rolling by theories of a Hertzian contact in which pressure and traction do
/// not couple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingTheory {
    /// The forces of Kalker's linear theory, in which nothing slips.
    pub linear: CreepForces,
    /// The forces along x and y \[N\] after Vermeulen and Johnson; `None` with spin, which their
    /// law does not know.
    pub vermeulen_johnson: Option<[f64; 2]>,
    /// The forces along x and y \[N\] after Shen, Hedrick and Elkins.
    pub shen_hedrick_elkins: [f64; 2],
}

impl RollingTheory {
    /// Returns what theories say of an increment, from the load that it came to and the creepages
    /// at which it rolls or came to roll. `hertz` is Hertz's contact under that load, if it is
    /// known; only a wheel on a rail needs it.
    ///
    /// It is `None` where they have nothing to say: for an increment that does not roll or has no
    /// load, without friction, on layers, for punches that are not smooth, and for ellipses more
    /// slender than [`KalkerCoefficients::new`](crate::theory::KalkerCoefficients::new) has them. A
    /// coupling of pressure and traction is not counted. In a transient increment it is the steady
    /// state of its creepages.
    pub fn of(scene: &Scene, end: &StepOutcome, hertz: Option<&Hertz>) -> Option<Self> {
        let rolling = scene.loading.steps.get(end.step as usize)?.rolling?;
        let load = end.observables.load;
        let limit = scene.friction.mu * load;
        if limit <= 0.0 || !scene.foundation.layers.is_empty() {
            return None;
        }
        let semi_axes = semi_axes(scene, load, hertz)?;
        let [modulus, poisson] = combined(scene)?;
        let backward = rolling.direction == RollingDirection::Backward;
        let theory = LinearCreep::new(semi_axes, modulus, poisson, backward)?;
        // The origin is the middle of the contact.
        let Rolled { creepage_x, creepage_y_at_origin, spin, .. } =
            rolling.rolled(&end.motion, end.observables.element_x);
        let linear = theory.forces([creepage_x, creepage_y_at_origin], spin);
        let shen_hedrick_elkins = saturated([linear.force_x, linear.force_y], limit);
        let vermeulen_johnson = (spin == 0.0).then_some(shen_hedrick_elkins);
        Some(Self { linear, vermeulen_johnson, shen_hedrick_elkins })
    }
}

/// Returns the semi-axes along x and y of Hertz's ellipse under a load.
fn semi_axes(scene: &Scene, load: f64, hertz: Option<&Hertz>) -> Option<[f64; 2]> {
    let modulus = 2.0 / surface_compliance(scene);
    let [radius_x, radius_y] = match &scene.punch.shape {
        Shape::Sphere { radius } => [*radius; 2],
        Shape::Ellipsoid { radius_x, radius_y } => [*radius_x, *radius_y],
        Shape::WheelOnRail(wheel) => {
            // The ellipse is known, and which of its axes lies along the track is told by the
            // curvature there, that of the wheel about its axle.
            let Hertz { semi_axis_a: a, semi_axis_b: b, .. } = *hertz?;
            let along = 0.5 / wheel.rolling_radius;
            let [of_a, of_b] = hertz_curvatures(modulus, [a, b], load);
            let distance = |curvature: f64| (curvature / along).ln().abs();
            return Some(if distance(of_a) <= distance(of_b) { [a, b] } else { [b, a] });
        }
        _ => return None,
    };
    let ellipse = hertz_ellipse(modulus, 0.5 / radius_x, 0.5 / radius_y, load);
    Some([ellipse.semi_axis_x, ellipse.semi_axis_y])
}

/// Returns G = 2/Σ(1/G) \[Pa\] and ν = ½ G Σ(ν/G) of both bodies.
fn combined(scene: &Scene) -> Option<[f64; 2]> {
    let bodies: Vec<Material> =
        scene.foundation.surface().into_iter().chain(scene.punch.material).collect();
    let sum = |value: fn(&Material) -> f64| bodies.iter().map(value).sum::<f64>();
    let modulus = 2.0 / sum(|material| 1.0 / material.shear_modulus);
    let poisson = 0.5 * modulus * sum(|material| material.poisson / material.shear_modulus);
    // Rounding may lift two of ½ above it.
    modulus.is_finite().then_some([modulus, poisson.min(0.5)])
}
