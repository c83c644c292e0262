//! Runs that stop after a number of jobs (`--max-jobs`) or of failures (`--max-failures`).

use super::adaptive::halved;
use crate::place::{Place, SMALL};

/// The small study with five values of friction, and with one value of ν.
fn five() -> String {
    SMALL.replace("[0.05, 0.2, 0.6]", "[0.1, 0.2, 0.3, 0.4, 0.5]").replace("[0.0, 0.3]", "[0.3]")
}

/// Returns the values of μ that have a result.
fn done(place: &Place) -> Vec<f64> {
    let rows = place.json("query small --where status!=null --select mu --sort mu --json");
    rows["rows"].as_array().unwrap().iter().map(|row| row["mu"].as_f64().unwrap()).collect()
}

#[test]
fn so_many_jobs_are_computed_and_the_coarse_grid_comes_first() {
    let place = Place::with("small.toml", five());
    let grids: [&[f64]; 3] = [&[0.1, 0.5], &[0.1, 0.3, 0.5], &[0.1, 0.2, 0.3, 0.4, 0.5]];
    for (most, grid) in [2, 1, 2].into_iter().zip(grids) {
        let said = place.call(&format!("run small.toml --max-jobs {most} --workers 2"));
        let left = 5 - grid.len();
        assert_eq!(said.code, if left > 0 { 75 } else { 0 }, "{}", said.err);
        assert_eq!(done(&place), grid);
        if left > 0 {
            let words = format!(
                "stopped in time (--max-jobs {most}): {left} of 5 jobs are left; the same command \
                 goes on\n"
            );
            assert!(said.out.ends_with(&words), "{}", said.out);
            assert!(said.out.contains("\nthe jobs left take about "), "{}", said.out);
        }
    }
    let summary = place.json("run small.toml --max-jobs 1 --json");
    assert_eq!(summary["run"]["computing"], 0);
    assert_eq!(summary["run"]["stopped_in_time"], false);
}

#[test]
fn events_tell_of_a_number_of_jobs_too() {
    let place = Place::with("small.toml", five());
    let said = place.call("run small.toml --max-jobs 3 --json");
    assert_eq!(said.code, 75);
    let summary: serde_json::Value =
        serde_json::from_str(said.out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["run"]["jobs"], 5);
    assert_eq!(summary["run"]["computing"], 3);
    assert_eq!(summary["run"]["stopped_by"], "--max-jobs 3");
    assert!(summary["run"]["seconds_left"].as_f64().unwrap() > 0.0);
    assert_eq!(summary["progress"]["left"], 2);
}

#[test]
fn a_study_that_chooses_its_points_chooses_the_same_by_and_by() {
    let study = halved("friction.mu", "[0.1, 0.5]", "mu > 0.3");
    let (place, other) = (Place::with("halved.toml", &study), Place::with("halved.toml", &study));
    let mut starts = 0;
    while place.call("run halved.toml --max-jobs 1").code == 75 {
        starts += 1;
        assert!(starts < 100);
    }
    assert!(starts > 1);
    assert_eq!(other.call("run halved.toml").code, 0);
    let query = "query halved --select mu,key,status --sort mu --format csv";
    assert_eq!(place.call(query).out, other.call(query).out);
}

/// One iteration is too few for any solution, so every job fails.
#[test]
fn too_many_failures_end_a_run_with_a_code_of_their_own() {
    let failing = five().replace("mesh = 6", "mesh = 6\nmax_iterations = 1");
    for (limit, code) in [("0", 3), ("20%", 3), ("5", 2), ("99.9%", 2)] {
        let place = Place::with("small.toml", &failing);
        let said = place.call(&format!("run small.toml --workers 1 --max-failures {limit}"));
        let counts = place.json("status small --json")[0]["progress"].clone();
        let failed = counts["failed"].as_u64().unwrap();
        if limit == "99.9%" {
            // The fifth of five failures is one too many, and nothing is left to be stopped.
            assert_eq!(failed, 5);
        }
        assert_eq!(said.code, code, "{limit}: {}\n{}", said.out, said.err);
        let stopped = format!("\nstopped (--max-failures {limit}: {failed} failed): ");
        assert_eq!(said.out.contains(&stopped), code == 3, "{}", said.out);
        assert_eq!(failed + counts["left"].as_u64().unwrap(), 5);
        // The same command goes on, without the limit to the end.
        assert_eq!(place.call("run small.toml").code, 2);
        assert_eq!(place.json("status small --json")[0]["progress"]["failed"], 5);
    }
}

#[test]
fn limits_without_meaning_are_refused() {
    let place = Place::with("small.toml", SMALL);
    for (limit, words) in [
        ("--max-jobs 0", "0 is not in 1.."),
        ("--max-jobs many", "invalid digit"),
        ("--max-failures many", "neither a number of jobs nor a part of them"),
        ("--max-failures 100%", "write for example 5 or 10%"),
        ("--max-failures -1", "unexpected argument"),
    ] {
        let said = place.call(&format!("run small.toml {limit}"));
        assert_eq!(said.code, 1, "{limit}");
        assert!(said.err.contains(words), "{}", said.err);
    }
    assert!(!place.path(".tribosweep").exists());
}
