//! Studies on a Slurm of two nodes and under GNU parallel, against the same study on one machine.
//!
//! `scripts/slurm-testbed` starts a real Slurm for each test, below a directory of its own. Where
//! Slurm or GNU parallel is not installed, a line says that a test is skipped.

mod slurm;

use std::process::Command;

use crate::place::{PROGRAM, Place, skip};
use slurm::Slurm;

/// A study of 2000 jobs that take next to no time.
const MANY: &str = r#"
name = "many"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "flat-disk", radius = "1 mm" }
loading.steps = [{ approach = "1 um" }]
[sweep]
mesh = [4, 6]
foundation.base.poisson = { from = 0, to = 0.45, count = 10 }
friction.mu = { from = 0.05, to = 0.9, count = 100 }
"#;

/// A study that chooses points by its results: four thresholds, found by halving.
const HALVED: &str = r#"
name = "halved"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm", material = { shear_modulus = "80 GPa", poisson = 0.3 } }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }, { shift_x = "0.1 um" }]
[numerics]
mesh = 12
[sweep]
friction.mu = [0.2, 0.3, 0.4, 0.5]
"loading.steps[1].shift_x" = ["0.05 um", "0.9 um"]
[bisect]
axis = "loading.steps[1].shift_x"
on = "stick_area > 0"
to = "5%"
"#;

/// A study of so many jobs that each take a while.
fn slow(jobs: usize) -> String {
    format!(
        r#"
name = "slow"
[scene]
foundation.base = {{ shear_modulus = "80 GPa", poisson = 0.3 }}
punch = {{ shape = "flat-disk", radius = "1 mm" }}
loading.steps = [{{ approach = "1 um" }}]
[numerics]
mesh = 128
tolerance = 1e-9
[sweep]
friction.mu = {{ from = 0.05, to = 0.9, count = {jobs} }}
"#
    )
}

#[test]
fn shards_on_a_cluster_give_the_bytes_of_one_machine() {
    let Some(slurm) = Slurm::start() else { return };
    let place = Place::with_files(&[("many.toml", MANY), ("halved.toml", HALVED)]);
    for study in ["many", "halved"] {
        place.succeed(&format!("run {study}.toml --store single --workers 2"));
    }
    // With eight indices to an array, twelve shards take two arrays.
    let report = slurm.submit(&place, "many.toml --shards 12");
    assert_eq!(report["arrays"].as_array().unwrap().len(), 2);
    slurm.submit(&place, "halved.toml --shards 3");
    slurm.wait_for_all();
    for study in ["many", "halved"] {
        let merged = format!("{study}-shards/{study}.tribosweep");
        assert!(place.has(&merged), "{}", place.logs(&format!("{study}-shards")));
        place.assert_same(study, "single", &merged);
        // The exports say the same before they are merged.
        place.assert_same(study, "single", &format!("{study}-shards/exports"));
    }

    // A shard is lost for good: its number is said, and how to compute it again.
    place.remove("many-shards/exports/many.5-of-12.tribosweep");
    let said = place.call("store merge many-shards/exports --into merged.tribosweep");
    assert_eq!(said.code, 2, "{}", said.err);
    let words = said.out + &said.err;
    assert!(words.contains("11 of 12 shards"), "{words}");
    assert!(words.contains("--shard 5/12"), "{words}");
    let report = slurm.submit(&place, "many.toml --shards 12");
    assert_eq!(report["arrays"][0]["shards"], serde_json::json!([5]), "others are finished");
    slurm.wait_for_all();
    let said = place.call("store merge many-shards/exports --into merged.tribosweep");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    place.assert_same("many", "single", "merged.tribosweep");
    place.assert_same("many", "single", "many-shards/many.tribosweep");
}

#[test]
fn a_node_that_dies_loses_only_what_it_had_not_exported() {
    let Some(slurm) = Slurm::start() else { return };
    let place = Place::with_files(&[("slow.toml", &slow(24))]);
    // Each shard has a node for itself.
    let report = slurm.submit(&place, "slow.toml --shards 2 -- --exclusive");
    let job = format!("{}_0", report["arrays"][0]["job"].as_str().unwrap());
    let export = "slow-shards/exports/slow.1-of-2.tribosweep";
    slurm.stop_in_time(&job);
    let exported = place.records(export);
    assert!((1..12).contains(&exported.len()), "{} results", exported.len());
    slurm.wait_for_workers(&job);
    let node = slurm.node_of(&job);
    slurm.kill_node(&node);
    slurm.wait_for_all();

    // The shard was queued again by itself and by Slurm, and went on where there was a node.
    assert_eq!(slurm.restarts(&job), 2, "{}", place.logs("slow-shards"));
    assert_ne!(slurm.node_of(&job), node);
    place.assert_kept(&exported, export);
    assert_eq!(place.records(export).len(), 12);
    place.succeed("run slow.toml --store single --workers 2");
    place.assert_same("slow", "single", "slow-shards/slow.tribosweep");
}

#[test]
fn a_shard_that_runs_out_of_time_goes_on_and_a_cancelled_one_is_missed() {
    let Some(slurm) = Slurm::start() else { return };
    // Each stop comes after some jobs of a stint, more of them on a busy machine.
    let place = Place::with_files(&[("slow.toml", &slow(64))]);
    let report = slurm.submit(&place, "slow.toml --shards 2 --time 5 -- --exclusive");
    let job = report["arrays"][0]["job"].as_str().unwrap();
    let (first, second) = (format!("{job}_0"), format!("{job}_1"));
    let export = "slow-shards/exports/slow.1-of-2.tribosweep";
    slurm.wait_for_workers(&second);
    slurm.succeed("scancel", &[&second]);
    let mut stints = Vec::new();
    for restart in 1..=3 {
        slurm.stop_in_time(&first);
        assert_eq!(slurm.restarts(&first), restart);
        stints.push(place.records(export));
    }
    slurm.wait_for_all();
    assert_eq!(slurm.restarts(&first), 3, "{}", place.logs("slow-shards"));
    stints.push(place.records(export));
    for pair in stints.windows(2) {
        assert!(pair[0].len() < pair[1].len(), "every stint adds results");
        place.assert_kept(&pair[0], export);
    }
    assert_eq!(stints[3].len(), 32);
    assert_eq!(slurm.restarts(&second), 0, "nobody starts a cancelled shard again");
    let log = place.logs("slow-shards");
    assert!(log.contains("is not finished, and was cancelled"), "{log}");
    assert!(!log.contains("stopping now"), "the signal of one cancellation counts once:\n{log}");
    assert!(log.contains("--shard 2/2"), "the merge says what is missing:\n{log}");

    slurm.submit(&place, "slow.toml --shards 2");
    slurm.wait_for_all();
    place.succeed("run slow.toml --store single --workers 2");
    place.assert_same("slow", "single", "slow-shards/slow.tribosweep");
}

/// A limit of Slurm is a minute at least, so this takes some four of them:
/// `cargo test --test program cluster:: -- --ignored`.
#[test]
#[ignore = "it waits for three limits of a minute"]
fn a_limit_shorter_than_the_work_takes_three_requeues() {
    let Some(slurm) = Slurm::start() else { return };
    // A stint has half a minute before it is told to stop, and the work is that of six of them.
    let place = Place::with_files(&[("slow.toml", &slow(2))]);
    let clock = std::time::Instant::now();
    place.succeed("run slow.toml --store sample --workers 1");
    let jobs = (6.0 * 31.0 / clock.elapsed().as_secs_f64() * 2.0).ceil() as usize;
    let place = Place::with_files(&[("slow.toml", &slow(jobs))]);
    let report = slurm.submit(&place, "slow.toml --shards 1 --time 1 -- --exclusive");
    let job = format!("{}_0", report["arrays"][0]["job"].as_str().unwrap());
    let export = "slow-shards/exports/slow.1-of-1.tribosweep";
    let mut stints = Vec::new();
    for restart in 1..=3 {
        let is_queued_again = slurm.waits_for_restart(&job, restart);
        assert!(is_queued_again, "restart {restart}\n{}", place.logs("slow-shards"));
        stints.push(place.records(export));
    }
    slurm.wait_for_all();
    let log = place.logs("slow-shards");
    assert!(slurm.restarts(&job) >= 3, "{log}");
    stints.push(place.records(export));
    assert_eq!(stints[stints.len() - 1].len(), jobs, "{log}");
    for pair in stints.windows(2) {
        assert!(pair[0].len() < pair[1].len(), "every stint adds results:\n{log}");
        place.assert_kept(&pair[0], export);
    }
    place.succeed("run slow.toml --store single --workers 2");
    place.assert_same("slow", "single", "slow-shards/slow.tribosweep");
}

#[test]
fn a_cluster_ends_with_its_owner_and_nothing_else_is_removed() {
    let mut owner = Command::new("sleep").arg("600").spawn().unwrap();
    let slurm = Slurm::start_for(owner.id());
    owner.kill().unwrap();
    owner.wait().unwrap();
    let Some(slurm) = slurm else { return };
    slurm.wait_for_the_end();

    let place = Place::with_files(&[("slurm.conf", ""), ("munge", "")]);
    place.remove("munge");
    std::fs::create_dir(place.path("munge")).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/slurm-testbed");
    let output = place.program(script).arg("stop").arg(place.path("")).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(place.has("slurm.conf"), "what `start` has not made stays");
}

#[test]
fn gnu_parallel_runs_shards_as_well() {
    let is_there = Command::new("parallel").arg("--version").output();
    if !is_there.is_ok_and(|output| output.status.success()) {
        return skip("GNU parallel is not installed");
    }
    let place = Place::with_files(&[("many.toml", MANY), ("halved.toml", HALVED)]);
    for study in ["many", "halved"] {
        place.succeed(&format!("run {study}.toml --store single --workers 2"));
        let mut parallel = place.program("parallel");
        parallel.args(["--jobs", "2", "--will-cite", PROGRAM, "run", &format!("{study}.toml")]);
        parallel.args(["--workers", "1", "--shard", "{}/4", "--export", "exports"]);
        let output = parallel.args([":::", "1", "2", "3", "4"]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let merged = format!("{study}.tribosweep");
        let said = place.call(&format!("store merge exports --into {merged}"));
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        place.assert_same(study, "single", &merged);
        place.remove("exports");
    }
}
