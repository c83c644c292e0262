//! The lower side of μ* meets a prototype's figures, and holds as a certificate.

use contact::model::{Base, Material, Projection};
use contact::uniqueness::lower::{
    Freedom, Lower, LowerBound, VerifyError, lower, lower_from, orbits, verify as verify_up_to,
};
use contact::uniqueness::{Question, Sole, System};

use crate::common::rectangle_question;

fn question(mesh: [u32; 2], poisson: f64) -> Question {
    rectangle_question(mesh, [1.0, f64::from(mesh[1]) / f64::from(mesh[0])], 1.0, poisson)
}

fn verify(system: &System, bound: &LowerBound) -> Result<(), VerifyError> {
    verify_up_to(system, bound, 2000)
}

fn bound(system: &System, freedom: Freedom) -> LowerBound {
    let Lower::Bound(bound) = lower(system, freedom).unwrap() else { panic!("unbounded") };
    assert!(bound.verified);
    verify(system, &bound).unwrap();
    bound
}

/// The figures come from an independent prototype (Python, scipy) for a square Ω, a rigid punch and
/// averages over elements.
#[test]
fn reproduces_the_prototype() {
    struct Case {
        n: u32,
        poisson: f64,
        freedom: Freedom,
        mu: f64,
        digits: f64,
    }
    use Freedom::{Global, PerOrbit};
    for Case { n, poisson, freedom, mu: expected, digits } in [
        Case { n: 2, poisson: 0.3, freedom: Global, mu: 4.702062, digits: 1e-6 },
        Case { n: 2, poisson: 0.0, freedom: Global, mu: 2.700273, digits: 1e-6 },
        Case { n: 3, poisson: 0.3, freedom: Global, mu: 3.146, digits: 5e-4 },
        Case { n: 3, poisson: 0.0, freedom: Global, mu: 1.831, digits: 5e-4 },
        Case { n: 4, poisson: 0.3, freedom: Global, mu: 2.596, digits: 5e-4 },
        Case { n: 4, poisson: 0.0, freedom: Global, mu: 1.518, digits: 5e-4 },
        Case { n: 8, poisson: 0.3, freedom: Global, mu: 1.835, digits: 5e-4 },
        Case { n: 8, poisson: 0.0, freedom: Global, mu: 1.080, digits: 5e-4 },
        Case { n: 3, poisson: 0.3, freedom: PerOrbit, mu: 3.272, digits: 5e-4 },
        Case { n: 3, poisson: 0.0, freedom: PerOrbit, mu: 1.904, digits: 5e-4 },
        Case { n: 4, poisson: 0.3, freedom: PerOrbit, mu: 2.722, digits: 5e-4 },
        Case { n: 4, poisson: 0.0, freedom: PerOrbit, mu: 1.584, digits: 5e-4 },
    ] {
        let system = System::new(&question([n, n], poisson)).unwrap();
        let found = bound(&system, freedom);
        assert!(
            (found.mu - expected).abs() <= digits,
            "{n} × {n}, ν = {poisson}, {freedom:?}: {} instead of {expected}",
            found.mu
        );
    }
}

/// The figures come from an independent prototype for displacements at midpoints; it was run with
/// two weights to four digits.
#[test]
fn reproduces_the_prototype_at_midpoints() {
    for (n, expected) in [(4, 3.262), (8, 2.330), (16, 1.690)] {
        let system =
            System::new(&Question { projection: Projection::Midpoint, ..question([n, n], 0.3) })
                .unwrap();
        let found = bound(&system, Freedom::Global).mu;
        assert!((found - expected).abs() <= 5e-4, "{n} × {n}: {found} instead of {expected}");
    }
}

#[test]
fn weights_per_orbit_are_better_than_two() {
    let masked = Question { sole: Sole::Disk { radius: 1.0 }, ..question([6, 6], 0.2) };
    for question in [question([5, 3], 0.3), question([1, 4], 0.1), masked, question([8, 8], 0.3)] {
        let system = System::new(&question).unwrap();
        let (two, all) = (bound(&system, Freedom::Global), bound(&system, Freedom::PerOrbit));
        assert!(all.mu >= two.mu * (1.0 - 1e-4), "{} below {}", all.mu, two.mu);
        assert_eq!(all.alpha.len(), orbits(&system).iter().max().unwrap() + 1);
    }
}

#[test]
fn without_coupling_there_is_no_bound() {
    let half = System::new(&question([4, 4], 0.5)).unwrap();
    let one = System::new(&question([1, 1], 0.3)).unwrap();
    let material = Material { shear_modulus: 2.0, poisson: 0.2 };
    let mut twins = question([3, 3], 0.3);
    twins.foundation.base = Base::Elastic(material);
    twins.punch = Some(material);
    for system in [half, one, System::new(&twins).unwrap()] {
        assert_eq!(lower(&system, Freedom::PerOrbit).unwrap(), Lower::Unbounded);
    }
}

/// Returns the smallest eigenvalue of the whole F(μ) in the order of the fields, without symmetry,
/// which the blocks stand for.
fn smallest_eigenvalue(system: &System, bound: &LowerBound, mu: f64) -> f64 {
    let (matrix, k, orbit) = (system.matrix(), system.elements(), orbits(system));
    let size = 3 * k;
    let weight = |values: &[f64], i: usize| values[orbit[i % k]];
    let linear = |i: usize| if i < k { weight(&bound.alpha, i) } else { weight(&bound.beta, i) };
    let form = faer::Mat::from_fn(size, size, |i, j| {
        let twice: f64 = (k..size)
            .map(|t| {
                matrix[(t, i)] * weight(&bound.beta, t) / weight(&bound.tau, t) * matrix[(t, j)]
            })
            .sum();
        let square =
            if i == j && i < k { weight(&bound.beta, i) * weight(&bound.tau, i) } else { 0.0 };
        0.5 * ((linear(i) + linear(j)) * matrix[(i, j)] - mu * (square + twice))
    });
    form.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0]
}

#[test]
fn the_blocks_are_the_whole() {
    let disk =
        Question { sole: Sole::Disk { radius: 1.0 }, epsilon: 0.05, ..question([5, 5], 0.2) };
    for question in [question([4, 4], 0.3), question([3, 3], 0.0), question([4, 3], 0.3), disk] {
        let system = System::new(&question).unwrap();
        let bound = bound(&system, Freedom::PerOrbit);
        let size = smallest_eigenvalue(&system, &bound, 0.0);
        assert!(size > 0.0 && smallest_eigenvalue(&system, &bound, bound.mu) > -1e-12 * size);
        assert!(
            smallest_eigenvalue(&system, &bound, bound.mu * (1.0 + 1e-6)) < 0.0,
            "a larger μ is proven too"
        );
    }
}

#[test]
fn refuses_what_proves_nothing() {
    let system = System::new(&question([3, 3], 0.3)).unwrap();
    let good = bound(&system, Freedom::PerOrbit);
    let too_much = LowerBound { mu: good.mu * (1.0 + 1e-6), ..good.clone() };
    assert_eq!(verify(&system, &too_much), Err(VerifyError::Indefinite { mu: too_much.mu }));
    let mut short = good.clone();
    short.tau.pop();
    assert_eq!(
        verify(&system, &short),
        Err(VerifyError::Length { name: "tau", found: 2, orbits: 3 })
    );
    for value in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        let mut wrong = good.clone();
        wrong.beta[1] = value;
        assert!(
            matches!(
                verify(&system, &wrong),
                Err(VerifyError::Weight { name: "beta", orbit: 1, .. })
            ),
            "{value}"
        );
        assert!(verify(&system, &LowerBound { mu: value, ..good.clone() }).is_err());
    }
    assert_eq!(verify_up_to(&system, &good, 6), Err(VerifyError::TooLarge { rows: 7, most: 6 }));
    assert_eq!(verify_up_to(&system, &good, 7), Ok(()));
    // The weights are those of another body.
    let other = System::new(&question([3, 3], 0.0)).unwrap();
    assert!(verify(&other, &good).is_err());
}

/// Uniqueness for one unit of length or modulus is uniqueness for all, and the record survives
/// being written.
#[test]
fn has_no_units_and_can_be_kept() {
    let mut large = question([4, 4], 0.3);
    large.sole = Sole::Rectangle { width_x: 1e9, width_y: 1e9 };
    large.foundation.base = Base::Elastic(Material { shear_modulus: 1e-12, poisson: 0.3 });
    let [one, other] = [question([4, 4], 0.3), large]
        .map(|question| bound(&System::new(&question).unwrap(), Freedom::PerOrbit));
    assert!((one.mu - other.mu).abs() < 1e-9 * one.mu);
    let written = serde_json::to_string(&Lower::Bound(one.clone())).unwrap();
    let Lower::Bound(read) = serde_json::from_str(&written).unwrap() else { panic!("unbounded") };
    verify(&System::new(&question([4, 4], 0.3)).unwrap(), &read).unwrap();
}

#[test]
fn same_bytes_on_any_number_of_threads() {
    let system = System::new(&question([6, 6], 0.3)).unwrap();
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bound(&system, Freedom::PerOrbit))
    });
    assert_eq!(one, three);
}

/// Carried over from a coarse mesh, the weights lose little against those found on the fine one,
/// and are proven just as well.
#[test]
fn weights_of_a_coarse_mesh_serve_a_fine_one() {
    let [coarse, fine] = [6, 12].map(|n| System::new(&question([n, n], 0.3)).unwrap());
    let weights = bound(&coarse, Freedom::PerOrbit);
    let Lower::Bound(carried) = lower_from(&fine, &coarse, &weights, 1000).unwrap() else {
        panic!("unbounded")
    };
    assert!(carried.verified);
    verify(&fine, &carried).unwrap();
    let (two, all) = (bound(&fine, Freedom::Global).mu, bound(&fine, Freedom::PerOrbit).mu);
    assert!(carried.mu > two && carried.mu <= all * (1.0 + 1e-4), "{two} < {} < {all}", carried.mu);
    // Without a factorisation the bound is lower, and says so.
    let Lower::Bound(guessed) = lower_from(&fine, &coarse, &weights, 0).unwrap() else {
        panic!("unbounded")
    };
    assert!(!guessed.verified && guessed.mu < carried.mu && guessed.mu > 0.995 * carried.mu);
    verify(&fine, &guessed).unwrap();
}

/// Only the ratios of α and β matter, even below the normal numbers, where there is no rounding to
/// allow for.
#[test]
fn scale_proves_nothing() {
    let system = System::new(&question([3, 3], 0.3)).unwrap();
    let good = bound(&system, Freedom::PerOrbit);
    let scaled = |weights: &[f64], factor: f64| -> Vec<f64> {
        weights.iter().map(|weight| weight * factor).collect()
    };
    for step in -40..40 {
        let mu = good.mu * (1.0 + 1e-3 * f64::from(step));
        let tiny = LowerBound {
            mu,
            alpha: scaled(&good.alpha, 1e-320),
            beta: scaled(&good.beta, 1e-320),
            ..good.clone()
        };
        let raised = LowerBound {
            alpha: scaled(&tiny.alpha, 1e300),
            beta: scaled(&tiny.beta, 1e300),
            ..tiny.clone()
        };
        assert_eq!(verify(&system, &tiny), verify(&system, &raised), "{mu}");
    }
}

/// The weaker the coupling, the larger both ends are; with two by two elements they meet.
#[test]
fn weak_coupling_has_a_large_bound() {
    let system = System::new(&question([2, 2], 0.499_999_9)).unwrap();
    let found = bound(&system, Freedom::PerOrbit);
    // The bound goes like 1/(1 − 2ν), and is 4.702 for ν = 0.3.
    assert!(found.mu > 4e6, "{}", found.mu);
}

/// Weights that make S indefinite are replaced by equal weights everywhere.
#[test]
fn weights_that_do_not_serve_are_replaced() {
    let [coarse, fine] = [4, 8].map(|n| System::new(&question([n, n], 0.3)).unwrap());
    let mut weights = bound(&coarse, Freedom::PerOrbit);
    let serve = weights.clone();
    weights.alpha =
        (0..weights.alpha.len()).map(|orbit| if orbit % 2 == 0 { 1e4 } else { 1e-4 }).collect();
    let found = |weights: &LowerBound| match lower_from(&fine, &coarse, weights, 1000) {
        Ok(Lower::Bound(bound)) => bound,
        other => panic!("{other:?}"),
    };
    let (instead, carried) = (found(&weights), found(&serve));
    assert_eq!(verify(&fine, &instead), Ok(()));
    assert!(
        instead.verified && instead.mu > 0.3 * carried.mu && instead.mu < carried.mu,
        "{} {}",
        instead.mu,
        carried.mu
    );
}

/// The mesh has 48 × 48 elements, and the problem 6912 unknowns.
#[test]
#[ignore = "minutes without optimisation"]
fn forty_eight_elements_across() {
    let [coarse, fine] = [16, 48].map(|n| System::new(&question([n, n], 0.3)).unwrap());
    let weights = bound(&coarse, Freedom::PerOrbit);
    let Lower::Bound(found) = lower_from(&fine, &coarse, &weights, 2000).unwrap() else {
        panic!("unbounded")
    };
    eprintln!("{}", found.mu);
    assert!(found.verified && found.mu > 0.7 && found.mu < weights.mu);
}
