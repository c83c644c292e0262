//! `accuracy` in place of a mesh: the settings that are chosen, from earlier results or by trying,
//! and the words for them.

use std::path::Path;
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::place::Place;

const SCENE: &str = r#"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0
loading.steps = [{ approach = "1 um" }]
"#;

/// The load of a rigid sphere without friction on that half-space (Hertz) \[N\].
fn hertz() -> f64 {
    let modulus = 2.0 * 80e9 / (1.0 - 0.3);
    4.0 / 3.0 * modulus * 0.01_f64.sqrt() * 1e-6_f64.powf(1.5)
}

fn study(name: &str, accuracy: &str, more: &str) -> String {
    format!("name = \"{name}\"\naccuracy = {accuracy}\n{SCENE}{more}")
}

const FRICTION: &str = "[sweep]\nfriction.mu = [0, 0.3]\n";

fn summary(place: &Place, line: &str) -> (i32, Value) {
    let said = place.call(line);
    let last = said.out.lines().last().unwrap_or_else(|| panic!("{}", said.err));
    (said.code, serde_json::from_str(last).unwrap())
}

fn found(place: &Place, name: &str) -> Vec<Value> {
    place.json(&format!("answer {name} --json"))["answers"]["found"]["rows"]
        .as_array()
        .unwrap()
        .clone()
}

#[test]
fn the_mesh_that_an_accuracy_takes_is_found_once() {
    let place = Place::with("fine.toml", study("fine", "\"0.5%\"", FRICTION));
    let before = place.call("plan fine.toml");
    assert!(
        before.code == 0
            && before.out.contains("to be tried next")
            && before.out.contains("8 x 8 elements: 2 jobs"),
        "{}",
        before.out
    );
    assert!(!place.path(".tribosweep").exists());

    let (code, ran) = summary(&place, "run fine.toml --json");
    assert_eq!(
        (code, &ran["progress"]["points"], &ran["progress"]["done"], &ran["inaccurate"]),
        (0, &2.into(), &2.into(), &0.into())
    );
    let computed = ran["run"]["computing"].as_u64().unwrap();
    assert!(computed > 2, "the ladder was climbed: {ran}");
    let rows =
        place.json(
            "query fine --select mu,mesh,tolerance,load,estimate_load,estimate_solver --json",
        )["rows"]
            .clone();
    for (row, said) in rows.as_array().unwrap().iter().zip(found(&place, "fine")) {
        let number = |name: &str| row[name].as_f64().unwrap();
        let error = said["estimated error"].as_f64().unwrap();
        assert!(
            said["found"] == "accurate enough"
                && said["mesh"].as_str() == Some(&row["mesh"].to_string()),
            "{said} for {row}"
        );
        assert!(
            error <= 0.005
                && (number("estimate_load") + number("estimate_solver") - error).abs()
                    < 0.06 * error,
            "{said} for {row}"
        );
        assert!(number("tolerance") == 1e-4 && number("mesh") <= 48.0, "{row}");
    }
    assert!((rows[0]["load"].as_f64().unwrap() / hertz() - 1.0).abs() < 0.005, "{rows}");

    // Results serve again, those of other studies too.
    assert_eq!(summary(&place, "run fine.toml --json").1["run"]["computing"], 0);
    let plan = place.json("plan fine.toml --json");
    assert_eq!(
        (&plan["to_run"], &plan["chosen"]["rows"][1]["found"]),
        (&0.into(), &"accurate enough".into())
    );
    place.write("again.toml", study("again", "{ is = \"0.5%\", of = \"load\" }", FRICTION));
    assert_eq!(summary(&place, "run again.toml --json").1["run"]["computing"], 0);
    // A digit more begins where the first study ended.
    place.write("finer.toml", study("finer", "0.0005", FRICTION));
    let (code, finer) = summary(&place, "run finer.toml --json");
    assert!(code == 0 && finer["run"]["computing"].as_u64().unwrap() <= computed, "{finer}");
    assert!(
        found(&place, "finer").iter().all(|row| row["estimated error"].as_f64().unwrap() <= 5e-4)
    );
    let said = place.call("run finer.toml");
    assert!(
        said.out.contains("accurate enough") && said.out.contains("finer: 2 points, 2 certified"),
        "{}",
        said.out
    );
}

#[test]
fn results_of_other_studies_teach() {
    let with_mesh =
        format!("name = \"given\"\n{SCENE}[numerics]\nmesh = 40\n[sweep]\nmesh = [8, 40]\n");
    let place = Place::with("given.toml", with_mesh);
    assert_eq!(place.call("run given.toml").code, 0);
    place.write("fine.toml", study("fine", "\"0.5%\"", ""));
    let (_, ran) = summary(&place, "run fine.toml --json");
    assert_eq!(
        (&ran["run"]["computing"], &found(&place, "fine")[0]["mesh"]),
        (&0.into(), &"40".into()),
        "{ran}"
    );
    // They do not serve a scene that differs in anything, nor other numerics.
    place.write("other.toml", study("other", "\"0.5%\"", "[numerics]\nepsilon = 1e-9\n"));
    assert!(summary(&place, "run other.toml --json").1["run"]["computing"].as_u64().unwrap() > 1);

    // The rungs were measured for their cost: only the one that is chosen is solved as a result.
    let cost = format!(
        "name = \"price\"\nkind = \"cost\"\n{SCENE}[numerics]\nmesh = 8\n[sweep]\nmesh = [8, 16, 32]\ntolerance = [1e-4]\n[cost]\nrepeat = 1\n"
    );
    let place = Place::with("price.toml", cost);
    assert_eq!(place.call("run price.toml").code, 0);
    place.write("fine.toml", study("fine", "\"0.5%\"", ""));
    let (code, ran) = summary(&place, "run fine.toml --json");
    assert_eq!(
        (code, &ran["run"]["computing"], &found(&place, "fine")[0]["mesh"]),
        (0, &1.into(), &"32".into()),
        "{ran}"
    );
}

#[test]
fn an_accuracy_out_of_reach_is_said_to_be() {
    let place = Place::with("far.toml", study("far", "{ is = 1e-5, at_most = 24 }", ""));
    let said = place.call("run far.toml");
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(
        said.out.contains("warning: 1 point misses the accuracy asked for: tribosweep answer far"),
        "{}",
        said.out
    );
    let row = &found(&place, "far")[0];
    assert!(
        row["found"] == "not reached on the finest mesh allowed" && row["mesh"] == "24",
        "{row}"
    );
    assert!(row["estimated error"].as_f64().unwrap() > 1e-5, "{row}");
    assert_eq!(place.call("run far.toml").code, 2, "nor when it is asked again");
    // A tolerance that the user gives is kept, although it is in the way.
    let place = Place::with("loose.toml", study("loose", "1e-4", "[numerics]\ntolerance = 0.5\n"));
    assert_eq!(place.call("run loose.toml").code, 2);
    assert_eq!(found(&place, "loose")[0]["found"], "the solver leaves more than that");
    // Under a flat punch the pressure has no limit.
    let flat = study("flat", "{ is = 0.01, of = \"peak_pressure\" }", "")
        .replace("\"sphere\", radius = \"10 mm\"", "\"flat-disk\", radius = \"1 mm\"");
    let place = Place::with("flat.toml", flat);
    assert_eq!(place.call("run flat.toml").code, 2);
    assert_eq!(found(&place, "flat")[0]["found"], "no error of it is estimated");
}

#[test]
fn killed_on_its_way_to_an_accuracy_it_ends_where_it_would_have() {
    let text = study("fine", "\"0.1%\"", "[sweep]\nfriction.mu = [0, 0.1, 0.2, 0.3]\n");
    let rows = |place: &Place| {
        place.call("query fine --select key,mu,mesh,tolerance,load --format csv").out
    };
    let whole = Place::with("fine.toml", &text);
    assert_eq!(whole.call("run fine.toml --workers 2").code, 0);
    let killed = Place::with("fine.toml", &text);
    for milliseconds in [60, 120, 200, 320] {
        let mut run = killed.command(&["run", "fine.toml", "--workers", "1"]).spawn().unwrap();
        sleep(Duration::from_millis(milliseconds));
        let _ = run.kill();
        run.wait().unwrap();
    }
    assert_eq!(killed.call("run fine.toml --workers 1").code, 0);
    assert_eq!(rows(&killed), rows(&whole));
    assert_eq!(found(&killed, "fine"), found(&whole, "fine"));
}

#[test]
fn one_scene_is_solved_to_an_accuracy_without_a_store() {
    let place = Place::with("one.toml", study("one", "\"0.5%\"", ""));
    let shown = place.json("solve one.toml --json");
    let solved = &shown["result"];
    assert!(
        solved["estimate_load"].as_f64().unwrap() <= 0.005
            && solved["mesh_x"].as_u64().unwrap() > 8,
        "{shown}"
    );
    assert!(
        solved.get("attempt").is_none() && solved.get("finished").is_none(),
        "of a run only: {shown}"
    );
    assert_eq!(
        place.json("solve one.toml --json --set mesh=10")["result"]["mesh_x"],
        10,
        "who says the mesh picks it"
    );
    place.write("one.toml", study("one", "{ is = 1e-6, at_most = 12 }", ""));
    let said = place.call("solve one.toml");
    assert!(
        said.code == 2 && said.err.contains("the accuracy asked for was missed"),
        "{}",
        said.err
    );
    let said = place.call("effects one.toml");
    assert!(said.code == 1 && said.err.contains("in place of the accuracy"), "{}", said.err);
    assert_eq!(place.files().len(), 1);
}

/// A script compares the program with a page of the documentation and leaves nothing behind.
fn check(script: &str) {
    let temporary = TempDir::new().unwrap();
    let mut check =
        Command::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts").join(script));
    check
        .args(["--check", "--program", env!("CARGO_BIN_EXE_tribosweep")])
        .env("TMPDIR", temporary.path());
    let output = check.env_remove("TRIBOSWEEP_STORE").output().unwrap();
    let said = [output.stdout, output.stderr]
        .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
        .concat();
    assert!(output.status.success(), "{said}");
    let left: Vec<_> =
        std::fs::read_dir(temporary.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn hard_cases_end_as_their_table_says() {
    check("hard-cases");
}

#[test]
fn the_tables_of_accuracy_are_what_its_script_makes() {
    check("accuracy");
}
