//! Steps whose distances, creepages and spins have no meaning next to Ω or in double precision
//! are refused with their key before anything is computed, and so are settings that do not
//! suit rolling.

use super::{PAIR, rolling, sphere};
use crate::common::*;
use contact::model::*;
use contact::problem::Problem;
use contact::punch::Surfaces;

fn mesh() -> Numerics {
    numerics(Mesh::Across(16), Projection::Midpoint, 1e-8)
}

/// Returns the key that binding a scene to its grid refuses.
fn refused(scene: &Scene) -> Option<String> {
    Problem::new(scene, &mesh(), &Surfaces::new()).err().map(|error| error.key)
}

#[test]
fn distances_next_to_which_the_domain_is_nothing() {
    for history in [RollingHistory::Steady, RollingHistory::Transient] {
        for layers in [vec![], vec![Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.3 }]] {
            for (dq, is_refused) in
                [(2399.0, false), (2401.0, true), (1e150, true), (1e300, true), (f64::MAX, true)]
            {
                let zero = Rolling { dq: Some(dq), ..rolling(history) };
                let mut scene = sphere(PAIR, zero);
                scene.foundation.layers = layers.clone();
                let key = is_refused.then(|| "loading.steps[0].dq".to_owned());
                assert_eq!(refused(&scene), key, "{history:?} {dq:e}");
                let plan = contact::forecast(&scene, &mesh(), &Surfaces::new());
                assert_eq!(plan.err().map(|error| error.key), key, "{history:?} {dq:e}");
                if !is_refused {
                    certified(&scene, &mesh());
                }
            }
        }
    }
}

#[test]
fn creepages_that_cannot_be_squared() {
    let zero = rolling(RollingHistory::Steady);
    for (name, rolling) in [
        ("creepage_x", Rolling { creepage_x: Some(1e-200), ..zero }),
        ("creepage_x", Rolling { creepage_x: Some(-1e200), ..zero }),
        ("creepage_y", Rolling { creepage_y: Some(1e-200), ..zero }),
        ("spin", Rolling { spin: Some(1e200), ..zero }),
        ("spin_center", Rolling { spin: Some(1e100), spin_center: 1e100, ..zero }),
        ("spin_center", Rolling { spin: Some(1e10), spin_center: 1e300, ..zero }),
    ] {
        assert_eq!(refused(&sphere(PAIR, rolling)), Some(format!("loading.steps[0].{name}")));
    }
    let small = Rolling { creepage_x: Some(1e-100), spin: Some(1e100), ..zero };
    assert_eq!(refused(&sphere(PAIR, small)), None);
}

#[test]
fn a_center_of_no_spin() {
    let scene = |spin: Option<f64>| {
        let center = Rolling { spin_center: 0.1, spin, ..rolling(RollingHistory::Steady) };
        let center = Rolling { creepage_y: None, ..center };
        let mut scene = sphere(PAIR, center);
        scene.loading.steps[0].moment_z = spin.is_none().then_some(0.01);
        scene
    };
    assert_eq!(refused(&scene(None)), Some("loading.steps[0].spin_center".to_owned()));
    assert_eq!(refused(&scene(Some(0.01))), None);
    assert!(scene(Some(0.01)).moves(Dof::ShiftY), "the spin carries the punch along");
    assert!(
        !sphere(PAIR, Rolling { creepage_y: None, ..rolling(RollingHistory::Steady) })
            .moves(Dof::ShiftY)
    );
}

#[test]
fn plans_refuse_the_settings_that_a_solve_refuses() {
    let steady = sphere(PAIR, rolling(RollingHistory::Steady));
    for (key, numerics) in [
        ("epsilon", Numerics { epsilon: 1e-6, ..mesh() }),
        ("method", Numerics { method: Method::Seidel, ..mesh() }),
    ] {
        let error = contact::forecast(&steady, &numerics, &Surfaces::new()).unwrap_err();
        assert_eq!(error.key, key);
    }
}
