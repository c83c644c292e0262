//! Studies that choose points: their ends, and refusals before they begin.

use crate::place::{Place, SMALL};

/// A sphere pressed and shifted to and fro, on the fewest elements.
const HALVED: &str = r#"name = "halved"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }, { shift_x = "0.1 um" }]
[numerics]
mesh = 4
[sweep]
AXIS
[bisect]
axis = "NAME"
on = "CONDITION"
to = "10%"
"#;

pub(crate) fn halved(name: &str, values: &str, condition: &str) -> String {
    HALVED
        .replace("AXIS", &format!("\"{name}\" = {values}"))
        .replace("NAME", name)
        .replace("CONDITION", condition)
}

/// No interval that begins at 0 is as short as a tenth of its upper end.
#[test]
fn halving_ends_at_zero_and_below() {
    let cases = [
        ("friction.mu", "[0, 0.5]", "mu > 0", "mu", [0.0, 0.03125]),
        (
            "loading.steps[1].shift_x",
            "[-1e-6, 0]",
            "step1_shift_x == 0",
            "step1_shift_x",
            [-6.25e-8, 0.0],
        ),
        (
            "loading.steps[1].shift_x",
            "[-1e-6, 1e-6]",
            "step1_shift_x > 4e-7",
            "step1_shift_x",
            [3.75e-7, 4.0625e-7],
        ),
        (
            "loading.steps[1].shift_x",
            "[-1e-6, 1e-6]",
            "step1_shift_x > -4e-7",
            "step1_shift_x",
            [-5e-7, -3.75e-7],
        ),
    ];
    for (name, values, condition, column, [from, to]) in cases {
        let place = Place::with("halved.toml", halved(name, values, condition));
        let said = place.call("run halved.toml --workers 1");
        assert_eq!(said.code, 0, "{condition}: {}", said.err);
        let found = place.json("answer halved --json")["answers"]["found"]["rows"].clone();
        assert_eq!(found.as_array().map(Vec::len), Some(1), "{found}");
        assert_eq!(found[0]["found"], "begins to hold");
        for (end, exact) in [("from", from), ("to", to)] {
            let value = found[0][format!("{column}_{end}")].as_f64().unwrap();
            assert!(
                (value - exact).abs() <= 1e-12 * exact.abs(),
                "{condition}: {end} {value}, not {exact}"
            );
        }
    }
}

/// Otherwise conditions would fail after jobs have run, and every command that reads the study with
/// them.
#[test]
fn conditions_that_no_result_could_meet_are_refused_at_their_place() {
    let cases = [
        ("way > 1", "column `way` is text and 1 is a number"),
        ("mu > 0.9 && way > 1", "column `way` is text"),
        ("status == \"certified\" || load == \"large\"", "column `load` is a number"),
        ("load", "must be a condition"),
        ("load >", "at character"),
        ("lod > 0", "load"),
        ("", "empty"),
    ];
    for (condition, words) in cases {
        let place = Place::with(
            "halved.toml",
            halved("friction.mu", "[0.1, 0.5]", &condition.replace('"', "\\\"")),
        );
        for command in ["run", "plan"] {
            let said = place.words(&[command, "halved.toml"]);
            assert_eq!((said.code, said.out.as_str()), (1, ""), "{condition}: {}", said.err);
            assert!(
                said.err.contains(words) && said.err.contains("--> halved.toml:13:6"),
                "{condition}: {}",
                said.err
            );
        }
        assert_eq!(place.files().len(), 1, "{condition}: nothing is left");
    }
    // A mesh is a number of elements or a pair of them.
    let pair = halved("friction.mu", "[0.1, 0.5]\nmesh = [4, [4, 6]]", "mesh > 1")
        .replace("mesh = 4\n[sweep]", "[sweep]");
    let said = Place::with("halved.toml", pair).call("plan halved.toml");
    assert!(said.code == 1 && said.err.contains("column `mesh` is text"), "{}", said.err);
}

#[test]
fn what_is_only_compared_at_the_end_chooses_nothing() {
    let compared = halved(
        "friction.mu",
        "[0.1, 0.5]\nepsilon = [0, 1e-3, 1e-2]",
        "load > 0 && error_load < 0.1",
    );
    let text = compared.replacen(
        "[scene]",
        "kind = \"convergence\"\nconvergence.along = \"epsilon\"\n[scene]",
        1,
    );
    let place = Place::with("halved.toml", &text);
    let said = place.call("run halved.toml");
    assert_eq!((said.code, said.out.as_str()), (1, ""), "{}", said.err);
    assert!(
        said.err.contains("`error_load` is known only when")
            && said.err.contains("--> halved.toml:"),
        "{}",
        said.err
    );
    assert_eq!(place.files().len(), 1);
    // A column that a single job determines is accepted.
    place.write("halved.toml", text.replace("error_load", "residual"));
    let said = place.call("plan halved.toml");
    assert_eq!(said.code, 0, "{}", said.err);
}

/// A single mesh would show no change.
#[test]
fn a_mesh_is_doubled_at_least_once_or_not_at_all() {
    let refine = |most: &str| {
        SMALL.replace(
            "[sweep]",
            &format!("[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = {most}\n[sweep]"),
        )
    };
    for (most, words) in [("0", "must be from 12"), ("11", "must be from 12"), ("5000", "to 4096")]
    {
        let place = Place::with("small.toml", refine(most));
        let said = place.call("run small.toml");
        assert_eq!((said.code, said.out.as_str()), (1, ""), "{most}: {}", said.err);
        assert!(
            said.err.contains(words) && said.err.contains("--> small.toml:"),
            "{most}: {}",
            said.err
        );
    }
    let place = Place::with("small.toml", refine("12"));
    assert_eq!(place.call("run small.toml").code, 0);
    let found = place.json("answer small --json")["answers"]["found"]["rows"].clone();
    assert!(
        found.as_array().unwrap().iter().all(|row| row["change"].is_f64() && row["mesh"] == "12"),
        "{found}"
    );
}
