//! Lower bounds by cases of open and closed elements come nearer to the witnesses, and each part of
//! a wrong one is refused.

use contact::uniqueness::cases::{CaseBound, CaseError, ExcludedCase, verify};
use contact::uniqueness::cover::{CoverError, NormalCase};
use contact::uniqueness::{Bracket, BracketError, Question, System, WitnessSearch, bracket, lower};

use crate::common::rectangle_question;

/// The effort of a search that is brief about the upper end.
const BRIEF: WitnessSearch =
    WitnessSearch { starts: 1, kept: 1, seed: 1, cases: true, width: None };

/// Returns the question for a rigid rectangle of square elements on a half-space.
pub(super) fn rectangle(mesh: [u32; 2], poisson: f64) -> Question {
    rectangle_question(mesh, mesh.map(|n| 0.01 * f64::from(n)), 80e9, poisson)
}

fn by_cases(question: &Question) -> (CaseBound, f64) {
    match bracket(question, &BRIEF) {
        Ok(Bracket::Cases { lower, upper }) => (lower, upper.mu),
        other => panic!("{other:?}"),
    }
}

#[test]
fn three_by_three_elements_are_bounded_twice_as_well() {
    for (poisson, without, with, witness) in
        [(0.0, 1.903_8, 2.056, 2.187_4), (0.3, 3.271_9, 3.53, 3.774_1)]
    {
        let question = rectangle([3, 3], poisson);
        let system = System::new(&question).unwrap();
        let Ok(lower::Lower::Bound(root)) = lower::lower(&system, lower::Freedom::PerOrbit) else {
            panic!("no bound")
        };
        let (bound, _) = by_cases(&question);
        assert!(root.mu > without && bound.mu > with && bound.mu < witness, "{}", bound.mu);
        assert_eq!(verify(&system, &bound), Ok(()));
        println!("ν = {poisson}: {} to {}, {} cases", root.mu, bound.mu, bound.cases.len());
    }
}

#[test]
fn a_case_bound_is_never_below_that_without_cases_nor_above_a_witness() {
    for (elements, poisson, epsilon) in
        [([2, 2], 0.0, 0.0), ([3, 2], 0.2, 0.0), ([4, 1], 0.3, 0.0), ([2, 2], 0.45, 0.1)]
    {
        let question = Question { epsilon, ..rectangle(elements, poisson) };
        let system = System::new(&question).unwrap();
        let Ok(lower::Lower::Bound(root)) = lower::lower(&system, lower::Freedom::PerOrbit) else {
            panic!("no bound")
        };
        let (bound, upper) = by_cases(&question);
        assert!(
            bound.mu >= root.mu && bound.mu < upper,
            "{elements:?}: {} {} {upper}",
            root.mu,
            bound.mu
        );
        assert_eq!(verify(&system, &bound), Ok(()));
    }
}

#[test]
fn a_wrong_case_bound_is_refused_in_each_of_its_parts() {
    let question = rectangle([3, 2], 0.0);
    let system = System::new(&question).unwrap();
    let (bound, _) = by_cases(&question);
    assert!(bound.cases.len() > 1, "{}", bound.cases.len());
    let change = |change: &dyn Fn(&mut CaseBound)| {
        let mut changed = bound.clone();
        change(&mut changed);
        verify(&system, &changed).unwrap_err()
    };
    let is = |error: CaseError, kind: &str| {
        let name = match error {
            CaseError::Cover(CoverError::Missing { .. }) => "missing",
            CaseError::Cover(CoverError::States { .. }) => "states",
            CaseError::Numbers { .. } => "numbers",
            CaseError::Mu { .. } => "mu",
            CaseError::NotExcluded { .. } => "not excluded",
            CaseError::Cover(CoverError::Elements { .. }) => "elements",
        };
        assert_eq!(name, kind, "{error}");
    };
    is(change(&|bound| bound.mu *= 1.05), "not excluded");
    is(change(&|bound| bound.mu = f64::NAN), "mu");
    is(change(&|bound| bound.mu = -1.0), "mu");
    is(change(&|bound| bound.cases.clear()), "missing");
    // Some cases are images of parts of others, and those in which all may be closed are not.
    let may_be_closed = |case: &ExcludedCase| !case.states.contains(&NormalCase::Open);
    is(change(&|bound| bound.cases.retain(|case| !may_be_closed(case))), "missing");
    is(change(&|bound| bound.cases.retain(may_be_closed)), "missing");
    for index in 0..bound.cases.len() {
        // Weights that give an element far too much of the negative part.
        is(change(&|bound| bound.cases[index].tau[0] *= 1e-6), "not excluded");
        is(change(&|bound| bound.cases[index].tau[0] = -1.0), "numbers");
        is(change(&|bound| bound.cases[index].alpha.truncate(1)), "numbers");
        is(change(&|bound| bound.cases[index].states.truncate(5)), "states");
        is(change(&|bound| bound.cases[index].pressure_penalty = -1.0), "numbers");
        is(change(&|bound| bound.cases[index].displacement_penalty = f64::INFINITY), "numbers");
    }
    let undecided = |bound: &mut CaseBound| {
        let case = &mut bound.cases[0];
        case.states = vec![NormalCase::Undecided; 6];
    };
    let error = change(&undecided);
    assert!(matches!(error, CaseError::NotExcluded { .. } | CaseError::Numbers { .. }), "{error}");
}

#[test]
fn cases_of_too_many_elements_or_of_a_strip_in_a_plane_are_refused() {
    for question in [rectangle([5, 4], 0.0), Question { plane: true, ..rectangle([3, 1], 0.0) }] {
        match bracket(&question, &BRIEF) {
            Err(BracketError::Scene(error)) => assert_eq!(error.key, "search.cases"),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(bracket(&rectangle([3, 3], 0.5), &BRIEF), Ok(Bracket::Unbounded));
}

/// The bounds of squares, and their times.
#[test]
#[ignore = "takes minutes"]
fn table_of_cases() {
    for (n, poisson) in [(2, 0.0), (3, 0.0), (3, 0.3), (4, 0.0), (4, 0.3)] {
        let question = rectangle([n, n], poisson);
        let system = System::new(&question).unwrap();
        let start = std::time::Instant::now();
        let (bound, _) = by_cases(&question);
        let searched = start.elapsed().as_secs_f64();
        let start = std::time::Instant::now();
        assert_eq!(verify(&system, &bound), Ok(()));
        println!(
            "{n} ν = {poisson}: {:.6}, {} cases, {searched:.2} s, {:.2} s",
            bound.mu,
            bound.cases.len(),
            start.elapsed().as_secs_f64()
        );
    }
}
