//! μ* of strips is exact: it meets a closed form and determinants that are computed otherwise, and
//! each part of a wrong bracket is refused.

use contact::model::{Foundation, Layer, Material, Mesh, Projection};
use contact::uniqueness::strip::{ElementCase, StripBound, StripVerifyError, letters, verify};
use contact::uniqueness::witness::{Witness, WitnessError};
use contact::uniqueness::{
    Bracket, BracketError, Question, Sole, System, WitnessSearch, bracket, upper,
};

use crate::common::rectangle_question;

use ElementCase::{Open, SlipBackward, SlipForward, Stick};

/// Returns the question for a strip of `n` elements, each 1 long along x and `width` along y.
fn strip(n: u32, width: f64, poisson: f64) -> Question {
    let widths = [f64::from(n), width];
    Question { plane: true, ..rectangle_question([n, 1], widths, 1.0, poisson) }
}

fn bracketed(question: &Question) -> (StripBound, Witness) {
    match bracket(question, &WitnessSearch::default()) {
        Ok(Bracket::Strip { lower, upper }) => (lower, upper),
        other => panic!("{other:?}"),
    }
}

/// Computes the determinant of a case from its rows, by elimination of the whole matrix with
/// exchanges. There is a row for the normal and one for the tangential condition of each element.
fn determinant(system: &System, cases: &[ElementCase], mu: f64) -> f64 {
    let (k, n) = (system.elements(), cases.len());
    let operator = system.matrix();
    let scale = system.largest_diagonal();
    let of = |i: usize, j: usize| operator[(i, j)] / scale;
    let mut matrix = vec![vec![0.0; 2 * n]; 2 * n];
    for (i, case) in cases.iter().enumerate() {
        let closed = !matches!(case, Open | ElementCase::Held);
        let held = matches!(case, Stick | ElementCase::Held);
        for j in 0..n {
            if closed {
                matrix[i][j] = of(i, j);
                matrix[i][n + j] = of(i, k + j);
            }
            if held {
                matrix[n + i][j] = of(k + i, j);
                matrix[n + i][n + j] = of(k + i, k + j);
            }
        }
        if !closed {
            matrix[i][i] = 1.0;
        }
        if !held {
            matrix[n + i][n + i] = 1.0;
            match case {
                SlipForward => matrix[n + i][i] = -mu,
                SlipBackward => matrix[n + i][i] = mu,
                _ => {}
            }
        }
    }
    let mut determinant = 1.0;
    for column in 0..2 * n {
        let largest = (column..2 * n)
            .max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))
            .unwrap();
        if largest != column {
            matrix.swap(largest, column);
            determinant = -determinant;
        }
        determinant *= matrix[column][column];
        let (above, below) = matrix.split_at_mut(column + 1);
        let pivots = &above[column];
        for row in below {
            let factor = row[column] / pivots[column];
            row.iter_mut().zip(pivots).skip(column).for_each(|(x, pivot)| *x -= factor * pivot);
        }
    }
    determinant
}

/// Returns every choice of one of the cases for each of `n` elements.
fn choices(cases: &[ElementCase], n: usize) -> Vec<Vec<ElementCase>> {
    (0..n).fold(vec![Vec::new()], |shorter, _| {
        shorter
            .iter()
            .flat_map(|one| cases.iter().map(|case| [one.clone(), vec![*case]].concat()))
            .collect()
    })
}

/// Returns the least friction, to 10⁻⁹, at which a determinant of these cases is negative.
fn least_mu(system: &System, cases: &[ElementCase]) -> f64 {
    let choices = choices(cases, system.elements());
    let is_below = |mu: f64| choices.iter().all(|choice| determinant(system, choice, mu) > 0.0);
    let (mut low, mut high) = (0.0, 100.0);
    while high - low > 1e-9 * high {
        let mu = 0.5 * (low + high);
        if is_below(mu) { low = mu } else { high = mu }
    }
    high
}

#[test]
fn two_long_elements_meet_the_closed_form_of_plane_strain() {
    for poisson in [0.0, 0.3, 0.45] {
        let exact =
            8.0 * 2_f64.ln() * (1.0 - poisson) / (std::f64::consts::PI * (1.0 - 2.0 * poisson));
        let error = |width: f64| {
            let (lower, upper) = bracketed(&strip(2, width, poisson));
            assert!(upper.mu - lower.mu < 3e-6 * upper.mu, "{} {}", lower.mu, upper.mu);
            assert_eq!(letters(&lower.critical), "fb");
            (lower.mu / exact - 1.0).abs()
        };
        let [near, far] = [1e2, 1e4].map(error);
        assert!(near < 0.05 && far < 1e-3 && far < 0.03 * near, "ν = {poisson}: {near} {far}");
    }
}

#[test]
fn every_determinant_agrees_with_one_of_the_whole_matrix() {
    let layered = |n: u32| {
        let layers = vec![Layer { shear_modulus: 0.1, poisson: 0.2, thickness: 0.7 }];
        let question = strip(n, 3.0, 0.3);
        let foundation = Foundation { layers, ..question.foundation.clone() };
        Question { foundation, epsilon: 0.01, ..question }
    };
    for question in [strip(2, 1.0, 0.3), strip(3, 1.0, 0.0), strip(4, 50.0, 0.0), layered(4)] {
        let system = System::new(&question).unwrap();
        let (lower, upper) = bracketed(&question);
        let exact = least_mu(&system, &ElementCase::ALL);
        assert!(
            lower.mu < exact && exact < upper.mu && upper.mu - lower.mu < 3e-6 * exact,
            "{} {exact} {}",
            lower.mu,
            upper.mu
        );
        assert!(determinant(&system, &lower.critical, upper.mu) < 0.0);
        assert!(determinant(&system, &lower.critical, lower.mu) > 0.0);
        assert_eq!(verify(&system, &lower, upper.mu), Ok(()));
        let shown = upper.verify(&system).unwrap();
        assert!(shown.least_mu <= upper.mu && shown.residual < 1e-11 * shown.norm);
    }
}

#[test]
fn displacements_normal_to_the_surface_need_not_vanish_in_the_worst_case() {
    for (n, width, exact, restricted) in
        [(3, 1.0, 3.309_82, 3.616_29), (3, 1e3, 1.767_16, 1.814_95), (4, 1.0, 3.036_22, 3.234_53)]
    {
        let question = strip(n, width, 0.0);
        let system = System::new(&question).unwrap();
        let (lower, _) = bracketed(&question);
        let closed = least_mu(&system, &[Stick, SlipForward, SlipBackward]);
        assert!((lower.mu - exact).abs() < 1e-5, "{n} {width}: {}", lower.mu);
        assert!((closed - restricted).abs() < 1e-5, "{n} {width}: {closed}");
        assert!(lower.critical.contains(&ElementCase::Held), "{}", letters(&lower.critical));
    }
}

#[test]
fn a_longer_strip_needs_no_more_friction() {
    for (width, poisson) in [(1.0, 0.0), (1e3, 0.3)] {
        let mut before = f64::INFINITY;
        for n in 2..=6 {
            let (lower, upper) = bracketed(&strip(n, width, poisson));
            assert!(lower.mu <= before, "{n}: {} after {before}", lower.mu);
            before = upper.mu;
        }
    }
}

/// Fields in the plane are some of those in space.
#[test]
fn tractions_across_the_strip_need_no_more_friction() {
    let question = strip(3, 1.0, 0.0);
    let (lower, witness) = bracketed(&question);
    let space = Question { plane: false, ..question };
    assert!(witness.verify(&System::new(&space).unwrap()).is_ok());
    let search = WitnessSearch { starts: 6, ..WitnessSearch::default() };
    let Ok(upper::Upper::Bound(found)) = upper::upper(&space, &search) else {
        panic!("no witness")
    };
    assert!(found.mu < lower.mu * (1.0 + 1e-6), "{} {}", found.mu, lower.mu);
}

#[test]
fn units_and_threads_change_nothing() {
    let question = strip(5, 2.0, 0.2);
    let (lower, upper) = bracketed(&question);
    let scaled = Question {
        foundation: Foundation::half_space(Material { shear_modulus: 1e12, poisson: 0.2 }),
        sole: Sole::Rectangle { width_x: 5e-9, width_y: 2e-9 },
        ..question.clone()
    };
    let (of_scaled, _) = bracketed(&scaled);
    assert!((of_scaled.mu / lower.mu - 1.0).abs() < 1e-11);
    assert_eq!(of_scaled.critical, lower.critical);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| bracketed(&question)), (lower, upper));
}

#[test]
fn a_wrong_bracket_is_refused_in_each_of_its_parts() {
    let system = System::new(&strip(4, 1.0, 0.0)).unwrap();
    let (bound, witness) = bracketed(&strip(4, 1.0, 0.0));
    assert_eq!(verify(&system, &bound, witness.mu), Ok(()));
    let above = StripBound { mu: witness.mu, ..bound.clone() };
    assert!(matches!(
        verify(&system, &above, witness.mu),
        Err(StripVerifyError::NotPositive { mu, .. }) if mu == witness.mu
    ));
    for mu in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let senseless = StripBound { mu, ..bound.clone() };
        let is_refused = |lower: &StripBound, upper: f64| {
            matches!(verify(&system, lower, upper), Err(StripVerifyError::Mu { .. }))
        };
        assert!(is_refused(&senseless, witness.mu) && is_refused(&bound, mu));
    }
    let short = StripBound { critical: bound.critical[1..].to_vec(), ..bound.clone() };
    let length = StripVerifyError::Length { found: 3, elements: 4 };
    assert_eq!(verify(&system, &short, witness.mu), Err(length));
    let harmless = StripBound { critical: vec![Stick; 4], ..bound.clone() };
    let other = StripVerifyError::NotNegative { mu: witness.mu, case: "ssss".to_owned() };
    assert_eq!(verify(&system, &harmless, witness.mu), Err(other));
    // An upper end below μ* is not shown by the case, nor by the witness.
    let low = bound.mu * (1.0 - 1e-6);
    assert!(matches!(verify(&system, &bound, low), Err(StripVerifyError::NotNegative { .. })));
    let cheap = Witness { mu: low, ..witness.clone() };
    assert!(matches!(cheap.verify(&system), Err(WitnessError::Tangential { .. })));
    let mut x = witness.x.clone();
    x[0] = -x[0];
    assert!(Witness { x, ..witness }.verify(&system).is_err());
    let square = Question { mesh: Mesh::Exact([2, 2]), plane: false, ..strip(2, 2.0, 0.0) };
    let system = System::new(&square).unwrap();
    assert!(matches!(verify(&system, &bound, 1e3), Err(StripVerifyError::Mesh { .. })));
}

#[test]
fn what_is_no_strip_is_refused_with_its_key() {
    let refused = |question: Question| match bracket(&question, &WitnessSearch::default()) {
        Err(BracketError::Scene(error)) => error.key,
        other => panic!("{other:?}"),
    };
    for mesh in [Mesh::Exact([2, 2]), Mesh::Exact([1, 3]), Mesh::Across(3), Mesh::Exact([13, 1])] {
        assert_eq!(refused(Question { mesh, ..strip(3, 1.0, 0.0) }), "numerics.mesh");
    }
    let sole = Sole::Disk { radius: 1.0 };
    assert_eq!(refused(Question { sole, ..strip(3, 1.0, 0.0) }), "search.plane");
}

#[test]
fn strips_at_their_limits_have_an_end_or_a_reason() {
    let search = WitnessSearch::default();
    // Nothing couples pressures and tractions of an incompressible foundation, or of one element.
    assert_eq!(bracket(&strip(4, 1.0, 0.5), &search), Ok(Bracket::Unbounded));
    assert_eq!(bracket(&strip(1, 1.0, 0.0), &search), Ok(Bracket::Unbounded));
    // Midpoints of wide elements make no positive definite operator of some bodies; what is not
    // bracketed says why.
    for (width, poisson, epsilon) in
        [(1e-3, 0.3, 0.0), (1e6, 0.0, 0.0), (1.0, 0.4999, 0.0), (1.0, 0.3, 10.0), (1.0, 0.3, 1e-9)]
    {
        for projection in [Projection::Average, Projection::Midpoint] {
            let question = Question { projection, epsilon, ..strip(4, width, poisson) };
            match bracket(&question, &search) {
                Ok(Bracket::Strip { lower, upper }) => {
                    assert!(upper.mu - lower.mu < 1e-4 * upper.mu, "{width} {poisson} {epsilon}");
                    let system = System::new(&question).unwrap();
                    assert_eq!(verify(&system, &lower, upper.mu), Ok(()));
                    assert!(upper.verify(&system).is_ok());
                }
                Err(BracketError::Strip(error)) if projection == Projection::Midpoint => {
                    assert!(error.to_string().contains("not positive definite"), "{error}");
                }
                other => panic!("{width} {poisson} {epsilon}: {other:?}"),
            }
        }
    }
}

/// The time of long strips, and their figures.
#[test]
#[ignore = "takes a minute"]
fn table_of_strips() {
    for n in 2..=12 {
        let question = strip(n, 1e3, 0.0);
        let start = std::time::Instant::now();
        let (lower, upper) = bracketed(&question);
        let system = System::new(&question).unwrap();
        let searched = start.elapsed().as_secs_f64();
        assert_eq!(verify(&system, &lower, upper.mu), Ok(()));
        println!(
            "{n} {:.6} {:.6} {} {searched:.3} s {:.3} s",
            lower.mu,
            upper.mu,
            letters(&lower.critical),
            start.elapsed().as_secs_f64() - searched
        );
    }
}
