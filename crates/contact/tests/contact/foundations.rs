//! Layered foundations meet reference solutions that use no boundary elements (tests/reference),
//! and obey the laws of a layered foundation as a scene.

use crate::common::*;
use contact::model::*;
use std::f64::consts::PI;

/// Returns a layer given by E₁/E₀ over a half-space with E₀ = 1, or on a rigid base.
fn foundation(ratio: Option<f64>, nu: [f64; 2], thickness: f64) -> Foundation {
    let shear = |young: f64, poisson: f64| young / (2.0 * (1.0 + poisson));
    Foundation {
        layers: vec![Layer {
            shear_modulus: shear(ratio.unwrap_or(1.0), nu[0]),
            poisson: nu[0],
            thickness,
        }],
        base: ratio.map_or(Base::Rigid, |_| {
            Base::Elastic(Material { shear_modulus: shear(1.0, nu[1]), poisson: nu[1] })
        }),
    }
}

fn pressed(shape: Shape, foundation: &Foundation, mu: f64, approach: f64) -> Scene {
    let mut scene =
        scene(shape, 1.0, 0.0, mu, Step { approach: Some(approach), ..Step::default() });
    scene.foundation = foundation.clone();
    scene
}

fn solved(scene: &Scene, mesh: u32) -> Observables {
    certified(scene, &numerics(Mesh::Across(mesh), Projection::Average, 1e-7)).0.observables
}

/// The approach of the flat disks, whose radius is 1; nothing but scale depends on it.
const APPROACH: f64 = 1e-3;

/// Returns κ = F(1−ν₁)/4G₁aδ of a flat disk, with its observables.
fn kappa(foundation: &Foundation, mu: f64, mesh: u32) -> (f64, Observables) {
    let layer = foundation.layers[0];
    let o = solved(&pressed(Shape::FlatDisk { radius: 1.0 }, foundation, mu, APPROACH), mesh);
    (0.25 * o.load * (1.0 - layer.poisson) / (layer.shear_modulus * APPROACH), o)
}

/// Returns Φ = 3F(1−ν₁)R/8G₁a³ of a sphere with R = 1, at the approach χ at which a = 1, and the
/// contact radius found.
fn phi(foundation: &Foundation, chi: f64, mesh: u32) -> (f64, f64) {
    let layer = foundation.layers[0];
    let mut scene = pressed(Shape::Sphere { radius: 1.0 }, foundation, 0.0, chi);
    scene.domain = square(2.5);
    let o = solved(&scene, mesh);
    (0.375 * o.load * (1.0 - layer.poisson) / layer.shear_modulus, (o.contact_area / PI).sqrt())
}

const MESHES: [u32; 3] = [12, 24, 48];

/// Returns the order over two refinements by 2.
fn order(errors: &[f64]) -> f64 {
    (errors[0] / errors[2]).abs().log2() / 2.0
}

/// Asserts a row of a table for the flat disk and the sphere. The flat disk's load converges at
/// first order, as its edge singularity has it.
fn meets(name: &str, foundation: &Foundation, flat: Option<f64>, chi: f64, sphere: f64) {
    if let Some(flat) = flat {
        let errors = MESHES.map(|n| kappa(foundation, 0.0, n).0 / flat - 1.0);
        // The thinnest layers are half as thick as the elements of the coarsest mesh.
        assert!(
            order(&errors) > 0.75 && errors[2].abs() < 6e-3,
            "{name}: flat {errors:?}, order {:.2}",
            order(&errors)
        );
    }
    let (found, radius) = phi(foundation, chi, 48);
    assert!((found / sphere - 1.0).abs() < 2e-3, "{name}: sphere {:.1e}", found / sphere - 1.0);
    assert!((radius - 1.0).abs() < 0.5 * 2.5 / 48.0, "{name}: contact radius {radius}");
}

#[test]
fn a_layer_on_a_rigid_base() {
    let mut rows = 0;
    for line in reference("rigid_base_layer.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| cells[column].parse::<f64>().unwrap();
        assert_eq!(cells[2], "bonded");
        meets(
            line,
            &foundation(None, [number(0), 0.0], 1.0 / number(1)),
            Some(number(3)),
            number(4),
            number(5),
        );
        rows += 1;
    }
    assert_eq!(rows, 84);
}

/// Reads E₁/E₀ and the Poisson's ratios from a case's name: `E1/E0=0.1 nu1=nu0=0.3`, `E1/E0=2
/// nu1=0.25 nu0=0.35`, `E1/E0=10 nu=.3/.3`.
fn named(case: &str) -> (f64, [f64; 2]) {
    let after = |key: &str| {
        case.split(key)
            .nth(1)
            .and_then(|rest| rest.split([' ', '/']).next())
            .and_then(|text| text.parse::<f64>().ok())
    };
    let below = after("nu0=").or(after("nu=")).expect("a Poisson's ratio");
    (after("E1/E0=").expect("a ratio"), [after("nu1=").unwrap_or(below), below])
}

#[test]
fn a_coating_on_a_half_space() {
    let mut rows = 0;
    for line in reference("layered_frictionless.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| cells[column].parse::<f64>().unwrap();
        let (ratio, nu) = named(cells[0]);
        // The table's flat punch may pull; on a stiff and thin layer a real one lifts off instead,
        // as the next test shows.
        let flat = (ratio < 10.0 || number(1) < 1.0).then(|| number(2));
        meets(line, &foundation(Some(ratio), nu, 1.0 / number(1)), flat, number(3), number(4));
        rows += 1;
    }
    assert_eq!(rows, 29);
}

/// The source finds that the sole of a flat punch lifts off a stiff layer within a disk around its
/// middle.
#[test]
fn a_flat_sole_separates_from_a_stiff_layer() {
    for line in reference("flat_punch_separation.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| cells[column].parse::<f64>().unwrap();
        let (ratio, nu) = named(cells[0]);
        let foundation = foundation(Some(ratio), nu, 1.0 / number(1));
        let (mut errors, mut shown) = (Vec::new(), Vec::new());
        for n in [24, 48, 96] {
            let (kappa, o) = kappa(&foundation, 0.0, n);
            errors.push(kappa / number(2) - 1.0);
            let radius = ((o.sole_area - o.contact_area) / PI).sqrt();
            shown.push((
                (radius - number(3)) / o.element_x,
                o.largest_gap / APPROACH / number(4) - 1.0,
            ));
            assert!(
                (radius - number(3)).abs() < 0.75 * o.element_x,
                "{line}, {n}: separated within {radius}"
            );
        }
        eprintln!("{line}: load {errors:?}, (radius in elements, gap) {shown:?}");
        assert!(order(&errors) > 0.8 && errors[2].abs() < 4e-3, "{line}: {errors:?}");
        assert!(shown[2].1.abs() < 0.03, "{line}: {shown:?}");
    }
}

#[test]
fn a_flat_punch_with_friction_on_a_layer() {
    for line in reference("flat_punch_friction_layered.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| cells[column].parse::<f64>().unwrap();
        let after = |key: &str| {
            cells[0]
                .split(key)
                .nth(1)
                .map(|rest| rest.split(' ').next().unwrap().parse::<f64>().unwrap())
        };
        let foundation = foundation(after("E1/E0="), [after("nu=").unwrap(); 2], 1.0 / number(1));
        let mut errors = Vec::new();
        for n in MESHES {
            let (kappa, o) = kappa(&foundation, number(2), n);
            errors.push(kappa / number(4) - 1.0);
            let off = ((o.stick_area / PI).sqrt() - number(3)) / o.element_x;
            assert!(off.abs() < 0.75, "{line}, {n}: stick radius off by {off:.2} elements");
        }
        eprintln!("{line}: {errors:?}, order {:.2}", order(&errors));
        assert!(order(&errors) > 0.8 && errors[2].abs() < 6e-3, "{line}: {errors:?}");
    }
}

/// Returns a scene of a sphere with every effect: friction, coupling, shifts, a tilt, a twist.
fn everything(foundation: &Foundation) -> Scene {
    let step = Step {
        approach: Some(0.5),
        shift_x: Some(0.05),
        shift_y: Some(0.02),
        tilt_y: Some(0.02),
        twist: Some(0.03),
        ..Step::default()
    };
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.4, step);
    (scene.foundation, scene.domain) = (foundation.clone(), square(2.4));
    scene
}

fn fields(scene: &Scene) -> Fields {
    certified(scene, &numerics(Mesh::Across(20), Projection::Average, 1e-11)).1
}

const BASE: Material = Material { shear_modulus: 1.0, poisson: 0.3 };

fn layer(shear_modulus: f64, poisson: f64, thickness: f64) -> Layer {
    Layer { shear_modulus, poisson, thickness }
}

#[test]
fn layers_of_the_bases_material_are_the_half_space() {
    let half_space = fields(&everything(&Foundation::half_space(BASE)));
    let five: Vec<Layer> = [0.1, 0.02, 0.5, 1.0, 0.3].map(|h| layer(1.0, 0.3, h)).into();
    let equal = Foundation { layers: five.clone(), base: Base::Elastic(BASE) };
    assert!(difference(&half_space, &fields(&everything(&equal))) < 1e-12);
    // Nearly equal layers go through all of the layers' machinery.
    let jitter = [1e-9, -1e-9, 2e-9, 0.0, 1e-9];
    let nearly = five
        .iter()
        .zip(jitter)
        .map(|(five, jitter)| Layer { shear_modulus: 1.0 + jitter, ..*five })
        .collect();
    let nearly = fields(&everything(&Foundation { layers: nearly, base: Base::Elastic(BASE) }));
    assert!(difference(&half_space, &nearly) < 1e-7, "{:.1e}", difference(&half_space, &nearly));
}

#[test]
fn a_layer_cut_into_five_is_the_layer() {
    for base in [Base::Rigid, Base::Elastic(BASE)] {
        let whole = fields(&everything(&Foundation { layers: vec![layer(3.0, 0.25, 1.0)], base }));
        let cut = |jitter: f64| -> Foundation {
            let layers = [0.1, 0.2, 0.3, 0.25, 0.15]
                .iter()
                .enumerate()
                .map(|(i, h)| layer(3.0 * (1.0 + jitter * i as f64), 0.25, *h));
            Foundation { layers: layers.collect(), base }
        };
        assert!(difference(&whole, &fields(&everything(&cut(0.0)))) < 1e-9);
        let nearly = difference(&whole, &fields(&everything(&cut(1e-9))));
        assert!(nearly < 1e-7, "{nearly:.1e}");
    }
}

/// A base far below is felt as the inverse of its depth, and a thin coating in proportion to its
/// thickness.
#[test]
fn thick_layers_hide_the_base_and_thin_ones_vanish() {
    let base = Base::Elastic(BASE);
    let coated =
        |thickness: f64| everything(&Foundation { layers: vec![layer(4.0, 0.2, thickness)], base });
    let alone =
        fields(&everything(&Foundation::half_space(Material { shear_modulus: 4.0, poisson: 0.2 })));
    let below = fields(&everything(&Foundation::half_space(BASE)));
    let thick: Vec<f64> =
        [1e2, 1e3, 1e4, 1e12].iter().map(|h| difference(&alone, &fields(&coated(*h)))).collect();
    let thin: Vec<f64> = [1e-3, 1e-4, 1e-5, 1e-12]
        .iter()
        .map(|h| difference(&below, &fields(&coated(*h))))
        .collect();
    eprintln!("thick {thick:?}, thin {thin:?}");
    for errors in [&thick, &thin] {
        assert!(
            errors[0] < 0.1
                && errors[1] < 0.2 * errors[0]
                && errors[2] < 0.2 * errors[1]
                && errors[3] < 1e-8,
            "{thick:?} {thin:?}"
        );
    }
}

#[test]
fn a_layered_foundation_looks_the_same_from_every_side() {
    let foundation = Foundation {
        layers: vec![layer(5.0, 0.2, 0.3), layer(0.5, 0.45, 0.6)],
        base: Base::Elastic(BASE),
    };
    let plain = everything(&foundation);
    let with = |change: &dyn Fn(&mut Step)| {
        let mut scene = plain.clone();
        change(&mut scene.loading.steps[0]);
        fields(&scene)
    };
    let minus = |x: Option<f64>| x.map(|x| -x);
    let mirrored = with(&|s| {
        (s.shift_x, s.tilt_y, s.twist) = (minus(s.shift_x), minus(s.tilt_y), minus(s.twist))
    });
    let turned = with(&|s| {
        (s.shift_x, s.shift_y) = (minus(s.shift_y), s.shift_x);
        (s.tilt_x, s.tilt_y) = (minus(s.tilt_y), s.tilt_x);
    });
    let plain = with(&|_| ());
    let n = 20;
    let peak = plain.pressure.iter().copied().fold(0.0, f64::max);
    for j in 0..n {
        for i in 0..n {
            let (here, mirror, turn) = (j * n + i, j * n + (n - 1 - i), i * n + (n - 1 - j));
            let pairs = [
                (plain.pressure[here], mirrored.pressure[mirror]),
                (plain.traction_x[here], -mirrored.traction_x[mirror]),
                (plain.traction_y[here], mirrored.traction_y[mirror]),
                (plain.pressure[here], turned.pressure[turn]),
                (plain.traction_x[here], turned.traction_y[turn]),
                (plain.traction_y[here], -turned.traction_x[turn]),
            ];
            assert!(
                pairs.iter().all(|(a, b)| (a - b).abs() < 1e-8 * peak),
                "({i}, {j}): {pairs:?}"
            );
        }
    }
}

/// A punch that sticks all over and lifts off nowhere makes a linear problem, so the answers to
/// motions add.
#[test]
fn motions_of_a_sticking_sole_superpose() {
    let foundation = Foundation { layers: vec![layer(0.3, 0.4, 0.5)], base: Base::Elastic(BASE) };
    let tractions = |step: Step| {
        let mut scene = scene(Shape::FlatDisk { radius: 1.0 }, 1.0, 0.3, 1e3, step);
        scene.foundation = foundation.clone();
        let (end, fields) =
            certified(&scene, &numerics(Mesh::Across(16), Projection::Average, 1e-11));
        assert_eq!(end.observables.stick_area, end.observables.sole_area);
        fields
    };
    let press = Step { approach: Some(0.01), ..Step::default() };
    let motions = [
        Step { shift_x: Some(1e-3), ..press },
        Step { shift_y: Some(-5e-4), ..press },
        Step { twist: Some(5e-4), ..press },
        Step { tilt_x: Some(2e-4), ..press },
    ];
    let together = tractions(Step {
        shift_x: Some(1e-3),
        shift_y: Some(-5e-4),
        twist: Some(5e-4),
        tilt_x: Some(2e-4),
        ..press
    });
    let alone = tractions(press);
    let mut sum = alone.clone();
    for motion in motions {
        let moved = tractions(motion);
        for (sum, moved, alone) in [
            (&mut sum.pressure, &moved.pressure, &alone.pressure),
            (&mut sum.traction_x, &moved.traction_x, &alone.traction_x),
            (&mut sum.traction_y, &moved.traction_y, &alone.traction_y),
        ] {
            sum.iter_mut()
                .zip(moved.iter().zip(alone))
                .for_each(|(sum, (moved, alone))| *sum += moved - alone);
        }
    }
    assert!(difference(&together, &sum) < 1e-8, "{:.1e}", difference(&together, &sum));
}
