//! A contact has one solution below the end μ* of the uniqueness set, and several above it where
//! the right-hand side allows.

use std::sync::Arc;

use crate::common::{numerics, scene, square};
use contact::Operators;
use contact::influence::{Dense, Influence, InfluenceTable, Scratch};
use contact::model::*;
use contact::multiplicity::{Multiplicity, Search, search, search_from};
use contact::problem::Problem;
use contact::punch::{Surface, Surfaces};
use proptest::prelude::*;

/// The units in which a scene is written.
#[derive(Clone, Copy)]
struct Units {
    length: f64,
    modulus: f64,
}

/// A flat sole of 2 × 2 whose left half touches first and is shifted by `shift`. Then the right
/// half touches as well, the punch is shifted back to `share` of that, and in the end it is at the
/// approach `end`. That leaves the two halves pulled towards each other (shift > 0) or apart (shift
/// < 0).
struct Walk {
    poisson: f64,
    mu: f64,
    shift: f64,
    share: f64,
    end: f64,
}

impl Walk {
    fn scene(&self, units: Units) -> Scene {
        let mut scene = scene(
            Shape::FlatRectangle { width_x: 2.0 * units.length, width_y: 2.0 * units.length },
            units.modulus,
            self.poisson,
            self.mu,
            Step::default(),
        );
        let scaled = |x: f64| Some(x * units.length);
        scene.loading = Loading::path(vec![
            Step { approach: scaled(0.0), tilt_y: Some(2.0), ..Step::default() },
            Step { shift_x: scaled(self.shift), ..Step::default() },
            Step { approach: scaled(1.0), tilt_y: Some(0.0), ..Step::default() },
            Step { shift_x: scaled(self.share * self.shift), ..Step::default() },
            Step { approach: scaled(self.end), ..Step::default() },
        ]);
        scene
    }
}

const ONE: Units = Units { length: 1.0, modulus: 1.0 };

fn exactly(n: [u32; 2]) -> Numerics {
    numerics(Mesh::Exact(n), Projection::Average, 1e-10)
}

fn searched(scene: &Scene, numerics: &Numerics, starts: u32) -> Multiplicity {
    search(
        scene,
        numerics,
        &Surfaces::new(),
        &mut Operators::default(),
        &Search { starts, seed: 1 },
    )
    .unwrap()
}

/// Returns a flat sole on n × n elements, pressed so that `p` = (1, μ n) with slip w_t = −σ μ n
/// solves the problem whatever its index: the height map makes f₁ = (A p)₁ and the past f_t = (A p
/// − w)_t. The second value is the motion of the punch.
fn slipping_along(
    directions: &[[f64; 2]],
    poisson: f64,
    mu: f64,
    sigma: f64,
) -> (Problem, PerDof<Control>) {
    let n = directions.len().isqrt();
    let sole = |surface: &str| Shape::HeightMap {
        surface: surface.to_owned(),
        width_x: 2.0,
        width_y: 2.0,
    };
    let bound = |heights: Vec<f64>, approach: f64| {
        let scene = scene(
            sole("map"),
            1.0,
            poisson,
            mu,
            Step { approach: Some(approach), ..Step::default() },
        );
        let mut surfaces = Surfaces::new();
        surfaces.insert("map".to_owned(), Arc::new(Surface::new(n, n, heights).unwrap()));
        Problem::new(&scene, &exactly([n as u32; 2]), &surfaces).unwrap()
    };
    let flat = bound(vec![0.0; n * n], 0.0);
    let k = flat.grid.len();
    let table = InfluenceTable::new(&flat.grid, &flat.elasticity, flat.projection);
    let p: Vec<f64> = (0..3 * k)
        .map(|entry| if entry < k { 1.0 } else { mu * directions[entry % k][entry / k - 1] })
        .collect();
    let dense = Dense::new(&table);
    let mut f = vec![0.0; 3 * k];
    dense.apply(&mut f, &p, &mut Scratch::new(&dense));
    for entry in k..3 * k {
        f[entry] += sigma * p[entry];
    }
    // The mean of the map's surface over each element must be this; its pixels follow.
    let wanted: Vec<f64> = f[..k].iter().map(|f| f * flat.scale.length).collect();
    let (mut heights, mut approach) = (wanted.clone(), 0.0);
    let mut problem = flat.clone();
    let scale = wanted.iter().map(|height| height.abs()).fold(0.0, f64::max);
    let mut rest = f64::INFINITY;
    for _ in 0..200 {
        problem = bound(heights.clone(), 0.0);
        problem.place(&PerDof::all(0.0));
        let reached = problem.f[..k].iter().map(|f| f * flat.scale.length);
        let off: Vec<f64> = wanted.iter().zip(reached).map(|(wanted, f)| wanted - f).collect();
        approach = off.iter().sum::<f64>() / k as f64;
        rest = off.iter().map(|off| (off - approach).abs()).fold(0.0, f64::max);
        if rest <= 1e-12 * scale {
            break;
        }
        heights.iter_mut().zip(&off).for_each(|(height, off)| *height += off - approach);
    }
    assert!(rest <= 1e-12 * scale, "{rest:e} of {scale:e} is left");
    problem.remember(&f, &PerDof::all(0.0));
    (problem, PerDof::new([approach, 0.0, 0.0, 0.0, 0.0, 0.0]).map(Control::Motion))
}

/// Returns the directions in which a square of 2 × 2 elements is nearest to losing uniqueness: the
/// halves are pulled together along x, and a little apart along y.
fn nearest_to_multiple(degrees: f64) -> [[f64; 2]; 4] {
    let (y, x) = degrees.to_radians().sin_cos();
    [[x, -y], [-x, -y], [x, y], [-x, y]]
}

#[test]
fn at_the_end_of_the_uniqueness_set_one_solution_becomes_three() {
    struct Case {
        poisson: f64,
        end: f64,
        degrees: f64,
    }
    for Case { poisson, end, degrees } in [
        Case { poisson: 0.3, end: 4.702062, degrees: 8.8 },
        Case { poisson: 0.0, end: 2.700273, degrees: 9.1 },
    ] {
        for (share, expected) in [(0.995, vec![1]), (1.005, vec![-1, 1, 1])] {
            let (problem, controls) =
                slipping_along(&nearest_to_multiple(degrees), poisson, share * end, 1e-4);
            let search = Search { starts: 40, seed: 3 };
            let found = search_from(
                problem,
                &controls,
                &exactly([2, 2]),
                &mut Operators::default(),
                &search,
            )
            .unwrap();
            let mut indices: Vec<i64> =
                found.solutions.iter().filter_map(|solution| solution.index).collect();
            indices.sort_unstable();
            assert_eq!(indices, expected, "ν = {poisson}, μ/μ* = {share}: {found:#?}");
            assert_eq!(found.index_sum, Some(1));
            certified(&found);
        }
    }
}

#[test]
fn on_four_by_four_elements_there_are_several_solutions_just_above_the_witness() {
    // The directions are in degrees from x. They were found by minimising the μ at which the
    // linearised problem turns singular, 2.0426 at ν = 0.
    let degrees = [
        74.5, 30.0, 200.9, 235.6, 254.6, 76.9, 16.6, 187.7, 205.8, 257.8, 75.9, 44.6, 23.0, 213.6,
        252.2, 251.5,
    ];
    let directions =
        degrees.map(|degrees: f64| [degrees.to_radians().cos(), degrees.to_radians().sin()]);
    let found = |mu: f64| {
        let (problem, controls) = slipping_along(&directions, 0.0, mu, 1e-4);
        search_from(
            problem,
            &controls,
            &exactly([4, 4]),
            &mut Operators::default(),
            &Search { starts: 20, seed: 3 },
        )
        .unwrap()
    };
    let (below, above) = (found(2.02), found(2.07));
    println!("{} {} {:?}", below.solutions.len(), above.solutions.len(), above.index_sum);
    assert_eq!((below.solutions.len(), below.index_sum), (1, Some(1)));
    assert_eq!((above.solutions.len(), above.index_sum), (3, Some(1)));
    certified(&above);
}

/// Asserts that every solution stands by itself, within its tolerance and away from all others.
fn certified(found: &Multiplicity) {
    for (i, solution) in found.solutions.iter().enumerate() {
        assert!(solution.certificate.meets(1e-10), "{:?}", solution.certificate);
        assert!(solution.error < 1e-8, "{}", solution.error);
        assert_eq!(solution.distances.len(), found.solutions.len());
        assert!(
            (0..found.solutions.len()).all(|j| (solution.distances[j] > 1e-5) == (i != j)),
            "{:?}",
            solution.distances
        );
    }
}

#[test]
fn a_walked_punch_has_three_solutions_and_with_less_friction_one() {
    for (n, poisson, mu) in [(2, 0.0, 4.0), (2, 0.3, 8.0), (4, 0.0, 14.0)] {
        let walk = Walk { poisson, mu, shift: 1.0, share: 0.4, end: 0.01 };
        let several = searched(&walk.scene(ONE), &exactly([n, n]), 10);
        assert_eq!(
            (several.status.clone(), several.solutions.len(), several.index_sum),
            (Status::Certified, 3, Some(1))
        );
        certified(&several);
        assert!(several.before.len() == 4 && several.furthest().is_some());
        let [i, j] = several.furthest().unwrap();
        assert!(several.solutions[i].distances[j] > 0.1);
        let slippery = Walk { mu: 0.2 * mu, ..walk };
        let one = searched(&slippery.scene(ONE), &exactly([n, n]), 10);
        assert_eq!((one.status, one.solutions.len()), (Status::Certified, 1));
    }
}

#[test]
fn a_punch_lifted_off_may_be_jammed() {
    // One row of two elements is pulled apart: friction holds it although nothing presses.
    let mut scene = Walk { poisson: 0.0, mu: 12.0, shift: -1.0, share: 0.3, end: -0.01 }.scene(ONE);
    scene.punch.shape = Shape::FlatRectangle { width_x: 2.0, width_y: 1.0 };
    let found = searched(&scene, &exactly([2, 1]), 20);
    assert_eq!((found.solutions.len(), found.index_sum), (3, Some(1)));
    certified(&found);
    let mut loads: Vec<f64> =
        found.solutions.iter().map(|solution| solution.observables.load).collect();
    loads.sort_by(f64::total_cmp);
    assert!(loads[0] == 0.0 && loads[1] > 0.05 && loads[2] > 1.2 * loads[1], "{loads:?}");
}

#[test]
fn images_of_solutions_are_solutions() {
    // The scene is its own image in y.
    let found = searched(
        &Walk { poisson: 0.0, mu: 8.0, shift: 1.0, share: 0.5, end: 0.02 }.scene(ONE),
        &exactly([2, 2]),
        20,
    );
    assert_eq!((found.solutions.len(), found.index_sum), (5, Some(1)));
    let unsymmetric = |fields: &Fields| {
        (fields.pressure[0] - fields.pressure[2]).abs()
            > 1e-3 * fields.pressure[0].max(fields.pressure[2])
    };
    let mut pairs = 0;
    for solution in found.solutions.iter().filter(|solution| unsymmetric(&solution.fields)) {
        let swap = |values: &[f64]| [2, 3, 0, 1].map(|e| values[e]).to_vec();
        let fields = &solution.fields;
        let image = Fields {
            pressure: swap(&fields.pressure),
            traction_x: swap(&fields.traction_x),
            traction_y: swap(&fields.traction_y).iter().map(|p| -p).collect(),
            ..Fields::default()
        };
        assert!(found.solutions.iter().any(|other| {
            image.difference(&other.fields).is_some_and(|difference| difference < 1e-9)
        }));
        pairs += 1;
    }
    assert_eq!(pairs, 2);
}

#[test]
fn the_same_search_gives_the_same_bytes_on_any_number_of_threads() {
    let scene = Walk { poisson: 0.3, mu: 8.0, shift: 1.0, share: 0.4, end: 0.01 }.scene(ONE);
    let found_with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = Search { starts: 10, seed };
        let found = pool.install(|| {
            search(&scene, &exactly([4, 4]), &Surfaces::new(), &mut Operators::default(), &settings)
                .unwrap()
        });
        serde_json::to_string(&found).unwrap()
    };
    let first = found_with(1, 5);
    assert_eq!(first, found_with(3, 5));
    assert_ne!(first, found_with(1, 6), "the seed counts");
}

#[test]
fn units_do_not_count() {
    let found = |units: Units| {
        searched(
            &Walk { poisson: 0.0, mu: 8.0, shift: 1.0, share: 0.5, end: 0.02 }.scene(units),
            &exactly([2, 2]),
            10,
        )
    };
    let (one, other) = (found(ONE), found(Units { length: 1e-9, modulus: 1e12 }));
    assert_eq!(one.solutions.len(), other.solutions.len());
    for (a, b) in one.solutions.iter().zip(&other.solutions) {
        assert!((b.observables.load / (a.observables.load * 1e12 * 1e-18) - 1.0).abs() < 1e-9);
        assert_eq!((a.origin, a.method, a.index), (b.origin, b.method, b.index));
    }
}

#[test]
fn a_path_that_cannot_be_followed_and_a_mesh_too_fine_say_so() {
    let mut scene = Walk { poisson: 0.3, mu: 0.1, shift: 1.0, share: 0.4, end: 0.01 }.scene(ONE);
    scene.loading.steps[1] = Step { shift_x: None, force_x: Some(100.0), ..Step::default() };
    let failed = searched(&scene, &exactly([4, 4]), 5);
    let Status::Failed { reason } = &failed.status else { panic!("{failed:?}") };
    assert!(reason.starts_with("loading.steps[1], increment 1 of 1: gross sliding"), "{reason}");
    assert!(failed.solutions.is_empty() && failed.before.len() == 2 && failed.starts == 0);

    let scene = Walk { poisson: 0.3, mu: 0.1, shift: 1.0, share: 0.4, end: 0.01 }.scene(ONE);
    let refused = search(
        &scene,
        &exactly([33, 33]),
        &Surfaces::new(),
        &mut Operators::default(),
        &Search::default(),
    )
    .unwrap_err();
    assert_eq!((refused.key.as_str(), refused.value.as_str()), ("mesh", "1089 elements of Ω"));
}

#[test]
fn under_a_force_the_motion_is_found_and_there_is_no_index() {
    let step = Step { normal_force: Some(0.1), force_x: Some(0.01), ..Step::default() };
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.5, step);
    scene.domain = square(1.0);
    let found = searched(&scene, &exactly([6, 6]), 6);
    assert_eq!((found.solutions.len(), found.index_sum), (1, None));
    let solution = &found.solutions[0];
    assert!((solution.observables.load / 0.1 - 1.0).abs() < 1e-9 && solution.motion.approach > 0.0);
    assert!(solution.reached > found.starts / 2, "{} of {}", solution.reached, found.starts);
}

/// A square of n × n elements and the lower end of its bracket of μ*.
struct Ground {
    n: u32,
    poisson: f64,
    low: f64,
}

const GROUNDS: [Ground; 4] = [
    Ground { n: 2, poisson: 0.3, low: 4.70 },
    Ground { n: 4, poisson: 0.3, low: 2.59 },
    Ground { n: 2, poisson: 0.0, low: 2.70 },
    Ground { n: 4, poisson: 0.0, low: 1.51 },
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Below the lower end of the bracket of μ* (square Ω, rigid punch) no path leads to more than
    /// one solution.
    #[test]
    fn below_the_end_of_the_uniqueness_set_there_is_one_solution(
        ground in 0usize..4,
        share in 0.3..1.0f64,
        is_sphere: bool,
        seed: u64,
        motions in prop::collection::vec(
            (
                -0.2..1.0f64,
                prop::array::uniform2(-1.5..1.5f64),
                prop::array::uniform3(-1.0..1.0f64),
            ),
            1..5,
        ),
    ) {
        let Ground { n, poisson, low } = GROUNDS[ground];
        let shape = if is_sphere {
            Shape::Sphere { radius: 1.0 }
        } else {
            Shape::FlatRectangle { width_x: 2.0, width_y: 2.0 }
        };
        let mut scene = scene(shape, 1.0, poisson, share * low, Step::default());
        scene.domain = square(2.0);
        let steps = motions.into_iter().map(|(approach, [x, y], [tilt_x, tilt_y, twist])| Step {
            approach: Some(approach),
            shift_x: Some(x),
            shift_y: Some(y),
            tilt_x: Some(tilt_x),
            tilt_y: Some(tilt_y),
            twist: Some(twist),
            ..Step::default()
        });
        scene.loading = Loading::path(steps.collect());
        let settings = Search { starts: 6, seed };
        let found = search(
            &scene,
            &exactly([n, n]),
            &Surfaces::new(),
            &mut Operators::default(),
            &settings,
        )
        .unwrap();
        prop_assert_eq!(&found.status, &Status::Certified);
        prop_assert_eq!(found.solutions.len(), 1);
        prop_assert!(found.solutions[0].index.is_none_or(|index| index >= 0));
        prop_assert_eq!(found.starts, found.failed + found.solutions[0].reached);
    }
}
