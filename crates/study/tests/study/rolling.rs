//! Steps that roll, in a study file: what they become, what a job writes, and what is refused.

use contact::model::{ImposedCreepages, Loading, Rolling, RollingDirection, RollingHistory, Step};
use proptest::prelude::*;
use study::{Case, Job, NamedFile, Study, StudyError, columns};

fn no_files(name: &str) -> Result<NamedFile, String> {
    Err(format!("{name}: no such file"))
}

/// Returns a study of a wheel with these load steps and these further lines.
fn text(steps: &str, more: &str) -> String {
    format!(
        "name = \"roll\"\n[scene]\nfoundation.base = {{ youngs_modulus = \"210 GPa\", poisson = \
         0.28 }}\npunch = {{ shape = \"sphere\", radius = \"0.46 m\", material = {{ \
         youngs_modulus = \"210 GPa\", poisson = 0.28 }} }}\nfriction.mu = 0.3\nloading.steps = \
         [{steps}]\n[numerics]\nmesh = 16\n{more}"
    )
}

fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut no_files)
}

/// Returns the steps of the first point.
fn steps(given: &str) -> Vec<Step> {
    let study = read(&text(given, "")).unwrap_or_else(|error| panic!("{error}"));
    study.points()[0].job.case().unwrap().scene.loading.steps.clone()
}

#[test]
fn the_keys_of_a_step_make_its_rolling() {
    let steady = steps(
        r#"{ normal_force = "80 kN", steady = true, creepage_x = 1e-3, spin = "0.2 1/m", spin_center = "1 mm", direction = "backward" }"#,
    );
    let rolling = Rolling {
        creepage_x: Some(1e-3),
        creepage_y: None,
        spin: Some(0.2),
        spin_center: 1e-3,
        direction: RollingDirection::Backward,
        dq: None,
        distance: None,
        history: RollingHistory::Steady,
        imposed: ImposedCreepages::default(),
    };
    assert_eq!((steady[0].increments, steady[0].rolling), (1, Some(rolling)));
    let governed = steps(
        r#"{ normal_force = "80 kN", steady = true, force_x = "-4 kN", force_y = "1 kN", moment_z = "2 N m", dq = "1 mm" }"#,
    )[0];
    let governing = [governed.force_x, governed.force_y, governed.moment_z];
    assert_eq!(governing, [Some(-4e3), Some(1e3), Some(2.0)]);
    assert_eq!(
        governed.rolling.map(|rolling| (rolling.creepage_x, rolling.dq)),
        Some((None, Some(1e-3)))
    );
    assert_eq!(steps("{ approach = 1e-5, steady = false }")[0].rolling, None);
}

#[test]
fn a_distance_is_divided_evenly() {
    for (given, increments, dq) in [
        ("distance = \"12 mm\", increments = 5", 5, 0.012 / 5.0),
        ("distance = \"12 mm\", dq = \"2 mm\"", 6, 0.002),
        ("distance = \"1.1 m\", dq = \"0.1 m\"", 11, 1.1 / 11.0),
        ("distance = \"12.1 mm\", dq = \"2 mm\"", 7, 0.0121 / 7.0),
        ("distance = \"12 mm\", dq = \"1 m\"", 1, 0.012),
    ] {
        let step = steps(&format!("{{ approach = 1e-5, creepage_y = 1e-3, {given} }}"))[0];
        let rolling = step.rolling.unwrap();
        assert_eq!((step.increments, rolling.dq), (increments, Some(dq)), "{given}");
        assert_eq!(rolling.history, RollingHistory::Transient);
    }
}

#[test]
fn creepages_distances_and_steadiness_are_axes_and_columns() {
    let steps =
        r#"{ normal_force = "80 kN", steady = true }, { distance = "1 mm", dq = "0.5 mm" }"#;
    let axes = "[sweep]\n\"loading.steps[0].creepage_x\" = [0, 1e-3]\n\
                \"loading.steps[0].direction\" = [\"forward\", \"backward\"]\n\
                \"loading.steps[1].distance\" = [\"1 mm\", \"2 mm\"]";
    let study = read(&text(steps, axes)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(study.len(), 8);
    let columns = study.columns();
    let last = study.point(7).unwrap();
    for (name, value) in [
        ("creepage_x", "0.001"),
        ("loading.steps[0].direction", "backward"),
        ("steady", "true"),
        ("step1_distance", "0.002"),
        ("step1_dq", "0.0005"),
    ] {
        let column = columns::find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
        assert_eq!(column.value(&last, None).to_string(), value, "{name}");
    }
    let rolls = "[sweep]\n\"loading.steps[0].steady\" = [true, false]";
    let study = read(&text("{ normal_force = \"80 kN\" }", rolls)).unwrap();
    let rolling = |point: usize| {
        study.point(point).unwrap().job.case().unwrap().scene.loading.steps[0].rolling
    };
    assert!(rolling(0).is_some() && rolling(1).is_none());
}

/// Each is refused with its place, and in words.
#[test]
fn steps_that_cannot_roll_are_refused() {
    let press = "normal_force = \"80 kN\"";
    let refusals = [
        ("creepage without rolling", "creepage_x = 1e-3"),
        ("spin of a step that is not steady", "spin = 0.1, steady = false"),
        ("direction of nothing", "direction = \"backward\""),
        ("steady and a distance", "steady = true, distance = \"1 mm\""),
        ("steady in increments", "steady = true, increments = 3"),
        ("steady in words", "steady = \"yes\""),
        ("several creepages without rolling", "direction = \"backward\", spin = 1, creepage_x = 0"),
        ("distance in countless increments", "distance = \"10 mm\", dq = 1e-300"),
        ("distance in more increments than numbers", "distance = \"10 mm\", dq = 5e-324"),
        ("distance that cannot be divided", "distance = 5e-324, increments = 2"),
        ("distance to the back, undivided", "distance = \"-10 mm\""),
        ("distance divided twice", "distance = \"10 mm\", dq = \"1 mm\", increments = 10"),
        ("distance in no increments", "distance = \"10 mm\", increments = 0"),
        ("distance in too many increments", "distance = \"10 mm\", dq = \"1 um\""),
        ("distance to the back", "distance = \"-10 mm\", increments = 5"),
        ("no distance", "distance = 0, increments = 5"),
        ("dq to the back", "distance = \"10 mm\", dq = \"-1 mm\""),
        ("dq of nothing", "steady = true, dq = 0"),
        ("creepage with a unit", "steady = true, creepage_x = \"1 mm\""),
        ("creepage in percent", "steady = true, creepage_x = \"0.1 %\""),
        ("spin as an angle", "steady = true, spin = \"1 deg\""),
        ("spin per millimetre, misspelt", "steady = true, spin = \"1 /mm\""),
        ("spin that is no number", "steady = true, spin = nan"),
        ("direction that is none", "steady = true, direction = \"left\""),
        ("creepage and its force", "steady = true, creepage_x = 1e-3, force_x = \"1 kN\""),
        ("spin and its moment", "steady = true, spin = 0.1, moment_z = \"1 N m\""),
        ("shift in a step that rolls", "steady = true, shift_x = \"1 um\""),
        ("twist along a distance", "distance = \"1 mm\", increments = 2, twist = 0.1"),
        ("centre of no spin", "steady = true, spin_center = \"1 mm\""),
        ("misspelt creepage", "steady = true, creepage = 1e-3"),
        ("creep by another name", "steady = true, slip_x = 1e-3"),
    ];
    let mut said = String::new();
    for (name, given) in refusals {
        let error = read(&text(&format!("{{ {press}, {given} }}"), "")).expect_err(name);
        said += &format!("## {name}\n{error}\n");
    }
    for (name, more) in [
        ("a regularised step", "epsilon = 1e-6\n"),
        ("a steady step by Seidel's method", "method = \"seidel\"\n"),
        ("a step of a search", "[search]\nstarts = 3\n"),
    ] {
        let kind = if name.ends_with("search") { "kind = \"multiplicity\"\n" } else { "" };
        let text = kind.to_owned() + &text(&format!("{{ {press}, steady = true }}"), more);
        said += &format!("## {name}\n{}\n", read(&text).expect_err(name));
    }
    let axis = "[sweep]\n\"loading.steps[0].creepage_x\" = [0, 1e-3]";
    let error = read(&text(&format!("{{ {press} }}"), axis)).expect_err("an axis");
    said += &format!("## an axis of creepages of a step that does not roll\n{error}\n");
    insta::assert_snapshot!(said);
}

prop_compose! {
    fn rolling_step()(
        creepages in prop::array::uniform3(prop::option::of(-1e-2..1e-2f64)),
        center in prop_oneof![Just(0.0), -1e-2..1e-2f64],
        is_backward in any::<bool>(),
        distance in 1e-6..10.0f64,
        increments in 1u32..300,
        dq in prop::option::of(1e-6..1.0f64),
        is_steady in any::<bool>(),
    ) -> Step {
        let [creepage_x, creepage_y, spin] = creepages;
        let rolling = Rolling {
            creepage_x,
            creepage_y,
            spin,
            spin_center: if spin.is_some() { center } else { 0.0 },
            direction: if is_backward { RollingDirection::Backward } else { RollingDirection::Forward },
            dq: if is_steady { dq } else { Some(distance / f64::from(increments)) },
            distance: None,
            history: if is_steady { RollingHistory::Steady } else { RollingHistory::Transient },
            imposed: ImposedCreepages::default(),
        };
        let increments = if is_steady { 1 } else { increments };
        Step { normal_force: Some(1e3), increments, rolling: Some(rolling), ..Step::default() }
    }
}

/// A distance that nothing else divides is divided by the elements, which the job does not know.
#[test]
fn a_distance_alone_is_left_to_the_elements() {
    let given = "{ normal_force = \"80 kN\", distance = \"10 mm\", creepage_x = 1e-3 }";
    let study = read(&text(given, "")).unwrap();
    let job = &study.points()[0].job;
    let step = job.case().unwrap().scene.loading.steps[0];
    let rolling = step.rolling.unwrap();
    assert_eq!((step.increments, rolling.dq, rolling.distance), (1, None, Some(0.01)));
    assert_eq!(rolling.history, RollingHistory::Transient);
    let written = job.to_toml();
    assert!(written.contains("distance = 0.01") && !written.contains("increments"), "{written}");
    assert_eq!(Job::parse(&job.canonical()).unwrap(), *job);
    let columns = study.columns();
    let value = |name: &str| {
        columns::find(&columns, name).map(|column| column.value(&study.points()[0], None))
    };
    assert_eq!(value("distance"), Some(study::Value::Number(0.01)));
    assert_eq!(value("dq").unwrap_or(study::Value::Missing), study::Value::Missing);
    assert_eq!(value("increments"), Some(study::Value::Missing));
}

/// A creepage that is 0 unless it is given leaves no trace where 0 is given.
#[test]
fn creepages_of_nothing_leave_no_trace() {
    let key = |steps: &str| read(&text(steps, "")).unwrap().points()[0].key;
    let same = |steps: [&str; 2]| assert_eq!(key(steps[0]), key(steps[1]), "{steps:?}");
    let differ = |steps: [&str; 2]| assert_ne!(key(steps[0]), key(steps[1]), "{steps:?}");
    let press = "normal_force = \"80 kN\"";
    let roll = |more: &str| format!("{{ {press}, steady = true, spin = 0.1{more} }}");
    same([&roll(""), &roll(", creepage_x = 0, creepage_y = -0.0")]);
    same([
        &format!("{{ {press}, steady = true }}"),
        &format!("{{ {press}, steady = true, spin = 0, spin_center = 1e-3 }}"),
    ]);
    // A force of the step before would govern it.
    let pull = |more: &str| format!("{{ {press}, force_x = \"1 kN\" }}, {{ steady = true{more} }}");
    same([&pull(""), &pull(", creepage_y = 0")]);
    differ([&pull(""), &pull(", creepage_x = 0")]);
}

/// A flag is true or false in conditions, as it is in the file.
#[test]
fn conditions_know_flags() {
    let steps = "{ normal_force = \"80 kN\", creepage_x = 1e-3, steady = true }";
    let axes =
        "[sweep]\nfriction.mu = [0.1, 0.3]\n[[exclude]]\nwhen = \"steady == true && mu > 0.2\"\n";
    let study = read(&text(steps, axes)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((study.len(), study.points().len()), (2, 1));
    let columns = study.columns();
    let column = columns::find(&columns, "steady").unwrap();
    assert_eq!(column.values(), study::ValueType::Flag);
    assert_eq!(column.value(&study.points()[0], None), study::Value::Flag(true));
    // Python and pandas write them with capitals.
    let listed = text(steps, "[points]\nfile = \"points.csv\"\n");
    let with_file = |lines: &str| {
        let bytes = format!("loading.steps[0].steady,loading.steps[0].distance\n{lines}");
        let mut file =
            |_: &str| Ok(NamedFile { bytes: bytes.clone().into_bytes(), may_quote: true });
        Study::parse(&listed, "study.toml", &mut file)
    };
    let distance = |word: &str| format!("{word},0.001\n");
    for word in ["false", "False"] {
        let study = with_file(&distance(word)).unwrap_or_else(|error| panic!("{error}"));
        let step = study.points()[0].job.case().unwrap().scene.loading.steps[0];
        assert_eq!(step.rolling.unwrap().history, RollingHistory::Transient);
    }
    for word in ["true", "True"] {
        let error = with_file(&distance(word)).unwrap_err().to_string();
        assert!(error.contains("cannot stand beside"), "{error}");
    }
    assert!(with_file(&distance("yes")).unwrap_err().to_string().contains("true or false"));
}

proptest! {
    #[test]
    fn what_a_rolling_job_writes_is_read(steps in prop::collection::vec(rolling_step(), 1..4)) {
        let study = read(&text("{ approach = 1e-5 }", "")).unwrap();
        let mut case: Case = study.points()[0].job.case().unwrap().clone();
        case.scene.loading = Loading::path(steps);
        let job = Job::Solve(case);
        let written = format!("name = \"job\"\n{}", job.to_toml());
        let again = read(&written).unwrap_or_else(|error| panic!("{written}\n{error}"));
        prop_assert_eq!(&again.points()[0].job, &job, "{}", written);
        prop_assert_eq!(Job::parse(&job.canonical()).map(|parsed| parsed.key()).ok(), Some(job.key()));
    }
}
