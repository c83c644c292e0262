//! Leaving out an effect that a scene does not call for changes nothing, and an effect that it does
//! call for is not left out.

use std::sync::Arc;

use crate::common::*;
use contact::model::*;
use contact::problem::Effects;
use contact::punch::{Surface, Surfaces};
use contact::{Operators, solve};
use proptest::prelude::*;

fn effects(scene: &Scene, numerics: &Numerics, surfaces: &Surfaces) -> Effects {
    let Mesh::Exact([nx, ny]) = numerics.mesh else { panic!("the tests give both") };
    Effects::of(scene, numerics, [nx as usize, ny as usize], surfaces).unwrap()
}

fn left_out(effects: &Effects) -> Vec<Effect> {
    Effect::OPTIONAL.into_iter().filter(|effect| !effects.has(*effect)).collect()
}

struct Solved {
    steps: Vec<StepOutcome>,
    fields: Fields,
    status: Status,
}

/// Solves the scene with the effects that it calls for and with every effect, and compares. Returns
/// the effects that were left out.
fn agree(scene: &Scene, mesh: [u32; 2]) -> Vec<Effect> {
    let lean_numerics = Numerics {
        simulate: Vec::new(),
        ..numerics(Mesh::Exact(mesh), Projection::Average, 1e-10)
    };
    let full_numerics = Numerics { simulate: Effect::OPTIONAL.to_vec(), ..lean_numerics.clone() };
    let run = |numerics: &Numerics| {
        let (outcome, fields) =
            solve(scene, numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
        Solved { steps: outcome.steps, fields, status: outcome.status }
    };
    let (lean, full) = (run(&lean_numerics), run(&full_numerics));
    assert_eq!(
        matches!(lean.status, Status::Certified),
        matches!(full.status, Status::Certified),
        "{:?} {:?} {scene:?}",
        lean.status,
        full.status
    );
    if lean.status == Status::Certified {
        let apart = difference(&lean.fields, &full.fields);
        assert!(apart < 1e-7, "{apart:.1e}: {scene:?}");
        for (step, all) in lean.steps.iter().zip(&full.steps) {
            for (a, b) in step.observables.resultants().iter().zip(all.observables.resultants()) {
                assert!(
                    (a - b).abs() <= 1e-7 * all.observables.load.max(1e-3),
                    "{:?} {:?}",
                    step.observables,
                    all.observables
                );
            }
            assert!(
                (step.observables.dissipation - all.observables.dissipation).abs()
                    <= 1e-7 * all.observables.energy.max(1e-6)
            );
        }
    }
    left_out(&effects(scene, &lean_numerics, &Surfaces::new()))
}

const STEEL: Material = Material { shear_modulus: 1.0, poisson: 0.3 };

fn sphere(poisson: f64, punch: Option<Material>, mu: f64, steps: &[Step]) -> Scene {
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, poisson, mu, Step::default());
    scene.punch.material = punch;
    scene.loading = Loading::path(steps.to_vec());
    scene.domain = Some(Domain { width_x: 3.0, width_y: 2.8, center_x: 0.0, center_y: 0.0 });
    scene
}

#[test]
fn each_reduction_is_taken_where_it_is_exact_and_changes_nothing() {
    use Effect::*;
    let press = Step { approach: Some(1.0), ..Step::default() };
    let along_x = Step { shift_x: Some(0.1), ..Step::default() };
    let along_y = Step { force_y: Some(0.3), ..Step::default() };
    let twist = Step { twist: Some(0.2), ..Step::default() };
    let tilt = Step { tilt_y: Some(0.05), ..Step::default() };
    let nothing_tangential = vec![Friction, Coupling, TractionX, TractionY, AsymmetryX, AsymmetryY];
    let even = [14, 12];
    assert_eq!(agree(&sphere(0.3, None, 0.0, &[press]), even), nothing_tangential, "no friction");
    assert_eq!(
        agree(&sphere(0.5, None, 0.3, &[press]), even),
        nothing_tangential,
        "incompressible and pressed only"
    );
    assert_eq!(
        agree(&sphere(0.3, Some(STEEL), 0.3, &[press]), even),
        nothing_tangential,
        "like bodies pressed only"
    );
    assert_eq!(agree(&sphere(0.3, None, 0.3, &[press]), even), [AsymmetryX, AsymmetryY]);
    assert_eq!(agree(&sphere(0.3, None, 0.3, &[press, along_x]), even), [AsymmetryY]);
    assert_eq!(agree(&sphere(0.3, None, 0.3, &[press, along_y]), even), [AsymmetryX]);
    assert_eq!(agree(&sphere(0.3, None, 0.3, &[press, twist]), even), []);
    assert_eq!(agree(&sphere(0.3, None, 0.3, &[press, tilt]), even), [AsymmetryY]);
    assert_eq!(
        agree(&sphere(0.3, Some(STEEL), 0.3, &[press, along_x]), even),
        [Coupling, AsymmetryX, AsymmetryY]
    );
    assert_eq!(agree(&sphere(0.3, Some(STEEL), 0.3, &[press, along_x, along_y]), even), [Coupling]);
    assert_eq!(
        agree(&sphere(0.3, Some(STEEL), 0.3, &[press, twist]), even),
        [Coupling, AsymmetryX, AsymmetryY]
    );
    assert_eq!(
        agree(&sphere(0.3, Some(STEEL), 0.3, &[press, twist, along_y]), even),
        [Coupling, AsymmetryY]
    );
    let like = Some(Material { shear_modulus: 1.0, poisson: 0.0 });
    assert_eq!(
        agree(&sphere(0.0, like, 0.3, &[press, along_x]), even),
        [Coupling, TractionY, AsymmetryX, AsymmetryY]
    );
    assert_eq!(
        agree(&sphere(0.0, like, 0.3, &[press, along_y, along_y]), even),
        [Coupling, TractionX, AsymmetryX, AsymmetryY]
    );
    assert_eq!(
        agree(&sphere(0.0, like, 0.3, &[press, along_x, tilt]), even),
        [Coupling, TractionY, AsymmetryY]
    );
    assert_eq!(
        agree(&sphere(0.0, like, 0.3, &[press, twist]), even),
        [Coupling, AsymmetryX, AsymmetryY]
    );
    // Loads replace motions, and the moments are zero.
    let loaded = Step {
        normal_force: Some(2.0),
        moment_x: Some(0.0),
        moment_y: Some(0.0),
        moment_z: Some(0.0),
        ..Step::default()
    };
    assert_eq!(agree(&sphere(0.3, None, 0.3, &[loaded]), even), [AsymmetryX, AsymmetryY]);
    assert_eq!(
        agree(
            &sphere(0.3, None, 0.3, &[loaded, Step { force_x: Some(0.3), ..Step::default() }]),
            even
        ),
        [AsymmetryY]
    );
    assert_eq!(
        agree(&sphere(0.3, Some(STEEL), 0.3, &[loaded, along_y]), even),
        [Coupling, AsymmetryX, AsymmetryY]
    );
}

#[test]
fn a_slightly_broken_symmetry_is_no_symmetry() {
    let press = Step { approach: Some(1.0), ..Step::default() };
    let has = |scene: &Scene, mesh: [u32; 2], surfaces: &Surfaces| {
        let effects =
            effects(scene, &numerics(Mesh::Exact(mesh), Projection::Average, 1e-9), surfaces);
        [Effect::AsymmetryX, Effect::AsymmetryY].map(|effect| effects.has(effect))
    };
    let none = Surfaces::new();
    let base = sphere(0.3, None, 0.3, &[press]);
    assert_eq!(has(&base, [8, 8], &none), [false, false]);
    assert_eq!(has(&base, [9, 8], &none), [true, false], "odd numbers of elements");
    let mut moved = base.clone();
    moved.domain.as_mut().unwrap().center_y = 1e-15;
    assert_eq!(has(&moved, [8, 8], &none), [false, true]);
    for (step, expected) in [
        (Step { tilt_x: Some(1e-300), ..press }, [false, true]),
        (Step { moment_y: Some(-1e-300), ..press }, [true, false]),
        (Step { shift_y: Some(1e-300), ..press }, [false, true]),
        (Step { twist: Some(1e-300), ..press }, [true, true]),
    ] {
        assert_eq!(has(&sphere(0.3, None, 0.3, &[step]), [8, 8], &none), expected, "{step:?}");
        assert_eq!(
            has(&sphere(0.3, None, 0.3, &[press, step, press]), [8, 8], &none),
            expected,
            "{step:?} on the way"
        );
    }
    let mut heights = vec![0.0, -1.0, 0.0, -1.0, -2.0, -1.0];
    let mut map = base.clone();
    map.punch.shape = Shape::HeightMap { surface: "map".to_owned(), width_x: 3.0, width_y: 2.8 };
    let with = |heights: &[f64]| {
        let mut surfaces = Surfaces::new();
        surfaces.insert("map".to_owned(), Arc::new(Surface::new(3, 2, heights.to_vec()).unwrap()));
        has(&map, [8, 8], &surfaces)
    };
    assert_eq!(with(&heights), [false, true]);
    heights[0] = 1e-300;
    assert_eq!(with(&heights), [true, true]);
    // A coupling that nearly cancels is there.
    let nearly = Material { shear_modulus: 1.0, poisson: 0.3 + 1e-16 };
    let like = sphere(0.3, Some(nearly), 0.3, &[press]);
    let decided = effects(&like, &numerics(Mesh::Exact([8, 8]), Projection::Average, 1e-9), &none);
    assert_eq!(decided.has(Effect::Coupling), nearly.poisson != 0.3);
}

#[test]
fn every_decision_has_its_reason() {
    let press = Step { approach: Some(1.0), ..Step::default() };
    let numerics = numerics(Mesh::Exact([8, 8]), Projection::Average, 1e-9);
    let decided = effects(&sphere(0.3, None, 0.3, &[press]), &numerics, &Surfaces::new());
    assert_eq!(
        decided.decisions().iter().map(|decision| decision.effect).collect::<Vec<_>>(),
        Effect::ALL
    );
    assert!(decided.decisions().iter().all(|decision| !decision.reason.is_empty()));
    let refused = Numerics { simulate: vec![Effect::Ceiling], ..numerics };
    assert_eq!(refused.validate().unwrap_err().key, "simulate");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// On any scene the reduced problem has the solution of the full one.
    #[test]
    fn reduced_is_full(
        shape in 0usize..4,
        bodies in 0usize..5,
        mu in prop_oneof![Just(0.0), 0.05..1.0f64],
        loads in prop::collection::vec((0usize..7, 0.02..0.3f64), 0..3),
        mesh in prop::array::uniform2(4u32..13),
        center in prop_oneof![3 => Just([0.0, 0.0]), 1 => Just([0.1, 0.0]), 1 => Just([0.0, -0.1])],
    ) {
        let shape = match shape {
            0 => Shape::Sphere { radius: 1.0 },
            1 => Shape::Ellipsoid { radius_x: 1.0, radius_y: 0.4 },
            2 => Shape::FlatRectangle { width_x: 2.0, width_y: 1.4 },
            _ => Shape::Cone { angle: 0.4 },
        };
        let mut steps = vec![Step { approach: Some(0.6), ..Step::default() }];
        for (kind, value) in loads {
            steps.push(match kind {
                0 => Step { shift_x: Some(value), ..Step::default() },
                1 => Step { shift_y: Some(-value), ..Step::default() },
                2 => Step { twist: Some(value), ..Step::default() },
                3 => Step { tilt_x: Some(0.2 * value), ..Step::default() },
                4 => Step { tilt_y: Some(0.2 * value), ..Step::default() },
                5 => Step { force_x: Some(0.05 * value), ..Step::default() },
                _ => Step { approach: Some(0.6 + value), ..Step::default() },
            });
        }
        let mut scene = scene(shape, 1.0, 0.3, mu, Step::default());
        scene.loading = Loading::path(steps);
        scene.domain =
            Some(Domain { width_x: 2.6, width_y: 2.0, center_x: center[0], center_y: center[1] });
        match bodies {
            0 => scene.punch.material = Some(STEEL),
            1 => {
                scene.foundation =
                    Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.5 })
            }
            2 => {
                let cork = Material { shear_modulus: 1.0, poisson: 0.0 };
                (scene.foundation, scene.punch.material) =
                    (Foundation::half_space(cork), Some(cork));
            }
            3 => {
                scene.foundation.layers =
                    vec![Layer { shear_modulus: 3.0, poisson: 0.2, thickness: 0.4 }]
            }
            _ => {}
        }
        agree(&scene, mesh);
    }
}
