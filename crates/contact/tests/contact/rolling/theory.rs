//! Rolling against theories: Kalker's linear one where nothing slips, and Carter's line contact,
//! each with its order.

use super::{rolling, sphere};
use crate::common::*;
use contact::assess::RollingTheory;
use contact::model::*;
use contact::theory::{Carter, KalkerCoefficients, hertz_ellipse};

/// Forces come to Kalker's linear theory linearly in the element's length where nothing slips, for
/// a circle and for ellipses on either side.
#[test]
fn without_slip_it_comes_to_kalkers_coefficients() {
    for (radii, poisson, meshes) in [
        ([10.0, 10.0], 0.0, [48, 192]),
        ([10.0, 10.0], 0.5, [48, 192]),
        ([30.0, 10.0], 0.25, [32, 128]),
        ([10.0, 30.0], 0.25, [32, 128]),
        ([10.0, 60.0], 0.4, [32, 128]),
    ] {
        // Each body has G = 1, and E* = 1/(1 − ν). The load gives an area of about π.
        let load = 4.0 / 3.0 / (1.0 - poisson) * (1.0 / radii[0] + 1.0 / radii[1]) / 2.0;
        let hertz = hertz_ellipse(1.0 / (1.0 - poisson), 0.5 / radii[0], 0.5 / radii[1], load);
        let ratio = hertz.semi_axis_x / hertz.semi_axis_y;
        let exact = KalkerCoefficients::new(ratio, poisson).unwrap();
        let exact = [exact.c11, exact.c22, exact.c23, exact.c23, exact.c33];
        let coefficients = |n: u32| -> [f64; 5] {
            let run = |rolling: Rolling| {
                let mut scene = sphere([poisson; 2], rolling);
                scene.friction.mu = 1e6;
                scene.punch.shape = Shape::Ellipsoid { radius_x: radii[0], radius_y: radii[1] };
                scene.loading.steps[0].normal_force = Some(load);
                scene.domain = Some(Domain {
                    width_x: 2.4 * hertz.semi_axis_x,
                    width_y: 2.4 * hertz.semi_axis_y,
                    center_x: 0.0,
                    center_y: 0.0,
                });
                let (end, _) =
                    certified(&scene, &numerics(Mesh::Exact([n; 2]), Projection::Average, 1e-10));
                assert_eq!(end.observables.slip_elements, 0);
                end.observables
            };
            let zero = rolling(RollingHistory::Steady);
            let small = 1e-2;
            let along = run(Rolling { creepage_x: Some(small), ..zero });
            let across = run(Rolling { creepage_y: Some(small), ..zero });
            let turned = run(Rolling { spin: Some(small), ..zero });
            // The mean semi-axis is that of the ellipse of the elements' area.
            let size = (along.contact_area / std::f64::consts::PI).sqrt();
            [
                -along.force_x / (small * size.powi(2)),
                -across.force_y / (small * size.powi(2)),
                -turned.force_y / (small * size.powi(3)),
                across.moment_z / (small * size.powi(3)),
                -turned.moment_z / (small * size.powi(4)),
            ]
        };
        let [coarse, fine] = meshes.map(coefficients);
        for c in 0..5 {
            let [coarse, fine] = [coarse[c], fine[c]].map(|value| value / exact[c] - 1.0);
            let order = (coarse / fine).abs().log2() / 2.0;
            let place = format!("{radii:?}, ν = {poisson}, {c}: {coarse:e} {fine:e}");
            // C₂₃ has so little of the first order that the next one shows, which is faster.
            let (orders, most) = match c {
                2 | 3 => (0.95..1.6, 1e-3),
                _ => (0.95..1.1, 2e-3),
            };
            assert!(fine.abs() < 0.06, "{place}");
            assert!(orders.contains(&order), "{place}: {order}");
            // What is linear in the element's length taken away, the coefficient is left.
            let limit = (4.0 * fine - coarse) / 3.0;
            assert!(limit.abs() < most, "{place}: {limit:e}");
        }
    }
}

/// Theories in the direction and the units of a scene: what nearly sticks has the forces of the
/// linear theory, those that saturate are up to a tenth off, in direction where everything slips.
#[test]
fn theories_foretell_a_scene() {
    let backward =
        Rolling { direction: RollingDirection::Backward, ..rolling(RollingHistory::Steady) };
    for zero in [rolling(RollingHistory::Steady), backward] {
        for (creepages, share) in [
            ([1e-4, -2e-4, 0.0], 0.05),
            ([1e-4, -2e-4, 3e-4], 0.05),
            ([8e-3, 8e-3, 0.0], 0.12),
            ([0.3, -0.4, 0.0], 0.1),
        ] {
            let [x, y, spin] = creepages.map(Some);
            let turned = Rolling { creepage_x: x, creepage_y: y, spin, ..zero };
            let mut scene = sphere([0.28; 2], turned);
            scene.loading.steps[0].rolling = Some(Rolling { dq: Some(0.05), ..turned });
            let (end, _) =
                certified(&scene, &numerics(Mesh::Across(48), Projection::Average, 1e-8));
            let theory = RollingTheory::of(&scene, &end, None).unwrap();
            let o = end.observables;
            let limit = 0.3 * o.load;
            let foretold = theory.shen_hedrick_elkins;
            let size = foretold[0].hypot(foretold[1]);
            let apart = (o.force_x - foretold[0]).hypot(o.force_y - foretold[1]);
            assert!(apart <= share * size, "{creepages:?}: {foretold:?} {o:?}");
            assert!(size <= limit * (1.0 + 1e-12));
            assert_eq!(theory.vermeulen_johnson.is_none(), spin != Some(0.0));
            if share == 0.05 {
                let linear = theory.linear;
                let linear_apart = (o.force_x - linear.force_x).hypot(o.force_y - linear.force_y);
                assert!(linear_apart <= share * size, "{creepages:?}: {linear:?} {o:?}");
                // Of the two parts of the moment, backwards one is the other's opposite.
                let exact = KalkerCoefficients::new(1.0, 0.28).unwrap();
                let radius = (o.contact_area / std::f64::consts::PI).sqrt();
                let of_creepage = exact.c23 * creepages[1].abs() * radius.powi(3);
                let of_spin = exact.c33 * creepages[2].abs() * radius.powi(4);
                let slack = 0.01 * of_creepage + 0.07 * of_spin;
                assert!((o.moment_z - linear.moment_z).abs() < slack, "{linear:?} {o:?}");
            }
            // They are silent where they do not hold.
            let silent = |change: &dyn Fn(&mut Scene)| {
                let mut scene = scene.clone();
                change(&mut scene);
                RollingTheory::of(&scene, &end, None).is_none()
            };
            assert!(silent(&|scene| scene.friction.mu = 0.0));
            assert!(silent(&|scene| scene.loading.steps[0].rolling = None));
            assert!(silent(&|scene| scene.punch.shape = Shape::Cone { angle: 0.1 }));
            let layer = Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.3 };
            assert!(silent(&|scene| scene.foundation.layers = vec![layer]));
        }
    }
}

/// A contact that is one element long across is a line contact: a strip of 10⁴ half-widths. Forces
/// and tractions come to Carter's with the first order.
#[test]
fn a_long_contact_comes_to_carters() {
    let (half_width, radius, mu, poisson) = (1.0, 500.0, 0.3, 0.28);
    let length = 1e4;
    // Each body has G = 1, and a² = 4P'R/πE*.
    let per_length =
        std::f64::consts::PI / (1.0 - poisson) * half_width * half_width / 4.0 / radius;
    let peak = 2.0 * per_length / (std::f64::consts::PI * half_width);
    for creepage in [-0.00024, 0.00045] {
        let exact = Carter::of_creepage(creepage, radius, half_width, mu);
        let errors: Vec<[f64; 2]> = [40, 80, 160, 320]
            .into_iter()
            .map(|n| {
                let rolling =
                    Rolling { creepage_x: Some(creepage), ..rolling(RollingHistory::Steady) };
                let mut scene = sphere([poisson; 2], rolling);
                scene.friction.mu = mu;
                scene.punch.shape = Shape::Ellipsoid { radius_x: radius, radius_y: 1e15 };
                scene.loading.steps[0].normal_force = Some(per_length * length);
                scene.domain = Some(Domain {
                    width_x: 2.5 * half_width,
                    width_y: length,
                    center_x: 0.0,
                    center_y: 0.0,
                });
                let numerics = numerics(Mesh::Exact([n, 1]), Projection::Midpoint, 1e-10);
                let (end, fields) = certified(&scene, &numerics);
                let o = end.observables;
                let force = o.force_x / (mu * o.load) - exact.force_ratio();
                let traction: f64 = (0..n as usize)
                    .map(|e| {
                        let x = fields.origin[0] + e as f64 * fields.element[0];
                        (fields.traction_x[e] / (mu * peak) - exact.traction(x)).abs()
                    })
                    .sum::<f64>()
                    * fields.element[0];
                [force.abs(), traction]
            })
            .collect();
        for figure in 0..2 {
            let [coarse, fine] = [errors[0][figure], errors[3][figure]];
            let order = (coarse / fine).log2() / 3.0;
            assert!((order - 1.0).abs() < 0.25, "{creepage}: {errors:?}");
            assert!(fine < 0.01, "{creepage}: {errors:?}");
        }
    }
}
