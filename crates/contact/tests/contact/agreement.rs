//! Every method gives the same solution, under prescribed motions and under prescribed forces. A
//! path of forces gives a motion that, prescribed in its turn, gives these forces back.

use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Operators, solve};
use proptest::prelude::*;

fn solved_by(method: Method, scene: &Scene, mesh: Mesh) -> (StepOutcome, Fields) {
    certified(scene, &Numerics { method, ..numerics(mesh, Projection::Average, 1e-10) })
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let sphere = Shape::Sphere { radius: 1.0 };
    let disk = Shape::FlatDisk { radius: 1.0 };
    let pressed = Step { approach: Some(1.0), ..Step::default() };
    let flat = Step { approach: Some(0.01), ..Step::default() };
    let loaded = Step { normal_force: Some(3.8), ..Step::default() };
    vec![
        ("sphere", scene(sphere.clone(), 1.0, 0.3, 0.3, pressed)),
        ("sphere, much friction", scene(sphere.clone(), 1.0, 0.0, 3.0, pressed)),
        ("sphere, no friction", scene(sphere.clone(), 1.0, 0.3, 0.0, pressed)),
        (
            "sphere, shifted",
            scene(
                sphere.clone(),
                1.0,
                0.3,
                0.3,
                Step { shift_x: Some(0.1), shift_y: Some(0.04), ..pressed },
            ),
        ),
        (
            "sphere, uncoupled",
            scene(sphere.clone(), 1.0, 0.5, 0.3, Step { shift_x: Some(0.1), ..pressed }),
        ),
        (
            "sphere, sliding",
            scene(sphere.clone(), 1.0, 0.3, 0.2, Step { shift_x: Some(1.0), ..pressed }),
        ),
        (
            "sphere, twisted",
            scene(sphere.clone(), 1.0, 0.3, 0.3, Step { twist: Some(0.3), ..pressed }),
        ),
        ("disk", scene(disk.clone(), 1.0, 0.3, 0.1, flat)),
        (
            "disk, shifted",
            scene(disk.clone(), 1.0, 0.0, 0.8, Step { shift_x: Some(0.004), ..flat }),
        ),
        (
            "disk, on its edge",
            scene(disk.clone(), 1.0, 0.3, 0.3, Step { tilt_x: Some(0.02), ..flat }),
        ),
        (
            "ellipsoid",
            scene(
                Shape::Ellipsoid { radius_x: 1.0, radius_y: 0.1 },
                1.0,
                0.25,
                0.4,
                Step { shift_y: Some(0.1), ..pressed },
            ),
        ),
        ("load", scene(sphere.clone(), 1.0, 0.3, 0.3, loaded)),
        (
            "load and pull",
            scene(sphere.clone(), 1.0, 0.3, 0.3, Step { force_x: Some(0.5), ..loaded }),
        ),
        (
            "nearly sliding",
            scene(
                sphere.clone(),
                1.0,
                0.0,
                0.3,
                Step { force_x: Some(0.999 * 0.3 * 3.8), ..loaded },
            ),
        ),
        (
            "every force",
            scene(
                sphere,
                1.0,
                0.3,
                0.3,
                Step {
                    force_x: Some(0.5),
                    force_y: Some(-0.2),
                    moment_x: Some(0.1),
                    moment_y: Some(0.05),
                    moment_z: Some(0.1),
                    ..loaded
                },
            ),
        ),
        (
            "eccentric load on a disk",
            scene(
                disk,
                1.0,
                0.3,
                0.3,
                Step {
                    normal_force: Some(1.0),
                    moment_x: Some(0.5),
                    force_y: Some(0.1),
                    ..Step::default()
                },
            ),
        ),
    ]
}

#[test]
fn the_methods_agree() {
    for (name, scene) in scenes() {
        for n in [9, 20] {
            let (seidel, one) = solved_by(Method::Seidel, &scene, Mesh::Across(n));
            let (newton, other) = solved_by(Method::Newton, &scene, Mesh::Across(n));
            let off = difference(&one, &other);
            assert!(off < 1e-7, "{name}, {n}: {off:.1e}");
            assert_eq!(one.state, other.state, "{name}, {n}");
            let scale = seidel.motion.approach;
            for (a, b) in seidel.motion.per_dof().iter().zip(newton.motion.per_dof()) {
                assert!(
                    (a - b).abs() < 1e-7 * scale,
                    "{name}, {n}: {:?} {:?}",
                    seidel.motion,
                    newton.motion
                );
            }
        }
    }
}

#[test]
fn forces_give_the_motion_that_gives_the_forces() {
    for (name, scene) in scenes() {
        let (by_motion, fields) = solved_by(Method::Newton, &scene, Mesh::Across(16));
        let o = by_motion.observables;
        let mut forced = scene.clone();
        // As a rule the moments about the tilting axes cannot be prescribed, so they are left out.
        forced.loading.steps[0] = Step {
            normal_force: Some(o.load),
            force_x: Some(o.force_x),
            force_y: Some(o.force_y),
            ..scene.loading.steps[0]
        };
        let step = &mut forced.loading.steps[0];
        (step.approach, step.shift_x, step.shift_y) = (None, None, None);
        if forced.friction.mu == 0.0 || name == "sphere, sliding" {
            (step.force_x, step.force_y) = (None, None);
            (step.shift_x, step.shift_y) =
                (scene.loading.steps[0].shift_x, scene.loading.steps[0].shift_y);
        }
        forced.domain = Some(contact::punch::domain(&scene, &Surfaces::new()).unwrap());
        let (by_force, back) = solved_by(Method::Newton, &forced, Mesh::Across(16));
        if !matches!(scene.punch.shape, Shape::FlatDisk { .. }) {
            let off = difference(&fields, &back);
            assert!(off < 1e-6, "{name}: {off:.1e}");
        }
        assert!((by_force.observables.load / o.load - 1.0).abs() < 1e-9, "{name}");
    }
}

#[test]
fn fine_grids_are_solved_by_way_of_coarse_ones() {
    for (name, scene) in scenes() {
        let (outcome, _) = solved_by(Method::Newton, &scene, Mesh::Exact([75, 70]));
        assert!(outcome.work.operator_applications < 3000, "{name}: {:?}", outcome.work);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    /// On any scene Newton's method certifies every case that Seidel's does, with the same
    /// solution.
    #[test]
    fn on_any_scene(
        shape in 0usize..4,
        poisson in 0.0..=0.5,
        mu in 0.0..2.0f64,
        approach in 0.05..1.0f64,
        shift in prop::array::uniform2(-0.3..0.3f64),
        rotation in prop::array::uniform3(-0.05..0.05f64),
        mesh in prop::array::uniform2(3u32..14),
        epsilon in prop_oneof![Just(0.0), 1e-6..1e-2f64],
        ceiling in prop_oneof![Just(None), (0.1..2.0f64).prop_map(Some)],
    ) {
        let shape = match shape {
            0 => Shape::Sphere { radius: 1.0 },
            1 => Shape::Ellipsoid { radius_x: 1.0, radius_y: 0.3 },
            2 => Shape::FlatRectangle { width_x: 2.0, width_y: 1.0 },
            _ => Shape::Cone { angle: 0.4 },
        };
        let [tilt_x, tilt_y, twist] = rotation.map(Some);
        let step = Step {
            approach: Some(approach),
            shift_x: Some(shift[0]),
            shift_y: Some(shift[1]),
            tilt_x,
            tilt_y,
            twist,
            ..Step::default()
        };
        let scene = scene(shape, 1.0, poisson, mu, step);
        let numerics = Numerics {
            epsilon,
            ceiling,
            max_iterations: 5000,
            ..numerics(Mesh::Exact(mesh), Projection::Average, 1e-10)
        };
        let run = |method| {
            solve(
                &scene,
                &Numerics { method, ..numerics.clone() },
                &Surfaces::new(),
                &mut Operators::default(),
            )
            .unwrap()
        };
        let ((seidel, one), (newton, other)) = (run(Method::Seidel), run(Method::Newton));
        if seidel.status == Status::Certified {
            prop_assert_eq!(&newton.status, &Status::Certified);
            if seidel.last().unwrap().observables.load > 0.0 {
                prop_assert!(difference(&one, &other) < 1e-6, "{}", difference(&one, &other));
            }
        }
    }
}

/// When a contact is pulled lightly, most of it sticks. From slip of all elements to one side, a
/// Newton step leads to slip of all elements to the other side, for ever. The method has to find
/// out of that cycle by itself, whether there is a transverse direction (ν > 0) or not.
#[test]
fn a_light_pull_needs_no_other_method() {
    for poisson in [0.0, 0.3, 0.5] {
        let body = Material { shear_modulus: 80e9, poisson };
        let mut scene = scene(Shape::Sphere { radius: 0.01 }, 80e9, poisson, 0.3, Step::default());
        scene.foundation = Foundation::half_space(body);
        scene.punch.material = Some(body);
        scene.loading = Loading::path(vec![
            Step { approach: Some(1e-6), ..Step::default() },
            Step { shift_x: Some(1e-7), ..Step::default() },
        ]);
        for mesh in [8, 24, 48] {
            let (outcome, _) = solve(
                &scene,
                &numerics(Mesh::Across(mesh), Projection::Average, 1e-8),
                &Surfaces::new(),
                &mut Operators::default(),
            )
            .unwrap();
            assert_eq!(
                (&outcome.status, outcome.route()),
                (&Status::Certified, Some(Route::Newton)),
                "ν = {poisson}, mesh {mesh}"
            );
            let end = outcome.last().unwrap();
            assert!(
                end.work.iterations <= 20
                    && end.observables.stick_area > 0.5 * end.observables.contact_area,
                "{:?}",
                end.work
            );
        }
    }
}

/// Linear systems that were solved too loosely sent Newton's method round in circles, and into
/// Seidel sweeps that take minutes.
#[test]
fn many_elements_under_a_flat_disk_take_few_steps() {
    let pressed = Step { approach: Some(0.01), ..Step::default() };
    let pulled = Step { normal_force: Some(0.1), force_x: Some(0.02), ..Step::default() };
    for (step, mesh) in [(pressed, 224), (pulled, 200)] {
        let scene = scene(Shape::FlatDisk { radius: 1.0 }, 1.0, 0.3, 0.3, step);
        let numerics = numerics(Mesh::Across(mesh), Projection::Midpoint, 1e-8);
        let (outcome, _) =
            solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
        assert_eq!(
            (&outcome.status, outcome.route()),
            (&Status::Certified, Some(Route::Newton)),
            "{step:?}"
        );
        assert!(
            outcome.last().unwrap().work.iterations <= 15,
            "{:?}",
            outcome.last().unwrap().work
        );
    }
}

/// The mesh is large enough that every loop is shared between threads.
#[test]
fn a_solution_has_the_same_bytes_on_any_number_of_threads() {
    let force =
        Step { normal_force: Some(3.8), force_x: Some(0.5), force_y: Some(0.1), ..Step::default() };
    let scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.3, force);
    let numerics = numerics(Mesh::Across(190), Projection::Midpoint, 1e-8);
    let solved_on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            solve(&scene, &numerics, &Surfaces::default(), &mut Operators::default()).unwrap()
        })
    };
    let (outcome, fields) = solved_on(1);
    assert_eq!(outcome.status, Status::Certified);
    assert!(outcome.estimate.is_some());
    for threads in [2, 3] {
        // Every digit of a double goes into its debug text.
        assert_eq!(
            format!("{:?}", solved_on(threads)),
            format!("{:?}", (&outcome, &fields)),
            "{threads} threads"
        );
    }
}
