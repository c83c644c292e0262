//! Points of a study beyond the product of its axes: excluded, derived, from a file.

use std::fs;
use std::path::Path;

use crate::place::Place;

/// A study of the repository, with the files beside it.
fn sweep(name: &str) -> Place {
    let place = Place::empty();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("sweeps");
    for file in [format!("{name}.toml"), format!("{name}.csv")] {
        if let Ok(text) = fs::read(folder.join(&file)) {
            place.write(&file, text);
        }
    }
    place
}

#[test]
fn what_is_excluded_is_counted_and_what_is_derived_is_a_column() {
    let place = sweep("scaled-coating");
    let plan = place.call("plan scaled-coating.toml");
    assert!(plan.out.contains("12 points (3 more excluded), 12 distinct jobs"), "{}", plan.out);
    assert_eq!(place.json("plan scaled-coating.toml --json")["excluded"], 3);
    let run = place.call("run scaled-coating.toml --workers 2");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("12 points (3 more excluded), 12 certified"), "{}", run.out);
    let answer = place.call("answer scaled-coating");
    assert!(answer.out.contains("3 more of the axes are excluded"), "{}", answer.out);
    let progress = place.json("answer scaled-coating --json")["progress"].clone();
    assert_eq!((&progress["points"], &progress["excluded"]), (&12.into(), &3.into()));
    let query = place.call(
        "query scaled-coating --select radius,layer0_thickness,peak_pressure --format csv --where \
         layer0_shear_modulus==4e9",
    );
    let rows: Vec<Vec<f64>> = query
        .out
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|value| value.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 3, "{}", query.out);
    for row in &rows {
        assert!((row[1] / row[0] - 0.02).abs() < 1e-15, "{row:?}");
        assert!((row[2] / rows[0][2] - 1.0).abs() < 1e-6, "size does not matter: {rows:?}");
    }
}

/// The shards of a study leave out what the whole does.
#[test]
fn shards_leave_out_the_same_points() {
    let place = sweep("scaled-coating");
    for shard in ["1/2", "2/2"] {
        let run = place.call(&format!("run scaled-coating.toml --shard {shard} --workers 2"));
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let run = place.call("run scaled-coating.toml --workers 2");
    assert!(run.out.contains("12 points (3 more excluded)"), "{}", run.out);
    assert!(run.out.contains("0 of 12 jobs computed"), "{}", run.out);
}

/// The store keeps the file, so that the study goes on without it; what a query writes is a file of
/// points.
#[test]
fn a_file_of_points_is_kept_and_a_query_is_another() {
    let place = sweep("listed-points");
    let run = place.call("run listed-points.toml --workers 2");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("14 points, 14 certified"), "{}", run.out);
    fs::remove_file(place.path("listed-points.csv")).unwrap();
    let resume = place.call("resume listed-points");
    assert!(resume.out.contains("0 of 14 jobs computed"), "{}{}", resume.out, resume.err);
    let query = place.call("query listed-points --where mesh==12 --format csv");
    assert_eq!(query.out.lines().count(), 8, "{}", query.out);
    place.write("listed-points.csv", query.out);
    let text = fs::read_to_string(place.path("listed-points.toml")).unwrap();
    let again = text.replace("[sweep]\nmesh = [12, 24]\n", "").replace("\"mesh\"", "\"mu\"");
    place.write("again.toml", again.replace("name = \"listed-points\"", "name = \"again\""));
    let plan = place.call("plan again.toml");
    assert!(
        plan.out.contains("7 points, 7 distinct jobs: 7 in the store, 0 to run"),
        "{}",
        plan.out
    );
    assert!(plan.out.contains("left out, since they are results: "), "{}", plan.out);
}

/// A scene may derive keys too.
#[test]
fn a_single_scene_is_solved_with_derived_keys() {
    let text = "name = \"one\"\n[scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson = \
                0.3 }\npunch = { shape = \"sphere\", radius = \"10 mm\" }\nloading.steps = [{}]\n\
                [numerics]\nmesh = 8\n[derive]\n\"loading.steps[0].approach\" = \"1e-4 * radius\"\n";
    let place = Place::with("one.toml", text);
    let derived = place.call("solve one.toml");
    assert_eq!(derived.code, 0, "{}", derived.err);
    let set = place.call("solve one.toml --set loading.steps[0].approach=1um");
    let key = |out: &str| {
        out.lines().find(|line| line.starts_with("  key ")).map(str::to_owned).expect("a key")
    };
    assert_eq!(key(&set.out), key(&derived.out));
    let other = place.call("solve one.toml --set punch.radius=20mm");
    assert!(other.out.contains("approach = 2e-6"), "{}", other.out);
    assert_ne!(key(&other.out), key(&derived.out));
}

/// A plan of more points than are listed says of conditions what one of fewer says.
#[test]
fn conditions_of_a_large_study_are_judged_by_its_plan() {
    let study = |conditions: &str| {
        format!(
            "name = \"large\"\n[scene]\nfoundation.base = {{ shear_modulus = \"80 GPa\", \
             poisson = 0.3 }}\npunch = {{ shape = \"sphere\", radius = \"10 mm\" }}\n\
             loading.steps = [{{ approach = \"1 um\" }}]\n[numerics]\nmesh = 8\n[sweep]\n\
             \"friction.mu\" = {{ from = 0, to = 1, count = 150000 }}\n\
             \"punch.radius\" = [\"5 mm\", \"10 mm\"]\n{conditions}"
        )
    };
    let few = "[[keep]]\nwhen = \"mu < 0.001\"\n[[exclude]]\nwhen = \"mu > 2\"\n";
    let place = Place::with("large.toml", study(few));
    let plan = place.call("plan large.toml");
    assert!(plan.out.contains("300 points (299700 more excluded)"), "{}{}", plan.out, plan.err);
    assert!(plan.out.contains("[[exclude]] `mu > 2` holds at no point"), "{}", plan.out);
    place.write("large.toml", study("[[keep]]\nwhen = \"radius > 7\"\n"));
    let plan = place.call("plan large.toml");
    assert_ne!(plan.code, 0);
    assert!(plan.err.contains("leave none of the study's 300000 points"), "{}", plan.err);
}
