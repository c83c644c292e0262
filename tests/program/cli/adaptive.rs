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

/// Curves of equal spheres: by Cattaneo and Mindlin the force along x is μP (1 − (1 − s/s*)^(3/2)),
/// where s* = 17/14 μ times the approach is the shift from which on all of it slips.
const CURVES: &str = r#"name = "curves"
question = "Where?"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm", material = { shear_modulus = "80 GPa", poisson = 0.3 } }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }, { shift_x = "0.2 um" }]
[numerics]
mesh = 24
[sweep]
friction.mu = [0.05, 0.4, 0.8]
"loading.steps[1].shift_x" = ["0.2 um", "0.3 um", "0.4 um"]
"#;

/// Returns the rows of what a study of curves has found.
fn found_in_curves(place: &Place) -> Vec<serde_json::Value> {
    let answers = place.json("answer curves --json");
    answers["answers"]["found"]["rows"].as_array().unwrap().clone()
}

#[test]
fn roots_are_found_with_their_brackets_in_few_jobs() {
    let find = "[find]\naxis = \"mu\"\ncolumn = \"force_x\"\nvalue = \"2.8 N\"\nto = \"0.1%\"\n";
    let place = Place::with("curves.toml", format!("{CURVES}{find}"));
    let plan = place.json("plan curves.toml --json");
    assert_eq!((&plan["points"], &plan["to_run"]), (&9.into(), &9.into()));
    let bound = plan["more_at_most"].as_u64().unwrap();
    let said = place.call("plan curves.toml");
    assert!(said.out.contains(&format!("at most {bound} points")), "{}", said.out);
    assert_eq!(place.call("run curves.toml --workers 2").code, 0);
    let rows = found_in_curves(&place);
    assert_eq!(rows.len(), 3, "{rows:?}");
    for row in &rows {
        let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name}: {row}"));
        let (mu, from, to) = (number("mu"), number("mu_from"), number("mu_to"));
        assert!(from <= mu && mu <= to && to - from <= 1e-3 * to, "{row}");
        let (below, above) = (number("force_x_from"), number("force_x_to"));
        assert!(below <= 2.8 && 2.8 <= above && row["found"] == "rises through it", "{row}");
        // The load of these spheres is 15.24 N.
        let full = 17.0 / 14.0 * mu * 1e-6;
        let stuck = (1.0 - number("step1_shift_x") / full).max(0.0);
        let force = mu * 15.24 * (1.0 - stuck.powf(1.5));
        assert!((force - 2.8).abs() < 0.06, "{force}: {row}");
    }
    let done = place.json("plan curves.toml --json");
    let points = done["points"].as_u64().unwrap();
    assert_eq!((&done["to_run"], &done["more_at_most"]), (&0.into(), &0.into()));
    // Bisection takes nine jobs for each.
    assert!(points - 9 <= bound.min(3 * 6), "{points} points, {bound}");
    let svg = std::fs::read_to_string(place.path(".tribosweep/figures/curves.svg")).unwrap();
    assert!(svg.contains("value that is looked for") && svg.contains("stroke-dasharray=\"5 3\""));
    assert_eq!(svg.matches("r=\"6\"").count(), 3, "each root has its ring");
    let cited = place.call("cite curves");
    assert!(cited.out.contains("10.1145/3423597"), "{}", cited.out);
    let few = place.json("query curves --select mu,force_x --format json");
    assert_eq!(few["rows"].as_array().unwrap().len() as u64, points);
}

#[test]
fn where_nothing_crosses_that_is_said() {
    let find = "[find]\naxis = \"mu\"\ncolumn = \"force_x\"\nvalue = \"50 N\"\nto = \"1%\"\n";
    let place = Place::with("curves.toml", format!("{CURVES}{find}"));
    assert_eq!(place.call("run curves.toml").code, 0);
    let rows = found_in_curves(&place);
    assert_eq!(rows.len(), 3, "{rows:?}");
    for row in rows {
        assert_eq!(row["found"], "below it at all given values, nearest here");
        assert_eq!((row["mu_from"].as_f64(), row["mu"].is_null()), (Some(0.8), true), "{row}");
    }
}

/// The points and results do not depend on who computes them.
#[test]
fn curves_and_maps_are_filled_alike_by_any_number_of_workers() {
    let curve = "[fill]\naxis = \"mu\"\ncolumn = \"stick_fraction\"\nto = \"5%\"\n";
    let map =
        "[fill]\naxis = [\"mu\", \"step1_shift_x\"]\ncolumn = \"stick_fraction\"\nat_most = 12\n";
    for (fill, places) in [(curve, 3), (map, 1)] {
        let table = |workers: &str| {
            let place = Place::with("curves.toml", format!("{CURVES}{fill}"));
            let said = place.call(&format!("run curves.toml --workers {workers}"));
            assert_eq!(said.code, 0, "{}", said.err);
            let rows = found_in_curves(&place);
            assert_eq!(rows.len(), places, "{rows:?}");
            for row in &rows {
                let deviation = row["deviation"].as_f64().unwrap();
                match row["found"].as_str().unwrap() {
                    "as many as may be added" => assert_eq!(row["added"], 12),
                    _ => assert!(deviation <= 0.05 && row["added"].as_u64() > Some(1), "{row}"),
                }
            }
            assert!(place.call("cite curves").out.contains("10.5281/zenodo.1182437"));
            let select = "query curves --select key,mu,step1_shift_x,stick_fraction --format csv";
            let table = place.call(select).out;
            let done = place.json("plan curves.toml --json");
            assert_eq!((&done["to_run"], &done["more_at_most"]), (&0.into(), &0.into()));
            table
        };
        let [alone, together] = ["1", "3"].map(table);
        assert_eq!(alone, together);
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
