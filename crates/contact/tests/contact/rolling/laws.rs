//! Laws of rolling that need no other program: forces and creepages are inverses, reflections,
//! units, energy, the linear theory, the end of a long way, and effects left out.

use super::{PAIR, case, number, problem, rolling, sphere, step};
use crate::common::*;
use contact::model::*;
use contact::multiplicity::{Search, search};
use contact::punch::Surfaces;
use contact::{Operators, solve};

/// Prescribes the forces of a steady case instead of its creepages, which must come back.
#[test]
fn creepages_come_back_from_their_forces() {
    for id in [
        "long_quarter",
        "long_mid",
        "long_reversed",
        "lat_mid",
        "lat_ellipse",
        "spin_small",
        "spin_offset",
        "long_lat",
        "lat_spin_wide",
        "all_slender",
        "all_slender_reversed",
        "approach_circle",
        "approach_ellipse",
        "half_step",
        "double_step",
        "nu_zero",
        "nu_half",
        "unlike_K_zero",
        "rigid_counterbody",
        "aluminium_steel",
        "aluminium_steel_reversed",
        "wheel_rail",
    ] {
        let case = case("steady", id);
        let mut given = step(&case, &case["step"]);
        let known = given.rolling.unwrap();
        given.rolling = Some(Rolling { creepage_x: None, creepage_y: None, ..known });
        given.force_x = Some(number(&case["result"], "force_x"));
        given.force_y = Some(number(&case["result"], "force_y"));
        let (scene, numerics) = problem(&case, vec![given]);
        let (end, fields) = certified(&scene, &numerics);
        let distance = known.dq.unwrap();
        let reach = 0.5 * f64::from(fields.shape[0]) * fields.element[0];
        let found = [
            -end.motion.shift_x / distance,
            -end.motion.shift_y / distance + known.spin.unwrap() * known.spin_center,
        ];
        let wanted = [known.creepage_x.unwrap(), known.creepage_y.unwrap()];
        let size = wanted[0].hypot(wanted[1]).max(known.spin.unwrap().abs() * reach);
        for (found, wanted) in found.iter().zip(wanted) {
            let error = (found - wanted).abs() / size;
            assert!(error <= 1e-7, "{id}: {found:e} instead of {wanted:e}, off by {error:e}");
        }
        assert_eq!(
            Some(end.observables.stick_elements),
            case["result"]["n_stick"].as_u64(),
            "{id}"
        );
    }
}

/// The scene that is seen in a mirror across x rolls the other way with the opposite creepage and
/// spin.
#[test]
fn reversed_it_is_its_mirror_image() {
    let along = Rolling {
        creepage_x: Some(0.005),
        creepage_y: Some(-0.003),
        spin: Some(0.006),
        ..rolling(RollingHistory::Steady)
    };
    let back = Rolling {
        creepage_x: Some(-0.005),
        spin: Some(-0.006),
        direction: RollingDirection::Backward,
        ..along
    };
    for history in [RollingHistory::Steady, RollingHistory::Transient] {
        for dq in [None, Some(0.11)] {
            let run = |rolling: Rolling| {
                let mut scene = sphere([0.2, 0.4], Rolling { history, dq, ..rolling });
                let first = scene.loading.steps[0];
                let shift = if rolling.direction == RollingDirection::Forward { 1.0 } else { -1.0 };
                let press = Step {
                    normal_force: first.normal_force,
                    shift_x: Some(2e-3 * shift),
                    ..Step::default()
                };
                scene.loading.steps = vec![press, first, first];
                certified(&scene, &numerics(Mesh::Across(20), Projection::Average, 1e-10)).1
            };
            let (forward, backward) = (run(along), run(back));
            let peak = forward.pressure.iter().fold(0.0_f64, |peak, p| peak.max(*p));
            for e in 0..400 {
                let image = e / 20 * 20 + 19 - e % 20;
                for (got, exact) in [
                    (backward.pressure[image], forward.pressure[e]),
                    (backward.traction_x[image], -forward.traction_x[e]),
                    (backward.traction_y[image], forward.traction_y[e]),
                ] {
                    assert!((got - exact).abs() <= 1e-9 * peak, "{history:?} {e}: {got} {exact}");
                }
            }
        }
    }
}

#[test]
fn units_do_not_matter() {
    let rolling = Rolling {
        creepage_x: Some(0.005),
        spin: Some(0.006),
        dq: Some(0.2),
        ..rolling(RollingHistory::Steady)
    };
    let small = sphere([0.2, 0.4], rolling);
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-10);
    let (length, modulus) = (1e-3, 1e9);
    let mut large = small.clone();
    let stiffer = |m: Material| Material { shear_modulus: m.shear_modulus * modulus, ..m };
    let below = Material { shear_modulus: 1.0, poisson: 0.2 };
    large.foundation = Foundation::half_space(stiffer(below));
    large.punch.material = large.punch.material.map(stiffer);
    let Shape::Sphere { radius } = large.punch.shape else { unreachable!() };
    large.punch.shape = Shape::Sphere { radius: radius * length };
    large.domain = square(2.4 * length);
    let force = small.loading.steps[0].normal_force.map(|p| p * modulus * length * length);
    large.loading.steps[0].normal_force = force;
    large.loading.steps[0].rolling =
        Some(Rolling { spin: Some(0.006 / length), dq: Some(0.2 * length), ..rolling });
    let (small, large) = (certified(&small, &numerics), certified(&large, &numerics));
    for (small, large) in [
        (small.1.traction_x, large.1.traction_x),
        (small.1.traction_y, large.1.traction_y),
        (small.1.pressure, large.1.pressure),
    ] {
        let peak = small.iter().fold(0.0_f64, |peak, p| peak.max(p.abs()));
        for (small, large) in small.iter().zip(large) {
            assert!((small - large / modulus).abs() <= 1e-9 * peak, "{small} {large}");
        }
    }
}

/// Without coupling the creepages do the work that friction loses, up to what the mesh loses: the
/// difference halves with the elements.
#[test]
fn friction_loses_the_work_of_the_creepages() {
    let [creepage, spin] = [0.008, 0.006];
    let rolling =
        Rolling { creepage_x: Some(creepage), spin: Some(spin), ..rolling(RollingHistory::Steady) };
    let mut scene = sphere(PAIR, rolling);
    // The approach is held, so that nothing else does work.
    let given = Step { normal_force: None, approach: Some(0.113), ..scene.loading.steps[0] };
    scene.loading.steps = vec![Step { rolling: None, ..given }, given];
    let gaps: Vec<f64> = [16, 32, 64]
        .into_iter()
        .map(|n| {
            let (end, fields) =
                certified(&scene, &numerics(Mesh::Across(n), Projection::Average, 1e-9));
            let o = end.observables;
            let work = -(creepage * o.force_x + spin * o.moment_z) * fields.element[0];
            // The motion of the punch says the same.
            assert!((end.observables.external_work - work).abs() <= 1e-9 * work);
            (work - o.dissipation) / work
        })
        .collect();
    assert!(gaps[2] > 0.0 && gaps[2] < 0.1, "{gaps:?}");
    assert!(gaps.windows(2).all(|pair| pair[1] < 0.65 * pair[0]), "{gaps:?}");
}

/// Returns C11, C22, C23 and C33 of Kalker's linear theory for a circle at this ν.
fn kalker(poisson: f64) -> [f64; 4] {
    let table = reference("kalker_coefficients.csv");
    let rows = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>());
    let row = rows.into_iter().find(|row| row[0] == 1.0 && row[1] == poisson).unwrap();
    [row[2], row[3], row[4], row[5]]
}

/// Where nothing slips, forces come to Kalker's linear theory linearly in the element's length.
#[test]
fn without_slip_it_comes_to_kalkers_coefficients() {
    for poisson in [0.0, 0.25, 0.5] {
        let exact = kalker(poisson);
        let coefficients = |n: u32| -> [f64; 4] {
            // The Hertzian contact has radius 1, and each body G = 1.
            let run = |rolling: Rolling| {
                let mut scene = sphere([poisson; 2], rolling);
                scene.friction.mu = 1e6;
                scene.punch.shape = Shape::Sphere { radius: 10.0 };
                // The modulus E* is 1/(1 − ν), and P = 4E*a³/3R.
                scene.loading.steps[0].normal_force = Some(4.0 / 3.0 / (1.0 - poisson) / 10.0);
                let (end, _) =
                    certified(&scene, &numerics(Mesh::Across(n), Projection::Average, 1e-10));
                assert_eq!(end.observables.slip_elements, 0);
                end.observables
            };
            let zero = rolling(RollingHistory::Steady);
            let small = 1e-2;
            let along = run(Rolling { creepage_x: Some(small), ..zero });
            let across = run(Rolling { creepage_y: Some(small), ..zero });
            let turned = run(Rolling { spin: Some(small), ..zero });
            assert!((across.moment_z / turned.force_y + 1.0).abs() < 0.2);
            // The radius is that of the circle of the elements' area.
            let radius = (along.contact_area / std::f64::consts::PI).sqrt();
            [
                -along.force_x / (small * radius.powi(2)),
                -across.force_y / (small * radius.powi(2)),
                -turned.force_y / (small * radius.powi(3)),
                -turned.moment_z / (small * radius.powi(4)),
            ]
        };
        let [coarse, fine] = [48, 192].map(coefficients);
        for c in 0..4 {
            let [coarse, fine] = [coarse[c], fine[c]].map(|value| (value / exact[c] - 1.0).abs());
            let order = (coarse / fine).log2() / 2.0;
            assert!(fine < 0.02, "ν = {poisson}, {c}: {fine:e}");
            assert!((order - 1.0).abs() < 0.25, "ν = {poisson}, {c}: {coarse:e} {fine:e}");
        }
    }
}

/// The steady limit of a path that is 2 % short of it after two lengths of the contact.
#[test]
fn a_long_way_ends_in_the_steady_state() {
    let case = case("transient", "tr_long_way");
    let mut end = step(&case, &case["steps"][1]);
    end.rolling = end.rolling.map(|rolling| Rolling { history: RollingHistory::Steady, ..rolling });
    let (scene, numerics) = problem(&case, vec![end]);
    let (steady, _) = certified(&scene, &numerics);
    let o = steady.observables;
    assert!((o.force_x / (0.3 * o.load) + 0.608968075672).abs() < 1e-8);
    assert_eq!(o.stick_elements, 188);
}

/// Effects that a rolling scene does not call for are left out, and the solution has none of them.
#[test]
fn effects_left_out_change_nothing() {
    let zero = rolling(RollingHistory::Steady);
    let longitudinal = Rolling { creepage_x: Some(0.008), ..zero };
    let lateral = Rolling { creepage_y: Some(0.008), ..zero };
    let turning = Rolling { spin: Some(0.01), ..zero };
    let transient = Rolling { history: RollingHistory::Transient, ..longitudinal };
    let (layer, unlike, incompressible) = ([0.3, 0.2], [0.0, 0.45], [0.5, 0.5]);
    for (pair, rolling) in [
        ([0.0; 2], longitudinal),
        ([0.0; 2], lateral),
        (PAIR, longitudinal),
        (PAIR, lateral),
        (PAIR, turning),
        (unlike, longitudinal),
        (unlike, turning),
        (incompressible, turning),
        (layer, longitudinal),
        ([0.0; 2], transient),
        (PAIR, transient),
        (unlike, transient),
    ] {
        let mut scene = sphere(pair, rolling);
        if pair == layer {
            scene.foundation.layers =
                vec![Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.3 }];
        }
        let first = scene.loading.steps[0];
        scene.loading.steps.push(first);
        let lean = numerics(Mesh::Across(16), Projection::Average, 1e-10);
        let full = Numerics { simulate: Effect::OPTIONAL.to_vec(), ..lean.clone() };
        let apart = difference(&certified(&scene, &lean).1, &certified(&scene, &full).1);
        assert!(apart <= 1e-9, "{pair:?} {rolling:?}: {apart:e}");
    }
}

#[test]
fn steps_that_cannot_roll_are_refused() {
    let steady = sphere(PAIR, rolling(RollingHistory::Steady));
    let passing = sphere(PAIR, rolling(RollingHistory::Transient));
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-8);
    let refused = |scene: &Scene, numerics: &Numerics| {
        solve(scene, numerics, &Surfaces::new(), &mut Operators::default()).unwrap_err().key
    };
    let regularised = Numerics { epsilon: 1e-6, ..numerics.clone() };
    assert_eq!(refused(&passing, &regularised), "epsilon");
    let swept = Numerics { method: Method::Seidel, ..numerics.clone() };
    assert_eq!(refused(&steady, &swept), "method");
    let near = Rolling { dq: Some(0.014), ..rolling(RollingHistory::Steady) };
    assert_eq!(
        refused(&sphere(PAIR, near), &numerics),
        "loading.steps[0].dq",
        "a tenth of an element has 0.015"
    );
    let error = search(
        &passing,
        &numerics,
        &Surfaces::new(),
        &mut Operators::default(),
        &Search::default(),
    );
    assert_eq!(error.unwrap_err().key, "loading.steps[0].distance");
}
