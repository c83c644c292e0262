//! Processes that are killed and stopped from outside, coordinators among them.

use std::io::{BufRead, BufReader, Write};
use std::process::Child;

use super::*;

/// Returns the next number of a fixed pseudo-random sequence.
fn scramble(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

#[test]
fn workers_killed_at_random_moments_change_no_result() {
    // The attempts have no end: the killer is outside, and no job is to blame.
    let options = Options { attempts: u32::MAX, ..options() };
    let tasks: Vec<_> = (0..300).map(|number| task(number, format!("sleep 5 {number}"))).collect();
    let (mut kept, mut pids, mut seed, mut events) = (Kept::default(), Vec::new(), 7, 0u64);
    let summary =
        runner::run(&tasks, &mut kept, &options, &Interrupt::new().unwrap(), &mut |event| {
            match event.kind {
                EventKind::WorkerStarted { pid, .. } => pids.push(pid),
                EventKind::WorkerLost { pid: Some(pid), .. } => pids.retain(|&other| other != pid),
                _ => {}
            }
            events += 1;
            if scramble(&mut seed).is_multiple_of(20) && !pids.is_empty() {
                send(pids[(scramble(&mut seed) % pids.len() as u64) as usize], Signal::KILL);
            }
        });
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.quarantined), (300, 0));
    assert!(summary.workers_lost > 5, "{summary:?}");
    for number in 0..300 {
        assert_eq!(kept.text(number), number.to_string());
    }
}

/// A ledger that appends the numbers of the jobs to a file, one a line, and syncs it.
struct Journal(std::fs::File);

impl Ledger for Journal {
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>> {
        let lines: String = results.iter().map(|done| format!("{}\n", number(done.key))).collect();
        self.0.write_all(lines.as_bytes())?;
        Ok(self.0.sync_data()?)
    }
}

const JOURNAL: &str = "RUNNER_TEST_JOURNAL";
const JOBS: &str = "RUNNER_TEST_JOBS";

#[test]
#[ignore = "the coordinator that other tests disturb"]
fn coordinator() {
    let (Some(path), Ok(jobs)) = (std::env::var_os(JOURNAL), std::env::var(JOBS)) else { return };
    let mut journal =
        Journal(std::fs::File::options().append(true).create(true).open(path).unwrap());
    let tasks: Vec<_> = (0..jobs.parse().unwrap())
        .map(|number| task(number, format!("sleep 2 {number}")))
        .collect();
    // The attempts have no end: the killer is outside, and no job is to blame.
    let options = Options { attempts: u32::MAX, ..options() };
    runner::run(&tasks, &mut journal, &options, &Interrupt::new().unwrap(), &mut |event| {
        eprintln!("{}", serde_json::to_string(event).unwrap());
    })
    .unwrap();
}

/// Returns the directory of large bodies of the coordinator that keeps this journal.
fn bodies_of(journal: &Path) -> PathBuf {
    journal.with_extension("bodies")
}

/// Starts a coordinator in a process of its own, whose events can be read from its standard error.
fn start_coordinator(
    journal: &Path,
    jobs: u32,
) -> (Child, impl Iterator<Item = serde_json::Value> + Send + use<>) {
    start_coordinator_of("coordinator", journal, jobs)
}

fn start_coordinator_of(
    test: &str,
    journal: &Path,
    jobs: u32,
) -> (Child, impl Iterator<Item = serde_json::Value> + Send + use<>) {
    let command = ourselves(&format!("outside::{test}"));
    let mut child = Command::new(&command[0]);
    child
        .args(&command[1..])
        .env(JOURNAL, journal)
        .env(JOBS, jobs.to_string())
        .env(BODIES, bodies_of(journal))
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let mut child = child.spawn().unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines();
    // The last line of a killed process may be cut off.
    (child, lines.filter_map(|line| serde_json::from_str(&line.unwrap()).ok()))
}

fn children(parent: u32) -> Vec<u32> {
    let numbers = std::fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let is_child = |pid: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        stat.rsplit(')').next().and_then(|rest| rest.split_ascii_whitespace().nth(1)?.parse().ok())
            == Some(parent)
    };
    numbers.filter(is_child).collect()
}

#[test]
fn workers_killed_from_outside_even_while_they_start_change_no_result() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("journal");
    let (mut child, events) = start_coordinator(&path, 1000);
    let (mut seed, mut kills) = (11, 0);
    for event in events {
        if event["event"] == "done" && scramble(&mut seed).is_multiple_of(12) {
            let workers = children(child.id());
            // What it has is known to be its own only while it lives.
            leftovers(&bodies_of(&path));
            if !workers.is_empty() {
                send(workers[(scramble(&mut seed) % workers.len() as u64) as usize], Signal::KILL);
                kills += 1;
            }
        }
    }
    assert!(child.wait().unwrap().success());
    assert!(kills > 20, "{kills}");
    let mut done: Vec<u64> =
        std::fs::read_to_string(&path).unwrap().lines().map(|line| line.parse().unwrap()).collect();
    done.sort_unstable();
    assert_eq!(done, (0..1000).collect::<Vec<_>>(), "every job once");
    assert_eq!(leftovers(&bodies_of(&path)), Vec::<PathBuf>::new());
}

fn lives(pid: u32) -> bool {
    // A child of a dead coordinator belongs to init, which may reap it late.
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit(')')
        .next()
        .is_some_and(|rest| !rest.trim_start().starts_with('Z') && !rest.trim().is_empty())
}

#[test]
fn a_killed_coordinator_takes_its_workers_along_and_the_next_run_cleans_up() {
    let dir = tempfile::tempdir().unwrap();
    let mut seed = 3;
    for round in 0..5 {
        let journal = dir.path().join(format!("{round}"));
        let bodies = bodies_of(&journal);
        let (mut child, mut events) = start_coordinator(&journal, 100_000);
        let enough = 3 + scramble(&mut seed) % 300;
        let mut pids = Vec::new();
        for event in events.by_ref().take(enough as usize) {
            if event["event"] == "worker-started" {
                pids.push(event["pid"].as_u64().unwrap() as u32);
            }
        }
        assert!(
            !leftovers(&bodies).is_empty(),
            "round {round}: while it lives, nobody cleans up after it"
        );
        let listen = std::thread::spawn(move || events.for_each(drop));
        std::thread::sleep(Duration::from_micros(scramble(&mut seed) % 20_000));
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success());
        listen.join().unwrap();
        assert!(
            within(Duration::from_secs(20), || !pids.iter().any(|&pid| lives(pid))),
            "round {round}: a worker outlived its coordinator"
        );
        let (summary, kept, _) = run(squares(5), &options());
        assert_eq!(summary.unwrap().done, 5);
        assert_squares(&kept, 5);
        // The directory of large bodies belongs to whoever holds the store.
        runner::remove_bodies(&bodies).unwrap();
        assert_eq!(leftovers(&bodies), Vec::<PathBuf>::new(), "round {round}");
    }
}

#[test]
#[ignore = "a coordinator without patience, which another test stops and continues"]
fn coordinator_without_patience() {
    let Some(path) = std::env::var_os(JOURNAL) else { return };
    let mut journal =
        Journal(std::fs::File::options().append(true).create(true).open(path).unwrap());
    let options = Options {
        heartbeat: Duration::from_millis(100),
        silence: Duration::from_millis(2500),
        grace: Duration::from_millis(2500),
        patience: 0.0,
        attempts: 1,
        ..options()
    };
    let tasks: Vec<_> = (0..2).map(|number| task(number, format!("sleep 300 {number}"))).collect();
    runner::run(&tasks, &mut journal, &options, &Interrupt::new().unwrap(), &mut |event| {
        eprintln!("{}", serde_json::to_string(event).unwrap());
    })
    .unwrap();
}

#[test]
fn a_run_that_is_stopped_as_a_whole_and_continued_blames_nobody() {
    let dir = tempfile::tempdir().unwrap();
    let journal = dir.path().join("journal");
    let (mut child, mut events) = start_coordinator_of("coordinator_without_patience", &journal, 0);
    let mut leased = 0;
    for event in events.by_ref() {
        leased += usize::from(event["event"] == "leased");
        if leased == 2 {
            break;
        }
    }
    let group = || children(child.id()).into_iter().chain([child.id()]);
    group().for_each(|pid| send(pid, Signal::STOP));
    std::thread::sleep(Duration::from_millis(4500));
    group().for_each(|pid| send(pid, Signal::CONT));
    let lost: Vec<_> = events.filter(|event| event["event"] == "worker-lost").collect();
    assert!(child.wait().unwrap().success());
    assert_eq!(lost, Vec::<serde_json::Value>::new());
    assert_eq!(std::fs::read_to_string(&journal).unwrap().lines().count(), 2);
}
