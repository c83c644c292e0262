//! Results that are read in blocks say what results in memory say.

use answers::{Results, RowSource, Selection};
use study::{Figure, Study};

use crate::shelf::Shelf;
use crate::{SPHERES, parse};

/// Returns a study of 18 points.
fn study() -> Study {
    parse(&format!(
        "name = \"test\"\n{SPHERES}loading.steps = [{{ approach = \"1 um\" }}]\n\
         [numerics]\nmesh = 8\n[sweep]\nfriction.mu = [0.1, 0.2, 0.4]\n\
         \"loading.steps[0].approach\" = [\"1 um\", \"5 um\", \"20 um\"]\nmesh = [2, 6]\n"
    ))
}

#[test]
fn results_in_blocks_are_those_in_memory() {
    let study = study();
    let mut shelf = Shelf::default();
    let points = shelf.run(&study).points;
    shelf.fail(&points[4].key);
    shelf.set_aside(&points[7].key);
    shelf.make_older(&points[9].key);
    let whole = Results::read(study.clone(), &shelf).unwrap();
    let blocks = Results::in_blocks_above(1, study.clone(), &shelf).unwrap();
    assert!(blocks.points().is_empty(), "its points are not in memory");

    assert_eq!(blocks.progress(), whole.progress());
    assert_eq!(blocks.warnings(), whole.warnings());
    assert!(!whole.warnings().is_empty());
    assert_eq!(blocks.failures(), whole.failures());
    assert_eq!(whole.failures().count, 2);
    assert_eq!(blocks.inaccurate(), whole.inaccurate());
    assert_eq!(blocks.answers().unwrap(), whole.answers().unwrap());
    assert_eq!(blocks.figures().unwrap(), whole.figures().unwrap());
    assert_eq!(blocks.usual_columns(false).unwrap(), whole.usual_columns(false).unwrap());
    assert_eq!(blocks.usual_columns(true).unwrap(), whole.usual_columns(true).unwrap());
    assert_eq!(blocks.usual_table().unwrap(), whole.usual_table().unwrap());
    assert_eq!(blocks.increments().unwrap(), whole.increments().unwrap());
    let drawn = Figure::new("mu".to_owned(), vec!["load".to_owned(), "dissipation".to_owned()]);
    for figure in whole.figures().unwrap().iter().chain([&drawn]) {
        for filter in [None, Some("mesh == 6 && hertz_peak_pressure > 0"), Some("load > 1")] {
            let names: Vec<&String> = figure.shown().chain([&figure.x]).collect();
            let rows = |results: &Results<'_>| {
                let rows = results.figure_rows(figure, filter).unwrap();
                (rows.table.select(&names).unwrap(), rows.undrawn)
            };
            assert_eq!(rows(&blocks), rows(&whole), "{filter:?}");
        }
        assert!(blocks.figure_rows(figure, Some("mush > 1")).is_err());
    }
}

#[test]
fn rows_are_gathered_as_they_are_chosen_in_memory() {
    let study = study();
    let mut shelf = Shelf::default();
    shelf.run(&study);
    let results = Results::read(study.clone(), &shelf).unwrap();
    let source = RowSource::Records { records: &shelf, keeper: None };
    for (filter, sort) in [
        (None, vec![]),
        (Some("mesh == 6"), vec!["-load", "mu"]),
        (Some("load > 1e300"), vec!["approach"]),
    ] {
        let selection = Selection {
            filter: filter.map(str::to_owned),
            sort: sort.iter().map(|name: &&str| (*name).to_owned()).collect(),
            columns: ["stick_fraction", "mu"].map(str::to_owned).to_vec(),
            steps: false,
        };
        let (gathered, _) = selection.gathered(&study, source, 18).unwrap().unwrap();
        assert_eq!(gathered, selection.of(&results).unwrap(), "{filter:?}");
    }
    let all = Selection { columns: vec!["mu".to_owned()], ..Selection::default() };
    assert!(all.gathered(&study, source, 17).unwrap().is_none(), "there are 18 rows");
}
