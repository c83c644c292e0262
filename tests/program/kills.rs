//! Studies whose processes are killed and interrupted, against the same study left in peace.
//!
//! Processes are found and judged by marks that only these tests leave: a variable in their
//! environment, their parents, the names that their coordinator gives to shared memory. Other runs
//! on the same machine are neither touched nor counted.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rustix::process::Signal;

mod blows;
mod kinds;
mod limits;
mod place;

use blows::{Hits, KILLS, Random, blows, strike};
use place::{MarkedPlace, belongings, keys, last_line, reference};

/// A study of two shapes and 64 jobs; those on the finest mesh take most of the time.
const STUDY: &str = r#"
name = "kills"
question = "Does anything that happens to the processes change a result?"

[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }

[numerics]
tolerance = 1e-8

[sweep]
friction.mu = [0.1, 0.2, 0.4, 0.8]
foundation.base.poisson = [0.0, 0.3]
mesh = [6, 8, 10, 24]

[[sweep.zip]]
punch = [
    { label = "disk", shape = "flat-disk", radius = "1 mm" },
    { label = "sphere", shape = "sphere", radius = "50 mm" },
]
"loading.steps[0].approach" = ["1 um", "20 um"]

[figure]
x = "mu"
y = "stick_fraction"
series = ["poisson", "mesh"]
panels = "punch"
"#;
const NAME: &str = "kills";
const JOBS: usize = 64;

#[test]
fn killed_at_random_moments_a_study_completes_with_the_same_results() {
    let seed = match std::env::var("TRIBOSWEEP_TEST_SEED") {
        Ok(seed) => seed.parse().expect("the seed is a whole number"),
        Err(_) => SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64,
    };
    println!("TRIBOSWEEP_TEST_SEED={seed}");
    let mut random = Random(seed);
    reference();

    // The delay follows the pace of the machine: blows that come too late make it shorter.
    let mut window = Duration::from_secs(1);
    let (mut hits, mut launches, mut studies, mut noticed, mut owned) =
        (Hits::default(), 0, 0, 0, 0);
    while !hits.suffice() {
        studies += 1;
        let place = MarkedPlace::new();
        let mut durable = BTreeSet::new();
        let mut kept = BTreeMap::new();
        loop {
            launches += 1;
            assert!(launches < 20 * KILLS, "only {hits:?} in {launches} launches");
            let begin = Instant::now();
            let mut running = place.start_run(&["--json"]);
            let plan = blows(&mut random, window);
            println!("study {studies}, launch {launches}: {plan:?}");
            let mut met = 0;
            for (moment, blow) in plan {
                sleep(moment.saturating_sub(begin.elapsed()));
                if running.has_ended() {
                    window = window.mul_f64(0.8);
                    break;
                }
                window = window.mul_f64(1.1);
                owned += usize::from(!belongings(&running.bodies).is_empty());
                let before;
                (before, met) = strike(&mut running, blow, &mut random);
                hits.workers += before;
            }
            let status = running.wait();
            if status.signal() == Some(9) {
                hits.coordinators += 1;
                hits.both += usize::from(met > 0);
            }
            let events = running.events();
            noticed += events.iter().filter(|event| event["event"] == "worker-lost").count();
            for key in keys(&events, "leased") {
                assert!(!durable.contains(&key), "job {key} has a durable result and is run again");
            }
            for key in keys(&events, "done") {
                assert!(durable.insert(key.clone()), "job {key} is done twice");
            }
            if status.code() == Some(0) {
                let summary = events.last().unwrap();
                assert_eq!(
                    summary["progress"],
                    serde_json::json!({ "points": JOBS, "done": JOBS, "failed": 0, "left": 0 })
                );
                assert_eq!(summary["run"]["interrupted"], false);
                assert!(summary["run"]["cached"].as_u64().unwrap() as usize >= kept.len());
                break;
            }
            assert_eq!(status.signal(), Some(9), "{status}\n{}", running.said());
            // Half of the time the next launch follows at once, and nobody opens the store in
            // between.
            if random.below(2) == 0 {
                place.assert_quiet();
                let records = place.records();
                assert!(
                    durable.iter().all(|key| records.contains_key(key)),
                    "a result that was called durable is gone"
                );
                assert!(
                    kept.iter().all(|(key, record)| records.get(key) == Some(record)),
                    "a record has changed"
                );
                kept = records;
                durable.extend(kept.keys().cloned());
            }
        }
        let records = place.records();
        assert_eq!(records.len(), JOBS);
        assert!(
            kept.iter().all(|(key, record)| records.get(key) == Some(record)),
            "a record has changed"
        );
        place.assert_undisturbed();
        let left = belongings(&place.bodies());
        assert!(left.is_empty(), "left behind by a killed run or by the last: {left:?}");
        assert!(!place.bodies().exists());
    }
    println!(
        "{hits:?} in {launches} launches of {studies} studies; coordinators saw {noticed} workers die"
    );
    assert!(noticed > 0, "workers were killed and no coordinator noticed");
    assert!(
        owned > 0,
        "no coordinator had anything in shared memory, so the search for it is wrong"
    );
}

/// Stops a run in its middle, and returns the results that it kept and the place.
fn stopped(signal: Signal) -> (MarkedPlace, BTreeMap<String, Vec<u8>>) {
    // On a busy machine the study may be over before it is seen to have begun.
    for _ in 0..10 {
        let place = MarkedPlace::new();
        let mut running = place.start_run(&[]);
        // A run that has workers has its store open and answers requests for records.
        while !running.has_ended() && running.workers().is_empty() {
            sleep(Duration::from_millis(2));
        }
        while !running.has_ended() && place.records().is_empty() {
            sleep(Duration::from_millis(2));
        }
        if running.has_ended() {
            continue;
        }
        running.signal(signal);
        if signal != Signal::INT && !running.has_ended() {
            // Slurm sends it to all processes of a job, and the script of the job passes it on.
            sleep(Duration::from_millis(10));
            running.signal(signal);
        }
        let status = running.wait();
        if status.code() == Some(0) {
            continue;
        }
        let said = running.said();
        assert!(!said.contains("stopping now"), "{said}");
        let kept = place.records();
        assert!(!kept.is_empty() && kept.len() < JOBS);
        let left = JOBS - kept.len();
        assert!(
            said.contains(&format!(
                "{JOBS} points, {} certified, 0 failed, {left} left",
                kept.len()
            )),
            "{said}"
        );
        let store = place.store();
        let again = format!("tribosweep resume {NAME} --store {}", store.display());
        let end = format!("{left} of {JOBS} jobs are left; the same command goes on\n");
        let (code, notice, end) = if signal == Signal::INT {
            let end = format!("interrupted; continue with: {again}\n");
            (130, "stopping after the jobs in flight; Ctrl-C again stops now\n", end)
        } else {
            let end = format!("stopped in time (a signal asked for it): {end}");
            (75, "stopping in time: no further job is begun\n", end)
        };
        assert_eq!(status.code(), Some(code), "{status}\n{said}");
        assert!(said.contains(notice) && said.contains(&end), "{said}");
        assert_eq!(place.processes(), Vec::<u32>::new());
        assert_eq!(belongings(&running.bodies), Vec::<PathBuf>::new());
        return (place, kept);
    }
    panic!("ten runs ended before they could be stopped");
}

/// Stops a run in its middle, and finishes it by a command of these words.
fn stop_and_go_on(signal: Signal, words: &[&str]) {
    let (place, kept) = stopped(signal);
    if !words.contains(&"study.toml") {
        fs::remove_file(place.path("study.toml")).unwrap();
    }
    let summary = last_line(&place.succeed(&[words, &["--workers", "2", "--json"]].concat()));
    assert_eq!(summary["run"]["cached"], kept.len());
    assert_eq!(summary["run"]["computing"], JOBS - kept.len());
    let records = place.records();
    assert!(
        kept.iter().all(|(key, record)| records.get(key) == Some(record)),
        "a record has changed"
    );
    place.assert_undisturbed();
}

#[test]
fn ctrl_c_keeps_what_is_finished_and_resume_needs_no_file() {
    stop_and_go_on(Signal::INT, &["resume", NAME]);
}

#[test]
fn termination_keeps_what_is_finished_and_resume_needs_no_file() {
    stop_and_go_on(Signal::TERM, &["resume", NAME]);
}

/// Batch systems send this signal some time before they kill.
#[test]
fn the_signal_of_a_batch_system_stops_in_time_and_the_same_command_goes_on() {
    stop_and_go_on(Signal::USR1, &["run", "study.toml"]);
}

#[test]
fn a_finished_study_computes_nothing() {
    let place = MarkedPlace::new();
    place.succeed(&["run", "study.toml", "--json"]);
    let records = place.records();
    for arguments in [&["run", "study.toml", "--json"][..], &["resume", NAME, "--json"]] {
        let out = place.succeed(arguments);
        assert_eq!(out.lines().count(), 1, "nothing happens, and there is a summary: {out}");
        let summary = last_line(&out);
        assert_eq!(
            summary["run"],
            serde_json::json!({ "jobs": JOBS, "cached": JOBS, "computing": 0, "seconds": 0.0, "interrupted": false, "stopped_in_time": false })
        );
        assert_eq!(place.records(), records);
    }
    place.assert_undisturbed();
}

/// A run that finds everything in the store starts no worker, but still clears away the leftovers
/// of a killed one.
#[test]
fn the_next_run_removes_what_a_killed_one_left_even_if_it_computes_nothing() {
    let finished = MarkedPlace::new();
    finished.succeed(&["run", "study.toml"]);
    let killed = MarkedPlace::new();
    let mut running = killed.start_run(&[]);
    while belongings(&running.bodies).is_empty() {
        assert!(!running.has_ended(), "it had nothing in shared memory\n{}", running.said());
        sleep(Duration::from_millis(1));
    }
    running.kill();
    assert_eq!(running.wait().signal(), Some(9));
    killed.assert_quiet();
    finished.succeed(&["run", "study.toml"]);
    assert_eq!(belongings(&running.bodies), Vec::<PathBuf>::new());
}
