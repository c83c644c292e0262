//! Studies that bracket, search and compare: in the middle of each the coordinator is killed, then
//! a worker.

use std::collections::BTreeSet;
use std::os::unix::process::ExitStatusExt;
use std::thread::sleep;
use std::time::Duration;

use super::place::{MarkedPlace, Results, Running, keys};

/// Returns a study of the uniqueness sets of six materials, with such a sole [mm], mesh and search.
fn uniqueness([x, y]: [u32; 2], mesh: &str, search: &str) -> String {
    format!(
        r#"
name = "kinds"
kind = "uniqueness"
[scene]
foundation.base = {{ shear_modulus = "80 GPa", poisson = 0 }}
punch = {{ shape = "flat-rectangle", width_x = "{x} mm", width_y = "{y} mm" }}
[numerics]
mesh = {mesh}
[search]
{search}
[sweep]
foundation.base.poisson = [0, 0.1, 0.2, 0.3, 0.4, 0.5]
"#
    )
}

const MULTIPLICITY: &str = include_str!("../studies/several.toml");

const CONVERGENCE: &str = r#"
name = "kinds"
kind = "convergence"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 8
[sweep]
mesh = [8, 16, 24, 32, 48, 64]
projection = ["average", "midpoint"]
"#;

/// The curves of a sphere that is pressed and shifted, for the rules that add points to them.
const CURVES: &str = r#"
name = "kinds"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
loading.steps = [{ approach = "1 um" }, { shift_x = "0.2 um" }]
[numerics]
mesh = 24
[sweep]
friction.mu = [0.05, 0.3, 0.8]
"loading.steps[1].shift_x" = ["0.2 um", "0.3 um"]
"#;

const FIND: &str = r#"
[find]
axis = "friction.mu"
column = "force_x"
value = "5 N"
to = "0.1%"
"#;

const FILL: &str = r#"
[fill]
axis = "friction.mu"
column = "stick_fraction"
at_most = 6
"#;

const SAMPLE: &str = r#"
name = "kinds"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 24
[sample]
method = "latin-hypercube"
count = 24
[sample.keys]
friction.mu = { from = 0.1, to = 0.5 }
foundation.base.poisson = { distribution = "normal", mean = 0.3, deviation = 0.05, from = 0, to = 0.45 }
"#;

const SENSITIVITY: &str = r#"
name = "kinds"
kind = "sensitivity"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 24
[sensitivity]
of = "load"
[sample]
method = "sobol"
count = 6
[sample.keys]
"friction.mu" = { from = 0.1, to = 0.5 }
"punch.radius" = { from = "8 mm", to = "12 mm" }
"#;

/// A ball that is pressed, rolls and comes into its steady state, with every creepage.
const ROLLING: &str = r#"
name = "kinds"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.3
loading.steps = [
    { normal_force = "10 N" },
    { distance = "0.1 mm", increments = 4, creepage_x = 1e-3, spin = "1 rad/m" },
    { steady = true, creepage_x = 2e-3, creepage_y = 1e-3 },
]
[numerics]
mesh = 20
[sweep]
"loading.steps[1].creepage_x" = [0, 1e-3, 3e-3]
"loading.steps[2].creepage_y" = [-1e-3, 0, 1e-3, 3e-3]
"#;

/// A ball that frets and wears its shape.
const WEAR: &str = r#"
name = "kinds"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.6
wear.coefficient = "2e-7 1/MPa"
domain = { width_x = "0.5 mm", width_y = "0.5 mm" }
loading.steps = [{ normal_force = "50 N" }, { shift_x = "4 um", increments = 8 }]
[numerics]
mesh = 20
[sweep]
"wear.update" = [false, true]
"wear.coefficient" = ["1e-8 1/MPa", "2e-8 1/MPa", "5e-8 1/MPa", "1e-7 1/MPa", "2e-7 1/MPa", "3e-7 1/MPa"]
"#;

/// Waits until a number of jobs are durable and some are not; returns `false` if the study was over
/// before that was seen.
fn is_in_its_middle(running: &mut Running, durable: usize) -> bool {
    while keys(&running.events(), "done").len() < durable {
        if running.has_ended() {
            return false;
        }
        sleep(Duration::from_micros(200));
    }
    !running.has_ended()
}

/// Checks that a run ends well and that no job was done twice.
fn finished(place: &MarkedPlace, mut running: Running) -> BTreeSet<String> {
    let status = running.wait();
    assert_eq!(status.code(), Some(0), "{status}\n{}", running.said());
    let done = keys(&running.events(), "done");
    let once: BTreeSet<String> = done.iter().cloned().collect();
    assert_eq!(once.len(), done.len(), "a job is done twice: {done:?}");
    place.assert_quiet();
    once
}

/// Kills the coordinator and resumes.
fn without_coordinator(study: &str, jobs: usize, durable: usize) -> Option<Results> {
    let place = MarkedPlace::with(study);
    let mut running = place.start_run(&["--json"]);
    if !is_in_its_middle(&mut running, durable) {
        return None;
    }
    running.kill();
    if running.wait().signal() != Some(9) {
        return None;
    }
    place.assert_quiet();
    let kept = place.records();
    let said = keys(&running.events(), "done");
    assert!(
        said.iter().all(|key| kept.contains_key(key)),
        "a result that was called durable is gone"
    );
    if kept.len() == jobs {
        return None;
    }
    let resumed = place.start(&["resume", "kinds", "--workers", "2", "--json"]);
    let done = finished(&place, resumed);
    assert!(
        done.iter().all(|key| !kept.contains_key(key)),
        "a job with a durable result is done again"
    );
    assert_eq!(done.len() + kept.len(), jobs);
    let records = place.records();
    assert!(
        kept.iter().all(|(key, record)| records.get(key) == Some(record)),
        "a record has changed"
    );
    Some(place.results("kinds"))
}

/// Kills a worker; the run goes on.
fn without_worker(study: &str, jobs: usize, durable: usize) -> Option<Results> {
    let place = MarkedPlace::with(study);
    let mut running = place.start_run(&["--json"]);
    if !is_in_its_middle(&mut running, durable) {
        return None;
    }
    let workers = running.workers();
    if !workers.first().is_some_and(|worker| running.kill_worker(*worker)) {
        return None;
    }
    let done = finished(&place, running);
    assert_eq!(done.len(), jobs);
    Some(place.results("kinds"))
}

fn survives(study: &str, jobs: usize) {
    survives_after(study, jobs, 1);
}

/// Checks that a study of so many jobs survives a kill after some are durable.
fn survives_after(study: &str, jobs: usize, durable: usize) {
    let place = MarkedPlace::with(study);
    assert_eq!(finished(&place, place.start_run(&["--json"])).len(), jobs);
    let undisturbed = place.results("kinds");
    assert_eq!(undisturbed.table.lines().count(), 1 + jobs);
    for disturbed in [without_coordinator, without_worker] {
        // On a busy machine the study may be over before it is seen to have begun.
        let found = (0..10)
            .find_map(|_| disturbed(study, jobs, durable))
            .expect("ten runs ended before anything could be killed");
        assert!(found == undisturbed, "{}\ninstead of\n{}", found.table, undisturbed.table);
    }
}

#[test]
fn brackets_of_uniqueness_sets_survive() {
    survives(&uniqueness([2, 2], "2", "starts = 1"), 6);
}

#[test]
fn ends_shown_by_cases_survive() {
    survives(&uniqueness([3, 2], "[3, 2]", "starts = 1\ncases = true"), 6);
}

#[test]
fn ends_shown_by_cones_survive() {
    survives(&uniqueness([3, 2], "[3, 2]", "starts = 1\ncases = true\nwidth = 0.01"), 6);
}

#[test]
fn brackets_narrowed_by_branches_survive() {
    let branch = "starts = 1\n[branch]\nto = \"1%\"";
    let study = uniqueness([3, 3], "3", branch);
    // The bracket and the first branch are generations by themselves.
    survives_after(&study.replace("[0, 0.1, 0.2, 0.3, 0.4, 0.5]", "[0]"), 21, 3);
}

#[test]
fn exact_ends_of_strips_survive() {
    survives(&uniqueness([8, 1000], "[8, 1]", "plane = true"), 6);
}

#[test]
fn searches_for_solutions_survive() {
    let friction = "[1, 2, 3, 4, 5, 7]";
    let study = MULTIPLICITY.replace("\"several\"", "\"kinds\"").replace("[2, 4]", friction);
    survives(&study, 6);
}

#[test]
fn samples_survive() {
    survives(SAMPLE, 24);
}

#[test]
fn measured_convergence_survives() {
    survives(CONVERGENCE, 12);
}

#[test]
fn rolling_contacts_survive() {
    survives(ROLLING, 12);
}

#[test]
fn contacts_that_wear_survive() {
    survives(WEAR, 12);
}

#[test]
fn searches_for_roots_survive() {
    survives(&format!("{CURVES}{FIND}"), 16);
}

#[test]
fn filled_curves_survive() {
    survives(&format!("{CURVES}{FILL}"), 18);
}

#[test]
fn rows_of_a_design_survive() {
    survives(SENSITIVITY, 24);
}
