//! Studies whose processes are killed and interrupted, against the same study left in peace.
//!
//! Processes are found and judged by marks that only these tests leave: a variable in their
//! environment, their parents, the names that their coordinator gives to shared memory. Other runs
//! on the same machine are neither touched nor counted.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use serde_json::Value;
use store::{OpenError, Store};
use study::{Record, Standing};

mod kinds;
mod limits;

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

/// A variable in the environment of every process that these tests start, and so of its
/// descendants.
const MARK: &str = "TRIBOSWEEP_TEST_PLACE";
/// The number of SIGKILLs that must have met a live process.
const KILLS: usize = 50;
/// The time that anything may take on the slowest machine before it counts as hanging.
const PATIENCE: Duration = Duration::from_secs(120);

/// A directory with the study and a store.
struct MarkedPlace {
    directory: tempfile::TempDir,
}

impl MarkedPlace {
    fn new() -> Self {
        Self::with(STUDY)
    }

    fn with(study: &str) -> Self {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("study.toml"), study).unwrap();
        Self { directory }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn store(&self) -> PathBuf {
        self.path("store")
    }

    /// Returns the directory through which large jobs and results of a run here travel.
    fn bodies(&self) -> PathBuf {
        self.store().join("in-transit")
    }

    /// Starts `tribosweep` with these arguments on this store; its output goes to files.
    fn start(&self, arguments: &[&str]) -> Running {
        self.start_program(Path::new(env!("CARGO_BIN_EXE_tribosweep")), arguments)
    }

    /// Starts another copy of the program.
    fn start_program(&self, program: &Path, arguments: &[&str]) -> Running {
        let (out, err) = (self.path("out"), self.path("err"));
        let mut command = Command::new(program);
        command.args(arguments).arg("--store").arg(self.store()).current_dir(self.directory.path());
        command.env(MARK, self.directory.path()).env_remove("TRIBOSWEEP_STORE");
        command
            .stdin(Stdio::null())
            .stdout(File::create(&out).unwrap())
            .stderr(File::create(&err).unwrap());
        let child = command.spawn().unwrap();
        Running { bodies: self.bodies(), child, out, err }
    }

    fn start_run(&self, more: &[&str]) -> Running {
        self.start(&[&["run", "study.toml", "--workers", "2"], more].concat())
    }

    /// Runs a command that must succeed, and returns its standard output.
    fn succeed(&self, arguments: &[&str]) -> String {
        let mut running = self.start(arguments);
        let status = running.wait();
        assert_eq!(status.code(), Some(0), "{arguments:?}: {status}\n{}", running.said());
        fs::read_to_string(&running.out).unwrap()
    }

    /// Returns every record with its key, whole; none if there is no store yet.
    fn records(&self) -> BTreeMap<String, Vec<u8>> {
        match Store::read(&self.store()) {
            Ok(reader) => reader
                .records()
                .unwrap()
                .map(|(key, bytes)| (key.to_string(), bytes.unwrap()))
                .collect(),
            Err(OpenError::Missing { .. }) => BTreeMap::new(),
            Err(error) => panic!("the store cannot be read: {error}"),
        }
    }

    fn results(&self, study: &str) -> Results {
        let mut results = BTreeMap::new();
        for (key, bytes) in self.records() {
            let record = Record::decode(&bytes).unwrap();
            assert_eq!(record.standing(), Standing::Certified, "job {key}: {:?}", record.ending);
            results.insert(key, record.result_bytes());
        }
        let columns: Value =
            serde_json::from_str(&self.succeed(&["query", study, "--columns", "--format", "json"]))
                .unwrap();
        let rows = columns["rows"].as_array().unwrap().iter();
        let reproducible = rows
            .filter(|row| row["kind"] != "provenance")
            .map(|row| row["column"].as_str().unwrap());
        let select = reproducible.collect::<Vec<_>>().join(",");
        Results {
            results,
            table: self.succeed(&["query", study, "--select", &select, "--format", "csv"]),
        }
    }

    /// Returns the live processes that descend from this test through this place.
    fn processes(&self) -> Vec<u32> {
        let mark = format!("{MARK}={}", self.directory.path().display());
        let marked = |pid: &u32| {
            let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
            environment.split(|byte| *byte == 0).any(|variable| variable == mark.as_bytes())
        };
        pids().filter(marked).filter(|pid| stat(*pid).is_some_and(|stat| stat.lives)).collect()
    }

    /// Waits for the end of all processes here; a killed one takes a moment to die.
    fn assert_quiet(&self) {
        let end = Instant::now() + PATIENCE;
        while !self.processes().is_empty() {
            assert!(Instant::now() < end, "processes are left: {:?}", self.processes());
            sleep(Duration::from_millis(2));
        }
    }

    /// Checks that the study is finished and nothing is wrong with it.
    fn assert_undisturbed(&self) {
        let (found, expected) = (self.results(NAME), reference());
        assert!(found.results.keys().eq(expected.results.keys()), "other jobs");
        for (key, result) in &found.results {
            assert!(*result == expected.results[key], "job {key} has another result");
        }
        assert_eq!(found.table, expected.table);
        self.succeed(&["store", "verify"]);
        self.assert_quiet();
    }
}

/// The results that are the same whenever the study is run.
#[derive(Debug, PartialEq)]
struct Results {
    /// The deterministic part of every record.
    results: BTreeMap<String, Vec<u8>>,
    /// Every reproducible column of every point.
    table: String,
}

/// Returns the results of an undisturbed run.
fn reference() -> &'static Results {
    static REFERENCE: OnceLock<Results> = OnceLock::new();
    REFERENCE.get_or_init(|| {
        let place = MarkedPlace::new();
        let summary = last_line(&place.succeed(&["run", "study.toml", "--workers", "2", "--json"]));
        assert_eq!(summary["run"]["computing"], JOBS);
        let results = place.results(NAME);
        assert_eq!(results.results.len(), JOBS);
        assert_eq!(results.table.lines().count(), 1 + JOBS);
        assert!(
            results.table.contains("stick_fraction")
                && results.table.contains("iterations")
                && !results.table.contains("finished")
        );
        results
    })
}

/// A process of these tests, killed and reaped when dropped.
struct Running {
    child: Child,
    /// The directory through which its large jobs and results travel, which tells its directory in
    /// shared memory from others.
    bodies: PathBuf,
    out: PathBuf,
    err: PathBuf,
}

impl Running {
    fn has_ended(&mut self) -> bool {
        // What it has in shared memory is known to be its own only while it lives.
        belongings(&self.bodies);
        self.child.try_wait().unwrap().is_some()
    }

    fn wait(&mut self) -> ExitStatus {
        let end = Instant::now() + PATIENCE;
        while !self.has_ended() {
            assert!(Instant::now() < end, "it hangs\n{}", self.said());
            sleep(Duration::from_millis(2));
        }
        self.child.wait().unwrap()
    }

    /// Returns the live children.
    fn workers(&self) -> Vec<u32> {
        let parent = self.child.id();
        pids()
            .filter(|pid| stat(*pid).is_some_and(|stat| stat.lives && stat.parent == parent))
            .collect()
    }

    /// Kills a live child of this process; returns `false` if it is gone.
    fn kill_worker(&self, pid: u32) -> bool {
        let Ok(fd) = pidfd_open(Pid::from_raw(pid as i32).unwrap(), PidfdFlags::empty()) else {
            return false;
        };
        // The child is looked up again, now that its number cannot pass to another process.
        let ours = stat(pid).is_some_and(|stat| stat.lives && stat.parent == self.child.id());
        ours && pidfd_send_signal(fd, Signal::KILL).is_ok()
    }

    /// Kills the coordinator, if it is still there.
    fn kill(&mut self) {
        self.child.kill().unwrap();
    }

    fn signal(&self, signal: Signal) {
        rustix::process::kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Returns the events that it has printed; the last line of a killed process may be cut off.
    fn events(&self) -> Vec<Value> {
        let text = fs::read_to_string(&self.out).unwrap();
        text.split_inclusive('\n')
            .filter(|line| line.ends_with('\n'))
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    fn said(&self) -> String {
        let read = |path| fs::read_to_string(path).unwrap_or_default();
        format!("standard output:\n{}\nstandard error:\n{}", read(&self.out), read(&self.err))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns the keys in events of one kind.
fn keys(events: &[Value], kind: &str) -> Vec<String> {
    events
        .iter()
        .filter(|event| event["event"] == kind)
        .map(|event| event["key"].as_str().unwrap().to_owned())
        .collect()
}

fn last_line(text: &str) -> Value {
    serde_json::from_str(text.lines().last().unwrap()).unwrap()
}

struct Stat {
    lives: bool,
    parent: u32,
}

fn stat(pid: u32) -> Option<Stat> {
    let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let fields: Vec<&str> = text[text.rfind(')')? + 1..].split_ascii_whitespace().collect();
    Some(Stat { lives: !matches!(fields[0], "Z" | "X"), parent: fields[1].parse().ok()? })
}

fn pids() -> impl Iterator<Item = u32> {
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// The tags of runs that were seen to live, by the directory of their large bodies.
static TAGS: Mutex<BTreeMap<PathBuf, BTreeSet<String>>> = Mutex::new(BTreeMap::new());

/// Returns what runs have in shared memory whose large bodies travel through a directory: what has
/// the tag of a run that this function has seen before, or sees now.
fn belongings(bodies: &Path) -> Vec<PathBuf> {
    let shared: Vec<PathBuf> =
        fs::read_dir("/dev/shm").unwrap().flatten().map(|entry| entry.path()).collect();
    let tag = |path: &PathBuf| {
        let name = path.file_name()?.to_str()?.strip_prefix("tribo-")?;
        Some(name.get(..18)?.to_owned())
    };
    let leads_here =
        |path: &&PathBuf| fs::read_link(path.join("bodies")).is_ok_and(|target| target == bodies);
    let mut tags = TAGS.lock().unwrap_or_else(PoisonError::into_inner);
    let known = tags.entry(bodies.to_owned()).or_default();
    known.extend(shared.iter().filter(leads_here).filter_map(tag));
    let is_own = |path: &&PathBuf| {
        tag(path).is_some_and(|tag| known.contains(&tag)) && fs::symlink_metadata(path).is_ok()
    };
    shared.iter().filter(is_own).cloned().collect()
}

/// A generator of random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits ^ (bits >> 31)) % end
    }

    fn moment(&mut self, end: Duration) -> Duration {
        Duration::from_micros(self.below(end.as_micros() as u64))
    }
}

/// The processes that are killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Blow {
    Worker,
    Coordinator,
    Both,
    All,
}

/// The blows that meet one launch, in the order of their moments.
///
/// A job that loses three workers in one launch is to blame for it and set aside, so at most two
/// are killed before the coordinator is.
fn blows(random: &mut Random, window: Duration) -> Vec<(Duration, Blow)> {
    let last = match random.below(7) {
        0 | 1 => Some(Blow::Coordinator),
        2 | 3 => Some(Blow::Both),
        4 | 5 => Some(Blow::All),
        _ => None,
    };
    let most = if matches!(last, Some(Blow::Both | Blow::All)) { 1 } else { 2 };
    let mut moments: Vec<Duration> =
        (0..random.below(most + 1)).map(|_| random.moment(window)).collect();
    let mut blows: Vec<(Duration, Blow)> = Vec::new();
    moments.extend(last.map(|_| random.moment(window)));
    moments.sort();
    let workers = moments.len() - usize::from(last.is_some());
    blows.extend(moments[..workers].iter().map(|moment| (*moment, Blow::Worker)));
    blows.extend(last.map(|blow| (moments[workers], blow)));
    blows
}

/// Deals a blow. Returns the number of workers that were killed before their coordinator, and of
/// all that were killed: those that are killed after it die of its death as well.
fn strike(running: &mut Running, blow: Blow, random: &mut Random) -> (usize, usize) {
    let mut workers = running.workers();
    match blow {
        Blow::Coordinator => workers.clear(),
        Blow::Worker | Blow::Both if !workers.is_empty() => {
            workers = vec![workers[random.below(workers.len() as u64) as usize]]
        }
        Blow::Worker | Blow::Both | Blow::All => {}
    }
    let coordinator_first = random.below(2) == 0;
    if blow != Blow::Worker && coordinator_first {
        running.kill();
    }
    let met = workers.into_iter().filter(|pid| running.kill_worker(*pid)).count();
    if blow != Blow::Worker && !coordinator_first {
        running.kill();
    }
    (if blow != Blow::Worker && coordinator_first { 0 } else { met }, met)
}

/// The numbers of SIGKILLs that met a live process.
#[derive(Debug, Default)]
struct Hits {
    workers: usize,
    coordinators: usize,
    /// The launches that lost the coordinator and a worker in one blow.
    both: usize,
}

impl Hits {
    fn suffice(&self) -> bool {
        self.workers + self.coordinators >= KILLS
            && self.workers >= 10
            && self.coordinators >= 10
            && self.both >= 5
    }
}

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
