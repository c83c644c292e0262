//! Warnings of results whose errors are not estimated, or large beside what is asked.

use answers::{Results, Warning, warnings};
use contact::model::Interior;
use study::Ending;

use crate::shelf::Shelf;
use crate::{SPHERES, parse};

/// Runs a sphere that is pressed, and returns the doubts about its results.
fn doubts(more: &str) -> Vec<Warning> {
    let study = parse(&format!(
        "name = \"test\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]\n{more}\n"
    ));
    let mut shelf = Shelf::default();
    shelf.run(&study);
    Results::read(study, &shelf).unwrap().warnings()
}

#[test]
fn an_error_that_is_not_estimated_is_said_to_be_missing() {
    let found = doubts("[numerics]\nmesh = [3, 16]");
    // So few elements leave no margin at the edge either.
    let [_, warning] = &found[..] else { panic!("{found:?}") };
    assert_eq!(
        warning.words,
        "no error of 1 point is estimated: there are fewer than 4 elements along a side; give a \
         finer `mesh`"
    );
    assert_eq!(warning.filter, "status == \"certified\" && estimate_solver == null");
}

#[test]
fn an_estimate_is_held_against_what_is_asked() {
    let found = doubts("[numerics]\nmesh = 8\n[sweep]\nmesh = [6, 16, 48]");
    let [coarse] = &found[..] else { panic!("{found:?}") };
    assert!(
        coarse.words.starts_with("estimated errors of 1 point are above 10 %: load up to "),
        "{coarse:?}"
    );
    assert!(coarse.filter.contains("estimate_load > 0.1"), "{coarse:?}");
    assert_eq!(doubts("[numerics]\nmesh = 48"), []);
    // A load that holds still need not be near its limit.
    let refined = |until: &str| {
        doubts(&format!(
            "[numerics]\nmesh = 8\n[refine]\non = \"load\"\nuntil = \"{until}\"\nat_most = 64"
        ))
    };
    let [asked] = &refined("0.5%")[..] else { panic!("{:?}", refined("0.5%")) };
    assert!(
        asked.words.contains("of 1 point are above the 0.5 % asked for: load up to"),
        "{asked:?}"
    );
    assert!(asked.words.contains("a smaller `until`"), "{asked:?}");
}

#[test]
fn one_result_has_its_doubts_without_a_study() {
    let study = parse(&format!(
        "name = \"test\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]\n[numerics]\nmesh = 3\n"
    ));
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    let found = warnings(results.record(&choice.points[0]).unwrap());
    let [_, doubt] = &found[..] else { panic!("{found:?}") };
    assert!(doubt.words.starts_with("no error is estimated: "), "{doubt:?}");
}

/// Stresses below the surface on which two ways do not agree are not shown without a word.
#[test]
fn stresses_with_a_large_residual_are_doubted() {
    let study = parse(&format!(
        "name = \"test\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]\n[numerics]\nmesh = 48\n"
    ));
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    let doubts = |residual: Option<f64>| {
        let mut record = results.record(&choice.points[0]).unwrap().clone();
        let Ending::Finished(outcome) = &mut record.ending else { panic!("{record:?}") };
        outcome.further.interior = Some(Interior { residual, ..Interior::default() });
        warnings(&record)
    };
    assert_eq!(doubts(None), []);
    assert_eq!(doubts(Some(1e-9)), []);
    for residual in [0.02, f64::INFINITY] {
        let found = doubts(Some(residual));
        let [doubt] = &found[..] else { panic!("{found:?}") };
        assert!(doubt.words.starts_with("stresses below the surface differ by up to"), "{doubt:?}");
        assert_eq!(doubt.filter, "interior_residual > 1e-5");
    }
}
