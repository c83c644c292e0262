//! Samples: they grow, are resumed, planned, cut into shards and drawn.

use crate::place::{Place, Said};

/// Returns a study of a sample; each of its points takes a few milliseconds.
fn study(method: &str, count: usize, more: &str) -> String {
    format!(
        r#"
name = "drawn"
[scene]
foundation.base = {{ shear_modulus = "80 GPa", poisson = 0.3 }}
punch = {{ shape = "sphere", radius = "10 mm" }}
loading.steps = [{{ approach = "1 um" }}]
[numerics]
mesh = 8
[sample]
method = "{method}"
count = {count}
seed = 4
[sample.keys]
"friction.mu" = {{ from = 0.1, to = 0.5 }}
"punch.radius" = {{ distribution = "normal", mean = "10 mm", deviation = "0.5 mm" }}
{more}"#
    )
}

fn last_line(said: &Said) -> serde_json::Value {
    let last = said.out.lines().last().unwrap_or_else(|| panic!("{}", said.err));
    serde_json::from_str(last).unwrap_or_else(|error| panic!("{error}: {last}\n{}", said.err))
}

fn csv(place: &Place) -> String {
    let said = place.call("query drawn --select mu,radius,load,stick_fraction,key --format csv");
    assert_eq!(said.code, 0, "{}", said.err);
    said.out
}

#[test]
fn a_larger_sample_computes_only_what_it_adds() {
    for (method, more) in [("sobol", 11), ("halton", 9), ("random", 9), ("latin-hypercube", 16)] {
        let place = Place::with("drawn.toml", study(method, 8, ""));
        assert_eq!(place.call("run drawn.toml --workers 2").code, 0);
        let few = csv(&place);
        place.write("drawn.toml", study(method, more, ""));
        let plan = place.json("plan drawn.toml --json");
        assert_eq!((&plan["cached"], &plan["to_run"]), (&8.into(), &(more - 8).into()), "{method}");
        let said = place.call("run drawn.toml --workers 2 --json");
        assert_eq!(last_line(&said)["run"]["computing"], more - 8, "{method}");
        let many = csv(&place);
        assert!(many.starts_with(&few) && many.lines().count() == more + 1, "{method}\n{many}");
    }
}

#[test]
fn a_hypercube_that_would_lose_its_points_is_refused() {
    let place = Place::with("drawn.toml", study("latin-hypercube", 8, ""));
    assert_eq!(place.call("run drawn.toml --workers 2").code, 0);
    let few = csv(&place);
    place.write("drawn.toml", study("latin-hypercube", 12, ""));
    let refused = place.call("run drawn.toml");
    assert_eq!(refused.code, 1);
    insta::assert_snapshot!(refused.err);
    assert_eq!(csv(&place), few, "nothing was changed");
    // Half of them are the beginning, and another seed is another sample.
    for text in [
        study("latin-hypercube", 4, ""),
        study("latin-hypercube", 12, "").replace("seed = 4", "seed = 5"),
    ] {
        place.write("drawn.toml", text);
        assert_eq!(place.call("run drawn.toml --workers 2").code, 0);
    }
}

#[test]
fn a_plan_says_that_a_number_of_sobol_points_is_uneven() {
    let said = |count| Place::with("drawn.toml", study("sobol", count, "")).call("plan drawn.toml");
    let note = "note: the 100 points of the sample are no power of two, where Sobol' points are \
                most even: 64 or 128\n";
    assert!(said(100).out.contains(note), "{}", said(100).out);
    assert!(!said(64).out.contains("note:"));
}

#[test]
fn shards_of_a_sample_beside_an_axis_are_the_whole() {
    let place = Place::with("drawn.toml", study("halton", 6, "[sweep]\nmesh = [6, 8]\n"));
    assert_eq!(place.call("run drawn.toml --workers 2").code, 0);
    let whole = csv(&place);
    assert_eq!(whole.lines().count(), 13);
    for shard in 1..=3 {
        let line = format!("run drawn.toml --shard {shard}/3 --store other --workers 1");
        assert_eq!(place.call(&line).code, 0);
    }
    let said = place
        .call("query drawn --select mu,radius,load,stick_fraction,key --format csv --store other");
    assert_eq!(said.out, whole);
}

#[test]
fn measured_values_are_drawn_and_go_along_with_the_study() {
    let measured = "\"foundation.base.poisson\" = { file = \"nu.csv\", column = \"nu\" }\n";
    let place = Place::with("drawn.toml", study("sobol", 8, measured));
    let missing = place.call("run drawn.toml");
    assert!(missing.code == 1 && missing.err.contains("nu.csv"), "{}", missing.err);
    place.write("nu.csv", "sample,nu\na,0.25\nb,0.3\nc,0.25\nd,x\n");
    let refused = place.call("run drawn.toml");
    assert!(refused.err.contains("line 5, value 2"), "{}", refused.err);
    place.write("nu.csv", "sample,nu\na,0.25\nb,0.3\nc,0.25\nd,0.35\n");
    assert_eq!(place.call("run drawn.toml --workers 2").code, 0);
    // The study in the store has its file.
    std::fs::remove_file(place.path("nu.csv")).unwrap();
    std::fs::remove_file(place.path("drawn.toml")).unwrap();
    let rows = place.call("query drawn --select poisson --format csv").out;
    let count = |value: &str| rows.lines().filter(|line| *line == value).count();
    assert_eq!([count("0.25"), count("0.3"), count("0.35")], [4, 2, 2], "{rows}");
    assert_eq!(place.call("resume drawn").code, 0);
}

#[test]
fn a_sample_is_drawn_as_a_histogram_and_as_points() {
    let place = Place::with("drawn.toml", study("sobol", 32, ""));
    let said = place.call("run drawn.toml --workers 2");
    assert_eq!(said.code, 0, "{}", said.err);
    let svg = |line: &str| {
        let said = place.call(&format!("plot drawn --output picture.svg {line}"));
        assert_eq!(said.code, 0, "{line}: {}", said.err);
        std::fs::read_to_string(place.path("picture.svg")).unwrap()
    };
    let suggested = svg("");
    assert!(suggested.contains(">points<") && suggested.contains(">load [N]<"), "{suggested}");
    let scatter = svg("--x mu --y stick_fraction");
    assert_eq!(scatter.matches("<circle").count(), 32);
    assert!(
        svg("--x peak_pressure --kind histogram --bins 4 --share").contains("share of the points")
    );
    assert!(svg("--x mu --y stick_fraction --kind curves").contains("<path d=\"M"));
    let refused = place.call("plot drawn --x mu --y load --bins 3");
    assert!(refused.code == 1 && refused.err.contains("has no --y"), "{}", refused.err);
    let page = place.call("report drawn --output page.html");
    assert_eq!(page.code, 0, "{}", page.err);
}

#[test]
fn a_setting_takes_a_key_out_of_a_sample() {
    let place = Place::with("drawn.toml", study("sobol", 8, ""));
    let said = place.call("solve drawn.toml --set friction.mu=0.2 --set punch.radius=10mm --json");
    assert_eq!(said.code, 0, "{}", said.err);
    let refused = place.call("solve drawn.toml --set friction.mu=0.2");
    assert!(refused.code == 1 && refused.err.contains("punch.radius"), "{}", refused.err);
}
