//! A directory whose processes are known by marks, and what they leave.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};
use serde_json::Value;
use study::{Record, Standing};

use super::{JOBS, NAME, STUDY};
use crate::place::{PROGRAM, records_in};

/// A variable in the environment of every process that these tests start, and so of its
/// descendants.
pub(super) const MARK: &str = "TRIBOSWEEP_TEST_PLACE";
/// The time that anything may take on the slowest machine before it counts as hanging.
pub(super) const PATIENCE: Duration = Duration::from_secs(120);

/// A directory with the study and a store.
pub(super) struct MarkedPlace {
    pub(super) directory: tempfile::TempDir,
}

impl MarkedPlace {
    pub(super) fn new() -> Self {
        Self::with(STUDY)
    }

    pub(super) fn with(study: &str) -> Self {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("study.toml"), study).unwrap();
        Self { directory }
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub(super) fn store(&self) -> PathBuf {
        self.path("store")
    }

    /// Returns the directory through which large jobs and results of a run here travel.
    pub(super) fn bodies(&self) -> PathBuf {
        self.store().join("in-transit")
    }

    /// Starts `tribosweep` with these arguments on this store; its output goes to files.
    pub(super) fn start(&self, arguments: &[&str]) -> Running {
        self.start_program(Path::new(PROGRAM), arguments)
    }

    /// Starts another copy of the program.
    pub(super) fn start_program(&self, program: &Path, arguments: &[&str]) -> Running {
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

    pub(super) fn start_run(&self, more: &[&str]) -> Running {
        self.start(&[&["run", "study.toml", "--workers", "2"], more].concat())
    }

    /// Runs a command that must succeed, and returns its standard output.
    pub(super) fn succeed(&self, arguments: &[&str]) -> String {
        let mut running = self.start(arguments);
        let status = running.wait();
        assert_eq!(status.code(), Some(0), "{arguments:?}: {status}\n{}", running.said());
        fs::read_to_string(&running.out).unwrap()
    }

    /// Returns every record with its key, whole; none if there is no store yet.
    pub(super) fn records(&self) -> BTreeMap<String, Vec<u8>> {
        records_in(&self.store())
    }

    pub(super) fn results(&self, study: &str) -> Results {
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
    pub(super) fn processes(&self) -> Vec<u32> {
        let mark = format!("{MARK}={}", self.directory.path().display());
        let marked = |pid: &u32| {
            let environment = fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
            environment.split(|byte| *byte == 0).any(|variable| variable == mark.as_bytes())
        };
        pids().filter(marked).filter(|pid| stat(*pid).is_some_and(|stat| stat.lives)).collect()
    }

    /// Waits for the end of all processes here; a killed one takes a moment to die.
    pub(super) fn assert_quiet(&self) {
        let end = Instant::now() + PATIENCE;
        while !self.processes().is_empty() {
            assert!(Instant::now() < end, "processes are left: {:?}", self.processes());
            sleep(Duration::from_millis(2));
        }
    }

    /// Checks that the study is finished and nothing is wrong with it.
    pub(super) fn assert_undisturbed(&self) {
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
pub(super) struct Results {
    /// The deterministic part of every record.
    pub(super) results: BTreeMap<String, Vec<u8>>,
    /// Every reproducible column of every point.
    pub(super) table: String,
}

/// Returns the results of an undisturbed run.
pub(super) fn reference() -> &'static Results {
    pub(super) static REFERENCE: OnceLock<Results> = OnceLock::new();
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
pub(super) struct Running {
    pub(super) child: Child,
    /// The directory through which its large jobs and results travel, which tells its directory in
    /// shared memory from others.
    pub(super) bodies: PathBuf,
    pub(super) out: PathBuf,
    pub(super) err: PathBuf,
}

impl Running {
    pub(super) fn has_ended(&mut self) -> bool {
        // What it has in shared memory is known to be its own only while it lives.
        belongings(&self.bodies);
        self.child.try_wait().unwrap().is_some()
    }

    pub(super) fn wait(&mut self) -> ExitStatus {
        let end = Instant::now() + PATIENCE;
        while !self.has_ended() {
            assert!(Instant::now() < end, "it hangs\n{}", self.said());
            sleep(Duration::from_millis(2));
        }
        self.child.wait().unwrap()
    }

    /// Returns the live children.
    pub(super) fn workers(&self) -> Vec<u32> {
        let parent = self.child.id();
        pids()
            .filter(|pid| stat(*pid).is_some_and(|stat| stat.lives && stat.parent == parent))
            .collect()
    }

    /// Kills a live child of this process; returns `false` if it is gone.
    pub(super) fn kill_worker(&self, pid: u32) -> bool {
        let Ok(fd) = pidfd_open(Pid::from_raw(pid as i32).unwrap(), PidfdFlags::empty()) else {
            return false;
        };
        // The child is looked up again, now that its number cannot pass to another process.
        let ours = stat(pid).is_some_and(|stat| stat.lives && stat.parent == self.child.id());
        ours && pidfd_send_signal(fd, Signal::KILL).is_ok()
    }

    /// Kills the coordinator, if it is still there.
    pub(super) fn kill(&mut self) {
        self.child.kill().unwrap();
    }

    pub(super) fn signal(&self, signal: Signal) {
        rustix::process::kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Returns the events that it has printed; the last line of a killed process may be cut off.
    pub(super) fn events(&self) -> Vec<Value> {
        let text = fs::read_to_string(&self.out).unwrap();
        text.split_inclusive('\n')
            .filter(|line| line.ends_with('\n'))
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }

    pub(super) fn said(&self) -> String {
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
pub(super) fn keys(events: &[Value], kind: &str) -> Vec<String> {
    events
        .iter()
        .filter(|event| event["event"] == kind)
        .map(|event| event["key"].as_str().unwrap().to_owned())
        .collect()
}

pub(super) fn last_line(text: &str) -> Value {
    serde_json::from_str(text.lines().last().unwrap()).unwrap()
}

pub(super) struct Stat {
    lives: bool,
    parent: u32,
}

pub(super) fn stat(pid: u32) -> Option<Stat> {
    let text = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let fields: Vec<&str> = text[text.rfind(')')? + 1..].split_ascii_whitespace().collect();
    Some(Stat { lives: !matches!(fields[0], "Z" | "X"), parent: fields[1].parse().ok()? })
}

pub(super) fn pids() -> impl Iterator<Item = u32> {
    fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
}

/// The tags of runs that were seen to live, by the directory of their large bodies.
pub(super) static TAGS: Mutex<BTreeMap<PathBuf, BTreeSet<String>>> = Mutex::new(BTreeMap::new());

/// Returns what runs have in shared memory whose large bodies travel through a directory: what has
/// the tag of a run that this function has seen before, or sees now.
pub(super) fn belongings(bodies: &Path) -> Vec<PathBuf> {
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
