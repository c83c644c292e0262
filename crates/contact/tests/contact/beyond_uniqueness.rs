//! These scenes have friction far beyond the range in which uniqueness is known. A solve ends with
//! a solution, or says with figures that it has none, within the limits that were set. A certified
//! outcome is a solution by the count of these tests as well.

use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Operators, solve};

const LIMIT: u32 = 500;

fn scenes(poisson: f64, mu: f64) -> Vec<(&'static str, Scene)> {
    let sphere = Shape::Sphere { radius: 1.0 };
    let flat = Shape::FlatRectangle { width_x: 2.0, width_y: 1.0 };
    let pressed = Step { approach: Some(1.0), ..Step::default() };
    let shallow = Step { approach: Some(0.01), ..Step::default() };
    let loaded = Step { normal_force: Some(3.8), force_x: Some(1.5), ..Step::default() };
    vec![
        ("sphere", scene(sphere.clone(), 1.0, poisson, mu, pressed)),
        (
            "sphere, shifted",
            scene(
                sphere.clone(),
                1.0,
                poisson,
                mu,
                Step { shift_x: Some(0.4), shift_y: Some(-0.1), ..pressed },
            ),
        ),
        ("sphere, pulled", scene(sphere, 1.0, poisson, mu, loaded)),
        ("flat punch", scene(flat.clone(), 1.0, poisson, mu, shallow)),
        (
            "flat punch, dragged",
            scene(flat.clone(), 1.0, poisson, mu, Step { shift_x: Some(0.03), ..shallow }),
        ),
        (
            "flat punch, tilted and dragged",
            scene(
                flat,
                1.0,
                poisson,
                mu,
                Step { tilt_x: Some(0.02), tilt_y: Some(-0.01), shift_x: Some(0.02), ..shallow },
            ),
        ),
    ]
}

#[test]
fn ends_certified_or_says_why_not() {
    let (mut certified, mut failed) = (0, 0);
    for mu in [2.0, 3.0, 5.0, 10.0] {
        for poisson in [0.0, 0.3] {
            for (name, scene) in scenes(poisson, mu) {
                for n in [6, 13, 24] {
                    for method in [Method::Auto, Method::Seidel] {
                        if method == Method::Seidel && n == 24 {
                            // Sweeps on 24² are slow, and show nothing that 13² does not.
                            continue;
                        }
                        let case = format!("{name}, ν = {poisson}, μ = {mu}, {n}², {method:?}");
                        let numerics = Numerics {
                            method,
                            max_iterations: LIMIT,
                            ..numerics(Mesh::Across(n), Projection::Average, 1e-9)
                        };
                        let (outcome, fields) =
                            solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default())
                                .unwrap();
                        let last = outcome.last().unwrap();
                        let c = last.certificate;
                        // Newton's method, its outer iteration for forces and the rounds of sweeps
                        // each have the limit.
                        assert!(
                            last.work.iterations <= 100 * u64::from(LIMIT),
                            "{case}: {:?}",
                            last.work
                        );
                        match &outcome.status {
                            Status::Certified => {
                                certified += 1;
                                let figures =
                                    [c.residual, c.tension, c.cone_violation, c.force_imbalance];
                                assert!(
                                    figures.iter().all(|figure| *figure <= 1e-9),
                                    "{case}: {c:?}"
                                );
                                assert!(
                                    c.penetration <= 1e-7 && c.gap_under_pressure <= 1e-7,
                                    "{case}: {c:?}"
                                );
                                let peak = fields.pressure.iter().copied().fold(0.0, f64::max);
                                assert!(peak > 0.0, "{case}: no contact");
                                for (e, p) in fields.pressure.iter().enumerate() {
                                    let traction = fields.traction_x[e].hypot(fields.traction_y[e]);
                                    assert!(
                                        *p >= -1e-9 * peak && traction <= mu * p + 1e-8 * peak,
                                        "{case}: {p} {traction}"
                                    );
                                }
                            }
                            Status::Failed { reason } => {
                                failed += 1;
                                println!("{case}: {reason}");
                                assert!(
                                    reason.contains("e-") || reason.contains("e0"),
                                    "{case}: no figures: {reason}"
                                );
                                assert!(
                                    !c.meets(numerics.tolerance)
                                        || reason.contains("gross sliding"),
                                    "{case}: {c:?}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }
    println!("{certified} certified, {failed} failed");
    assert!(certified > failed, "{certified} certified, {failed} failed");
}
