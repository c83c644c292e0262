//! Messages and their place: closed pipes, parameters that change nothing, and refusals before
//! anything is solved.

use std::process::Stdio;

use crate::place::{Place, SMALL};

/// A scene without a closed form on three meshes, without its `kind`.
const COUPLED: &str = r#"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "20 um" }]

[sweep]
mesh = [4, 6, 8]
"#;

fn coupled(name: &str, more: &str) -> String {
    format!("name = \"{name}\"\n{more}\n{COUPLED}")
}

/// Returns the exit code with standard output or standard error closed by its reader.
fn with_closed_pipe(place: &Place, line: &str, standard_error: bool) -> Option<i32> {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = place.command(&line.split_whitespace().collect::<Vec<_>>());
    let command = if standard_error {
        command.stderr(writer).stdout(Stdio::null())
    } else {
        command.stdout(writer).stderr(Stdio::null())
    };
    command.status().unwrap().code()
}

#[test]
fn nobody_listening_changes_no_exit_code() {
    let place = Place::run();
    assert_eq!(with_closed_pipe(&place, "query small", false), Some(0));
    assert_eq!(with_closed_pipe(&place, "query small --where load<0", true), Some(0));
    // The punch is pulled by more than friction holds, so that every job fails.
    place.write(
        "failing.toml",
        SMALL.replace("small", "failing").replace("\"20 um\"", "\"20 um\", force_x = 1e9"),
    );
    assert_eq!(place.call("run failing.toml").code, 2);
    assert_eq!(with_closed_pipe(&place, "run failing.toml", false), Some(2));
    assert_eq!(with_closed_pipe(&place, "run nowhere.toml", true), Some(1));
}

#[test]
fn what_changes_nothing_is_refused() {
    let place = Place::run();
    let key = &place.keys()[0];
    let ladder = "cost small.toml --set mu=0.2 --set poisson=0.3 --set mesh=64";
    for (line, words) in [
        ("query small --columns --where load>0".to_owned(), "cannot be used with"),
        ("query small --columns --sort load".to_owned(), "cannot be used with"),
        ("query small --json --format csv".to_owned(), "cannot be used with"),
        (format!("show {key} --field state --solution 7"), "only a study of kind \"multiplicity\""),
        (
            "solve small.toml --set mu=0.2 --set poisson=0.3 --field state --solution 0".to_owned(),
            "only a study of kind \"multiplicity\"",
        ),
        (
            "solve small.toml --set mu=0.2 --set poisson=0.3 --field stat".to_owned(),
            "there is no field `stat`",
        ),
        (
            "solve small.toml --set mu=0.2 --set poisson=0.3 --field state --output x.jpg"
                .to_owned(),
            ".png, .svg",
        ),
        (ladder.to_owned(), "the ladder has meshes and tolerances of its own"),
        ("solve small.toml --set loading.steps[0]=3".to_owned(), "holds several keys"),
        ("run small.toml --memory 99999999999999999999G".to_owned(), "below 16 EiB"),
    ] {
        let said = place.call(&line);
        assert!(
            said.code != 0 && said.out.is_empty() && said.err.contains(words),
            "{line}: {} {}{}",
            said.code,
            said.out,
            said.err
        );
    }
}

#[test]
fn a_reference_that_does_not_exist_is_refused_before_anything_is_solved() {
    let place = Place::empty();
    for (name, more) in [
        ("cost", "kind = \"cost\"\n[cost]\non = \"pressure\"\nrepeat = 1"),
        ("convergence", "kind = \"convergence\"\n[convergence]\nreference = \"closed-form\""),
    ] {
        place.write("x.toml", coupled(name, more));
        for command in ["plan", "run"] {
            let said = place.call(&format!("{command} x.toml"));
            assert!(
                said.code == 1 && said.err.contains("closed form"),
                "{name}: {} {}",
                said.code,
                said.err
            );
        }
        assert!(!place.path(".tribosweep").exists());
    }
    // A quantity that can be extrapolated is accepted.
    place.write(
        "x.toml",
        coupled("cost", "kind = \"cost\"\n[cost]\non = \"stick_area\"\nrepeat = 1"),
    );
    let said = place.call("run x.toml --workers 2");
    assert!(said.code == 0 && said.err.contains("one worker"), "{}{}", said.out, said.err);
    assert!(!place.call("query cost --select claimed_error").out.contains("NaN"));
}

#[test]
fn effects_of_a_study_that_leaves_none_out_are_refused() {
    let place = Place::with(
        "x.toml",
        coupled("several", "kind = \"multiplicity\"").replace("mesh = [4, 6, 8]", "mesh = [2]"),
    );
    let said = place.call("effects x.toml");
    assert!(
        said.code == 1 && said.err.contains("simulates every effect"),
        "{}{}",
        said.out,
        said.err
    );
}

/// The meshes of points that were chosen are no values of the axes.
#[test]
fn a_plan_names_the_points_that_a_study_chose() {
    let study = "name = \"finer\"\n[refine]\non = \"load\"\nuntil = \"10%\"\n".to_owned()
        + &COUPLED.replace("mesh = [4, 6, 8]", "friction.mu = [0, 0.3, 0.5]");
    let place =
        Place::with("finer.toml", study.replace("[sweep]", "[numerics]\nmesh = 4\n\n[sweep]"));
    assert_eq!(place.call("run finer.toml").code, 0);
    let said = place.call("plan finer.toml").out;
    assert!(
        said.contains("mu = 0") && said.contains("mu = 0.3, 0.5") && !said.contains(": \n"),
        "{said}"
    );
}

#[test]
fn a_column_is_suggested_for_what_others_call_it() {
    let place = Place::run();
    for line in ["query small --select nu", "query small --sort nu", "query small --where nu>0"] {
        let said = place.call(line);
        assert_eq!(
            (said.code, said.err.as_str()),
            (1, "error: there is no column `nu`; did you mean poisson?\n")
        );
    }
}

#[test]
fn a_scene_without_friction_is_planned_as_one_of_mu_0() {
    let study = COUPLED.replace("friction.mu = 0.3\n", "");
    let place = Place::with("free.toml", format!("name = \"free\"\n{study}"));
    let said = place.call("plan free.toml");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out
            .contains("friction        off  friction.mu = 0, as in every scene that gives none"),
        "{}",
        said.out
    );
}
