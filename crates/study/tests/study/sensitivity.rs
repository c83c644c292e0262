//! Studies of sensitivity: the rows of their designs, and what is refused of them.

use study::figure::FigureKind;
use study::kind::sensitivity::{SensitivityMethod, SobolEstimators};
use study::{Study, Value};

/// A good study; every case below spoils it in one way.
const GOOD: &str = r#"name = "moved"
kind = "sensitivity"
[scene.foundation]
base = { shear_modulus = "80 GPa", poisson = 0.3 }
[scene.punch]
shape = "sphere"
radius = "10 mm"
[scene.friction]
mu = 0.3
[scene.loading]
steps = [{ approach = "1 um" }]

[numerics]
mesh = 16

[sensitivity]
method = "sobol"
of = ["load", "peak_pressure"]

[sample]
method = "sobol"
count = 4
seed = 3

[sample.keys]
"friction.mu" = { from = 0.1, to = 0.5 }
"punch.radius" = { distribution = "normal", mean = "10 mm", deviation = "0.5 mm" }
"#;

const METHOD: &str = "[sensitivity]\nmethod = \"sobol\"";
const MORRIS: &str = "[sensitivity]\nmethod = \"morris\"";
const SAMPLE: &str = "[sample]\nmethod = \"sobol\"";
const OF: &str = "of = [\"load\", \"peak_pressure\"]";

/// The name of each case, the text that is replaced, and its replacement.
const CASES: &[(&str, &str, &str)] = &[
    ("unknown method", METHOD, "[sensitivity]\nmethod = \"fast\""),
    ("method is a number", METHOD, "[sensitivity]\nmethod = 1"),
    ("unknown estimator", METHOD, "[sensitivity]\nestimator = \"janson\""),
    ("estimator of morris", METHOD, "[sensitivity]\nmethod = \"morris\"\nestimator = \"jansen\""),
    ("levels of sobol", METHOD, "[sensitivity]\nlevels = 4"),
    ("trajectories of a sequence", METHOD, MORRIS),
    ("unknown key of the table", OF, "off = [\"load\"]"),
    ("unknown result", OF, "of = [\"peak_presure\"]"),
    ("a result of words", OF, "of = \"status\""),
    ("no result", OF, "of = []"),
    ("a result twice", OF, "of = [\"load\", \"load\"]"),
    ("results are a number", OF, "of = 3"),
    ("a table of another kind", "kind = \"sensitivity\"", "kind = \"solve\""),
    ("meshes by accuracy", "kind = \"sensitivity\"", "kind = \"sensitivity\"\naccuracy = \"1%\""),
    (
        "meshes that are refined",
        "[sensitivity]",
        "[refine]\non = \"load\"\nuntil = \"1%\"\n[sensitivity]",
    ),
    (
        "axes that are filled",
        "[sensitivity]",
        "[fill]\naxis = \"friction.mu\"\ncolumn = \"load\"\n[sensitivity]",
    ),
    (
        "a figure over something",
        "[sample]\n",
        "[figure]\nkind = \"sensitivity\"\nx = \"mu\"\ny = \"load\"\n[sample]\n",
    ),
    ("a figure of nothing", "[sample]\n", "[figure]\nkind = \"sensitivity\"\n[sample]\n"),
];

/// The cases of trajectories, likewise.
const TRAJECTORIES: &[(&str, &str, &str)] = &[
    ("a distribution without ends", "levels = 4", "levels = 8"),
    ("an odd number of levels", "levels = 4", "levels = 5"),
    ("one level", "levels = 4", "levels = 1"),
    ("no levels", "levels = 4", "levels = 0"),
    ("too many trajectories", "count = 4", "count = 4000000000"),
];

fn read(text: &str) -> Result<Study, study::StudyError> {
    Study::parse(text, "study.toml", &mut |_| Err("there are no files".to_owned()))
}

fn good(text: &str) -> Study {
    read(text).unwrap_or_else(|error| panic!("{error}"))
}

fn trajectories() -> String {
    GOOD.replace(METHOD, &format!("{MORRIS}\nlevels = 4"))
        .replace(SAMPLE, "[sample]\nmethod = \"random\"")
}

/// Trajectories of a key that has two ends.
fn bounded() -> String {
    trajectories().replace(
        "deviation = \"0.5 mm\"",
        "deviation = \"0.5 mm\", from = \"9 mm\", to = \"12 mm\"",
    )
}

#[test]
fn every_refusal_of_a_study_of_sensitivity_is_clear() {
    let mut said = String::new();
    let mut refuse = |name: &str, text: &str, old: &str, new: &str| {
        assert!(text.contains(old), "{name}");
        match read(&text.replacen(old, new, 1)) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said.push_str(&format!("## {name}\n{error}\n\n")),
        }
    };
    for (name, old, new) in CASES {
        refuse(name, GOOD, old, new);
    }
    for (name, old, new) in TRAJECTORIES {
        refuse(name, &trajectories(), old, new);
    }
    let (without, _) = GOOD.split_once("[sample]").unwrap();
    refuse("no sample", without, "mesh = 16", "mesh = 8");
    let plain = GOOD.replace("kind = \"sensitivity\"\n", "").replace(METHOD, "").replace(OF, "");
    let figure = "[figure]\nkind = \"sensitivity\"\ny = \"load\"\n[sample]\n";
    refuse("a figure of another kind of study", &plain, "[sample]\n", figure);
    insta::assert_snapshot!(said);
}

/// Returns the drawn values of each point.
fn drawn(study: &Study) -> Vec<[f64; 2]> {
    let number = |value: &Value| value.as_f64().unwrap();
    let point = |index: usize| study.point(index).unwrap().values;
    (0..study.len()).map(point).map(|values| [number(&values[0]), number(&values[1])]).collect()
}

#[test]
fn a_row_has_two_points_and_those_between_them() {
    let study = good(GOOD);
    assert_eq!(
        (study.len(), study.sensitivity()),
        (16, Some(SensitivityMethod::Sobol(SobolEstimators::Usual)))
    );
    for row in drawn(&study).chunks(4) {
        let [a, first, second, b] = row else { panic!("four points") };
        assert_eq!((first, second), (&[b[0], a[1]], &[a[0], b[1]]));
        assert!(a[0] != b[0] && a[1] != b[1]);
    }
}

#[test]
fn a_larger_count_keeps_every_job() {
    for text in [GOOD.to_owned(), bounded()] {
        let keys = |count: usize| -> Vec<String> {
            let study = good(&text.replace("count = 4", &format!("count = {count}")));
            study.points().iter().map(|point| point.key.to_string()).collect()
        };
        let (few, many) = (keys(4), keys(7));
        assert_eq!(few[..], many[..few.len()]);
        assert!(many.len() == few.len() / 4 * 7);
    }
}

#[test]
fn the_jobs_are_those_of_any_other_study() {
    let key = |study: &Study| study.point(0).unwrap().key;
    let study = good(GOOD);
    let [mu, radius] = drawn(&study)[0];
    let (before, _) = GOOD.split_once("[sensitivity]").unwrap();
    let alone = before
        .replace("kind = \"sensitivity\"\n", "")
        .replace("mu = 0.3", &format!("mu = {mu}"))
        .replace("\"10 mm\"", &format!("{radius}"));
    assert_eq!(key(&good(&alone)), key(&study));
}

#[test]
fn a_trajectory_moves_one_key_at_a_time_over_the_whole_range() {
    let study = good(&bounded().replace("count = 4", "count = 50"));
    assert_eq!((study.len(), study.sensitivity()), (150, Some(SensitivityMethod::Morris)));
    let points = drawn(&study);
    let mut levels: Vec<String> = points.iter().map(|[mu, _]| format!("{mu:.4}")).collect();
    levels.sort_unstable();
    levels.dedup();
    assert_eq!(levels, ["0.1000", "0.2333", "0.3667", "0.5000"]);
    let (mut first, mut upwards) = ([0_usize; 2], 0_usize);
    for trajectory in points.chunks(3) {
        let moved = |step: usize| -> Vec<usize> {
            (0..2).filter(|key| trajectory[step][*key] != trajectory[step + 1][*key]).collect()
        };
        let (one, other) = (moved(0), moved(1));
        assert!(one.len() == 1 && other.len() == 1 && one != other, "{trajectory:?}");
        first[one[0]] += 1;
        upwards += usize::from(trajectory[2][0] > trajectory[0][0]);
        // Half of the levels lie between the two places of a key.
        let step = (trajectory[2][0] - trajectory[0][0]).abs();
        assert!((step - 2.0 / 3.0 * 0.4).abs() < 1e-12, "{step}");
    }
    // Every order and direction occurs: 50 tosses are within 4 deviations.
    assert!(first[0].abs_diff(25) < 14 && upwards.abs_diff(25) < 14, "{first:?} {upwards}");
}

#[test]
fn results_that_are_not_named_are_those_that_the_scenes_leave_free() {
    let study = good(GOOD);
    assert_eq!(study.results_of_interest(), ["load", "peak_pressure"]);
    assert_eq!(study.figures()[0].kind, FigureKind::Sensitivity);
    let unnamed = good(&GOOD.replace(OF, ""));
    assert_eq!(unnamed.results_of_interest(), ["load", "peak_pressure", "contact_area"]);
    let drawn = "[figure]\nkind = \"sensitivity\"\ny = \"energy\"\n[sample]\n";
    let figure = good(&GOOD.replace(OF, "").replace("[sample]\n", drawn));
    assert_eq!(figure.results_of_interest(), ["energy"]);
    assert!(figure.figures()[0].x.is_empty());
}

#[test]
fn a_study_without_a_table_is_of_the_usual_method() {
    let study = good(&GOOD.replace(&format!("{METHOD}\n{OF}\n"), ""));
    let usual = SensitivityMethod::Sobol(SobolEstimators::Usual);
    assert_eq!(study.sensitivity(), Some(usual));
    let jansen = good(&GOOD.replace(METHOD, "[sensitivity]\nestimator = \"jansen\""));
    let expected = SensitivityMethod::Sobol(SobolEstimators::Jansen);
    assert_eq!(jansen.sensitivity(), Some(expected));
}

/// Rows and other levels are other points, as those of another seed are, which loses nothing that
/// could be kept.
#[test]
fn another_arrangement_is_another_sample() {
    let plain = GOOD
        .replace("kind = \"sensitivity\"\n", "")
        .replace(&format!("{METHOD}\n{OF}\n"), "")
        .replace("count = 4", "count = 64");
    let kept = |text: &str, former: &str| good(text).require_kept_points(&good(former));
    assert_eq!(kept(GOOD, &plain), Ok(()));
    assert_eq!(kept(&plain, GOOD), Ok(()));
    let levels = |levels: &str| bounded().replace("levels = 4", levels);
    assert_eq!(kept(&levels("levels = 8"), &levels("levels = 4")), Ok(()));
    let hypercube = GOOD.replace(SAMPLE, "[sample]\nmethod = \"latin-hypercube\"");
    let refused = kept(&hypercube.replace("count = 4", "count = 6"), &hypercube).unwrap_err();
    let message = &refused.mistakes()[0].message;
    assert!(message.starts_with("a Latin hypercube of 6 rows keeps none of the 4"), "{message}");
}
