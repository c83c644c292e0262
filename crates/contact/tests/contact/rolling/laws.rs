//! Laws of rolling that need no other program: reflections, units, energy, the end of a long way,
//! and effects left out.

use super::{PAIR, case, problem, rolling, sphere, step};
use crate::common::*;
use contact::model::*;
use contact::multiplicity::{Search, search};
use contact::punch::Surfaces;
use contact::{Operators, solve};

/// The scene that is seen in a mirror across x rolls the other way with the opposite creepage and
/// spin, and in a mirror across y with the opposite lateral creepage and spin: of unlike bodies and
/// on a layer.
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
    let beside = Rolling { creepage_y: Some(0.003), spin: Some(-0.006), ..along };
    let layer = Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.3 };
    for (history, dq, layers) in [
        (RollingHistory::Steady, None, vec![]),
        (RollingHistory::Steady, Some(0.11), vec![]),
        (RollingHistory::Transient, None, vec![]),
        (RollingHistory::Transient, Some(0.11), vec![]),
        (RollingHistory::Steady, None, vec![layer]),
        (RollingHistory::Transient, Some(0.11), vec![layer]),
    ] {
        let run = |rolling: Rolling, shift: [f64; 2]| {
            let mut scene = sphere([0.2, 0.4], Rolling { history, dq, ..rolling });
            scene.foundation.layers = layers.clone();
            let first = scene.loading.steps[0];
            let press = Step {
                normal_force: first.normal_force,
                shift_x: Some(shift[0]),
                shift_y: Some(shift[1]),
                ..Step::default()
            };
            scene.loading.steps = vec![press, first, first];
            certified(&scene, &numerics(Mesh::Across(20), Projection::Average, 1e-10)).1
        };
        let forward = run(along, [2e-3, 1e-3]);
        let peak = forward.pressure.iter().fold(0.0_f64, |peak, p| peak.max(*p));
        let [in_x, in_y] = [run(back, [-2e-3, 1e-3]), run(beside, [2e-3, -1e-3])];
        for e in 0..400 {
            let [across_x, across_y] = [e / 20 * 20 + 19 - e % 20, (19 - e / 20) * 20 + e % 20];
            for (got, exact) in [
                (in_x.pressure[across_x], forward.pressure[e]),
                (in_x.traction_x[across_x], -forward.traction_x[e]),
                (in_x.traction_y[across_x], forward.traction_y[e]),
                (in_y.pressure[across_y], forward.pressure[e]),
                (in_y.traction_x[across_y], forward.traction_x[e]),
                (in_y.traction_y[across_y], -forward.traction_y[e]),
            ] {
                assert!((got - exact).abs() <= 1e-9 * peak, "{history:?} {e}: {got} {exact}");
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
    for [x, y, spin] in [[0.008, 0.0, 0.006], [-0.004, 0.009, -0.002], [0.0, 0.0, 0.03]] {
        let rolling = Rolling {
            creepage_x: Some(x),
            creepage_y: Some(y),
            spin: Some(spin),
            ..rolling(RollingHistory::Steady)
        };
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
                let power = -(x * o.force_x + y * o.force_y + spin * o.moment_z);
                let work = power * fields.element[0];
                // The motion of the punch says the same.
                assert!((o.external_work - work).abs() <= 1e-9 * work);
                (work - o.dissipation) / work
            })
            .collect();
        assert!(gaps[2] > 0.0 && gaps[2] < 0.15, "{gaps:?}");
        assert!(gaps.windows(2).all(|pair| pair[1] < 0.65 * pair[0]), "{gaps:?}");
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

/// The mesh is large enough that every loop is shared between threads.
#[test]
fn what_rolls_has_the_same_bytes_on_any_number_of_threads() {
    let along = |history| Rolling {
        creepage_x: Some(0.008),
        creepage_y: Some(0.003),
        spin: Some(0.01),
        ..rolling(history)
    };
    for history in [RollingHistory::Steady, RollingHistory::Transient] {
        let mut scene = sphere([0.2, 0.4], along(history));
        let first = scene.loading.steps[0];
        scene.loading.steps.insert(0, Step { rolling: None, ..first });
        let numerics = numerics(Mesh::Across(190), Projection::Midpoint, 1e-8);
        let solved_on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap()
            })
        };
        let one = solved_on(1);
        assert_eq!(one.0.status, Status::Certified);
        assert!(one.0.estimate.is_some());
        // Every digit of a double goes into its debug text.
        assert!(format!("{:?}", solved_on(3)) == format!("{one:?}"), "{history:?}");
    }
}

/// Returns pairs of bodies and creepages at which some of the contact slips, in steady rolling by
/// an element.
fn creeping() -> [([f64; 2], Rolling); 5] {
    let zero = rolling(RollingHistory::Steady);
    let [along, across] = [Some(0.013464), Some(0.008)];
    [
        (PAIR, Rolling { creepage_x: along, ..zero }),
        (PAIR, Rolling { creepage_y: across, ..zero }),
        (PAIR, Rolling { creepage_x: across, spin: Some(0.01), ..zero }),
        ([0.2, 0.4], Rolling { creepage_x: along, ..zero }),
        ([0.2, 0.4], Rolling { creepage_x: Some(0.03), creepage_y: across, ..zero }),
    ]
}

/// Returns what estimates of creep forces are over their errors, on some meshes. The limit is what
/// a mesh of 192 elements finds, or if errors are of first order what two fine meshes lead to.
fn estimates_over_errors(pair: [f64; 2], rolling: Rolling, is_first_order: bool) -> Vec<f64> {
    let solved = |n: u32| {
        let numerics = numerics(Mesh::Across(n), Projection::Average, 1e-8);
        let scene = sphere(pair, rolling);
        let (outcome, _) =
            solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
        assert_eq!(outcome.status, Status::Certified);
        let o = outcome.last().unwrap().observables;
        let estimated = outcome.estimate.unwrap().figures.tangential_force.unwrap();
        ([o.force_x, o.force_y], estimated)
    };
    let (fine, _) = solved(192);
    let half = if is_first_order { solved(96).0 } else { fine };
    let limit = [0, 1].map(|c| 2.0 * fine[c] - half[c]);
    [12, 16, 20, 24, 32, 40, 48, 64]
        .into_iter()
        .map(|n| {
            let (force, estimated) = solved(n);
            let error = (force[0] - limit[0]).hypot(force[1] - limit[1]) / limit[0].hypot(limit[1]);
            let dq = rolling.dq;
            println!("{pair:?} {dq:?} {n:3}: estimated {estimated:.1e}, off by {error:.1e}");
            estimated / error
        })
        .collect()
}

/// Requires that 19 of 20 estimates cover the error, and that the one in the middle is less than
/// so many times as large.
fn require_covered(mut ratios: Vec<f64>, most: f64) {
    ratios.sort_by(f64::total_cmp);
    let (covered, count) = (ratios.iter().filter(|ratio| **ratio >= 1.0).count(), ratios.len());
    let median = ratios[count / 2];
    println!("{covered} of {count} covered, median {median:.1}");
    assert!(20 * covered >= 19 * count && median < most, "{covered} of {count}, {median}");
}

/// The estimate of a creep force covers the distance to the limit of fine meshes on nearly all
/// meshes, and is not many times as large. A creepage under a force is a motion over the distance,
/// whatever that is on the coarser grid.
#[test]
fn creep_forces_are_as_near_as_they_are_estimated() {
    let ratios =
        creeping().map(|(pair, rolling)| estimates_over_errors(pair, rolling, true)).concat();
    require_covered(ratios, 4.0);

    let zero = rolling(RollingHistory::Steady);
    let mut scene = sphere(PAIR, Rolling { creepage_x: None, ..zero });
    let step = &mut scene.loading.steps[0];
    step.force_x = step.normal_force.map(|load| 0.12 * load);
    let numerics = numerics(Mesh::Across(32), Projection::Average, 1e-8);
    let (outcome, _) =
        solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
    let estimated = outcome.estimate.unwrap().figures.shift.unwrap();
    assert!(estimated < 0.15, "{estimated:e}");
}

/// So it does in steady rolling by a given distance, which the coarser grid rolls too, from a tenth
/// of the coarsest element to eight of the finest. Errors are of second order from an element on,
/// which the estimate does not count on.
#[test]
fn creep_forces_by_a_given_distance_are_as_near_as_they_are_estimated() {
    let mut ratios = Vec::new();
    for dq in [0.02, 0.1, 0.3] {
        for (pair, rolling) in creeping() {
            let rolling = Rolling { dq: Some(dq), ..rolling };
            ratios.extend(estimates_over_errors(pair, rolling, false));
        }
    }
    require_covered(ratios, 8.0);
}

/// The coarser grid rolls a tenth of its own elements where it cannot roll as little as the grid that
/// was asked for. Motions are compared over the same distance then too.
#[test]
fn motions_by_a_small_distance_are_compared_over_the_same_distance() {
    // Elements of 0.15 and 0.3, of which tenths are 0.015 and 0.03.
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-8);
    let estimated = |dq: f64| {
        let free = Rolling { creepage_x: None, dq: Some(dq), ..rolling(RollingHistory::Steady) };
        let mut scene = sphere(PAIR, free);
        let step = &mut scene.loading.steps[0];
        step.force_x = step.normal_force.map(|load| 0.12 * load);
        let (outcome, _) =
            solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
        assert_eq!(outcome.status, Status::Certified);
        outcome.estimate.unwrap().figures.shift.unwrap()
    };
    let [clamped, same] = [0.016, 0.031].map(estimated);
    assert!(clamped < 0.3 && clamped < 2.0 * same, "{clamped:e} {same:e}");
}

/// A distance that nothing else divides is divided by the elements, on every grid by those of the
/// grid that was asked for.
#[test]
fn a_distance_alone_is_divided_by_the_elements() {
    let creeping = Rolling { creepage_x: Some(0.008), ..rolling(RollingHistory::Transient) };
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-10);
    let run = |rolling: Rolling, increments: u32| {
        let mut scene = sphere(PAIR, rolling);
        scene.loading.steps[0].increments = increments;
        let surfaces = Surfaces::new();
        let outcome = solve(&scene, &numerics, &surfaces, &mut Operators::default()).unwrap().0;
        (outcome, contact::forecast(&scene, &numerics, &surfaces).unwrap())
    };
    // An element is 0.15 long.
    let (outcome, forecast) = run(Rolling { distance: Some(0.7), ..creeping }, 1);
    let (expected, expected_forecast) = run(Rolling { dq: Some(0.7 / 5.0), ..creeping }, 5);
    assert_eq!((outcome.steps.len(), forecast.increments), (5, 5));
    assert_eq!((&outcome, forecast), (&expected, expected_forecast));
    assert!(outcome.estimate.is_some());
    assert_eq!(run(Rolling { distance: Some(0.6), ..creeping }, 1).0.steps.len(), 4);
    let far = sphere(PAIR, Rolling { distance: Some(1e3), ..creeping });
    let error = solve(&far, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap_err();
    assert_eq!(error.key, "loading.steps[0].distance");
    assert_eq!(
        error.expected,
        "must leave at most 1000 increments on the path: elements of 1.500e-1 m divide it into \
         6.667e3; give `dq` or `increments`"
    );
    for (given, increments) in [
        (Rolling { distance: Some(1.0), dq: Some(0.1), ..creeping }, 1),
        (Rolling { distance: Some(1.0), ..creeping }, 2),
        (Rolling { distance: Some(1.0), history: RollingHistory::Steady, ..creeping }, 1),
        (Rolling { distance: Some(-1.0), ..creeping }, 1),
    ] {
        let mut scene = sphere(PAIR, given);
        scene.loading.steps[0].increments = increments;
        assert_eq!(scene.validate().unwrap_err().key, "loading.steps[0].distance", "{given:?}");
    }
}

/// The leading edge is where the material enters, and every increment that rolls has one.
#[test]
fn the_leading_edge_is_on_the_side_that_the_contact_travels_to() {
    let forward = Rolling { creepage_x: Some(0.008), ..rolling(RollingHistory::Transient) };
    let backward = Rolling { direction: RollingDirection::Backward, ..forward };
    let edges = |rolling: Rolling| {
        let mut scene = sphere(PAIR, rolling);
        let roll = scene.loading.steps[0];
        let press = Step { rolling: None, ..roll };
        scene.loading.steps = vec![press, Step { normal_force: None, increments: 2, ..roll }];
        let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-8);
        let (outcome, _) =
            solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
        outcome.further.leading_edges
    };
    // The contact has a radius of about 1, which are seven elements.
    let ahead = edges(forward);
    assert!(ahead.len() == 3 && ahead[0].is_none() && ahead[1] == ahead[2], "{ahead:?}");
    assert!((ahead[2].unwrap() - 1.05).abs() < 1e-12, "{ahead:?}");
    let behind = edges(backward);
    assert!((behind[2].unwrap() + 1.05).abs() < 1e-12, "{behind:?}");
}

/// Operators of many distances are kept within their budget, and so is their forecast.
#[test]
fn the_memory_of_many_distances_is_bounded() {
    let memory = |count: u32| {
        let roll = |number: u32| Step {
            rolling: Some(Rolling {
                creepage_x: Some(0.008),
                dq: Some(0.01 + 1e-4 * f64::from(number)),
                ..rolling(RollingHistory::Transient)
            }),
            ..Step::default()
        };
        let mut scene = sphere(PAIR, rolling(RollingHistory::Transient));
        scene.loading.steps.extend((0..count).map(roll));
        let numerics = numerics(Mesh::Across(256), Projection::Average, 1e-8);
        contact::forecast(&scene, &numerics, &Surfaces::new()).unwrap().memory
    };
    assert_eq!(memory(20), memory(40));
    assert!(memory(20) > memory(5) && memory(20) < 800_000_000, "{}", memory(20));
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
