//! The points of a study beyond the product of its axes: what is left out.

use study::{NamedFile, Study, StudyError, Value};

/// A study of two axes, beside which the tests write.
const GOOD: &str = r#"name = "good"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 16
[sweep]
"friction.mu" = [0.1, 0.2, 0.3]
"punch.radius" = ["5 mm", "10 mm"]
"#;

/// The name of each case, and what it adds to the study.
const EXCLUSIONS: &[(&str, &str)] = &[
    ("no list of tables", "[exclude]\nwhen = \"mu > 0.2\"\n"),
    ("no condition", "[[exclude]]\n"),
    ("misspelt when", "[[exclude]]\nwhn = \"mu > 0.2\"\n"),
    ("a condition that is a number", "[[keep]]\nwhen = 3\n"),
    ("an empty condition", "[[keep]]\nwhen = \" \"\n"),
    ("a result", "[[exclude]]\nwhen = \"peak_pressure > 1e9\"\n"),
    ("the status", "[[keep]]\nwhen = \"status == 'certified'\"\n"),
    ("a misspelt axis", "[[exclude]]\nwhen = \"radus > 0.007\"\n"),
    ("a key that is not given", "[[exclude]]\nwhen = \"epsilon > 0\"\n"),
    ("the other modulus", "[[exclude]]\nwhen = \"youngs_modulus > 1e9\"\n"),
    ("no grammar", "[[exclude]]\nwhen = \"mu > 0.2 and radius > 0.007\"\n"),
    ("a number and a text", "[[exclude]]\nwhen = \"mu == 'high'\"\n"),
    ("a number alone", "[[exclude]]\nwhen = \"mu\"\n"),
    ("a unit", "[[exclude]]\nwhen = \"radius > 7 mm\"\n"),
    ("nothing left", "[[exclude]]\nwhen = \"mu > 0\"\n"),
    ("nothing kept", "[[keep]]\nwhen = \"radius > 7\"\n"),
    (
        "the axis that is halved",
        "[[exclude]]\nwhen = \"mu > 0.25\"\n[bisect]\naxis = \"mu\"\non = \"load > 0\"\nto = \"1%\"\n",
    ),
    (
        "the mesh that is refined",
        "[[exclude]]\nwhen = \"mesh > 25\"\n[refine]\non = \"load\"\nuntil = \"1%\"\n",
    ),
];

fn no_files(name: &str) -> Result<NamedFile, String> {
    Err(format!("{name}: no such file"))
}

fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut no_files)
}

fn with(addition: &str) -> Study {
    read(&format!("{GOOD}{addition}")).unwrap_or_else(|error| panic!("{addition}{error}"))
}

/// Returns the values of the points of a study, as text.
fn values(study: &Study) -> Vec<String> {
    let row = |point: study::StudyPoint| {
        point.values.iter().map(Value::to_string).collect::<Vec<_>>().join(" ")
    };
    study.points().into_iter().map(row).collect()
}

/// Returns what is said of studies that each case spoils.
fn refusals(cases: &[(&str, &str)]) -> String {
    let mut said = String::new();
    for (name, addition) in cases {
        match read(&format!("{GOOD}{addition}")) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said += &format!("## {name}\n{error}\n\n"),
        }
    }
    said
}

#[test]
fn conditions_without_meaning_are_refused_at_their_place() {
    insta::assert_snapshot!(refusals(EXCLUSIONS));
}

#[test]
fn points_are_left_out_by_any_condition_and_kept_by_any() {
    let all = with("");
    assert_eq!((all.points().len(), all.excluded(), all.has_conditions()), (6, 0, false));
    let left =
        with("[[exclude]]\nwhen = \"mu > 0.25\"\n[[exclude]]\nwhen = \"friction.mu < 0.15\"\n");
    assert_eq!(values(&left), ["0.2 0.005", "0.2 0.01"]);
    assert_eq!(left.excluded(), 4);
    let kept = with(
        "[[keep]]\nwhen = \"mu == 0.1\"\n[[keep]]\nwhen = \"radius == 0.005\"\n\
         [[exclude]]\nwhen = \"mu == 0.3 && punch.radius < 0.007\"\n",
    );
    assert_eq!(values(&kept), ["0.1 0.005", "0.1 0.01", "0.2 0.005"]);
    // A point keeps its index, and its key.
    let indices: Vec<usize> = kept.indices().collect();
    assert_eq!(indices, [0, 1, 2]);
    assert_eq!(left.indices().collect::<Vec<_>>(), [2, 3]);
    assert_eq!(left.points()[0].key, all.points()[2].key);
    assert_eq!(left.index(1), Some(3));
    assert_eq!(left.len(), 6);
}

#[test]
fn conditions_that_change_nothing_are_remarked() {
    let study = with(
        "[[exclude]]\nwhen = \"mu > 2\"\n[[keep]]\nwhen = \"mesh == 16\"\n\
         [[exclude]]\nwhen = \"mu > 0.25\"\n",
    );
    assert_eq!(
        study.remarks(),
        ["[[exclude]] `mu > 2` holds at no point", "[[keep]] `mesh == 16` holds at every point"]
    );
    assert_eq!((study.points().len(), study.excluded()), (4, 2));
}

/// A cone has no radius, and a sphere of no radius is none.
#[test]
fn what_is_left_out_need_make_no_sense() {
    let text = GOOD.replace("\"10 mm\"]", "\"10 mm\", \"-3 mm\"]");
    assert!(read(&text).is_err());
    let study = read(&format!("{text}[[exclude]]\nwhen = \"radius <= 0\"\n")).unwrap();
    assert_eq!((study.points().len(), study.excluded()), (6, 3));
    // The point that makes no sense with the others at their first values is left out as well.
    let text = GOOD.replace("[\"5 mm\",", "[\"-3 mm\", \"5 mm\",");
    let study = read(&format!("{text}[[exclude]]\nwhen = \"radius <= 0\"\n")).unwrap();
    assert_eq!((study.points().len(), study.excluded()), (6, 3));
}

/// A key that only some values of an axis give is `null` at the others.
#[test]
fn labels_and_keys_of_tables_are_names() {
    let text = GOOD.replace(
        "\"punch.radius\" = [\"5 mm\", \"10 mm\"]",
        "punch = [{ shape = \"sphere\", radius = \"5 mm\", label = \"ball\" }, { shape = \"cone\", \
         angle = \"5 deg\" }]",
    );
    let study = read(&format!("{text}[[exclude]]\nwhen = \"punch == 'ball' && mu < 0.15\"\n"));
    assert_eq!(study.unwrap().excluded(), 1);
    for (condition, excluded) in
        [("radius == null", 3), ("shape == 'cone'", 3), ("radius > 0.001", 3), ("angle != null", 3)]
    {
        let study = read(&format!("{text}[[exclude]]\nwhen = \"{condition}\"\n")).unwrap();
        assert_eq!(study.excluded(), excluded, "{condition}");
    }
}

#[test]
fn a_stored_definition_leaves_out_the_same_points() {
    let study = with("[[exclude]]\nwhen = \"mu > 0.25\"\n");
    let stored = Study::from_definition(&study.definition()).unwrap();
    assert_eq!(values(&stored), values(&study));
    assert_eq!(stored.excluded(), 2);
}

/// A study of 10⁹ points is decided where a part of it is taken.
#[test]
fn parts_of_a_large_study_leave_out_their_own_points() {
    let axes = "\"friction.mu\" = { from = 0, to = 1, count = 100000 }\n\
                \"foundation.base.poisson\" = { from = 0, to = 0.45, count = 10000 }\n";
    let text = GOOD.replace("\"friction.mu\" = [0.1, 0.2, 0.3]\n", axes).replace(
        "\"punch.radius\" = [\"5 mm\", \"10 mm\"]\n",
        "[[keep]]\nwhen = \"mu > 0.5 && poisson < 0.225\"\n",
    );
    let study = Study::parse_sharded(&text, "study.toml", &mut no_files).unwrap();
    assert_eq!((study.len(), study.is_listed(), study.excluded()), (1_000_000_000, false, 0));
    let part = study.restricted(vec![0, 700_000_000, 700_000_001, 700_009_999]).unwrap();
    assert_eq!(part.indices().collect::<Vec<_>>(), [700_000_000, 700_000_001]);
    assert_eq!(part.excluded(), 2);
}
