//! Studies that choose points, compare, time, search and bracket: their answers, which do not
//! change when a run is killed.

use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::place::Place;

/// Two like spheres. All of the contact slips from a shift of 0.3, 0.364 and 0.45 times the
/// approach on (Cattaneo 1938, Mindlin 1949).
const SLIDING: &str = r#"name = "sliding"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm", material = { shear_modulus = "80 GPa", poisson = 0.3 } }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }, { shift_x = "0.1 um" }]
[numerics]
mesh = 24
[sweep]
"loading.steps[1].shift_x" = ["0.1 um", "0.6 um"]
[[sweep.zip]]
"foundation.base.poisson" = [0, 0.3, 0.5]
"punch.material.poisson" = [0, 0.3, 0.5]
[bisect]
axis = "loading.steps[1].shift_x"
on = "stick_area > 0"
to = "1%"
"#;

/// A punch on a path to a state with three solutions, and with less friction to a state with one.
const SEVERAL: &str = include_str!("../studies/several.toml");

/// Returns rows without columns that differ from run to run.
fn rows(place: &Place) -> String {
    let said = place.call("query sliding --select key,step1_shift_x,poisson,load,stick_area,residual,iterations --format csv");
    assert_eq!(said.code, 0, "{}", said.err);
    said.out
}

#[test]
fn a_threshold_is_found_by_halving_whatever_is_killed() {
    let whole = Place::with("sliding.toml", SLIDING);
    assert_eq!(whole.call("run sliding.toml").code, 0);
    let answer = whole.json("answer sliding --json");
    let found = answer["answers"]["found"]["rows"].as_array().unwrap();
    let slides = [0.3, 0.3 * 1.7 / 1.4, 0.45];
    assert_eq!(found.len(), slides.len());
    for (row, exact) in found.iter().zip(slides) {
        let [from, to] = ["step1_shift_x_from", "step1_shift_x_to"]
            .map(|name| row[name].as_f64().unwrap() * 1e6);
        assert!(to - from <= 0.01 * to && row["found"] == "ceases to hold", "{row}");
        // One element of some ninety in contact is the last to slip.
        assert!((0.5 * (from + to) / exact - 1.0).abs() < 0.03, "{from} … {to} against {exact}");
    }

    let killed = Place::with("sliding.toml", SLIDING);
    let mut kills = 0;
    for milliseconds in [60, 120, 200, 320] {
        let mut run = killed.command(&["run", "sliding.toml", "--workers", "1"]).spawn().unwrap();
        sleep(Duration::from_millis(milliseconds));
        kills += u32::from(run.try_wait().unwrap().is_none());
        let _ = run.kill();
        run.wait().unwrap();
    }
    assert_eq!(killed.call("run sliding.toml --workers 2").code, 0);
    assert_eq!(rows(&killed), rows(&whole), "after {kills} kills");
    assert_eq!(killed.json("answer sliding --json"), answer);
}

#[test]
fn a_mesh_is_doubled_until_the_load_holds_still() {
    let text = SLIDING.split("[sweep]").next().unwrap().replace("mesh = 24", "mesh = 8")
        + "[refine]\non = \"load\"\nuntil = \"1%\"\nat_most = 64\n";
    let place = Place::with("sliding.toml", text);
    assert_eq!(place.call("run sliding.toml").code, 0);
    let answer = place.json("answer sliding --json");
    let row = &answer["answers"]["found"]["rows"][0];
    assert!(row["found"] == "holds still" && row["change"].as_f64().unwrap() <= 0.01, "{row}");
    let meshes = place
        .call("query sliding --select mesh --format csv")
        .out
        .lines()
        .skip(1)
        .map(str::to_owned)
        .collect::<Vec<_>>();
    assert!(meshes.len() >= 2 && meshes[0] == "8" && meshes[1] == "16", "{meshes:?}");
    let strict = Place::with(
        "sliding.toml",
        SLIDING.split("[sweep]").next().unwrap().replace("mesh = 24", "mesh = 4")
            + "[refine]\non = \"load\"\nuntil = 1e-9\nat_most = 8\n",
    );
    assert_eq!(strict.call("run sliding.toml").code, 0);
    assert_eq!(
        strict.json("answer sliding --json")["answers"]["found"]["rows"][0]["found"],
        "still changes on the finest mesh allowed"
    );
}

#[test]
fn a_condition_that_cannot_be_evaluated_is_refused_before_anything_runs() {
    let place = Place::with("sliding.toml", SLIDING.replace("stick_area > 0", "stick_aera > 0"));
    let said = place.call("run sliding.toml");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("stick_area") && !place.path(".tribosweep").exists(), "{}", said.err);
}

pub(crate) const HERTZ: &str = r#"name = "hertz"
kind = "KIND"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 8
[sweep]
mesh = [8, 16, 32, 64]
"#;

#[test]
fn convergence_is_measured_against_the_closed_form() {
    let place = Place::with("hertz.toml", HERTZ.replace("KIND", "convergence"));
    assert_eq!(place.call("run hertz.toml").code, 0);
    let answers = place.json("answer hertz --json")["answers"].clone();
    let order = |name: &str| {
        let rows = answers["orders"]["rows"].as_array().unwrap();
        let row = rows
            .iter()
            .find(|row| row["error"] == name)
            .unwrap_or_else(|| panic!("no {name} in {rows:?}"));
        assert!(row["reference"].as_str().unwrap().contains("Hertz"), "{row}");
        row["order"].as_f64().unwrap()
    };
    assert!(
        (0.8..1.05).contains(&order("pressure")) && (1.7..2.4).contains(&order("peak_pressure"))
    );
    assert!(
        answers["limits"]["rows"].as_array().unwrap().iter().any(|row| row["quantity"] == "load")
    );
    // It can be measured against its finest mesh as well, which then has no error.
    let text = HERTZ.replace("KIND", "convergence") + "[convergence]\nreference = \"finest\"\n";
    let place = Place::with("hertz.toml", text);
    assert_eq!(place.call("run hertz.toml").code, 0);
    let errors = place.call("query hertz --select error_pressure,reference --format csv").out;
    assert!(
        errors.lines().nth(1).unwrap().ends_with("mesh 64 x 64")
            && errors.lines().nth(4) == Some(","),
        "{errors}"
    );
    assert!(place.path(".tribosweep/figures/hertz.svg").exists());
}

#[test]
fn what_accuracy_costs_is_said_in_a_sentence() {
    let place = Place::with("hertz.toml", HERTZ.replace("KIND", "cost"));
    let said = place.call("cost hertz.toml");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains(" % of the load costs ") && said.out.contains("cheapest for their error"),
        "{}",
        said.out
    );
    let rows = place.json("query hertz --select seconds,spread,error_load --json")["rows"].clone();
    assert!(rows.as_array().unwrap().iter().all(
        |row| row["seconds"].as_f64().unwrap() > 0.0 && row["spread"].as_f64().unwrap() >= 0.0
    ));
    // Any scene can be priced.
    let place = Place::with(
        "scene.toml",
        HERTZ
            .replace("KIND", "solve")
            .replace("[8, 16, 32, 64]", "[8, 16]\nfriction.mu = [0, 0.3]"),
    );
    let said = place.call("cost scene.toml");
    assert!(said.code == 1 && said.err.contains("friction.mu"), "{}", said.err);
}

#[test]
fn each_way_of_solving_has_a_law_of_its_own() {
    let axes = "mesh = [6, 8, 12, 16]\nprojection = [\"average\", \"midpoint\"]\nmethod = [\"newton\", \"seidel\"]\nepsilon = [0, 1e-3]";
    let place = Place::with(
        "ways.toml",
        HERTZ.replace("KIND", "cost").replace("mesh = [8, 16, 32, 64]", axes),
    );
    let said = place.call("cost ways.toml");
    assert_eq!(said.code, 0, "{}", said.err);
    let (_, laws) = said.out.split_once("\nlaws\n").unwrap();
    for projection in ["average", "midpoint"] {
        for method in ["newton", "seidel"] {
            for epsilon in ["0 ", "0.001 "] {
                let way = format!("projection {projection}, method {method}, epsilon {epsilon}");
                assert_eq!(laws.matches(&way).count(), 1, "{way}\n{}", said.out);
            }
        }
    }
}

#[test]
fn brackets_are_proved_anew() {
    let text = r#"name = "unique"
kind = "uniqueness"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "flat-rectangle", width_x = "2 mm", width_y = "2 mm" }
[numerics]
mesh = 2
[sweep]
"foundation.base.poisson" = [0, 0.3, 0.5]
"#;
    let place = Place::with("unique.toml", text);
    assert_eq!(place.call("run unique.toml").code, 0);
    let rows =
        place.json("query unique --select poisson,mu_low,mu_high,unbounded --json")["rows"].clone();
    let value = |row: usize, name: &str| rows[row][name].as_f64().unwrap();
    for (row, exact) in [(0, 2.700273), (1, 4.702062)] {
        assert!(
            value(row, "mu_low") <= exact + 1e-5 && value(row, "mu_high") >= exact - 1e-5,
            "{rows}"
        );
        assert!(value(row, "mu_high") - value(row, "mu_low") < 1e-5, "{rows}");
    }
    assert!(rows[2]["unbounded"] == "yes" && rows[2]["mu_low"] == Value::Null, "{rows}");
    let said = place.call("store verify --deep");
    assert!(
        said.code == 0 && said.out.contains("3 brackets of uniqueness sets proved anew"),
        "{}",
        said.out
    );
}

#[test]
fn strips_are_proved_anew() {
    let text = r#"name = "strip"
kind = "uniqueness"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0 }
punch = { shape = "flat-rectangle", width_x = "2 mm", width_y = "1 m" }
[search]
plane = true
[sweep]
[[sweep.zip]]
numerics.mesh = [[2, 1], [4, 1], [5, 1]]
punch.width_x = ["2 mm", "4 mm", "5 mm"]
"#;
    let place = Place::with("strip.toml", text);
    let plan = place.call("plan strip.toml");
    assert!(
        plan.code == 0
            && plan.out.contains("method          determinants, in a plane every element has")
            && plan.out.contains("traction-y      off  `search.plane` asks for tractions in the"),
        "{}",
        plan.out
    );
    assert_eq!(place.call("run strip.toml").code, 0);
    let rows =
        place.json("query strip --select mu_low,mu_high,critical_case --json")["rows"].clone();
    for (row, (exact, case)) in
        [(1.773060, "fb"), (1.640249, "fbhf"), (1.512713, "fbhfb")].into_iter().enumerate()
    {
        let [low, high] = ["mu_low", "mu_high"].map(|name| rows[row][name].as_f64().unwrap());
        assert!((low - exact).abs() < 2e-6 && high > low && high - low < 5e-6, "{rows}");
        assert_eq!(rows[row]["critical_case"], case, "{rows}");
    }
    let said = place.call("store verify --deep");
    assert!(
        said.code == 0 && said.out.contains("3 brackets of uniqueness sets proved anew"),
        "{}",
        said.out
    );
}

/// The bracket of three by three elements is narrowed by a tree of jobs.
const BRANCHES: &str = r#"name = "branches"
kind = "uniqueness"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0 }
punch = { shape = "flat-rectangle", width_x = "2 mm", width_y = "2 mm" }
[numerics]
mesh = 3
[search]
starts = 1
[branch]
to = "1%"
"#;

#[test]
fn branches_narrow_a_bracket_alike_on_any_number_of_workers() {
    let table = |workers: &str| {
        let place = Place::with("branches.toml", BRANCHES);
        let plan = place.json("plan branches.toml --json");
        assert_eq!((&plan["points"], &plan["to_run"]), (&1.into(), &1.into()), "{plan}");
        let said = place.call(&format!("run branches.toml --workers {workers}"));
        assert_eq!(said.code, 0, "{}", said.err);
        let found = place.json("answer branches --json")["answers"]["found"]["rows"][0].clone();
        let number = |name: &str| found[name].as_f64().unwrap_or_else(|| panic!("{name}: {found}"));
        assert!(number("mu_low") > 2.165 && number("mu_high") < 2.188, "{found}");
        assert!(number("bracket_width") <= 0.01 && found["found"] == "branches show it", "{found}");
        let points = place.json("plan branches.toml --json");
        assert_eq!(points["points"].as_u64(), Some(1 + number("jobs") as u64), "{points}");
        assert_eq!(&points["to_run"], &0);
        let excluded = place.json(
            "query branches --where excluded_mu>2.165 --select key,excluded_case,excluded_cones --json",
        );
        let rows = excluded["rows"].as_array().unwrap();
        assert_eq!(rows.len() as f64, number("jobs"));
        let sum = |name: &str| rows.iter().map(|row| row[name].as_u64().unwrap()).sum::<u64>();
        assert!(sum("excluded_cones") > 50, "{excluded}");
        assert_eq!(rows[0]["excluded_case"], "uuuuuuuuu");
        let key = rows[1]["key"].as_str().unwrap();
        assert!(place.call(&format!("show {key}")).out.contains("excluded_mu"));
        let said = place.call("store verify --deep");
        let words = format!("\n{} branches of their fields proved anew\n", number("jobs"));
        assert!(said.code == 0 && said.out.contains(&words), "{}", said.out);
        assert!(said.out.contains("1 bracket of uniqueness sets proved anew"), "{}", said.out);
        place.call("query branches --select key,excluded_mu,excluded_cones,open_cones --format csv")
    };
    let [alone, together] = ["1", "3"].map(table);
    assert_eq!((alone.code, &alone.out), (0, &together.out));
}

#[test]
fn a_bracket_that_takes_too_many_branches_says_what_was_shown() {
    let text = BRANCHES.replace("to = \"1%\"", "to = \"0.3%\"\nat_most = 60");
    let place = Place::with("branches.toml", text);
    assert_eq!(place.call("run branches.toml").code, 0);
    let found = place.json("answer branches --json")["answers"]["found"]["rows"][0].clone();
    assert_eq!(found["found"], "branches show it; a narrower one takes too many cones", "{found}");
    let width = found["bracket_width"].as_f64().unwrap();
    assert!(width > 0.003 && width < 0.1, "{found}");
    let said = place.call("solve branches.toml");
    assert!(said.err.contains("bracketed by weights alone; `tribosweep run"), "{}", said.err);
}

#[test]
fn a_plan_says_how_the_lower_end_of_a_bracket_is_shown() {
    let text = r#"name = "ends"
kind = "uniqueness"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0 }
punch = { shape = "flat-rectangle", width_x = "2 mm", width_y = "2 mm" }
[numerics]
mesh = 3
"#;
    let place = Place::with("ends.toml", text);
    for (more, said) in [
        ("", "weights, `[branch]` or `search.cases` would narrow the bracket"),
        ("[search]\ncases = true\n", "cases, `search.cases` asks for them; `search.width` would"),
        ("[search]\ncases = true\nwidth = 0.02\n", "cones, `search.width` says how narrow"),
    ] {
        place.write("ends.toml", format!("{text}{more}"));
        let plan = place.call("plan ends.toml");
        assert!(plan.code == 0 && plan.out.contains(said), "{}", plan.out);
    }
}

#[test]
fn every_solution_of_a_search_is_shown() {
    let place = Place::with("several.toml", SEVERAL);
    assert_eq!(place.call("run several.toml").code, 0);
    let rows =
        place.json("query several --select key,mu,solutions,index_sum --json")["rows"].clone();
    assert_eq!(
        (rows[0]["solutions"].as_u64(), rows[1]["solutions"].as_u64()),
        (Some(1), Some(3)),
        "{rows}"
    );
    let key = &rows[1]["key"].as_str().unwrap()[..12];
    let shown = place.json(&format!("show {key} --json"));
    assert_eq!(shown["solutions"]["rows"].as_array().map(Vec::len), Some(3));
    let field = |which: usize| {
        place.call(&format!("show {key} --field pressure --solution {which} --output p{which}.csv"))
    };
    assert_eq!([field(0).code, field(2).code, field(3).code], [0, 0, 1]);
    assert_ne!(
        std::fs::read(place.path("p0.csv")).unwrap(),
        std::fs::read(place.path("p2.csv")).unwrap()
    );
}
