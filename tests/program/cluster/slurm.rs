//! A Slurm of two nodes that a test has for itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::place::{PROGRAM, Place, skip};

/// The script that starts and stops it.
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/slurm-testbed");

/// The exit code of the script where Slurm is not installed.
const NOT_INSTALLED: i32 = 77;

/// The time that anything may take on the slowest machine before it counts as hanging.
const PATIENCE: Duration = Duration::from_secs(180);

/// A Slurm, which ends with the value.
pub(crate) struct Slurm {
    directory: PathBuf,
}

/// Waits until something holds, and fails in words if it never does.
fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "waited in vain until {what}");
        sleep(Duration::from_millis(100));
    }
}

impl Slurm {
    /// Starts a Slurm whose arrays have at most eight elements; says so where none is installed.
    pub(crate) fn start() -> Option<Self> {
        // It ends with this process, too, however that is killed.
        Self::start_for(std::process::id())
    }

    /// Starts a Slurm that ends with a process.
    pub(crate) fn start_for(owner: u32) -> Option<Self> {
        let owner = owner.to_string();
        let output = script(&["start", "--max-array", "8", "--cpus", "2", "--owner", &owner]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        if output.status.code() == Some(NOT_INSTALLED) {
            skip(error.trim());
            return None;
        }
        assert!(output.status.success(), "{error}");
        let said = String::from_utf8(output.stdout).unwrap();
        let prefix = "export SLURM_TESTBED=";
        let directory = said.lines().find_map(|line| line.strip_prefix(prefix)).unwrap();
        Some(Self { directory: directory.into() })
    }

    /// Waits until the Slurm has ended with its owner, and has left nothing behind.
    pub(crate) fn wait_for_the_end(self) {
        wait_until("the testbed is removed", || !self.directory.exists());
        let daemons = fs::read_dir("/proc").unwrap().flatten().filter(|process| {
            let command = fs::read(process.path().join("cmdline")).unwrap_or_default();
            let named = self.directory.to_str().unwrap().as_bytes();
            command.windows(named.len()).any(|part| part == named)
        });
        // The watchdog itself ends when it has removed the directory.
        let mut daemons: Vec<PathBuf> = daemons.map(|process| process.path()).collect();
        wait_until("no process is left", || {
            daemons.retain(|process| process.exists());
            daemons.is_empty()
        });
        std::mem::forget(self);
    }

    /// Makes a command speak to this Slurm.
    fn reach(&self, mut command: Command) -> Command {
        for variable in ["SLURM_CONF_SERVER", "SLURM_CLUSTERS", "SLURM_JWT"] {
            command.env_remove(variable);
        }
        command.env("SLURM_CONF", self.directory.join("slurm.conf")).stdin(Stdio::null());
        command
    }

    /// Runs a program that must succeed, and returns its standard output.
    pub(crate) fn succeed(&self, program: &str, arguments: &[&str]) -> String {
        let output = self.reach(Command::new(program)).args(arguments).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{program} {arguments:?}: {error}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Submits a study and returns what is reported of that.
    pub(crate) fn submit(&self, place: &Place, line: &str) -> Value {
        let (options, passed) = line.split_once(" -- ").unwrap_or((line, ""));
        let mut submit = self.reach(place.program(PROGRAM));
        submit.arg("submit").args(options.split_whitespace()).arg("--json");
        if !passed.is_empty() {
            submit.arg("--").args(passed.split_whitespace());
        }
        let output = submit.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// Waits until no job is queued or runs.
    pub(crate) fn wait_for_all(&self) {
        wait_until("all jobs have ended", || self.succeed("squeue", &["--noheader"]).is_empty());
    }

    /// Waits until an element of an array computes something.
    pub(crate) fn wait_for_workers(&self, job: &str) {
        wait_until(&format!("{job} has workers that compute"), || self.has_busy_worker(job));
    }

    /// Stops an element that computes something as Slurm does before its time is over, and waits
    /// until it is queued again.
    pub(crate) fn stop_in_time(&self, job: &str) {
        let before = self.restarts(job);
        self.wait_for_workers(job);
        self.succeed("scancel", &["--batch", "--signal=USR1", job]);
        assert!(self.waits_for_restart(job, before + 1), "{job} is not queued again");
    }

    /// Waits until an element was queued again so many times, or has ended; returns true if it was
    /// queued again.
    pub(crate) fn waits_for_restart(&self, job: &str, restart: u32) -> bool {
        let mut is_queued_again = false;
        wait_until(&format!("{job} is queued again or ends"), || {
            is_queued_again = self.restarts(job) >= restart;
            is_queued_again || self.succeed("squeue", &["--noheader", "--jobs", job]).is_empty()
        });
        is_queued_again
    }

    /// Tells whether a worker of an element of an array, which carries the numbers of both in its
    /// environment, has taken more processor time than its start needs: then it has begun a job.
    /// A run that is stopped before that adds no result.
    fn has_busy_worker(&self, job: &str) -> bool {
        let (array, element) = job.split_once('_').expect("an element of an array");
        let marks = [
            format!("SLURM_CONF={}", self.directory.join("slurm.conf").display()),
            format!("SLURM_ARRAY_JOB_ID={array}"),
            format!("SLURM_ARRAY_TASK_ID={element}"),
        ];
        fs::read_dir("/proc").unwrap().flatten().any(|process| {
            // Processes end while they are looked at.
            let words = |file: &str| -> Vec<String> {
                let bytes = fs::read(process.path().join(file)).unwrap_or_default();
                String::from_utf8_lossy(&bytes).split('\0').map(str::to_owned).collect()
            };
            let command = words("cmdline");
            let is_worker = command.get(1).is_some_and(|name| name == "worker") && {
                let environment = words("environ");
                marks.iter().all(|mark| environment.contains(mark))
            };
            // A shard has one processor here, whatever its node has.
            assert!(!is_worker || command[2..4] == ["--threads", "1"], "{command:?}");
            let account = fs::read_to_string(process.path().join("stat")).unwrap_or_default();
            is_worker && processor_ticks(&account).is_some_and(|ticks| ticks >= 20)
        })
    }

    pub(crate) fn node_of(&self, job: &str) -> String {
        self.field(job, "NodeList")
    }

    /// Returns the number of times that a job was queued again.
    pub(crate) fn restarts(&self, job: &str) -> u32 {
        self.field(job, "Restarts").parse().unwrap()
    }

    /// Returns a field of what the controller knows of a job.
    fn field(&self, job: &str, name: &str) -> String {
        let said = self.succeed("scontrol", &["show", "job", "--oneliner", job]);
        let fields = said.split_whitespace().filter_map(|word| word.split_once('='));
        fields
            .filter(|(known, _)| *known == name)
            .map(|(_, value)| value.to_owned())
            .next()
            .unwrap_or_default()
    }

    /// Kills a node with all that runs on it, as a power cut does.
    pub(crate) fn kill_node(&self, node: &str) {
        let output = script(&["kill", node, self.directory.to_str().unwrap()]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        let output = script(&["stop", self.directory.to_str().unwrap()]);
        let error = String::from_utf8_lossy(&output.stderr);
        if !std::thread::panicking() {
            assert!(output.status.success() && !Path::new(&self.directory).exists(), "{error}");
        }
    }
}

/// Returns the processor time of a process in ticks of a hundredth of a second, from its line in
/// `/proc` (proc_pid_stat(5): `utime` is its field 14, and its name in brackets is field 2).
fn processor_ticks(account: &str) -> Option<u64> {
    let (_, fields) = account.rsplit_once(')')?;
    fields.split_whitespace().nth(11)?.parse().ok()
}

fn script(arguments: &[&str]) -> Output {
    Command::new(SCRIPT).args(arguments).stdin(Stdio::null()).output().unwrap()
}
