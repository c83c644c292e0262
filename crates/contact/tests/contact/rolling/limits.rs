//! Rolling from full stick to full slip, by distances from a tenth of an element to the contact's
//! length, with friction from almost none to much, is solved by Newton's method; where it cannot
//! be, words say why.

use super::{PAIR, rolling, sphere};
use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Operators, solve};

const UNLIKE: [f64; 2] = [0.2, 0.4];

/// Solves a scene on 32 × 32 elements.
fn solved(scene: &Scene, projection: Projection) -> StepOutcome {
    let (end, _) = certified(scene, &numerics(Mesh::Across(32), projection, 1e-8));
    assert_eq!(end.route, Route::Newton, "{:?}", scene.loading.steps[0]);
    end
}

/// Returns the force along x over μP.
fn force(scene: &Scene, projection: Projection) -> f64 {
    let observables = solved(scene, projection).observables;
    observables.force_x / (scene.friction.mu * observables.load)
}

#[test]
fn creepages_of_any_size() {
    for pair in [PAIR, UNLIKE] {
        let of = |creepage: f64| {
            let rolling = Rolling { creepage_x: Some(creepage), ..rolling(RollingHistory::Steady) };
            force(&sphere(pair, rolling), Projection::Midpoint)
        };
        let creepages = [1e-12, 1e-9, 1e-6, 1e-3, 0.01, 0.03, 0.04, 0.2, 10.0];
        let forces = creepages.map(of);
        assert!(forces[2..].windows(2).all(|pair| pair[1] < pair[0] + 1e-7), "{forces:?}");
        assert!((forces[8] + 1.0).abs() < 1e-6, "{forces:?}");
        // Of like bodies a small creepage has a force in proportion, and unlike ones have one
        // without any.
        let none = of(0.0);
        assert_eq!(none == 0.0, pair == PAIR);
        if pair == PAIR {
            let linear = forces[3] / creepages[3];
            for (force, creepage) in forces.iter().zip(creepages).take(3) {
                let ratio = force / creepage / linear;
                assert!((ratio - 1.0).abs() < 0.05, "{creepage:e}: {ratio}");
            }
            assert!((forces[0] * 1e6 / forces[2] - 1.0).abs() < 1e-3, "{forces:?}");
        } else {
            assert!((forces[0] - none).abs() < 1e-7, "{forces:?} {none}");
        }
    }
}

/// A creepage too small to make any element slip has a force in proportion along a path too.
#[test]
fn tiny_creepages_along_a_path() {
    let of = |creepage: f64| {
        let rolling = Rolling { creepage_x: Some(creepage), ..rolling(RollingHistory::Transient) };
        let mut scene = sphere(PAIR, rolling);
        scene.loading.steps[0].increments = 3;
        force(&scene, Projection::Midpoint) / creepage
    };
    let [tiny, small] = [1e-12, 1e-5].map(of);
    assert!(small < 0.0 && (tiny / small - 1.0).abs() < 1e-3, "{tiny} {small}");
}

#[test]
fn spins_of_any_size() {
    for pair in [PAIR, UNLIKE] {
        let of = |spin: f64| {
            let rolling = Rolling { spin: Some(spin), ..rolling(RollingHistory::Steady) };
            solved(&sphere(pair, rolling), Projection::Midpoint).observables
        };
        let spins = [1e-12, 1e-6, 3e-4, 0.07, 1.0, 100.0];
        let results = spins.map(of);
        if pair == PAIR {
            let across = |index: usize| results[index].force_y / spins[index];
            let [tiny, small, linear] = [0, 1, 2].map(across);
            assert!(linear != 0.0 && (tiny / small - 1.0).abs() < 1e-3, "{tiny} {small}");
            assert!((small / linear - 1.0).abs() < 0.05, "{small} {linear}");
        }
        // All that turns about the middle has the moment μ ∫ p r = 3π/16 μ P a.
        let Observables { load, contact_area, moment_z, .. } = results[5];
        let radius = (contact_area / std::f64::consts::PI).sqrt();
        let most = 3.0 * std::f64::consts::PI / 16.0 * 0.3 * load * radius;
        assert!((moment_z / most + 1.0).abs() < 0.03, "{moment_z} {most}");
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

/// Like bodies with creepages in proportion to μ have tractions in proportion to μ.
#[test]
fn friction_of_any_size() {
    let of = |pair: [f64; 2], mu: f64, creepage_x: f64, spin: f64| {
        let (creepage_x, spin) = (Some(creepage_x), Some(spin));
        let rolling = Rolling { creepage_x, spin, ..rolling(RollingHistory::Steady) };
        let mut scene = sphere(pair, rolling);
        scene.friction.mu = mu;
        force(&scene, Projection::Midpoint)
    };
    let usual = of(PAIR, 0.3, 0.04 * 0.3, 0.01 * 0.3);
    for mu in [1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3.0] {
        let scaled = of(PAIR, mu, 0.04 * mu, 0.01 * mu);
        assert!((scaled - usual).abs() < 1e-6, "{mu:e}: {scaled} {usual}");
        // Whatever friction unlike bodies have, they are solved.
        of(UNLIKE, mu, 0.013464 * mu, 0.01);
    }
    for mu in [1e-12, 1e-9, 1e-6] {
        let slides = of(PAIR, mu, 0.01, 0.0);
        assert!((slides + 1.0).abs() < 1e-6, "{mu:e}: {slides}");
    }
    let [least, less] = [1e-12, 1e-9].map(|mu| of(UNLIKE, mu, 0.01, 0.0));
    assert!(least < -0.5 && (least - less).abs() < 1e-3, "{least} {less}");
}

/// The creepages of small forces are in proportion to them.
#[test]
fn forces_of_any_size() {
    let of = |share: f64| {
        let free = Rolling { creepage_x: None, ..rolling(RollingHistory::Steady) };
        let mut scene = sphere(PAIR, free);
        let step = &mut scene.loading.steps[0];
        step.force_x = step.normal_force.map(|load| share * 0.3 * load);
        let end = solved(&scene, Projection::Midpoint);
        let reached = end.observables.force_x / (0.3 * end.observables.load);
        assert!((reached / share - 1.0).abs() < 1e-6, "{reached} instead of {share}");
        assert!(end.observables.tangential_force() > 0.0);
        end.motion.shift_x / share
    };
    let [tiny, small, linear] = [1e-12, 1e-9, 1e-3].map(of);
    assert!((tiny / small - 1.0).abs() < 1e-3, "{tiny} {small}");
    assert!(small > 0.0 && (small / linear - 1.0).abs() < 0.05, "{small} {linear}");
}

#[test]
fn forces_up_to_sliding() {
    for pair in [PAIR, UNLIKE] {
        for share in [0.1, -0.6, 0.9, 0.99, 0.999] {
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
