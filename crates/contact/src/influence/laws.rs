//! Laws that every [`Influence`] obeys; each implementation runs them on the same cases.

use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use super::components::Components;
use super::mirror::{Mirror, Symmetry};
use super::operator::{Influence, Scratch};
use super::table::InfluenceTable;
use crate::foundation::{Bodies, HalfSpace};
use crate::grid::Grid;
use crate::model::{Base, Layer, Material, Projection};

/// The largest error relative to the largest displacement.
const ROUNDING: f64 = 2e-13;

/// A grid as numbers, so that a law can turn or mirror it, two bodies, and two fields.
#[derive(Clone, Debug)]
struct Case {
    n: [usize; 2],
    h: [f64; 2],
    inside: Vec<bool>,
    layers: Vec<Layer>,
    base: Base,
    punch: Material,
    projection: Projection,
    components: Components,
    mirror: Mirror,
    p: Vec<f64>,
    q: Vec<f64>,
}

impl Case {
    fn grid(&self) -> Grid {
        Grid::new(self.n[0], self.n[1], self.h[0], self.h[1], [0.0; 2])
            .unwrap()
            .with_mask(self.inside.clone())
            .unwrap()
    }

    fn bodies(&self) -> Bodies {
        Bodies::new(&self.layers, &self.base, Some(&self.punch))
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let material = || {
        (0.5..2.0, prop_oneof![Just(0.0), Just(0.5), 0.0..0.5])
            .prop_map(|(shear_modulus, poisson)| Material { shear_modulus, poisson })
    };
    let thickness = || (-2.5..2.0).prop_map(|exponent: f64| 10_f64.powf(exponent));
    let layer = move || {
        (material(), thickness()).prop_map(|(m, thickness)| Layer {
            shear_modulus: m.shear_modulus,
            poisson: m.poisson,
            thickness,
        })
    };
    let foundation = prop_oneof![
        material().prop_map(|m| (Vec::new(), Base::Elastic(m))),
        (
            proptest::collection::vec(layer(), 1..4),
            prop_oneof![Just(Base::Rigid), material().prop_map(Base::Elastic)]
        ),
    ];
    let side = || prop_oneof![Just(1_usize), 2..14_usize];
    (side(), side()).prop_flat_map(move |(nx, ny)| {
        let k = nx * ny;
        let mask = prop_oneof![
            Just(vec![true; k]),
            proptest::collection::vec(prop::bool::weighted(0.7), k)
        ];
        let field = || proptest::collection::vec(-1.0..1.0, 3 * k);
        let size = || (-1.5..1.5).prop_map(|exponent: f64| 10_f64.powf(exponent));
        let projection = prop_oneof![Just(Projection::Average), Just(Projection::Midpoint)];
        let reduced = (prop::sample::select(component_sets()), prop::sample::select(mirrors()));
        let fields = (reduced, field(), field());
        (
            size(),
            prop_oneof![Just(None), size().prop_map(Some)],
            mask,
            foundation.clone(),
            material(),
            projection,
            fields,
        )
            .prop_map(
                move |(
                    hx,
                    hy,
                    inside,
                    (layers, base),
                    punch,
                    projection,
                    ((components, mirror), p, q),
                )| Case {
                    n: [nx, ny],
                    h: [hx, hy.unwrap_or(hx)], // Half the elements are square.
                    inside,
                    layers,
                    base,
                    punch,
                    projection,
                    components,
                    mirror,
                    p,
                    q,
                },
            )
    })
}

/// The implementation under test, made from a table.
type Build = fn(&InfluenceTable, Components, Mirror) -> Box<dyn Influence>;

/// Returns every set of components: each choice of directions, the normal one with and without
/// coupling.
fn component_sets() -> Vec<Components> {
    let members = (1..8).map(|bits| [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0]);
    let mut sets: Vec<Components> = members
        .flat_map(|members| [Components::of(members), Components::of(members).uncoupled()])
        .collect();
    sets.dedup();
    sets
}

/// Returns every choice of planes and symmetries.
fn mirrors() -> Vec<Mirror> {
    let each = [None, Some(Symmetry::Symmetric), Some(Symmetry::Antisymmetric)];
    each.into_iter().flat_map(|x| each.map(|y| Mirror { x, y })).collect()
}

/// Checks all laws on random cases and on grids that are a single element, a row, and a column.
pub(crate) fn hold(build: Build) {
    let mut runner =
        TestRunner::new(Config { cases: 96, failure_persistence: None, ..Config::default() });
    let checked = runner.run(&cases(), |case| {
        check(build, &case);
        Ok(())
    });
    checked.unwrap_or_else(|error| panic!("{error}"));
    for n in [[1, 1], [1, 9], [17, 1], [40, 23]] {
        let k = n[0] * n[1];
        let wave =
            |phase: f64| (0..3 * k).map(|e| (e as f64 * 1.7 + phase).sin()).collect::<Vec<_>>();
        for projection in [Projection::Average, Projection::Midpoint] {
            let case = Case {
                n,
                h: [0.1, 0.3],
                inside: (0..k).map(|e| e % 5 != 1).collect(),
                layers: Vec::new(),
                base: Base::Elastic(Material { shear_modulus: 1.0, poisson: 0.3 }),
                punch: Material { shear_modulus: 4.0, poisson: 0.1 },
                projection,
                components: Components::ALL,
                mirror: Mirror::NONE,
                p: wave(0.0),
                q: wave(1.0),
            };
            check(build, &case);
            if k < 100 {
                for (components, mirror) in component_sets()
                    .into_iter()
                    .flat_map(|set| mirrors().into_iter().map(move |mirror| (set, mirror)))
                {
                    check_reduced(build, &Case { components, mirror, ..case.clone() });
                }
            }
        }
    }
}

/// Checks that 1, 2, 3 and 7 threads give the same bytes.
pub(crate) fn same_on_any_number_of_threads(build: Build) {
    for n in [[33, 20], [2, 50], [1, 1], [50, 2]] {
        let grid = Grid::new(n[0], n[1], 1.0, 0.5, [0.0; 2]).unwrap().masked_by(|x, _| x != 16.0);
        let (material, layer) = (
            Material { shear_modulus: 1.0, poisson: 0.2 },
            Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.7 },
        );
        let bodies = Bodies::new(&[layer], &Base::Elastic(material), None);
        let table = InfluenceTable::new(&grid, &bodies, Projection::Average);
        for mirror in mirrors().into_iter().filter(|mirror| mirror.part(&grid).is_ok()) {
            for components in [Components::ALL, Components::TANGENTIAL, Components::NORMAL] {
                let operator = build(&table, components, mirror);
                let p: Vec<f64> = (0..components.len() * operator.grid().len())
                    .map(|e| (e as f64 * 0.7).sin())
                    .collect();
                let displacement = |threads| {
                    let mut out = vec![f64::NAN; p.len()];
                    operator.apply(&mut out, &p, &mut Scratch::with_threads(&*operator, threads));
                    out
                };
                let single = displacement(1);
                assert!(single.iter().all(|u| u.is_finite()));
                for threads in [2, 3, 7] {
                    assert_eq!(
                        displacement(threads),
                        single,
                        "{n:?} on {threads} threads, {components:?}, {mirror:?}"
                    );
                }
            }
        }
    }
}

fn check(build: Build, case: &Case) {
    let grid = case.grid();
    let a = operator(build, &grid, &case.bodies(), case.projection);
    let ap = apply(&*a, &case.p);
    let aq = apply(&*a, &case.q);
    let size = ap.iter().chain(&aq).fold(0.0_f64, |m, u| m.max(u.abs()));

    is_the_sum_over_sources(case, &ap, size);
    leaves_masked_elements_alone(case, &*a, &ap);
    is_self_adjoint_and_non_negative(case, &ap, &aq, size);
    is_linear(case, &*a, &ap, &aq, size);
    check_reduced(build, case);
    mirrored_loads_have_mirrored_displacements(build, case, &ap, size);
    turns(build, case, &ap, size);
    is_the_same_everywhere(build, case, size);
    superposes_bodies(build, case, &ap, size);
    scales(build, case, &ap);
}

fn check_reduced(build: Build, case: &Case) {
    keeps_to_its_components(build, case);
    a_part_says_everything(build, case);
}

fn operator(
    build: Build,
    grid: &Grid,
    bodies: &Bodies,
    projection: Projection,
) -> Box<dyn Influence> {
    build(&InfluenceTable::new(grid, bodies, projection), Components::ALL, Mirror::NONE)
}

/// Returns A p, computed in memory that held something else before.
pub(super) fn apply(a: &dyn Influence, p: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; p.len()];
    let mut scratch = Scratch::new(a);
    a.apply(&mut out, &vec![1e3; p.len()], &mut scratch);
    a.apply(&mut out, p, &mut scratch);
    out
}

pub(super) fn close(law: &str, got: &[f64], expected: &[f64], size: f64) {
    assert_eq!(got.len(), expected.len());
    for (e, (got, expected)) in got.iter().zip(expected).enumerate() {
        assert!(
            (got - expected).abs() <= ROUNDING * size,
            "{law}: {got} instead of {expected} at {e}"
        );
    }
}

/// Compares with the definition, with coefficients that have not been through a table.
fn is_the_sum_over_sources(case: &Case, ap: &[f64], size: f64) {
    let (grid, k) = (case.grid(), case.grid().len());
    let kernels =
        case.bodies().kernels((case.n[0] as f64 * case.h[0]).hypot(case.n[1] as f64 * case.h[1]));
    let mut expected = vec![0.0; 3 * k];
    for receiver in grid.active() {
        let (ri, rj) = grid.position(receiver);
        for source in grid.active() {
            let (si, sj) = grid.position(source);
            let offset = [ri as f64 - si as f64, rj as f64 - sj as f64];
            let block = kernels.influence(offset, grid.hx(), grid.hy(), case.projection).block();
            for c in 0..3 {
                expected[c * k + receiver] +=
                    (0..3).map(|d| block[c][d] * case.p[d * k + source]).sum::<f64>();
            }
        }
    }
    close("sum over sources", ap, &expected, size);
}

fn leaves_masked_elements_alone(case: &Case, a: &dyn Influence, ap: &[f64]) {
    let k = case.inside.len();
    let mut other = case.p.clone();
    for e in (0..3 * k).filter(|e| !case.inside[e % k]) {
        assert_eq!(ap[e], 0.0, "displacement of masked element");
        other[e] = 1e9;
    }
    assert_eq!(apply(a, &other), ap, "traction on masked elements counts");
}

fn is_self_adjoint_and_non_negative(case: &Case, ap: &[f64], aq: &[f64], size: f64) {
    let product = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
    let rounding = ROUNDING * size * ap.len() as f64;
    assert!((product(ap, &case.q) - product(&case.p, aq)).abs() <= rounding, "not self-adjoint");
    // Collocation at midpoints need not be positive.
    if case.projection == Projection::Average && case.inside.contains(&true) {
        let norm: f64 = (0..ap.len())
            .filter(|e| case.inside[e % case.inside.len()])
            .map(|e| case.p[e] * case.p[e])
            .sum();
        assert!(product(ap, &case.p) > 0.0 || norm == 0.0, "negative energy");
    }
}

fn is_linear(case: &Case, a: &dyn Influence, ap: &[f64], aq: &[f64], size: f64) {
    let combine =
        |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(u, v)| 2.5 * u - v).collect::<Vec<_>>();
    close("linearity", &apply(a, &combine(&case.p, &case.q)), &combine(ap, aq), 4.0 * size);
}

/// Returns the blocks of some components.
fn blocks(field: &[f64], components: Components) -> Vec<f64> {
    let k = field.len() / 3;
    components
        .directions()
        .flat_map(|direction| &field[direction as usize * k..][..k])
        .copied()
        .collect()
}

fn largest(field: &[f64]) -> f64 {
    field.iter().fold(0.0, |m, u| m.max(u.abs()))
}

/// Checks that an operator on some components is the block of the full one, and an uncoupled one
/// that without n with x and y, whether it is made of a table of its own coefficients or of all.
fn keeps_to_its_components(build: Build, case: &Case) {
    let (grid, k, components) = (case.grid(), case.inside.len(), case.components);
    let all = InfluenceTable::new(&grid, case.bodies(), case.projection);
    let a = build(&all, Components::ALL, Mirror::NONE);
    let mut expected = vec![0.0; 3 * k];
    for group in components.groups() {
        let mut p = vec![0.0; 3 * k];
        for &direction in &group {
            let block = direction as usize * k..(direction as usize + 1) * k;
            p[block.clone()].copy_from_slice(&case.p[block]);
        }
        let u = apply(&*a, &p);
        for direction in group {
            let block = direction as usize * k..(direction as usize + 1) * k;
            expected[block.clone()].copy_from_slice(&u[block]);
        }
    }
    let p = blocks(&case.p, components);
    let reduced = build(
        &InfluenceTable::of(&grid, case.bodies(), case.projection, components),
        components,
        Mirror::NONE,
    );
    assert_eq!(reduced.components(), components);
    let got = apply(&*reduced, &p);
    close("components", &got, &blocks(&expected, components), largest(&expected));
    assert_eq!(apply(&*build(&all, components, Mirror::NONE), &p), got, "a larger table");
}

/// Checks the operator on the part of a grid that mirror planes leave against the operator of the
/// whole grid on the field with its mirror images.
fn a_part_says_everything(build: Build, case: &Case) {
    let ([nx, ny], components, mirror) = (case.n, case.components, case.mirror);
    let twice = |n: usize, symmetry: Option<Symmetry>| if symmetry.is_some() { 2 * n } else { n };
    let whole = Grid::new(twice(nx, mirror.x), twice(ny, mirror.y), case.h[0], case.h[1], [0.0; 2])
        .unwrap();
    let inside: Vec<f64> = case.inside.iter().map(|&inside| f64::from(inside)).collect();
    let inside = mirror
        .extend(&whole, Components::NORMAL, &inside)
        .iter()
        .map(|value| *value != 0.0)
        .collect();
    let whole = whole.with_mask(inside).unwrap();
    let table = InfluenceTable::of(&whole, case.bodies(), case.projection, components);
    let p = blocks(&case.p, components);
    let full =
        apply(&*build(&table, components, Mirror::NONE), &mirror.extend(&whole, components, &p));
    let reduced = build(&table, components, mirror);
    assert_eq!(reduced.grid(), &mirror.part(&whole).unwrap());
    let got = apply(&*reduced, &p);
    // The images partly cancel each other.
    let size = largest(&full).max(largest(&p) * table.largest_diagonal());
    close("part", &got, &mirror.restrict(&whole, &full), size);
    close("images", &mirror.extend(&whole, components, &got), &full, size);
}

/// Moves values to the elements `target` and multiplies vectors by the signed permutation
/// `turn`[new component] = (old, sign).
fn moved(field: &[f64], target: &dyn Fn(usize) -> usize, turn: [(usize, f64); 3]) -> Vec<f64> {
    let k = field.len() / 3;
    let mut out = vec![0.0; 3 * k];
    for (new, (old, sign)) in turn.into_iter().enumerate() {
        for e in 0..k {
            out[new * k + target(e)] = sign * field[old * k + e];
        }
    }
    out
}

fn moved_mask(inside: &[bool], target: &dyn Fn(usize) -> usize) -> Vec<bool> {
    let mut out = vec![false; inside.len()];
    for (e, &flag) in inside.iter().enumerate() {
        out[target(e)] = flag;
    }
    out
}

fn mirrored_loads_have_mirrored_displacements(build: Build, case: &Case, ap: &[f64], size: f64) {
    let [nx, ny] = case.n;
    let in_x = |e: usize| e / nx * nx + (nx - 1 - e % nx);
    let in_y = |e: usize| (ny - 1 - e / nx) * nx + e % nx;
    let flips: [&dyn Fn(usize) -> usize; 2] = [&in_x, &in_y];
    let turns = [[(0, 1.0), (1, -1.0), (2, 1.0)], [(0, 1.0), (1, 1.0), (2, -1.0)]];
    for (target, turn) in flips.into_iter().zip(turns) {
        let other = Case { inside: moved_mask(&case.inside, target), ..case.clone() };
        let a = operator(build, &other.grid(), &case.bodies(), case.projection);
        close("mirror", &apply(&*a, &moved(&case.p, target, turn)), &moved(ap, target, turn), size);
    }
}

/// Turns the case by a right angle: (x, y) becomes (−y, x).
fn turns(build: Build, case: &Case, ap: &[f64], size: f64) {
    let [nx, ny] = case.n;
    let target = |e: usize| (e % nx) * ny + (ny - 1 - e / nx);
    let turn = [(0, 1.0), (2, -1.0), (1, 1.0)];
    let other = Case {
        n: [ny, nx],
        h: [case.h[1], case.h[0]],
        inside: moved_mask(&case.inside, &target),
        ..case.clone()
    };
    let a = operator(build, &other.grid(), &case.bodies(), case.projection);
    close(
        "right angle",
        &apply(&*a, &moved(&case.p, &target, turn)),
        &moved(ap, &target, turn),
        size,
    );
}

/// Checks that a load moved by one element moves its displacement.
fn is_the_same_everywhere(build: Build, case: &Case, size: f64) {
    let [nx, ny] = case.n;
    if nx < 2 || ny < 2 {
        return;
    }
    let whole = Case { inside: vec![true; nx * ny], ..case.clone() };
    let a = operator(build, &whole.grid(), &case.bodies(), case.projection);
    let k = nx * ny;
    let last = |e: usize| e % nx == nx - 1 || e / nx == ny - 1;
    let first = |e: usize| e.is_multiple_of(nx) || e / nx == 0;
    let p: Vec<f64> = (0..3 * k).map(|e| if last(e % k) { 0.0 } else { case.p[e] }).collect();
    let onward = |e: usize| (e + nx + 1) % k;
    let same = [(0, 1.0), (1, 1.0), (2, 1.0)];
    let keep = |field: Vec<f64>| -> Vec<f64> {
        field.into_iter().enumerate().map(|(e, u)| if first(e % k) { 0.0 } else { u }).collect()
    };
    let here = keep(moved(&apply(&*a, &p), &onward, same));
    let there = keep(apply(&*a, &moved(&p, &onward, same)));
    close("translation", &there, &here, 4.0 * size.max(case.h[0].max(case.h[1])));
}

/// Checks that the displacement is the foundation's plus the punch's, seen from its own side:
/// normal reversed, so the coupling is too.
fn superposes_bodies(build: Build, case: &Case, ap: &[f64], size: f64) {
    let grid = case.grid();
    let below =
        operator(build, &grid, &Bodies::new(&case.layers, &case.base, None), case.projection);
    let above =
        operator(build, &grid, &Bodies::from(&HalfSpace::new(&case.punch, None)), case.projection);
    let stay = |e: usize| e;
    let reverse = [(0, -1.0), (1, 1.0), (2, 1.0)];
    let seen = moved(&apply(&*above, &moved(&case.p, &stay, reverse)), &stay, reverse);
    let sum: Vec<f64> = apply(&*below, &case.p).iter().zip(&seen).map(|(u, v)| u + v).collect();
    close("superposition", ap, &sum, 4.0 * size);
}

/// Checks that displacement is proportional to length and inversely proportional to the moduli.
fn scales(build: Build, case: &Case, ap: &[f64]) {
    let (length, modulus) = (1e-9, 1e12);
    let stiffer = |m: Material| Material { shear_modulus: m.shear_modulus * modulus, ..m };
    let smaller = |l: &Layer| Layer {
        shear_modulus: l.shear_modulus * modulus,
        thickness: l.thickness * length,
        ..*l
    };
    let base = match case.base {
        Base::Rigid => Base::Rigid,
        Base::Elastic(m) => Base::Elastic(stiffer(m)),
    };
    let layers = case.layers.iter().map(smaller).collect();
    let other = Case {
        h: case.h.map(|h| h * length),
        layers,
        base,
        punch: stiffer(case.punch),
        ..case.clone()
    };
    let a = operator(build, &other.grid(), &other.bodies(), case.projection);
    let unscaled: Vec<f64> = apply(&*a, &case.p).iter().map(|u| u * modulus / length).collect();
    close("scaling", &unscaled, ap, ap.iter().fold(0.0_f64, |m, u| m.max(u.abs())));
}
