//! Rolling from full stick to full slip, by distances from a tenth of an element to the contact's
//! length, with friction from almost none to much, is solved by Newton's method; where it cannot
//! be, words say why.

use super::{PAIR, rolling, sphere};
use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Operators, solve};

const UNLIKE: [f64; 2] = [0.2, 0.4];

/// Solves a scene on 32 × 32 elements, and returns the force along x over μP.
fn force(scene: &Scene, projection: Projection) -> f64 {
    let (end, _) = certified(scene, &numerics(Mesh::Across(32), projection, 1e-8));
    assert_eq!(end.route, Route::Newton, "{:?}", scene.loading.steps[0]);
    end.observables.force_x / (scene.friction.mu * end.observables.load)
}

#[test]
fn creepages_of_any_size() {
    for pair in [PAIR, UNLIKE] {
        let forces: Vec<f64> = [1e-12, 1e-6, 1e-3, 0.01, 0.03, 0.04, 0.2, 10.0]
            .into_iter()
            .map(|creepage| {
                let rolling =
                    Rolling { creepage_x: Some(creepage), ..rolling(RollingHistory::Steady) };
                force(&sphere(pair, rolling), Projection::Midpoint)
            })
            .collect();
        assert!(forces.windows(2).all(|pair| pair[1] < pair[0] + 1e-7), "{forces:?}");
        assert!((forces[7] + 1.0).abs() < 1e-6, "{forces:?}");
    }
}

#[test]
fn spins_of_any_size() {
    for pair in [PAIR, UNLIKE] {
        for spin in [1e-12, 1e-6, 3e-3, 0.07, 1.0, 100.0] {
            let rolling = Rolling { spin: Some(spin), ..rolling(RollingHistory::Steady) };
            force(&sphere(pair, rolling), Projection::Midpoint);
        }
    }
}

#[test]
fn distances_from_a_tenth_of_an_element_to_beyond_the_contact() {
    for projection in [Projection::Midpoint, Projection::Average] {
        let forces: Vec<f64> = [0.1, 0.25, 0.5, 1.0, 1.5, 3.0, 10.0, 27.0, 60.0]
            .into_iter()
            .map(|elements| {
                let rolling = Rolling {
                    creepage_x: Some(0.013464),
                    spin: Some(0.01),
                    dq: Some(0.075 * elements),
                    ..rolling(RollingHistory::Steady)
                };
                force(&sphere(PAIR, rolling), projection)
            })
            .collect();
        // A few elements are near the limit, and a length beyond the contact has no steady state's
        // memory: all is a first step.
        assert!(forces[..6].iter().all(|force| (force + 0.66).abs() < 0.02), "{forces:?}");
        assert!(forces[8] < forces[6], "{forces:?}");
    }
}

#[test]
fn friction_of_any_size() {
    for mu in [1e-12, 1e-6, 1e-3, 1.0, 3.0] {
        let rolling = Rolling {
            creepage_x: Some(0.013464 * mu),
            spin: Some(0.01),
            ..rolling(RollingHistory::Steady)
        };
        let mut scene = sphere(UNLIKE, rolling);
        scene.friction.mu = mu;
        force(&scene, Projection::Midpoint);
    }
}

#[test]
fn forces_up_to_sliding() {
    for pair in [PAIR, UNLIKE] {
        for share in [1e-9, 0.1, -0.6, 0.9, 0.99, 0.999] {
            let rolling =
                Rolling { creepage_x: None, spin: Some(0.005), ..rolling(RollingHistory::Steady) };
            let mut scene = sphere(pair, rolling);
            let step = &mut scene.loading.steps[0];
            step.force_x = step.normal_force.map(|load| share * 0.3 * load);
            let reached = force(&scene, Projection::Midpoint);
            assert!((reached - share).abs() < 1e-7, "{reached} instead of {share}");
            scene.loading.steps[0].force_x = scene.loading.steps[0].normal_force.map(|p| 0.31 * p);
            let numerics = numerics(Mesh::Across(32), Projection::Midpoint, 1e-8);
            let (outcome, _) =
                solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
            let Status::Failed { reason } = outcome.status else { panic!("it must slide") };
            assert!(reason.starts_with("gross sliding"), "{reason}");
        }
    }
}

#[test]
fn coatings_of_any_thickness() {
    let longitudinal = Rolling { creepage_x: Some(0.008), ..rolling(RollingHistory::Steady) };
    let coated = |thickness: f64, poisson: f64| {
        let mut scene = sphere(PAIR, longitudinal);
        scene.foundation.layers = vec![Layer { shear_modulus: 4.0, poisson, thickness }];
        force(&scene, Projection::Average)
    };
    let bare = force(&sphere(PAIR, longitudinal), Projection::Average);
    let mut thick = sphere(PAIR, longitudinal);
    thick.foundation = Foundation::half_space(Material { shear_modulus: 4.0, poisson: 0.4 });
    let thick = force(&thick, Projection::Average);
    let forces = [1e-4, 0.01, 0.3, 3.0, 300.0].map(|thickness| coated(thickness, 0.4));
    assert!((forces[0] / bare - 1.0).abs() < 1e-2, "{forces:?} {bare}");
    assert!((forces[4] / thick - 1.0).abs() < 1e-2, "{forces:?} {thick}");
    // A coating of almost the material under it is hardly felt.
    let mut same = sphere(PAIR, longitudinal);
    same.foundation.layers =
        vec![Layer { shear_modulus: 1.0 + 1e-9, poisson: PAIR[0], thickness: 0.2 }];
    assert!((force(&same, Projection::Average) / bare - 1.0).abs() < 1e-7);
}
