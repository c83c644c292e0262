//! Points that failed are no results: in tables, filters, figures and answers.

use std::fs;

use serde_json::Value;

use crate::place::{Place, Said};

/// A sphere that carries 300 N by friction at most: at the last two forces it slides.
pub(crate) const PULLED: &str = r#"
name = "pulled"
question = "How does the stick zone shrink with the tangential force?"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
friction.mu = 0.3
loading.steps = [{ normal_force = "1 kN" }, { force_x = "100 N" }]
[numerics]
mesh = 8
[sweep]
"loading.steps[1].force_x" = ["100 N", "200 N", "290 N", "350 N", "500 N"]
[figure]
x = "step1_force_x"
y = "stick_fraction"
"#;

const MISSING: &str = "2 of 5 points failed and are not drawn";

fn pulled() -> (Place, Said) {
    let place = Place::with("pulled.toml", PULLED);
    let said = place.call("run pulled.toml --workers 2");
    (place, said)
}

fn rows(place: &Place, words: &[&str]) -> Vec<Value> {
    let said = place.words(words);
    let table: Value = serde_json::from_str(&said.out)
        .unwrap_or_else(|error| panic!("{error}: {}{}", said.out, said.err));
    table["rows"].as_array().unwrap().clone()
}

/// Counts the markers in the frame of a figure without a legend.
fn markers(place: &Place, file: &str) -> usize {
    let svg = fs::read_to_string(place.path(file)).unwrap();
    svg.matches("<circle").count()
}

#[test]
fn points_that_failed_are_no_points_of_a_figure() {
    let (place, said) = pulled();
    assert_eq!(said.code, 2, "{}{}", said.out, said.err);
    let named = format!("figure: .tribosweep/figures/pulled.svg ({MISSING})");
    assert!(said.out.contains(&named), "{}", said.out);
    let figure = ".tribosweep/figures/pulled.svg";
    assert_eq!(markers(&place, figure), 3, "the curve ends at 290 N");
    let svg = fs::read_to_string(place.path(figure)).unwrap();
    assert!(svg.contains(&format!("{MISSING}.")) && !svg.contains(">500<"), "{svg}");

    // Another figure of the same points, one of work that the failed jobs did as well, and rows
    // that a filter may concern.
    for (line, missing) in [
        ("plot pulled --output f.svg", MISSING),
        ("plot pulled --y iterations --output f.svg", MISSING),
        ("plot pulled --y at_shift_x --output f.svg", MISSING),
        ("plot pulled --where stick_fraction<2 --output f.svg", MISSING),
        ("plot pulled --where step1_force_x<400 --output f.svg", "1 of 4 points failed and is not"),
    ] {
        let said = place.call(line);
        assert!(said.code == 0 && said.err.contains(missing), "{line}: {}", said.err);
        assert_eq!(said.out, "f.svg\n", "{line}");
        assert_eq!(markers(&place, "f.svg"), 3, "{line}");
    }
    let said = place.call("plot pulled --where step1_force_x<300 --output f.svg");
    assert_eq!(said.err, "", "nothing is missing of what was asked for");
    let none = place.call("plot pulled --where step1_force_x>300 --output none.svg");
    assert!(
        none.code == 1 && none.err.contains("2 of 2 points failed and are not drawn"),
        "{}",
        none.err
    );
    assert!(!place.path("none.svg").exists());
    let summary = place.call("run pulled.toml --json").out;
    let summary: Value = serde_json::from_str(summary.lines().last().unwrap()).unwrap();
    assert_eq!(summary["undrawn"], serde_json::json!([MISSING]));
}

#[test]
fn results_of_points_that_failed_are_empty_and_match_nothing() {
    let (place, _) = pulled();
    let columns = place.json("query pulled --columns --json");
    let of_kind = |kinds: &[&str]| -> Vec<String> {
        let listed = columns["rows"].as_array().unwrap().iter();
        let meant = listed.filter(|column| kinds.contains(&column["kind"].as_str().unwrap()));
        meant.map(|column| column["column"].as_str().unwrap().to_owned()).collect()
    };
    let results = of_kind(&["observable", "certificate", "error"]);
    assert!(results.len() > 40, "{results:?}");
    let select = results.join(",");
    let failed = rows(
        &place,
        &["query", "pulled", "--json", "--where", "status == \"failed\"", "--select", &select],
    );
    assert_eq!(failed.len(), 2);
    for row in &failed {
        assert!(row.as_object().unwrap().values().all(Value::is_null), "{row}");
    }
    for column in ["load", "stick_fraction", "residual", "peak_pressure", "at_shift_x"] {
        for condition in ["> -1e300", "<= 1e300", "!= -7"] {
            let filter = format!("{column} {condition}");
            let matching = rows(
                &place,
                &["query", "pulled", "--json", "--where", &filter, "--select", "status"],
            );
            assert_eq!(matching.len(), 3, "{filter}");
            assert!(matching.iter().all(|row| row["status"] == "certified"), "{filter}");
        }
    }
    let csv = place.call("query pulled --select step1_force_x,load,status --format csv").out;
    assert!(csv.contains("\n350.0,,failed\n"), "{csv}");
}

#[test]
fn what_a_failed_path_came_through_is_kept() {
    let (place, said) = pulled();
    let steps = rows(
        &place,
        &["query", "pulled", "--steps", "--json", "--select", "step1_force_x,step,load,status"],
    );
    assert_eq!(steps.len(), 10);
    for row in &steps {
        let is_solved = row["status"] == "certified";
        assert_eq!(row["load"].is_number(), is_solved, "{row}");
        assert!(is_solved || row["step"] == 1, "{row}");
    }
    let show = said.out.lines().find_map(|line| Some(line.split_once("tribosweep show ")?.1));
    let key = show.unwrap_or_else(|| panic!("{}", said.out)).split(' ').next().unwrap();
    let shown = place.call(&format!("show {key}"));
    for words in [
        "observables at the last increment that was solved",
        "observables of the last iterate, which is no solution",
        "the path ended at its increment 2 of 2",
    ] {
        assert!(shown.out.contains(words), "{words}: {}", shown.out);
    }
    let shown = place.json(&format!("show {key} --json"));
    assert_eq!(shown["result"]["load"], Value::Null);
    assert!((shown["reached"]["load"].as_f64().unwrap() - 1000.0).abs() < 1e-3, "{shown}");
    assert!(shown["uncertified"]["residual"].is_number(), "{shown}");
}

#[test]
fn summaries_do_not_hide_failures() {
    let (place, said) = pulled();
    assert!(said.out.contains("5 points, 3 certified, 2 failed, 0 left"), "{}", said.out);
    let answer = place.call("answer pulled").out;
    assert!(answer.contains("2 of 5 points failed, 0 left: tribosweep query pulled"), "{answer}");
    let status = place.json("status --json");
    assert_eq!(status[0]["progress"]["failed"], 2);

    // The finest rung of a ladder needs more iterations than it is given.
    let ladder = PULLED
        .replace("\"pulled\"", "\"ladder\"\nkind = \"convergence\"")
        .replace("mesh = 8", "mesh = 4\nmethod = \"seidel\"\nmax_iterations = 40")
        .replace(
            "\"loading.steps[1].force_x\" = [\"100 N\", \"200 N\", \"290 N\", \"350 N\", \"500 N\"]",
            "mesh = [4, 6, 8, 64]",
        );
    let (ladder, _) = ladder.split_once("[figure]").unwrap();
    place.write("ladder.toml", ladder);
    let said = place.call("run ladder.toml --workers 2");
    let answer = place.call("answer ladder").out;
    assert_eq!(said.code, 2, "{}{}", said.out, said.err);
    for words in ["3 of 4", "the finest solved", "this leaves out 1 of 4 points: 1 failed"] {
        assert!(answer.contains(words) && said.out.contains(words), "{words}: {answer}");
    }
}
