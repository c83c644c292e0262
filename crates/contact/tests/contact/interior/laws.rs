//! Laws of stresses below the surface: equilibrium, tractions on the surface, what meets at an
//! interface, mirror images, and the limits of depths, layers and Poisson's ratio.

use proptest::prelude::*;

use super::{half_space, spread};
use contact::interior::Subsurface;
use contact::model::*;

/// Returns a foundation of these layers (G, ν, thickness) on an elastic base (G, ν).
fn layers(layers: &[[f64; 3]], [shear_modulus, poisson]: [f64; 2]) -> Foundation {
    let layers = layers
        .iter()
        .map(|&[shear_modulus, poisson, thickness]| Layer { shear_modulus, poisson, thickness })
        .collect();
    Foundation { layers, base: Base::Elastic(Material { shear_modulus, poisson }) }
}

/// Returns a patch of tractions without symmetry.
fn patch() -> Fields {
    let mut fields = spread(6, [1.0, 0.8], [1.0, 0.3, -0.2], |x, y| 1.0 - 0.4 * x + 0.3 * y * y);
    fields.pressure[4] = 0.0;
    fields.traction_x[7] = 2.0;
    fields
}

fn largest(stress: &Stress) -> f64 {
    stress.components().into_iter().fold(0.0, |most, part| most.max(part.abs()))
}

fn difference(a: &Stress, b: &Stress) -> f64 {
    let parts = a.components().into_iter().zip(b.components());
    parts.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// Returns the derivatives of all components along an axis, by a difference of sixth order.
fn derivative(below: &Subsurface<'_>, place: [f64; 3], axis: usize, step: f64) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (n, weight) in [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)] {
        for sign in [1.0, -1.0] {
            let mut at = place;
            at[axis] += sign * n * step;
            let stress = below.at(at).unwrap().components();
            (0..6).for_each(|i| sum[i] += sign * weight * stress[i] / step);
        }
    }
    sum
}

/// Returns the residual of equilibrium, ∂σ_ij/∂x_j, over the largest derivative.
fn imbalance(below: &Subsurface<'_>, place: [f64; 3], step: f64) -> f64 {
    let d = [0, 1, 2].map(|axis| derivative(below, place, axis, step));
    let [xx, yy, zz, xy, yz, xz] = [0, 1, 2, 3, 4, 5];
    let forces = [
        d[0][xx] + d[1][xy] + d[2][xz],
        d[0][xy] + d[1][yy] + d[2][yz],
        d[0][xz] + d[1][yz] + d[2][zz],
    ];
    let size = d.iter().flatten().fold(0.0_f64, |most, part| most.max(part.abs()));
    forces.iter().fold(0.0_f64, |most, force| most.max(force.abs())) / size
}

/// Returns the Laplacian of σ_xx + σ_yy + σ_zz over the sum of its terms' sizes, which vanishes for
/// compatible strains.
fn incompatibility(below: &Subsurface<'_>, place: [f64; 3], step: f64) -> f64 {
    let trace = |place: [f64; 3]| {
        let stress = below.at(place).unwrap();
        stress.xx + stress.yy + stress.zz
    };
    let (mut sum, mut size) = (0.0, 0.0);
    for axis in 0..3 {
        let mut second = -2.0 * 49.0 / 36.0 * trace(place);
        for (n, weight) in [(1.0, 1.5), (2.0, -0.15), (3.0, 1.0 / 90.0)] {
            for sign in [1.0, -1.0] {
                let mut at = place;
                at[axis] += sign * n * step;
                second += weight * trace(at);
            }
        }
        sum += second;
        size += second.abs();
    }
    sum.abs() / size
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn a_half_space_is_in_equilibrium(
        poisson in prop_oneof![Just(0.0), Just(0.5), 0.0..0.5f64],
        x in -2.0..2.0f64,
        y in -2.0..2.0f64,
        z in 0.3..3.0f64,
    ) {
        let (foundation, fields) = (half_space(poisson), patch());
        let below = Subsurface::new(&foundation, &fields);
        let step = 0.03 * z.min(1.0);
        prop_assert!(imbalance(&below, [x, y, z], step) < 1e-6);
        prop_assert!(incompatibility(&below, [x, y, z], step) < 1e-5);
    }

    #[test]
    fn the_surface_carries_its_tractions(
        poisson in 0.0..=0.5f64,
        element in 0usize..36,
        pressures in prop::collection::vec(0.0..1.0f64, 36),
    ) {
        let foundation = half_space(poisson);
        let fields = Fields { pressure: pressures, ..patch() };
        let below = Subsurface::new(&foundation, &fields);
        let [nx, _] = fields.shape.map(|n| n as usize);
        let place = [0, 1].map(|i| {
            fields.origin[i] + [element % nx, element / nx][i] as f64 * fields.element[i]
        });
        let stress = below.at([place[0], place[1], 0.0]).unwrap();
        let size = largest(&stress).max(1.0);
        prop_assert!((stress.zz + fields.pressure[element]).abs() < 1e-13 * size);
        prop_assert!((stress.xz + fields.traction_x[element]).abs() < 1e-13 * size);
        prop_assert!((stress.yz + fields.traction_y[element]).abs() < 1e-13 * size);
    }
}

/// Within each layer and the base there is equilibrium and the strains are compatible; where two
/// materials meet, the tractions and the strains in the plane are those of both; and the surface
/// carries its tractions. There is one such state only.
#[test]
fn layers_are_elastic_and_bonded() {
    let fields = patch();
    for (stack, base) in [
        (vec![[4.0, 0.2, 0.5], [0.5, 0.45, 0.8]], [1.0, 0.3]),
        (vec![[0.2, 0.5, 0.6]], [1.0, 0.0]),
        (vec![[20.0, 0.3, 0.4]], [1.0, 0.5]),
    ] {
        let foundation = layers(&stack, base);
        let below = Subsurface::new(&foundation, &fields);
        let mut faces = vec![0.0];
        for layer in &stack {
            faces.push(faces.last().unwrap() + layer[2]);
        }
        let middles = faces.windows(2).map(|face| 0.5 * (face[0] + face[1]));
        let deep = faces.last().unwrap() + 0.7;
        for z in middles.chain([deep]) {
            for [x, y] in [[0.2, 0.1], [-1.4, 0.9]] {
                let residual = imbalance(&below, [x, y, z], 0.02);
                assert!(residual < 1e-6, "{stack:?} {x} {y} {z}: {residual:e}");
                let residual = incompatibility(&below, [x, y, z], 0.03);
                assert!(residual < 1e-4, "{stack:?} {x} {y} {z}: {residual:e}");
            }
        }
        let materials: Vec<[f64; 2]> =
            stack.iter().map(|layer| [layer[0], layer[1]]).chain([base]).collect();
        for (index, face) in faces.iter().enumerate().skip(1) {
            for [x, y] in [[0.2, 0.1], [-1.4, 0.9]] {
                // The lower side is that of a depth that is a rounding error greater.
                let sides = [*face, face * (1.0 + 1e-12)].map(|z| below.at([x, y, z]).unwrap());
                let size = largest(&sides[0]).max(largest(&sides[1]));
                let strains = [0, 1].map(|side: usize| {
                    let [g, nu] = materials[index - 1 + side];
                    let Stress { xx, yy, zz, xy, .. } = sides[side];
                    let young = 2.0 * g * (1.0 + nu);
                    [(xx - nu * (yy + zz)) / young, (yy - nu * (xx + zz)) / young, xy / (2.0 * g)]
                });
                let [above, beneath] = sides;
                for (a, b) in [
                    (above.zz, beneath.zz),
                    (above.xz, beneath.xz),
                    (above.yz, beneath.yz),
                    (strains[0][0], strains[1][0]),
                    (strains[0][1], strains[1][1]),
                    (strains[0][2], strains[1][2]),
                ] {
                    assert!(
                        (a - b).abs() < 1e-9 * size,
                        "{stack:?} {x} {y}: {sides:?} {strains:?}"
                    );
                }
            }
        }
        let surface = below.at([fields.origin[0], fields.origin[1], 0.0]).unwrap();
        let size = largest(&surface);
        for (stress, traction) in [
            (surface.zz, fields.pressure[0]),
            (surface.xz, fields.traction_x[0]),
            (surface.yz, fields.traction_y[0]),
        ] {
            assert!((stress + traction).abs() < 1e-10 * size, "{stack:?}: {surface:?}");
        }
    }
}

/// A plane by transforms has the direct sums at every element.
#[test]
fn planes_are_sums_over_elements() {
    let mut fields = patch();
    // The loaded elements are a part of the grid, off its middle.
    for e in (0..36).filter(|e| e % 6 == 0 || e / 6 > 3) {
        (fields.pressure[e], fields.traction_x[e], fields.traction_y[e]) = (0.0, 0.0, 0.0);
    }
    for foundation in [half_space(0.3), layers(&[[3.0, 0.2, 0.4]], [1.0, 0.4])] {
        let below = Subsurface::new(&foundation, &fields);
        for z in [0.0, 0.05, 0.4, 1.7] {
            let plane = below.plane(z).unwrap();
            let size = plane.stresses.iter().map(largest).fold(0.0, f64::max);
            for (e, stress) in plane.stresses.iter().enumerate() {
                let place =
                    [0, 1].map(|i| fields.origin[i] + [e % 6, e / 6][i] as f64 * fields.element[i]);
                let direct = below.at([place[0], place[1], z]).unwrap();
                assert!(difference(stress, &direct) < 1e-13 * size, "{z} {e}");
            }
        }
    }
}

/// A coating of nearly the base's material has nearly its stresses; one that is very thin, or very
/// thick, leaves those of the base, or those of its own half-space.
#[test]
fn layers_have_the_limits_of_half_spaces() {
    let fields = patch();
    let bare = |poisson: f64, place: [f64; 3]| {
        let foundation = half_space(poisson);
        Subsurface::new(&foundation, &fields).at(place).unwrap()
    };
    for place in [[0.2, 0.1, 0.3], [-1.4, 0.9, 0.5], [0.0, 3.0, 2.0]] {
        let nearly = layers(&[[1.0 + 1e-9, 0.3, 0.4]], [1.0, 0.3]);
        let stress = Subsurface::new(&nearly, &fields).at(place).unwrap();
        let exact = bare(0.3, place);
        assert!(difference(&stress, &exact) < 1e-8 * largest(&exact), "{place:?}");
        for (poisson, foundation) in [
            (0.3, layers(&[[5.0, 0.2, 1e-7]], [1.0, 0.3])),
            (0.2, layers(&[[5.0, 0.2, 1e6]], [1.0, 0.3])),
        ] {
            let stress = Subsurface::new(&foundation, &fields).at(place).unwrap();
            let exact = bare(poisson, place);
            let error = difference(&stress, &exact) / largest(&exact);
            assert!(error < 1e-5, "{place:?}: {error:e} {stress:?} {exact:?}");
        }
        // Layers on a rigid base: the half-space is the limit of depth.
        let deep = Foundation {
            layers: vec![Layer { shear_modulus: 2.0, poisson: 0.3, thickness: 1e5 }],
            base: Base::Rigid,
        };
        let stress = Subsurface::new(&deep, &fields).at(place).unwrap();
        assert!(difference(&stress, &exact) < 1e-5 * largest(&exact), "{place:?}");
        assert!(Subsurface::new(&deep, &fields).at([0.0, 0.0, 2e5]).is_none());
    }
}

/// Depths of 1e-6 of an element are as good as others, and so are distances of 1e6 elements.
#[test]
fn depths_far_from_an_elements_size_are_as_good_as_others() {
    for poisson in [0.0, 0.3, 0.5] {
        let (foundation, fields) = (half_space(poisson), patch());
        let below = Subsurface::new(&foundation, &fields);
        let [x, y] = [0, 1].map(|i| fields.origin[i] + 2.0 * fields.element[i]);
        let surface = below.at([x, y, 0.0]).unwrap();
        let slope = (below.at([x, y, 1e-3]).unwrap().zz - surface.zz) / 1e-3;
        for depth in [1e-6, 1e-9, 1e-12].map(|part| part * fields.element[0]) {
            let stress = below.at([x, y, depth]).unwrap();
            let allowed = 1e-13 + 20.0 * depth * slope.abs().max(1.0);
            assert!(
                difference(&stress, &surface) < allowed * largest(&surface),
                "{poisson} {depth}"
            );
        }
        let sum = |field: &[f64]| field.iter().sum::<f64>() * fields.element[0] * fields.element[1];
        let load = [&fields.pressure, &fields.traction_x, &fields.traction_y].map(|f| sum(f));
        // A point load's σ_ij = −3 F·r x_i x_j/2πρ⁵ in an incompressible half-space, and
        // everywhere for the components on a plane z = const.
        for place in [[3e5_f64, -2e5, 1e5], [0.0, 0.0, 3e5], [2e5, 1e5, 30.0]] {
            let [x, y, z] = place;
            let r = (x * x + y * y + z * z).sqrt();
            let factor = -3.0 * (load[0] * z + load[1] * x + load[2] * y)
                / (std::f64::consts::TAU * r.powi(5));
            let stress = below.at(place).unwrap();
            let size = largest(&stress);
            for (got, exact) in [(stress.zz, z * z), (stress.xz, x * z), (stress.yz, y * z)] {
                assert!((got - factor * exact).abs() < 2e-5 * size, "{poisson} {place:?}");
            }
            if poisson == 0.5 {
                for (got, exact) in [(stress.xx, x * x), (stress.yy, y * y), (stress.xy, x * y)] {
                    assert!((got - factor * exact).abs() < 2e-5 * size, "{place:?}");
                }
            }
        }
    }
}

/// The mirror image of tractions has the mirror image of the stresses, and reversed tractions have
/// the reverse.
#[test]
fn mirror_images_and_reversals_are_kept() {
    let fields = patch();
    let columns = |field: &[f64], sign: f64| -> Vec<f64> {
        field.chunks(6).flat_map(|row| row.iter().rev().map(move |value| sign * value)).collect()
    };
    let mirrored = Fields {
        pressure: columns(&fields.pressure, 1.0),
        traction_x: columns(&fields.traction_x, -1.0),
        traction_y: columns(&fields.traction_y, 1.0),
        ..fields.clone()
    };
    let minus = |field: &[f64]| field.iter().map(|value| -value).collect();
    let reversed = Fields {
        pressure: minus(&fields.pressure),
        traction_x: minus(&fields.traction_x),
        traction_y: minus(&fields.traction_y),
        ..fields.clone()
    };
    for foundation in [half_space(0.3), layers(&[[3.0, 0.2, 0.4]], [1.0, 0.4])] {
        for [x, y, z] in [[0.3, 0.2, 0.1], [-1.7, 0.4, 0.9]] {
            let at = |fields: &Fields, x: f64| {
                Subsurface::new(&foundation, fields).at([x, y, z]).unwrap()
            };
            let here = at(&fields, x);
            let image = at(&mirrored, -x);
            let back = Stress { xy: -image.xy, xz: -image.xz, ..image };
            assert!(difference(&here, &back) < 1e-12 * largest(&here), "{here:?} {image:?}");
            let against = at(&reversed, x);
            let sums = here.components().into_iter().zip(against.components());
            assert!(sums.into_iter().all(|(a, b)| a + b == 0.0), "{here:?} {against:?}");
        }
    }
}
