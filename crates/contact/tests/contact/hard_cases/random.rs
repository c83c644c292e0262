//! Scenes of all kinds have sizes, stiffnesses and loads over many decades. Every one of them has
//! an end, and every one that counts as solved is solved.

use super::*;
use proptest::prelude::*;

/// Generates 10^exponent for exponents from `low` to `high`.
fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|exponent| 10f64.powf(exponent))
}

/// Generates a modulus in units of one modulus: ordinary most of the time, else far from it.
fn modulus() -> impl Strategy<Value = f64> {
    prop_oneof![3 => Just(1.0), 3 => decades(-3.0, 3.0), 1 => decades(-7.5, 7.5)]
}

fn poisson() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..=0.5,
        1 => Just(0.0),
        1 => Just(0.5),
        1 => decades(-12.0, -1.0).prop_map(|d| 0.5 - d),
    ]
}

fn material() -> impl Strategy<Value = Material> {
    (modulus(), poisson()).prop_map(|(shear_modulus, poisson)| Material { shear_modulus, poisson })
}

fn foundation() -> impl Strategy<Value = Foundation> {
    let layer = || {
        (material(), decades(-7.0, 7.0)).prop_map(|(material, thickness)| Layer {
            shear_modulus: material.shear_modulus,
            poisson: material.poisson,
            thickness,
        })
    };
    prop_oneof![
        (prop::collection::vec(layer(), 0..3), material())
            .prop_map(|(layers, base)| Foundation { layers, base: Base::Elastic(base) }),
        prop::collection::vec(layer(), 1..3)
            .prop_map(|layers| Foundation { layers, base: Base::Rigid }),
    ]
}

fn shape() -> impl Strategy<Value = Shape> {
    let side = || decades(-2.0, 2.0);
    prop_oneof![
        side().prop_map(|radius| Shape::Sphere { radius }),
        (side(), decades(-4.0, 4.0))
            .prop_map(|(radius_x, radius_y)| Shape::Ellipsoid { radius_x, radius_y }),
        (side(), side()).prop_map(|(width_x, width_y)| Shape::FlatRectangle { width_x, width_y }),
        side().prop_map(|radius| Shape::FlatDisk { radius }),
        (0.001..1.57).prop_map(|angle| Shape::Cone { angle }),
        (side(), side()).prop_map(|(width_x, width_y)| Shape::HeightMap {
            surface: "map".to_owned(),
            width_x,
            width_y
        }),
    ]
}

/// Generates no value, or a value of any size and sign.
fn either() -> impl Strategy<Value = Option<f64>> {
    let any = (decades(-8.0, 3.0), any::<bool>())
        .prop_map(|(size, positive)| if positive { size } else { -size });
    prop_oneof![3 => Just(None), 1 => Just(Some(0.0)), 2 => any.prop_map(Some)]
}

/// Generates the control of one degree of freedom in a step: none, a motion, or a force.
fn control() -> impl Strategy<Value = [Option<f64>; 2]> {
    (either(), any::<bool>())
        .prop_map(|(value, motion)| if motion { [value, None] } else { [None, value] })
}

/// Generates a step; its forces are in units of the foundation's modulus.
fn step() -> impl Strategy<Value = Step> {
    let pressing = prop_oneof![
        3 => decades(-8.0, 1.0).prop_map(|approach| [Some(approach), None]),
        1 => Just([Some(-1e-3), None]),
        3 => decades(-12.0, 2.0).prop_map(|force| [None, Some(force)]),
    ];
    (pressing, prop::array::uniform5(control()), 1u32..3).prop_map(
        |(n, [x, y, tx, ty, z], increments)| Step {
            approach: n[0],
            normal_force: n[1],
            shift_x: x[0],
            force_x: x[1],
            shift_y: y[0],
            force_y: y[1],
            tilt_x: tx[0],
            moment_x: tx[1],
            tilt_y: ty[0],
            moment_y: ty[1],
            twist: z[0],
            moment_z: z[1],
            increments,
            rolling: None,
        },
    )
}

fn mu() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => 0.0..1.0, 1 => decades(-14.0, 4.0)]
}

fn scenes() -> impl Strategy<Value = Scene> {
    let punch = (shape(), prop::option::weighted(0.3, material()))
        .prop_map(|(shape, material)| Punch { shape, material });
    let domain =
        prop::option::weighted(0.3, (decades(-3.0, 2.0), decades(-3.0, 2.0), -0.1..0.1, -0.1..0.1))
            .prop_map(|domain| {
                domain.map(|(width_x, width_y, center_x, center_y)| Domain {
                    width_x,
                    width_y,
                    center_x,
                    center_y,
                })
            });
    let unit = prop_oneof![Just(1.0), decades(-280.0, 280.0)];
    let path = prop::collection::vec(step(), 1..4);
    (foundation(), punch, mu(), domain, path, unit).prop_map(
        |(mut foundation, mut punch, mu, domain, mut steps, unit)| {
            let base = if let Base::Elastic(base) = &mut foundation.base {
                Some(&mut base.shear_modulus)
            } else {
                None
            };
            let layers = foundation.layers.iter_mut().map(|layer| &mut layer.shear_modulus);
            let moduli = layers
                .chain(base)
                .chain(punch.material.as_mut().map(|material| &mut material.shear_modulus));
            let forces = steps.iter_mut().flat_map(|step| {
                let Step { normal_force, force_x, force_y, moment_x, moment_y, moment_z, .. } =
                    step;
                [normal_force, force_x, force_y, moment_x, moment_y, moment_z].into_iter().flatten()
            });
            moduli.chain(forces).for_each(|value| *value *= unit);
            Scene {
                foundation,
                punch,
                friction: Friction { mu },
                wear: None,
                domain,
                loading: Loading::path(steps),
                interior: None,
            }
        },
    )
}

fn any_numerics() -> impl Strategy<Value = Numerics> {
    let mesh = prop::array::uniform2(1u32..17).prop_map(Mesh::Exact);
    let projection = prop_oneof![Just(Projection::Average), Just(Projection::Midpoint)];
    let epsilon = prop_oneof![3 => Just(0.0), 1 => decades(-16.0, 2.0)];
    let ceiling = prop_oneof![3 => Just(None), 1 => decades(-6.0, 3.0).prop_map(Some)];
    let method =
        prop_oneof![4 => Just(Method::Auto), 1 => Just(Method::Newton), 1 => Just(Method::Seidel)];
    (mesh, projection, epsilon, ceiling, method, decades(-10.0, -3.0)).prop_map(
        |(mesh, projection, epsilon, ceiling, method, tolerance)| Numerics {
            mesh,
            projection,
            epsilon,
            ceiling,
            method,
            tolerance,
            max_iterations: 300,
            simulate: Vec::new(),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, ..ProptestConfig::default() })]

    #[test]
    fn any_scene_ends_and_what_counts_as_solved_is(
        scene in scenes(),
        numerics in any_numerics(),
        seed in 0usize..1000,
    ) {
        let mut surfaces = Surfaces::new();
        let heights =
            (0..35).map(|pixel| ((pixel * 7919 + seed * 104_729) % 101) as f64 * 1e-4).collect();
        surfaces.insert("map".to_owned(), Arc::new(Surface::new(5, 7, heights).unwrap()));
        let case = Case { name: String::new(), scene, numerics, surfaces, end: Certified };
        match solve(&case.scene, &case.numerics, &case.surfaces, &mut Operators::default()) {
            Err(error) => prop_assert!(!error.expected.is_empty()),
            Ok((Outcome { status: Status::Failed { reason }, .. }, _)) => {
                prop_assert!(!reason.is_empty())
            }
            Ok((outcome, fields)) => prop_assert_eq!(flaw(&case, &outcome, &fields), None),
        }
    }
}
