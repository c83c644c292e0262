//! The scenes that have an exact answer in closed form, and that answer.
//!
//! The answer is that of the continuous problem, equation (1), on homogeneous half-spaces: mesh,
//! projection, ε, the ceiling and the method are ways to approximate it and do not enter. A scene
//! has one only where every condition of the theory holds exactly.

mod bodies;
mod curved;
mod disk;
mod exact;

use crate::foundation::{HalfSpace, relative_bodies};
use crate::model::{Dof, Scene, Shape};
use crate::punch::{Surfaces, domain};

use bodies::modulus;
use curved::{Indenter, curved};
use disk::disk;
pub use exact::ClosedForm;

/// Returns the exact answer of a scene, if there is one:
/// - for a sphere, ellipsoid or cone without tangential tractions (no friction, or neither coupling
///   nor tangential load), on any path;
/// - for the same with friction, moved or pulled in one direction, if there is neither coupling nor
///   ν (Σν/G = 0): the load comes first and stays as it is, or both come in one increment;
/// - for a flat disk without coupling that nowhere lifts off and, with friction, nowhere slips:
///   pressed, tilted, shifted and twisted.
///
/// `None` for everything else, such as layers, height maps, a coupling with friction (Spence's
/// problem has no closed form), a Cattaneo–Mindlin contact with ν > 0 (the theory leaves out the
/// slip across), or an Ω that cuts the contact.
pub fn closed_form(scene: &Scene) -> Option<ClosedForm> {
    scene.validate().ok()?;
    let relative = relative_bodies(scene, 1.0);
    let rolls = scene.loading.steps.iter().any(|step| step.rolling.is_some());
    let is_worn = scene.wear.is_some_and(|wear| wear.changes_shape());
    if relative.layers.is_some() || rolls || is_worn {
        return None;
    }
    // The effects decide it in the same way: a coupling that cancels there is left out of the
    // solution.
    let coupled = relative.surface.coupling != 0.0;
    if coupled && scene.friction.mu > 0.0 {
        return None;
    }
    let bodies = HalfSpace::new(&scene.foundation.surface()?, scene.punch.material.as_ref());
    let exact = match scene.punch.shape {
        Shape::Sphere { radius } => {
            curved(scene, &Indenter::paraboloid(&bodies, radius, radius), &bodies)?
        }
        Shape::Ellipsoid { radius_x, radius_y } => {
            curved(scene, &Indenter::paraboloid(&bodies, radius_x, radius_y), &bodies)?
        }
        Shape::Cone { angle } => {
            curved(scene, &Indenter::Cone { modulus: modulus(&bodies), angle }, &bodies)?
        }
        Shape::FlatDisk { radius } => disk(scene, radius, &bodies)?,
        Shape::FlatRectangle { .. } | Shape::HeightMap { .. } | Shape::WheelOnRail(_) => {
            return None;
        }
    };
    let domain = domain(scene, &Surfaces::new()).ok()?;
    let reach = [(domain.center_x, domain.width_x), (domain.center_y, domain.width_y)]
        .map(|(center, width)| 0.5 * width - center.abs());
    let holds = reach
        .iter()
        .zip(exact.semi_axes)
        .all(|(reach, semi_axis)| semi_axis <= reach * (1.0 + 1e-12));
    let figures = exact.resultants.iter().chain(&exact.semi_axes);
    (holds && figures.copied().all(f64::is_finite) && exact.resultants[Dof::Approach] > 0.0)
        .then_some(exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::quadrature::Rectangle;
    use crate::model::{Foundation, Friction, Loading, Material, PerDof, Punch, Step, rigid_modes};
    use crate::theory::{cattaneo_shift, cattaneo_stick_ratio, hertz_sphere};

    fn scene(shape: Shape, poisson: f64, mu: f64, steps: &[Step]) -> Scene {
        Scene {
            foundation: Foundation::half_space(Material { shear_modulus: 3.0, poisson }),
            punch: Punch {
                shape,
                material: (poisson != 0.5).then_some(Material { shear_modulus: 3.0, poisson }),
            },
            friction: Friction { mu },
            wear: None,
            domain: None,
            loading: Loading::path(steps.to_vec()),
            interior: None,
        }
    }

    /// Returns the resultants by integration over the box around the contact.
    fn integrated(exact: &ClosedForm) -> PerDof<f64> {
        let [a, b] = exact.semi_axes;
        let sums = exact.kinks().integrate(Rectangle { x: [-a, a], y: [-b, b] }, &|x, y| {
            let (tractions, modes) = (exact.tractions_at(x, y), rigid_modes(x, y));
            Dof::ALL.map(|dof| (0..3).map(|c| modes[c][dof] * tractions[c]).sum())
        });
        PerDof::new(sums)
    }

    #[test]
    fn tractions_have_the_resultants() {
        let press = Step { approach: Some(0.01), ..Step::default() };
        let pull = Step { shift_x: Some(0.0008), shift_y: Some(-0.0004), ..Step::default() };
        let sole = Step {
            normal_force: Some(1.0),
            shift_x: Some(0.002),
            tilt_x: Some(0.01),
            moment_y: Some(0.1),
            ..pull
        };
        let curved = [
            Shape::Sphere { radius: 0.7 },
            Shape::Ellipsoid { radius_x: 0.3, radius_y: 2.0 },
            Shape::Cone { angle: 0.2 },
        ];
        let mut scenes: Vec<Scene> =
            curved.iter().map(|shape| scene(shape.clone(), 0.3, 0.0, &[press])).collect();
        scenes.extend(curved.iter().map(|shape| scene(shape.clone(), 0.0, 0.2, &[press, pull])));
        scenes.push(scene(
            Shape::FlatDisk { radius: 0.4 },
            0.5,
            0.9,
            &[Step { twist: Some(0.01), ..sole }],
        ));
        scenes.push(scene(
            Shape::FlatDisk { radius: 0.4 },
            0.3,
            0.9,
            &[Step { twist: Some(0.01), ..sole }],
        ));
        for scene in &scenes {
            let exact = closed_form(scene).unwrap_or_else(|| panic!("{scene:?}"));
            for (sum, resultant) in integrated(&exact).iter().zip(exact.resultants) {
                assert!(
                    (sum - resultant).abs() < 1e-6 * exact.resultants[Dof::Approach],
                    "{}: {sum} {resultant}",
                    exact.name
                );
            }
        }
    }

    #[test]
    fn partial_slip_of_a_sphere_is_that_of_cattaneo_and_mindlin() {
        let (approach, mu) = (0.01, 0.2);
        // Together the two bodies have E* = 2G.
        let hertz = hertz_sphere(3.0, 0.7, approach);
        let limit = mu * hertz.load;
        let press = Step { normal_force: Some(hertz.load), ..Step::default() };
        for part in [1e-3, 0.3, 0.9, 0.9999] {
            let pull = Step { force_y: Some(-part * limit), ..Step::default() };
            let exact = closed_form(&scene(Shape::Sphere { radius: 0.7 }, 0.0, mu, &[press, pull]))
                .unwrap();
            let shift = cattaneo_shift(part * limit, limit, hertz.radius, 4.0 / 3.0);
            assert!((exact.motion.shift_y / -shift - 1.0).abs() < 1e-10, "{part}: {exact:?}");
            let stick = cattaneo_stick_ratio(part * limit, limit);
            assert!((exact.stick_semi_axes[0] / (stick * hertz.radius) - 1.0).abs() < 1e-10);
            assert!((exact.motion.approach / approach - 1.0).abs() < 1e-12);
            // The shift, prescribed in turn, gives the force back.
            let move_it = Step { shift_y: Some(-shift), ..Step::default() };
            let back =
                closed_form(&scene(Shape::Sphere { radius: 0.7 }, 0.0, mu, &[press, move_it]))
                    .unwrap();
            assert!((back.resultants[Dof::ShiftY] / (-part * limit) - 1.0).abs() < 1e-10);
        }
        let slide = Step { shift_x: Some(1.0), ..Step::default() };
        let sliding =
            closed_form(&scene(Shape::Sphere { radius: 0.7 }, 0.0, mu, &[press, slide])).unwrap();
        assert!(
            (sliding.resultants[Dof::ShiftX] / limit - 1.0).abs() < 1e-12
                && sliding.stick_area() == 0.0
        );
    }

    #[test]
    fn loads_and_approaches_are_each_others_inverse() {
        for shape in [
            Shape::Sphere { radius: 0.7 },
            Shape::Ellipsoid { radius_x: 0.3, radius_y: 2.0 },
            Shape::Cone { angle: 0.2 },
        ] {
            let press = Step { approach: Some(0.01), ..Step::default() };
            let exact = closed_form(&scene(shape.clone(), 0.3, 0.0, &[press])).unwrap();
            let load =
                Step { normal_force: Some(exact.resultants[Dof::Approach]), ..Step::default() };
            let back = closed_form(&scene(shape, 0.3, 0.0, &[load])).unwrap();
            assert!(
                (back.motion.approach / 0.01 - 1.0).abs() < 1e-13
                    && (back.semi_axes[0] / exact.semi_axes[0] - 1.0).abs() < 1e-13
            );
        }
    }
}
