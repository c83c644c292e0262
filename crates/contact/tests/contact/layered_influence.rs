//! The influence coefficients of layered foundations meet reference values, and have the right
//! limits.

use contact::foundation::{Bodies, Coefficient, HalfSpace};
use contact::grid::Grid;
use contact::influence::{Dense, InfluenceTable};
use contact::model::{Base, Layer, Material, Projection};

const PROJECTIONS: [Projection; 2] = [Projection::Average, Projection::Midpoint];

fn layer(shear_modulus: f64, poisson: f64, thickness: f64) -> Layer {
    Layer { shear_modulus, poisson, thickness }
}

fn half_space(shear_modulus: f64, poisson: f64) -> Base {
    Base::Elastic(Material { shear_modulus, poisson })
}

fn grid(nx: usize, ny: usize, hx: f64, hy: f64) -> Grid {
    Grid::new(nx, ny, hx, hy, [0.0; 2]).unwrap()
}

fn entries(c: &Coefficient) -> [f64; 6] {
    [c.nn, c.xx, c.yy, c.xy, c.nx, c.ny]
}

/// Returns the largest entry of each kind, nn | xx, yy | xy | nx, ny, spread over the six entries.
fn largest_of_kind<'a>(all: impl Iterator<Item = &'a Coefficient>) -> [f64; 6] {
    let mut most = [0.0_f64; 6];
    for c in all {
        let c = entries(c).map(f64::abs);
        most = [
            most[0].max(c[0]),
            most[1].max(c[1].max(c[2])),
            0.0,
            most[3].max(c[3]),
            most[4].max(c[4].max(c[5])),
            0.0,
        ];
    }
    [most[0], most[1], most[1], most[3], most[4], most[4]]
}

/// Returns the largest difference, relative to the largest entry of its kind in `exact`.
fn deviation(got: &[Coefficient], exact: &[Coefficient]) -> f64 {
    assert_eq!(got.len(), exact.len());
    let unit = largest_of_kind(exact.iter());
    let mut worst = 0.0_f64;
    for (got, exact) in got.iter().zip(exact) {
        for ((got, exact), unit) in entries(got).into_iter().zip(entries(exact)).zip(unit) {
            assert!(got.is_finite());
            if unit > 0.0 {
                worst = worst.max((got - exact).abs() / unit);
            }
        }
    }
    worst
}

/// Returns the coefficients of the quadrant Δi, Δj ≥ 0.
fn quadrant(bodies: &Bodies, grid: &Grid, projection: Projection) -> Vec<Coefficient> {
    let table = InfluenceTable::new(grid, bodies, projection);
    let offsets =
        (0..grid.ny() as i64).flat_map(|dj| (0..grid.nx() as i64).map(move |di| (di, dj)));
    offsets.map(|(di, dj)| table.coefficient(di, dj)).collect()
}

#[test]
fn coefficients_meet_the_reference() {
    struct Case {
        name: String,
        got: Vec<Coefficient>,
        exact: Vec<Coefficient>,
    }
    let mut cases: Vec<Case> = Vec::new();
    for line in include_str!("../reference/layer_influence.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = |text: &str| -> Vec<f64> {
            text.split([';', ',']).map(|cell| cell.parse().unwrap()).collect()
        };
        let layers: Vec<Layer> = cells[1]
            .split_whitespace()
            .map(|text| match numbers(text)[..] {
                [shear_modulus, poisson, thickness] => layer(shear_modulus, poisson, thickness),
                _ => panic!("{line}"),
            })
            .collect();
        let base = match cells[2] {
            "rigid" => Base::Rigid,
            text => half_space(numbers(text)[0], numbers(text)[1]),
        };
        let [hx, hy, di, dj, nn, xx, yy, xy, nx, ny] = numbers(&cells[3..].join(","))[..] else {
            panic!("{line}")
        };
        let table = InfluenceTable::new(
            &grid(21, 21, hx, hy),
            Bodies::new(&layers, &base, None),
            Projection::Average,
        );
        if cases.last().is_none_or(|case| case.name != cells[0]) {
            cases.push(Case { name: cells[0].to_owned(), got: Vec::new(), exact: Vec::new() });
        }
        let case = cases.last_mut().unwrap();
        case.got.push(table.coefficient(di as i64, dj as i64));
        case.exact.push(Coefficient { nn, xx, yy, xy, nx, ny });
    }
    assert_eq!(cases.iter().map(|case| case.got.len()).sum::<usize>(), 27);
    for Case { name, got, exact } in cases {
        assert!(deviation(&got, &exact) < 1e-10, "{name}: {:e}", deviation(&got, &exact));
    }
}

#[test]
fn equal_layers_are_a_half_space_exactly() {
    let (material, punch) = (
        Material { shear_modulus: 3.0, poisson: 0.2 },
        Material { shear_modulus: 0.5, poisson: 0.4 },
    );
    let equal = layer(3.0, 0.2, 0.7);
    let layered =
        Bodies::new(&[equal, layer(3.0, 0.2, 4.0)], &Base::Elastic(material), Some(&punch));
    assert_eq!(layered, Bodies::from(&HalfSpace::new(&material, Some(&punch))));
    assert_eq!(layered.reference_compliance(), 0.8 / 3.0 + 0.6 / 0.5);
    // Nearly equal layers go through the layers' transforms.
    let nearly =
        Bodies::new(&[layer(3.0, 0.2 + 1e-13, 0.7)], &Base::Elastic(material), Some(&punch));
    assert!(nearly.layers.is_some());
    for projection in PROJECTIONS {
        let grid = grid(12, 9, 0.3, 0.2);
        assert!(
            deviation(
                &quadrant(&nearly, &grid, projection),
                &quadrant(&layered, &grid, projection)
            ) < 1e-12
        );
    }
}

#[test]
fn a_layer_cut_into_five_is_the_layer() {
    for base in [Base::Rigid, half_space(0.01, 0.5)] {
        let whole = Bodies::new(&[layer(2.0, 0.3, 0.5)], &base, None);
        let same = Bodies::new(&[layer(2.0, 0.3, 0.1); 5], &base, None);
        // The slices are too nearly equal to matter, and too different to be merged.
        let slice = |n: u8| layer(2.0 * (1.0 + 1e-14 * f64::from(n % 2)), 0.3, 0.1);
        let cut = Bodies::new(&[0, 1, 2, 3, 4].map(slice), &base, None);
        assert_eq!(cut.layers.as_ref().unwrap().layers().len(), 5);
        let grid = grid(12, 9, 0.3, 0.2);
        for projection in PROJECTIONS {
            let whole = quadrant(&whole, &grid, projection);
            assert!(deviation(&quadrant(&same, &grid, projection), &whole) < 1e-14);
            let cut = deviation(&quadrant(&cut, &grid, projection), &whole);
            assert!(cut < 1e-12, "{base:?} {cut:e}");
        }
    }
}

#[test]
fn far_below_nothing_is_felt() {
    let grid = grid(16, 16, 0.1, 0.1);
    for projection in PROJECTIONS {
        for base in [Base::Rigid, half_space(1e-3, 0.2), half_space(1e4, 0.5)] {
            let alone = quadrant(
                &Bodies::from(&HalfSpace::new(
                    &Material { shear_modulus: 2.0, poisson: 0.3 },
                    None,
                )),
                &grid,
                projection,
            );
            let felt = |thickness| {
                deviation(
                    &quadrant(
                        &Bodies::new(&[layer(2.0, 0.3, thickness)], &base, None),
                        &grid,
                        projection,
                    ),
                    &alone,
                )
            };
            // The base is felt as one over the depth, times the softer of the two where that is the
            // base.
            let (near, far) = (felt(1e8), felt(1e10));
            assert!(far > 0.0 && (near / far - 100.0).abs() < 1.0, "{base:?}: {near:e} {far:e}");
            assert!(felt(1e18) < 1e-14);
        }
    }
}

#[test]
fn a_film_is_felt_in_proportion_to_its_thickness() {
    let (base, grid) = (half_space(1.0, 0.3), grid(10, 8, 0.1, 0.1));
    for projection in PROJECTIONS {
        let alone = quadrant(&Bodies::new(&[], &base, None), &grid, projection);
        for (shear_modulus, poisson) in [(0.2, 0.45), (30.0, 0.1)] {
            let felt = |thickness| {
                let film = layer(shear_modulus, poisson, thickness);
                deviation(&quadrant(&Bodies::new(&[film], &base, None), &grid, projection), &alone)
            };
            let (thin, thinner) = (felt(1e-6), felt(1e-8));
            assert!(thin < 1e-2 && (thin / thinner - 100.0).abs() < 1.0, "{thin:e} {thinner:e}");
        }
    }
}

/// Elements cover the plane, so the coefficients sum to the compliance at k = 0, which a rigid base
/// makes finite: h(1−2ν)/2(1−ν)G and h/G. Thin layers would lose it to the difference with the
/// half-space.
#[test]
fn coefficients_on_a_rigid_base_sum_to_uniform_compression_and_shear() {
    for thickness in [1e-9, 1e-6, 1e-3, 0.02, 0.1] {
        for poisson in [0.0, 0.3, 0.49] {
            let bodies = Bodies::new(&[layer(4.0, poisson, thickness)], &Base::Rigid, None);
            for (hx, hy) in [(1.0, 1.0), (2.0, 0.5), (0.3, 30.0)] {
                let (nx, ny) = ((8.0 / hx) as i64 + 2, (8.0 / hy) as i64 + 2);
                for projection in PROJECTIONS {
                    let table = InfluenceTable::new(
                        &grid(nx as usize + 1, ny as usize + 1, hx, hy),
                        &bodies,
                        projection,
                    );
                    let mut sum = [0.0; 6];
                    for (dj, di) in (-ny..=ny).flat_map(|dj| (-nx..=nx).map(move |di| (dj, di))) {
                        let c = entries(&table.coefficient(di, dj));
                        sum = std::array::from_fn(|i| sum[i] + c[i]);
                    }
                    let squeeze = thickness * (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson) * 4.0);
                    let shear = thickness / 4.0;
                    let errors = [sum[0] - squeeze, sum[1] - shear, sum[2] - shear];
                    assert!(
                        errors.iter().all(|e| e.abs() < 3e-11 * shear),
                        "h = {thickness}, ν = {poisson}, {hx} × {hy}: {errors:?}"
                    );
                    assert!(sum[3..].iter().all(|s| s.abs() < 3e-11 * shear));
                }
            }
        }
    }
}

#[test]
fn averages_are_means_of_what_points_feel() {
    // Simpson's rule over receivers is no choice: midpoints of a finer grid of the same source are
    // not available. Sources are summed instead: the average over an element of size 3h is the mean
    // over its nine parts of the averages over sources of nine parts.
    let bodies = [
        Bodies::new(&[layer(5.0, 0.2, 0.1), layer(0.5, 0.4, 0.3)], &half_space(1.0, 0.35), None),
        Bodies::new(
            &[layer(1.0, 0.5, 2.0)],
            &Base::Rigid,
            Some(&Material { shear_modulus: 2.0, poisson: 0.1 }),
        ),
        Bodies::new(&[layer(1.0, 0.3, 1e-4)], &half_space(30.0, 0.0), None),
    ];
    for bodies in bodies {
        let (coarse, fine) = (grid(5, 4, 0.3, 0.6), grid(15, 12, 0.1, 0.2));
        let coarse_coefficients = quadrant(&bodies, &coarse, Projection::Average);
        let table = InfluenceTable::new(&fine, &bodies, Projection::Average);
        let summed: Vec<Coefficient> = (0..4)
            .flat_map(|dj| (0..5).map(move |di| (di, dj)))
            .map(|(di, dj)| {
                let mut sum = [0.0; 6];
                for (i, j) in (-2_i64..=2).flat_map(|i| (-2_i64..=2).map(move |j| (i, j))) {
                    // The weight is the number of pairs of parts at this offset, per receiving
                    // part.
                    let weight = ((3 - i.abs()) * (3 - j.abs())) as f64 / 9.0;
                    let c = entries(&table.coefficient(3 * di + i, 3 * dj + j));
                    sum = std::array::from_fn(|n| sum[n] + weight * c[n]);
                }
                let [nn, xx, yy, xy, nx, ny] = sum;
                Coefficient { nn, xx, yy, xy, nx, ny }
            })
            .collect();
        // A part farther than the last offset of the fine table does not occur: 3·4 + 2 = 14.
        assert!(
            deviation(&summed, &coarse_coefficients) < 1e-12,
            "{:e}",
            deviation(&summed, &coarse_coefficients)
        );
        // A midpoint coefficient is the same but for the receiver's extent.
        let rows = |n: usize| {
            quadrant(&bodies, &grid(n, n, 1.0 / n as f64, 1.0 / n as f64), Projection::Midpoint)
        };
        let centre_of_five: Vec<f64> = entries(&rows(1)[0]).to_vec();
        let table = InfluenceTable::new(&grid(5, 5, 0.2, 0.2), &bodies, Projection::Midpoint);
        for (n, one) in centre_of_five.iter().enumerate().take(3) {
            let parts = (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j)));
            let sum: f64 = parts.map(|(i, j)| entries(&table.coefficient(i, j))[n]).sum();
            assert!((sum / one - 1.0).abs() < 1e-12, "{n}: {sum} {one}");
        }
    }
}

#[test]
fn long_elements_agree_with_their_square_parts() {
    let bodies =
        Bodies::new(&[layer(5.0, 0.2, 0.5), layer(0.5, 0.4, 30.0)], &half_space(1.0, 0.35), None);
    let n = 1000_i64;
    let long = InfluenceTable::new(&grid(3, 2, 1.0, n as f64), &bodies, Projection::Midpoint);
    let square =
        InfluenceTable::new(&grid(3, n as usize + 1, 1.0, 1.0), &bodies, Projection::Average);
    let averaged = InfluenceTable::new(&grid(3, 2, 1.0, n as f64), &bodies, Projection::Average);
    for di in 0..3 {
        let exact = averaged.coefficient(di, 0);
        let mut sum = [0.0; 3];
        for j in -n + 1..n {
            let c = square.coefficient(di, j);
            let weight = (n - j.abs()) as f64 / n as f64;
            sum = [sum[0] + weight * c.nn, sum[1] + weight * c.xx, sum[2] + weight * c.nx];
        }
        for (sum, exact) in sum.into_iter().zip([exact.nn, exact.xx, exact.nx]) {
            assert!(
                (sum - exact).abs() <= 1e-11 * averaged.coefficient(0, 0).nn,
                "{di}: {sum} {exact}"
            );
        }
        assert!(long.coefficient(di, 0).nn > exact.nn, "the middle of a long strip sinks deepest");
    }
}

#[test]
fn a_right_angle_exchanges_x_and_y() {
    let bodies = Bodies::new(&[layer(5.0, 0.2, 0.1), layer(0.5, 0.4, 0.3)], &Base::Rigid, None);
    for projection in PROJECTIONS {
        let (lying, standing) = (grid(7, 4, 0.3, 0.1), grid(4, 7, 0.1, 0.3));
        let (lying, standing) = (
            InfluenceTable::new(&lying, &bodies, projection),
            InfluenceTable::new(&standing, &bodies, projection),
        );
        for (i, j) in [(0, 0), (1, 0), (6, 3), (-2, 3), (5, -1)] {
            let (a, b) = (lying.coefficient(i, j), standing.coefficient(j, i));
            assert_eq!(entries(&a), [b.nn, b.yy, b.xx, b.xy, b.ny, b.nx]);
        }
    }
}

#[test]
fn averaged_operator_is_positive_definite() {
    let stacks = [
        Bodies::new(&[layer(1.0, 0.3, 0.4)], &Base::Rigid, None),
        Bodies::new(&[layer(1.0, 0.5, 0.02)], &Base::Rigid, None),
        Bodies::new(&[layer(1e3, 0.2, 0.1)], &half_space(1.0, 0.0), None),
        Bodies::new(&[layer(1e-3, 0.5, 0.1), layer(7.0, 0.1, 1e-3)], &half_space(1.0, 0.4), None),
    ];
    for bodies in stacks {
        for (hx, hy) in [(0.1, 0.1), (1.0, 1.0), (0.02, 0.5)] {
            let dense =
                Dense::new(&InfluenceTable::new(&grid(7, 6, hx, hy), &bodies, Projection::Average));
            let matrix = dense.matrix();
            assert_eq!((matrix - matrix.transpose()).norm_max(), 0.0);
            let least = matrix.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0];
            assert!(least > 0.0, "{bodies:?}, {hx} × {hy}: {least}");
        }
    }
}
