//! Wear in a study file: what its keys become, what a job writes, and what is refused.

use contact::model::{Scene, Wear};
use proptest::prelude::*;
use study::{Case, Job, NamedFile, Study, StudyError, columns};

fn no_files(name: &str) -> Result<NamedFile, String> {
    Err(format!("{name}: no such file"))
}

/// Returns a study of a ball that frets, with this `wear` and these further lines.
fn text(wear: &str, more: &str) -> String {
    format!(
        "name = \"fret\"\n[scene]\nfoundation.base = {{ youngs_modulus = \"210 GPa\", poisson = \
         0.3 }}\npunch = {{ shape = \"sphere\", radius = \"10 mm\" }}\nfriction.mu = 0.6\n{wear}\n\
         [scene.loading]\nsteps = [{{ normal_force = \"50 N\" }}, {{ shift_x = \"5 um\" }}, \
         {{ shift_x = \"-5 um\" }}]\ncycle_from = 1\ncycles = 2\n[numerics]\nmesh = 16\n{more}"
    )
}

fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut no_files)
}

fn wear(given: &str) -> Option<Wear> {
    let study = read(&text(given, "")).unwrap_or_else(|error| panic!("{error}"));
    study.points()[0].job.case().unwrap().scene.wear
}

#[test]
fn the_keys_of_wear_make_it() {
    let plain = Wear { coefficient: 1e-14, update: false, repeat: 1 };
    for coefficient in [
        "1e-14",
        "\"1e-14 1/Pa\"",
        "\"1e-8 1/MPa\"",
        "\"1e-8 mm^2/N\"",
        "\"1e-5 mm^3/(N m)\"",
        "\"1e-5 mm³/Nm\"",
        "\"1e-5 mm³/(N·m)\"",
    ] {
        assert_eq!(
            wear(&format!("wear.coefficient = {coefficient}")),
            Some(plain),
            "{coefficient}"
        );
    }
    let updated = "wear = { coefficient = 1e-14, update = true, repeat = 100 }";
    let expected = Wear { update: true, repeat: 100, ..plain };
    assert_eq!(wear(updated), Some(expected));
    assert_eq!(wear("wear = { coefficient = 1e-14, update = false }"), Some(plain));
    assert_eq!(wear(""), None);
}

#[test]
fn a_figure_over_the_coefficient_shows_the_depth_of_wear() {
    let axis = "[sweep]\nwear.coefficient = [1e-14, 1e-13]";
    let study = read(&text("wear.coefficient = 1e-14", axis)).unwrap();
    assert_eq!(study.figures()[0].y, ["wear_depth"]);
    assert_eq!(study.points()[0].job.asked_columns(), ["wear_depth"]);
}

/// A scene that says nothing of wear is the job that it always was, and defaults leave no trace.
#[test]
fn a_job_without_wear_does_not_mention_it() {
    let canonical = |given: &str| read(&text(given, "")).unwrap().points()[0].job.canonical();
    assert!(!canonical("").contains("wear"));
    let brief = canonical("wear.coefficient = 1e-14");
    assert!(brief.contains(r#""friction":{"mu":0.6},"wear":{"coefficient":1e-14},"loading""#));
    assert_eq!(canonical("wear = { coefficient = 1e-14, update = false, repeat = 1 }"), brief);
    assert_eq!(canonical("wear.coefficient = -0.0"), canonical("wear.coefficient = 0"));
}

#[test]
fn wear_can_be_swept_drawn_and_derived() {
    let sweep = "[sweep]\n\"wear.coefficient\" = { from = \"1e-9 1/MPa\", to = \"1e-7 1/MPa\", \
                 count = 3, log = true }\n\"wear.update\" = [true, false]";
    let study = read(&text("wear.coefficient = 1e-14", sweep)).unwrap_or_else(|e| panic!("{e}"));
    let all: Vec<Wear> =
        study.points().iter().filter_map(|point| point.job.case()?.scene.wear).collect();
    assert_eq!(all.len(), 6);
    assert_eq!(all[2], Wear { coefficient: 1e-14, update: true, repeat: 1 });
    let columns = study.columns();
    for (name, value) in [("wear_coefficient", "1e-15"), ("wear_update", "true")] {
        let column = columns::find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
        assert_eq!(column.value(&study.points()[0], None).to_string(), value, "{name}");
    }
    let results =
        ["wear_depth", "wear_volume", "cycle_wear_depth", "cycle_wear_volume", "wear_per_length"];
    for name in results {
        assert!(columns::find(&columns, name).is_some(), "{name}");
    }
    let derived = "[derive]\n\"wear.coefficient\" = \"1e-4 / (2 GPa)\"\n";
    let study = read(&text("", derived)).unwrap_or_else(|error| panic!("{error}"));
    let case = study.points()[0].job.case().unwrap().clone();
    assert_eq!(case.scene.wear.map(|wear| wear.coefficient), Some(1e-4 / 2e9));
}

#[test]
fn wear_that_cannot_be_is_refused_in_words() {
    let mut said = String::new();
    for (name, given) in [
        ("no coefficient", "wear.update = true"),
        ("an empty table", "[scene.wear]"),
        ("a coefficient below 0", "wear.coefficient = -1e-14"),
        ("a coefficient that is no number", "wear.coefficient = nan"),
        ("an infinite coefficient", "wear.coefficient = inf"),
        ("a coefficient as a pressure", "wear.coefficient = \"1e-14 Pa\""),
        ("a misspelt unit", "wear.coefficient = \"1e-8 MPa^-1\""),
        ("a coefficient without its unit", "wear.coefficient = \"1e-14\""),
        ("a hardness", "wear = { coefficient = 1e-4, hardness = \"2 GPa\" }"),
        ("k by its letter", "wear = { k = 1e-14 }"),
        ("an update in words", "wear = { coefficient = 1e-14, update = \"yes\" }"),
        ("no cycles", "wear = { coefficient = 1e-14, update = true, repeat = 0 }"),
        ("half a cycle", "wear = { coefficient = 1e-14, update = true, repeat = 0.5 }"),
        ("too many cycles", "wear = { coefficient = 1e-14, update = true, repeat = 1000001 }"),
        ("a number in place of the table", "wear = 1e-14"),
    ] {
        let error = read(&text(given, "")).expect_err(name);
        said += &format!("## {name}\n{error}\n");
    }
    let updated = "wear = { coefficient = 1e-14, update = true, repeat = 10 }";
    let replaced = |given: &str, from: &str, to: &str| text(given, "").replace(from, to);
    for (name, text) in [
        ("nothing of friction", replaced("wear.coefficient = 1e-14", "friction.mu = 0.6\n", "")),
        ("no friction", replaced("wear.coefficient = 1e-14", "mu = 0.6", "mu = 0")),
        (
            "no friction on an axis",
            text("wear.coefficient = 1e-14", "[sweep]\n\"friction.mu\" = [0.3, 0]"),
        ),
        ("cycles without a cycle", replaced(updated, "cycle_from = 1\ncycles = 2\n", "")),
        (
            "an update of a shape that rolls",
            replaced(updated, "{ shift_x = \"-5 um\" }", "{ steady = true, creepage_x = 1e-3 }"),
        ),
        (
            "cycles in place of one that rolls",
            replaced(
                "wear = { coefficient = 1e-14, repeat = 10 }",
                "{ shift_x = \"-5 um\" }",
                "{ steady = true, creepage_x = 1e-3 }",
            ),
        ),
        (
            "wear in a search",
            format!("kind = \"multiplicity\"\n{}", text("wear.coefficient = 1e-14", "")),
        ),
    ] {
        let error = read(&text).expect_err(name);
        said += &format!("## {name}\n{error}\n");
    }
    insta::assert_snapshot!(said);
}

proptest! {
    #[test]
    fn what_a_job_that_wears_writes_is_read(
        coefficient in prop_oneof![Just(0.0), 1e-30..1e3f64],
        update in any::<bool>(),
        cycles in 1u32..1_000_000,
    ) {
        let study = read(&text("", "")).unwrap();
        let mut case: Case = study.points()[0].job.case().unwrap().clone();
        let wear = Some(Wear { coefficient, update, repeat: cycles });
        case.scene = Scene { wear, ..case.scene };
        let job = Job::Solve(case);
        let written = format!("name = \"job\"\n{}", job.to_toml());
        let again = read(&written).unwrap_or_else(|error| panic!("{written}\n{error}"));
        prop_assert_eq!(&again.points()[0].job, &job, "{}", written);
        let parsed = Job::parse(&job.canonical()).map(|parsed| parsed.key()).ok();
        prop_assert_eq!(parsed, Some(job.key()));
    }
}
