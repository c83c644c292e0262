//! The effects that scenes call for, in the words of `plan`, `show` and `solve`, and the savings of
//! leaving them out, measured by `effects`.

use serde_json::Value;

use crate::place::{ONE, Place, redacted};

/// A shifted sphere, in which every test spoils or sweeps one thing.
const SPHERE: &str = r#"name = "sphere"

[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
loading.steps = [{ approach = "20 um", shift_x = "2 um" }]
friction.mu = 0.3

[numerics]
method = "newton"
mesh = 8
"#;

fn sphere(changes: &[(&str, &str)]) -> Place {
    let text = changes.iter().fold(SPHERE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    Place::with("sphere.toml", text)
}

const INCOMPRESSIBLE: (&str, &str) = ("poisson = 0.3", "poisson = 0.5");
const FRICTIONLESS: (&str, &str) = ("mu = 0.3", "mu = 0");
const UNSHIFTED: (&str, &str) = (", shift_x = \"2 um\"", "");

/// Returns the section of a plan about effects.
fn planned(changes: &[(&str, &str)]) -> String {
    let said = sphere(changes).call("plan sphere.toml");
    assert_eq!(said.code, 0, "{}", said.err);
    let from = said.out.find("\neffects").unwrap_or_else(|| panic!("{}", said.out));
    redacted(&said.out[from..])
}

#[test]
fn a_plan_says_which_effects_are_left_out_and_why() {
    let ask = |names: &'static str| ("mesh = 8", names);
    let scenes: &[(&str, &[(&str, &str)])] = &[
        ("coupled", &[]),
        ("frictionless", &[FRICTIONLESS]),
        ("uncoupled", &[INCOMPRESSIBLE]),
        ("symmetric", &[UNSHIFTED]),
        (
            "uncoupled, the coupling asked for",
            &[INCOMPRESSIBLE, ask("mesh = 8\nsimulate = [\"coupling\"]")],
        ),
        (
            "frictionless, friction asked for",
            &[FRICTIONLESS, ask("mesh = 8\nsimulate = [\"friction\"]")],
        ),
        (
            "symmetric, one mirror plane given up",
            &[UNSHIFTED, ask("mesh = 8\nsimulate = [\"asymmetry-y\"]")],
        ),
        ("an odd number of elements", &[UNSHIFTED, ask("mesh = [8, 9]")]),
    ];
    let said: Vec<String> =
        scenes.iter().map(|(name, changes)| format!("{name}{}", planned(changes))).collect();
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn jobs_that_call_for_the_same_effects_are_listed_together() {
    let axes = |text: &'static str| ("mesh = 8", text);
    let scenes: &[(&str, (&str, &str))] = &[
        (
            "one axis decides",
            axes("mesh = 8\n[sweep]\n\"friction.mu\" = [0, 0.1, 0.2]\nmesh = [8, 12]"),
        ),
        (
            "two do",
            axes(
                "[sweep]\nmesh = [8, 12]\n\"friction.mu\" = [0, 0.1, 0.2, 0.3, 0.4, 0.5]\n\"foundation.base.poisson\" = [0.3, 0.5]",
            ),
        ),
        (
            "no axis by itself",
            axes(
                "mesh = 8\n[sweep]\n\"loading.steps[0].shift_x\" = [0, 1e-6]\n\"foundation.base.poisson\" = [0.3, 0.4, 0.5]",
            ),
        ),
        ("what is asked for", axes("mesh = 8\n[sweep]\nsimulate = [[], [\"asymmetry-y\"]]")),
    ];
    let said: Vec<String> =
        scenes.iter().map(|(name, change)| format!("{name}{}", planned(&[*change]))).collect();
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn a_plan_lists_effects_as_json() {
    let place = sphere(&[("mesh = 8", "mesh = 8\n[sweep]\n\"friction.mu\" = [0, 0.1, 0.2]")]);
    let plan = place.json("plan sphere.toml --json");
    let groups = plan["effects"].as_array().unwrap();
    assert_eq!(groups.len(), 2);
    assert_eq!((&groups[0]["which"], &groups[0]["jobs"]), (&"mu = 0".into(), &1.into()));
    assert_eq!((&groups[1]["which"], &groups[1]["jobs"]), (&"mu = 0.1, 0.2".into(), &2.into()));
    let effect = |group: &Value, name: &str| {
        group["effects"]
            .as_array()
            .unwrap()
            .iter()
            .find(|line| line["effect"] == name)
            .unwrap_or_else(|| panic!("{name}"))
            .clone()
    };
    let friction = effect(&groups[0], "friction");
    assert_eq!(
        (&friction["simulated"], &friction["reason"]),
        (&false.into(), &"friction.mu = 0, as in every scene that gives none".into())
    );
    let unknowns = |of: &Value| of["unknowns"].as_u64().unwrap();
    let seconds = |of: &Value| of["seconds"].as_f64().unwrap();
    // The normal component alone takes a quarter; with tractions a shifted sphere has one mirror
    // plane.
    assert_eq!((unknowns(&groups[0]["cost"]), unknowns(&friction["with"])), (16, 3 * 32));
    assert!(seconds(&friction["with"]) > seconds(&groups[0]["cost"]));
    assert_eq!(unknowns(&groups[1]["cost"]), 2 * 3 * 32);
    assert_eq!(unknowns(&effect(&groups[1], "asymmetry-y")["with"]), 2 * 3 * 64);
    assert_eq!(effect(&groups[1], "friction")["with"], Value::Null);
    assert_eq!(effect(&groups[1], "ceiling")["with"], Value::Null, "it is no use asking for it");
}

#[test]
fn one_result_says_which_effects_were_simulated() {
    let place = sphere(&[INCOMPRESSIBLE]);
    let solved = place.call("solve sphere.toml").out;
    let part = |text: &str| {
        let (from, to) = (text.find("\neffects\n").unwrap(), text.find("\nresult\n").unwrap());
        redacted(&text[from..to])
    };
    insta::assert_snapshot!(part(&solved));
    assert_eq!(place.call("run sphere.toml --workers 1").code, 0);
    let key = place.call("query sphere --select key --format csv").out.lines().nth(1).unwrap()
        [..12]
        .to_owned();
    assert_eq!(part(&place.call(&format!("show {key}")).out), part(&solved));

    let asked =
        place.words(&["solve", "sphere.toml", "--set", "simulate=[\"coupling\"]", "--json"]);
    let asked: Value = serde_json::from_str(&asked.out).unwrap();
    let coupling = &asked["effects"][1];
    assert_eq!((&coupling["effect"], &coupling["simulated"]), (&"coupling".into(), &true.into()));
    assert_eq!(asked["job"]["numerics"]["simulate"], serde_json::json!(["coupling"]));
    let shown = place.json(&format!("show {key} --json"));
    let [with, without] = [&asked, &shown].map(|said| said["result"]["force_x"].as_f64().unwrap());
    assert!((with / without - 1.0).abs() < 1e-6, "{with} {without}");
    assert!(asked["predicted"]["unknowns"].as_u64() > shown["predicted"]["unknowns"].as_u64());
}

#[test]
fn effects_are_not_guessed_without_the_height_map() {
    let place = Place::with("one.toml", ONE);
    place.write("rough.csv", "0,1,2,1\n1,2,3,2\n0,1,2,1\n");
    let said = place.call("run one.toml --workers 1");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let key = place.call("query one --select key --format csv").out.lines().nth(1).unwrap()[..12]
        .to_owned();
    let shown = place.call(&format!("show {key}")).out;
    assert!(shown.contains("the punch's shape is not known to be its own image in x"), "{shown}");
    // The study is now about another map.
    place.write("rough.csv", "0,1,2,1\n1,2,4,2\n0,1,2,1\n");
    assert_eq!(place.call("run one.toml --workers 1").code, 0);
    let shown = place.call(&format!("show {key}")).out;
    assert!(
        shown.contains("effects\n  not known: the store's studies do not hold the height map "),
        "{shown}"
    );
    assert_eq!(place.json(&format!("show {key} --json"))["effects"], Value::Null);
}

#[test]
fn savings_are_measured() {
    let place = sphere(&[("mesh = 8", "mesh = 8\n[sweep]\n\"friction.mu\" = [0, 0.3]")]);
    let measured = place.json("effects sphere.toml --repeat 2 --json");
    let groups = measured["groups"].as_array().unwrap();
    let asked = |group: &Value| -> Vec<(Vec<Value>, u64)> {
        let runs = group["runs"].as_array().unwrap().iter();
        runs.map(|run| {
            (run["simulate"].as_array().unwrap().clone(), run["unknowns"].as_u64().unwrap())
        })
        .collect()
    };
    let names = |names: &[&str]| names.iter().map(|name| Value::from(*name)).collect::<Vec<_>>();
    let optional =
        ["friction", "coupling", "traction-x", "traction-y", "asymmetry-x", "asymmetry-y"];
    assert_eq!(
        asked(&groups[0]),
        [
            (names(&[]), 16),
            (names(&["friction"]), 96),
            (names(&["asymmetry-x"]), 32),
            (names(&["asymmetry-y"]), 32),
            (names(&optional), 192)
        ]
    );
    assert_eq!(asked(&groups[1]), [(names(&[]), 96), (names(&["asymmetry-y"]), 192)]);
    for run in groups.iter().flat_map(|group| group["runs"].as_array().unwrap()) {
        assert_eq!(run["status"], "certified");
        assert!(run["seconds"].as_f64().unwrap() > 0.0);
        assert!(run["difference"].as_f64().unwrap_or(0.0) < 1e-6, "{run}");
    }
    assert_eq!(place.files().len(), 1, "nothing is stored");

    let said = place.call("effects sphere.toml --repeat 1");
    assert_eq!(said.code, 0, "{}", said.err);
    let rows: Vec<&str> = said
        .out
        .lines()
        .filter(|line| line.contains("certified"))
        .map(|line| line.split("  ").next().unwrap().trim())
        .collect();
    assert_eq!(
        rows,
        [
            "nothing",
            "friction",
            "asymmetry-x",
            "asymmetry-y",
            "everything",
            "nothing",
            "asymmetry-y"
        ]
    );
    insta::assert_snapshot!(
        place
            .transcript(&[&["effects", "none.toml"], &["effects", "sphere.toml", "--repeat", "0"]])
    );
}
