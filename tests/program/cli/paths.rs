//! Studies of loading paths: increments as rows, in figures, and in the words about one result.

use std::fs;

use serde_json::Value;

use crate::place::{PATH, Place};

fn ran() -> Place {
    let place = Place::with("path.toml", PATH);
    let said = place.call("run path.toml --workers 2");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    place
}

fn rows(place: &Place, line: &str) -> Vec<Value> {
    place.json(line)["rows"].as_array().unwrap_or_else(|| panic!("{line}")).clone()
}

#[test]
fn increments_are_rows() {
    let place = Place::with("path.toml", PATH);
    let plan = place.json("plan path.toml --json");
    assert_eq!((&plan["to_run"], &plan["increments"]), (&2.into(), &26.into()));
    let place = ran();
    insta::assert_snapshot!(place.transcript(&[
        &[
            "query",
            "path",
            "--steps",
            "--where",
            "mu == 0.2",
            "--select",
            "mu,step,cycle,increment,at_shift_x,status"
        ],
        &[
            "query",
            "path",
            "--steps",
            "--where",
            "increment == 13",
            "--select",
            "mu,at_approach,step,cycle,status",
            "--format",
            "csv"
        ],
        &[
            "query",
            "path",
            "--select",
            "mu,increments,at_shift_x,approach,step1_shift_x,step2_increments,cycles,steps"
        ],
        &["query", "path", "--select", "mu,increment"],
        &["query", "path", "--steps", "--select", "mu,increments"],
        &["query", "path", "--select", "mu,step3_shift_x"],
    ]));
    let listed = |line: &str| -> Vec<String> {
        rows(&place, line).iter().map(|row| row["column"].as_str().unwrap().to_owned()).collect()
    };
    let (ends, increments) =
        (listed("query path --columns --json"), listed("query path --columns --steps --json"));
    assert!(
        ends.iter().any(|name| name == "increments")
            && !ends.iter().any(|name| name == "increment")
    );
    assert_eq!(increments[..4], ["mu", "step", "cycle", "increment"]);
    assert!(!ends.iter().any(|name| name == "step1_shift_y"), "what no job has is not listed");
}

/// The end of a path in the table of points is its last row in the table of increments, and sums
/// along the path agree.
#[test]
fn the_two_tables_agree() {
    let place = ran();
    let columns = "mu,load,force_x,at_shift_x,dissipation,total_dissipation,cycle_dissipation,total_work,external_work,energy,iterations";
    let ends = rows(&place, &format!("query path --json --select {columns}"));
    let all =
        rows(&place, &format!("query path --steps --json --select {columns},increment,cycle"));
    assert_eq!((ends.len(), all.len()), (2, 26));
    for end in &ends {
        let path: Vec<&Value> = all.iter().filter(|row| row["mu"] == end["mu"]).collect();
        let last = path.last().unwrap();
        columns.split(',').for_each(|name| assert_eq!(last[name], end[name], "{name}"));
        let sum = |rows: &[&Value], name: &str| {
            rows.iter().map(|row| row[name].as_f64().unwrap()).sum::<f64>()
        };
        let close = |a: f64, b: &Value| (a - b.as_f64().unwrap()).abs() <= 1e-12 * a.abs();
        assert!(close(sum(&path, "dissipation"), &end["total_dissipation"]));
        assert!(close(sum(&path, "external_work"), &end["total_work"]));
        let cycle: Vec<&Value> = path.iter().copied().filter(|row| row["cycle"] == 2).collect();
        assert!(close(sum(&cycle, "dissipation"), &end["cycle_dissipation"]));
        assert!(end["cycle_dissipation"].as_f64().unwrap() > 0.0 && cycle.len() == 6);
    }
}

#[test]
fn one_result_shows_its_path() {
    let place = ran();
    let key = &place.call("query path --select key --format csv").out.lines().nth(1).unwrap()[..12]
        .to_owned();
    let shown = place.call(&format!("show {key}")).out;
    assert!(
        shown.contains("a path of 13 increments: 3 steps, from the one with index 1 on 2 cycles"),
        "{shown}"
    );
    assert!(
        shown.contains(
            "scene.loading.steps = [{ approach = 2e-5 }, { shift_x = 3e-6, increments = 2 }"
        ),
        "{shown}"
    );
    assert_eq!(rows(&place, &format!("show {key} --steps --json")).len(), 13);
    let table = place.call(&format!("show {key} --steps")).out;
    assert!(
        ["step", "cycle", "increment", "at_shift_x", "force_x"]
            .iter()
            .all(|name| table.contains(name)),
        "{table}"
    );
    let solved = place.call("solve path.toml --set mu=0.4 --set loading.cycles=1");
    assert!(
        solved.out.contains("a path of 7 increments") && solved.out.contains("\npath\n"),
        "{}{}",
        solved.out,
        solved.err
    );
    let short = place.words(&[
        "solve",
        "path.toml",
        "--set",
        "mu=0.4",
        "--set",
        "step2_increments=1",
        "--set",
        "loading.steps[1].increments=1",
        "--json",
    ]);
    assert_eq!(serde_json::from_str::<Value>(&short.out).unwrap()["result"]["increments"], 5);
}

#[test]
fn figures_of_increments_follow_the_path() {
    let place = ran();
    assert!(place.path(".tribosweep/figures/path.svg").exists());
    let curve = |words: &[&str]| -> usize {
        let said = place.words(words);
        assert_eq!(said.code, 0, "{}", said.err);
        let svg = fs::read_to_string(place.path("f.svg")).unwrap();
        // The number of points that the longest curve joins.
        svg.split("<path d=\"")
            .skip(1)
            .map(|path| path.split('"').next().unwrap().matches('L').count())
            .max()
            .unwrap()
    };
    assert_eq!(
        curve(&["plot", "path", "--output", "f.svg"]),
        12,
        "a loop is one curve through every increment"
    );
    assert_eq!(
        curve(&[
            "plot",
            "path",
            "--steps",
            "--x",
            "increment",
            "--y",
            "dissipation",
            "--series",
            "mu",
            "--output",
            "f.svg"
        ]),
        12
    );
    assert_eq!(
        curve(&["plot", "path", "--x", "mu", "--y", "total_dissipation", "--output", "f.svg"]),
        1,
        "two ends of paths"
    );
    insta::assert_snapshot!(place.transcript(&[&[
        "plot",
        "path",
        "--x",
        "increment",
        "--y",
        "load",
        "--output",
        "f.svg"
    ]]));
}

#[test]
fn a_path_that_cannot_be_followed_keeps_what_it_came_through() {
    let pulled = PATH
        .replace("approach = \"20 um\"", "normal_force = \"1 kN\"")
        .replace("shift_x = \"3 um\"", "force_x = \"300 N\"")
        .replace("shift_x = \"-3 um\"", "force_x = \"-300 N\"");
    let place = Place::with("path.toml", pulled);
    let said = place.call("run path.toml --workers 1 --json");
    assert_eq!(said.code, 2, "{}", said.err);
    let failed = rows(&place, "query path --json --select mu,status,reason,increments");
    assert_eq!(
        (&failed[0]["status"], &failed[1]["status"]),
        (&"failed".into(), &"certified".into())
    );
    let reason = failed[0]["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("loading.steps[1], increment 2 of 2, cycle 1: gross sliding"),
        "{reason}"
    );
    assert_eq!((&failed[0]["increments"], &failed[1]["increments"]), (&3.into(), &13.into()));
    let path = rows(
        &place,
        "query path --steps --json --where 'mu==0.2' --select step,status,load"
            .replace('\'', "")
            .as_str(),
    );
    let statuses: Vec<_> = path.iter().map(|row| row["status"].as_str().unwrap()).collect();
    assert_eq!(statuses, ["certified", "certified", "failed"]);
    assert!((path[1]["load"].as_f64().unwrap() / 1000.0 - 1.0).abs() < 1e-6);
    let summary: Value = serde_json::from_str(said.out.lines().last().unwrap()).unwrap();
    let show = summary["failures"][0]["show"]
        .as_str()
        .unwrap()
        .strip_prefix("tribosweep ")
        .unwrap()
        .to_owned();
    assert!(place.call(&show).out.contains("the path ended at its increment 3 of 13"));
    assert!(place.path(".tribosweep/figures/path.svg").exists());
}
