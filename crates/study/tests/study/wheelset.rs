//! The motion of a wheelset, in a study file: what it becomes, what a job writes, and what is
//! refused.

use contact::model::{Shape, WheelsetMotion};
use proptest::prelude::*;
use study::{Case, Job, NamedFile, Study, StudyError, columns};

const WHEEL: &[u8] = include_bytes!("../../../../sweeps/profiles/MBench_S1002_v3.prw");
const RAIL: &[u8] = include_bytes!("../../../../sweeps/profiles/MBench_UIC60_v3.prr");

fn files(name: &str) -> Result<NamedFile, String> {
    let bytes = if name.ends_with("prw") { WHEEL } else { RAIL };
    Ok(NamedFile { bytes: bytes.to_vec(), may_quote: true })
}

/// Returns a study of a wheel on its rail with these keys of the punch, these load steps, and these
/// further lines.
fn text(punch: &str, steps: &str, more: &str) -> String {
    format!(
        "name = \"creep\"\n[scene]\nfoundation.base = {{ youngs_modulus = \"210 GPa\", poisson = \
         0.28 }}\nfriction.mu = 0.3\nloading.steps = [{steps}]\n[scene.punch]\nshape = \
         \"wheel-on-rail\"\nwheel = \"w.prw\"\nrail = \"r.prr\"\nside = \"right\"\nrolling_radius = \
         \"460 mm\"\nmaterial = {{ youngs_modulus = \"210 GPa\", poisson = 0.28 }}\n{punch}\n\
         [numerics]\nmesh = 16\n{more}"
    )
}

const ROLLS: &str = "{ normal_force = \"80 kN\", steady = true }";

fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut files)
}

/// Returns the case of the first point.
fn case(punch: &str, steps: &str) -> Case {
    let study = read(&text(punch, steps, "")).unwrap_or_else(|error| panic!("{error}"));
    study.points()[0].job.case().unwrap().clone()
}

fn motion(case: &Case) -> Option<WheelsetMotion> {
    match &case.scene.punch.shape {
        Shape::WheelOnRail(wheel) => wheel.motion,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_keys_of_a_wheelset_make_its_motion() {
    let all = "speed = \"72 km/h\"\nangular_speed = \"43.5 rad/s\"\nlateral_velocity = \
               \"3 mm/s\"\nyaw_rate = \"10 mrad/s\"\nroll_rate = \"-1 mrad/s\"";
    let expected = WheelsetMotion {
        speed: 20.0,
        angular_speed: Some(43.5),
        lateral_velocity: 3e-3,
        yaw_rate: 0.01,
        roll_rate: -1e-3,
    };
    assert_eq!(motion(&case(all, ROLLS)), Some(expected));
    let plain = WheelsetMotion {
        speed: -2.0,
        angular_speed: None,
        lateral_velocity: 0.0,
        yaw_rate: 0.0,
        roll_rate: 0.0,
    };
    let backward = "{ normal_force = \"80 kN\", steady = true, direction = \"backward\" }";
    assert_eq!(motion(&case("speed = -2", backward)), Some(plain));
    // A wheel without a motion has the text that it had before there were any.
    let still = Job::Solve(case("", "{ normal_force = \"80 kN\" }"));
    assert!(!still.canonical().contains("motion"), "{}", still.canonical());
    let moves = Job::Solve(case("speed = 2\nyaw_rate = \"-0 rad/s\"", ROLLS));
    assert!(moves.canonical().contains("\"motion\":{\"speed\":2.0}"), "{}", moves.canonical());
}

#[test]
fn velocities_are_axes_columns_and_in_formulas() {
    let axes = "[sweep]\n\"punch.lateral_velocity\" = [0, \"0.1 m/s\"]\n[derive]\n\
                \"punch.angular_speed\" = \"1.01 * speed / rolling_radius\"";
    let study = read(&text("speed = \"20 m/s\"", ROLLS, axes)).unwrap_or_else(|e| panic!("{e}"));
    let last = study.point(1).unwrap();
    let columns = study.columns();
    for (name, value) in
        [("speed", 20.0), ("lateral_velocity", 0.1), ("angular_speed", 20.2 / 0.46)]
    {
        let column = columns::find(&columns, name).unwrap();
        let found: f64 = column.value(&last, None).to_string().parse().unwrap();
        assert!((found / value - 1.0).abs() < 1e-12, "{name} {found}");
    }
}

/// Each is refused with its place, and in words.
#[test]
fn motions_that_make_no_sense_are_refused() {
    let speed = "speed = \"20 m/s\"";
    let refusals = [
        ("a wheelset that stands", "speed = 0", ROLLS),
        ("a speed of a wheel that is only pressed", speed, "{ normal_force = \"80 kN\" }"),
        ("a yaw rate without a speed", "yaw_rate = 0.1", ROLLS),
        ("an angular speed without a speed", "angular_speed = \"43 rad/s\"", ROLLS),
        ("a speed that is a length", "speed = \"20 m\"", ROLLS),
        ("a speed in knots", "speed = \"20 kn\"", ROLLS),
        ("a yaw rate as an angle", "speed = 2\nyaw_rate = \"1 mrad\"", ROLLS),
        ("an angular speed that is a velocity", "speed = 2\nangular_speed = \"2 m/s\"", ROLLS),
        ("a speed that is no number", "speed = nan", ROLLS),
        ("an infinite roll rate", "speed = 2\nroll_rate = inf", ROLLS),
        (
            "a creepage beside the motion",
            speed,
            "{ normal_force = \"80 kN\", steady = true, creepage_y = 1e-3 }",
        ),
        (
            "a spin beside the motion",
            speed,
            "{ normal_force = \"80 kN\" }, { distance = \"1 mm\", increments = 2, spin = 0.1 }",
        ),
        (
            "an angular speed that a force governs",
            "speed = 20\nangular_speed = 43",
            "{ normal_force = \"80 kN\", force_x = \"1 kN\" }, { steady = true }",
        ),
        ("a misspelt speed", "velocity = \"20 m/s\"", ROLLS),
        ("a pitch rate", "speed = 20\npitch_rate = -43", ROLLS),
    ];
    let mut said = String::new();
    for (name, punch, steps) in refusals {
        let error = read(&text(punch, steps, "")).expect_err(name);
        said += &format!("## {name}\n{error}\n");
    }
    let sphere = "name = \"creep\"\n[scene]\nfoundation.base = { youngs_modulus = \"210 GPa\", \
                  poisson = 0.28 }\npunch = { shape = \"sphere\", radius = 1, speed = 20 }\n\
                  loading.steps = [{ normal_force = 1e3, steady = true }]\n[numerics]\nmesh = 16\n";
    said += &format!("## a speed of a sphere\n{}\n", read(sphere).expect_err("a sphere"));
    let search = format!("kind = \"multiplicity\"\n{}", text(speed, "{ approach = 1e-5 }", ""));
    let error = read(&search).expect_err("a search");
    said += &format!("## a speed in a search\n{error}\n");
    let axis = "[sweep]\n\"punch.speed\" = [\"10 m/s\", \"0 m/s\"]";
    let error = read(&text(speed, ROLLS, axis)).expect_err("an axis");
    said += &format!("## an axis of speeds with one of 0\n{error}\n");
    insta::assert_snapshot!(said);
}

proptest! {
    #[test]
    fn what_a_job_with_a_motion_writes_is_read(
        speed in prop_oneof![0.01..100.0f64, -100.0..-0.01f64],
        angular_speed in prop::option::of(-100.0..100.0f64),
        rates in prop::array::uniform3(prop_oneof![Just(0.0), -10.0..10.0f64]),
    ) {
        let mut case = case("", ROLLS);
        let Shape::WheelOnRail(wheel) = &mut case.scene.punch.shape else { unreachable!() };
        let [lateral_velocity, yaw_rate, roll_rate] = rates;
        wheel.motion =
            Some(WheelsetMotion { speed, angular_speed, lateral_velocity, yaw_rate, roll_rate });
        // A stored job has the names of its profiles, which stand for the files here.
        let job = Job::Solve(case);
        let written = format!("name = \"job\"\n{}", job.to_toml());
        let mut stored = |name: &str| -> Result<NamedFile, String> {
            let Shape::WheelOnRail(wheel) = &job.case().unwrap().scene.punch.shape else {
                unreachable!()
            };
            let kind = if name == wheel.wheel {
                contact::punch::ProfileKind::Wheel
            } else {
                contact::punch::ProfileKind::Rail
            };
            let bytes = if name == wheel.wheel { WHEEL } else { RAIL };
            let profile = study::profile::read(bytes, kind).unwrap().profile;
            Ok(NamedFile { bytes: study::profile::encode_profile(&profile), may_quote: true })
        };
        let again = Study::parse(&written, "study.toml", &mut stored)
            .unwrap_or_else(|error| panic!("{written}\n{error}"));
        prop_assert_eq!(&again.points()[0].job, &job, "{}", written);
        prop_assert_eq!(Job::parse(&job.canonical()).map(|parsed| parsed.key()).ok(), Some(job.key()));
    }
}
