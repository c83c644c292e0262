//! Runs with a time (`--until`), which stop before their jobs are done and go on by the same
//! command.

use super::adaptive::halved;
use crate::place::{PATH, Place, SMALL};

/// The most starts after which a study must be done.
const MOST_STARTS: usize = 200;

/// Starts a command with hardly any time until it is done, and returns what each start said.
fn started_until_done(place: &Place, command: &str) -> Vec<String> {
    let mut starts = Vec::new();
    loop {
        let said = place.call(&format!("{command} --until 1ms"));
        starts.push(said.out);
        if said.code != 75 {
            assert_eq!(said.code, 0, "{}", said.err);
            return starts;
        }
        assert!(starts.len() < MOST_STARTS, "it gets nowhere: {starts:?}");
    }
}

/// Returns the rows of a study without what differs from run to run.
fn rows(place: &Place, study: &str) -> String {
    let said = place.call(&format!("query {study} --sort mu --select mu,key,status --format csv"));
    assert_eq!(said.code, 0, "{}", said.err);
    said.out
}

#[test]
fn with_hardly_any_time_each_start_does_one_job() {
    let place = Place::with("small.toml", SMALL);
    let starts = started_until_done(&place, "run small.toml --workers 2");
    let mut left = 6;
    for said in &starts[..starts.len() - 1] {
        // A slow machine may give up the job, and then none is done.
        let is_said = |left: &usize| {
            let are = if *left == 1 { "is" } else { "are" };
            let end = format!("{left} of 6 jobs {are} left; the same command goes on");
            said.contains(&format!("\nstopped in time (--until 1ms): {end}"))
        };
        let now = [left - 1, left].into_iter().find(is_said);
        left = now.unwrap_or_else(|| panic!("{left} were left before:\n{said}"));
    }
    assert_eq!(left, 1, "the last start does the last job");
    assert_eq!(rows(&place, "small"), rows(&Place::run(), "small"));
}

#[test]
fn a_study_that_chooses_its_points_chooses_the_same_in_many_starts() {
    let study = halved("friction.mu", "[0.1, 0.5]", "mu > 0.3");
    let (place, other) = (Place::with("halved.toml", &study), Place::with("halved.toml", &study));
    let starts = started_until_done(&place, "run halved.toml");
    assert!(starts.len() > 1 && starts[0].contains(" known so far "), "{starts:?}");
    assert_eq!(other.call("run halved.toml").code, 0);
    assert_eq!(rows(&place, "halved"), rows(&other, "halved"));
}

/// A path of a thousand increments on many elements takes minutes.
#[test]
fn a_job_that_takes_too_long_is_given_up_and_leaves_no_record() {
    let long = PATH.replace("mesh = 6", "mesh = 192").replace("cycles = 2", "cycles = 160");
    let place = Place::with("path.toml", long.replace("[0.2, 0.6]", "[0.2]"));
    for _ in 0..2 {
        let said = place.call("run path.toml --until 1ms");
        assert_eq!(said.code, 75, "{}", said.err);
        let given_up = "stopping now: the jobs in flight are given up for another run\n";
        assert!(said.err.contains(given_up), "{}", said.err);
        let end = "stopped in time (--until 1ms): 1 of 1 job is left; the same command goes on, \
                   but no job ended in this time\n";
        assert!(said.out.ends_with(end), "{}", said.out);
    }
    assert_eq!(place.json("status path --json")[0]["progress"]["left"], 1);
}

#[test]
fn a_run_that_is_done_in_time_ends_as_ever() {
    let place = Place::with("small.toml", SMALL);
    for command in ["run small.toml --until 100h", "resume small --until 100h"] {
        let said = place.call(command);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(!said.out.contains("in time") && !said.err.contains("in time"), "{}", said.out);
    }
    let summary = place.json("run small.toml --until 100h --json");
    assert_eq!(summary["run"]["stopped_in_time"], false);
}

#[test]
fn a_cost_study_stops_in_time_as_well() {
    let place = Place::with("small.toml", SMALL);
    let command = "cost small.toml --set friction.mu=0.2 --set foundation.base.poisson=0.3";
    let said = place.call(&format!("{command} --until 1ms"));
    assert_eq!(said.code, 75, "{}", said.err);
    assert!(said.out.contains("stopped in time (--until 1ms): "), "{}", said.out);
}
