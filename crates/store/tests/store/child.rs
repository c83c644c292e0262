//! Other processes run this test binary again and play one of a few parts.

use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use store::{
    ExportHeader, ExportWriter, KeptWords, MergeSelection, OpenError, ShardName, Store,
    merge_into_export,
};

use super::{RULES, key, record, records};

const PART: &str = "TRIBOSWEEP_STORE_PART";
const DIRECTORY: &str = "TRIBOSWEEP_STORE_DIRECTORY";
const FIRST: &str = "TRIBOSWEEP_STORE_FIRST";

/// A process that plays a part. It is killed when it is dropped.
pub(crate) struct Player {
    pub(crate) process: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

/// Returns the command that makes this binary play `part` on the store in `directory`.
pub(crate) fn command(part: &str, directory: &Path, first: u64) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "child::plays_its_part", "--ignored", "--nocapture"]);
    command.env(PART, part).env(DIRECTORY, directory).env(FIRST, first.to_string());
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    command
}

impl Player {
    pub(crate) fn start(mut command: Command) -> Player {
        let mut process = command.spawn().unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        Player { process, lines }
    }

    /// Returns the next line that the process says, or `None` once it has ended.
    pub(crate) fn line(&mut self) -> Option<String> {
        // The test harness talks too.
        self.lines
            .by_ref()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("says ").map(str::to_owned))
    }

    /// Ends the part. The process leaves the store in order.
    pub(crate) fn dismiss(mut self) {
        drop(self.process.stdin.take());
        assert!(self.process.wait().unwrap().success());
    }

    /// Kills the process with SIGKILL.
    pub(crate) fn kill(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }

    /// Ends the part and returns the lines that the process says.
    pub(crate) fn transcript_of_dismissed(mut self) -> Vec<String> {
        drop(self.process.stdin.take());
        self.transcript()
    }

    /// Returns the lines that the process says until it ends, which it must do within a minute.
    pub(crate) fn transcript(mut self) -> Vec<String> {
        let pid = rustix::process::Pid::from_child(&self.process);
        let (ended, watch) = std::sync::mpsc::channel::<()>();
        let watchdog = std::thread::spawn(move || {
            let hung = watch.recv_timeout(Duration::from_secs(60))
                == Err(std::sync::mpsc::RecvTimeoutError::Timeout);
            if hung {
                let _ = rustix::process::kill_process(pid, rustix::process::Signal::KILL);
            }
            hung
        });
        let lines = std::iter::from_fn(|| self.line()).collect();
        let status = self.process.wait().unwrap();
        drop(ended);
        assert!(!watchdog.join().unwrap(), "it hung after saying {lines:?}");
        assert!(status.success(), "it ended with {status} after saying {lines:?}");
        lines
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn say(what: impl std::fmt::Display) {
    // The text gets a line of its own, because the harness leaves its own line unfinished.
    let mut out = std::io::stdout().lock();
    writeln!(out, "\nsays {what}").and_then(|()| out.flush()).unwrap();
}

fn wait_for_dismissal() {
    let _ = std::io::stdin().lock().lines().next();
}

#[test]
#[ignore = "not a test: the part that other processes play in the tests"]
fn plays_its_part() {
    let Ok(part) = std::env::var(PART) else { return };
    let directory = std::path::PathBuf::from(std::env::var_os(DIRECTORY).unwrap());
    let first: u64 = std::env::var(FIRST).unwrap().parse().unwrap();
    match part.as_str() {
        "write" => write(&directory, first),
        "keep" => keep(&directory, first),
        "tabulate" => tabulate(&directory, first),
        "hold" => {
            let _store = Store::open(&directory).unwrap();
            say("open");
            wait_for_dismissal();
        }
        "read" => {
            match Store::read(&directory) {
                Ok(reader) => {
                    say(format!("{} records, {}", reader.keys().unwrap().len(), reader.origin()))
                }
                Err(error) => say(format!("refused: {error}")),
            }
            wait_for_dismissal();
        }
        "race" => {
            let opened = Store::open(&directory);
            say(match &opened {
                Ok(_) => "open".to_owned(),
                Err(OpenError::Held { pid, .. }) => format!("held by {pid}"),
                Err(error) => format!("refused: {error}"),
            });
            wait_for_dismissal();
        }
        "inspect" => inspect(&directory, first),
        "salvage" => match Store::salvage(&directory, |_, _| Vec::new()) {
            Ok(salvage) => say(format!("kept {}, studies {}", salvage.kept, salvage.studies)),
            Err(error) => say(format!("refused: {error}")),
        },
        "fill" => fill(&directory, first),
        "export" => export(&directory),
        "merge" => merge(&directory),
        "collect" => {
            let store = Store::open(&directory).unwrap();
            say("begins");
            let done = store.collect(&super::collection::garbage()).unwrap();
            say(format!("removed {}", done.records));
        }
        "merge into export" => {
            let reader = Store::read_by(&directory.join("exports"), &RULES).unwrap();
            say("begins");
            let (target, all) = (directory.join("all.tribosweep"), MergeSelection::default());
            let report = merge_into_export(&target, "0.1.0", &[&reader], &RULES, &all).unwrap();
            say(format!("added {}, already there {}", report.added, report.already_there));
        }
        other => panic!("no such part: {other}"),
    }
}

/// Commits and removes groups without end and says which are done. Group g has the jobs from first
/// + 100 g on, of which a later group removes a few.
fn write(directory: &Path, first: u64) {
    let store = Store::open(directory).unwrap();
    for group in 0.. {
        let start = first + 100 * group;
        store.commit(&records(start..start + size(group))).unwrap();
        say(format!("committed {group}"));
        if group % 3 == 2 {
            let before = first + 100 * (group - 1);
            store.remove(&(before..before + removed(group)).map(key).collect::<Vec<_>>()).unwrap();
            say(format!("removed {group}"));
        }
    }
}

/// Opens the store again and again, changes records, and keeps in words how many there are.
fn keep(directory: &Path, first: u64) {
    for group in 0.. {
        let store = Store::open(directory).unwrap();
        store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
        let start = first + 100 * group;
        store.commit(&records(start..start + size(group))).unwrap();
        let words = store.len().to_string().into_bytes();
        store.keep_words("sweep", KeptWords { words, is_final: false });
        if group % 4 == 3 {
            // These come after the words and make them wrong.
            store.commit(&records(start + 50..start + 53)).unwrap();
        }
        drop(store);
        say(format!("kept {group}"));
    }
}

/// Changes records and makes a table of all of them, again and again.
fn tabulate(directory: &Path, first: u64) {
    for group in 0.. {
        let store = Store::open(directory).unwrap();
        let start = first + 100 * group;
        store.commit(&records(start..start + 3)).unwrap();
        if group % 4 == 3 {
            store.commit(&[(key(start), record(start + 50))]).unwrap();
        }
        drop(store);
        say(format!("changed {group}"));
        super::tables::make_table(directory, false);
        say(format!("tabulated {group}"));
        // Some kills come while the table holds.
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Returns the number of records in a group.
pub(crate) fn size(group: u64) -> u64 {
    1 + group * 7 % 40
}

pub(crate) fn removed(group: u64) -> u64 {
    size(group - 1) / 2
}

/// Opens the store, which should hold the records 0..count, and says what became of them.
fn inspect(directory: &Path, count: u64) {
    let store = match Store::open(directory) {
        Ok(store) => store,
        Err(error) => return say(format!("refused: {error}")),
    };
    let (mut sound, mut reported) = (0, 0);
    for i in 0..count {
        match store.get(&key(i)) {
            Ok(Some(found)) if found == record(i) => sound += 1,
            Ok(Some(_)) => return say(format!("WRONG record {i}")),
            Ok(None) => return say(format!("SILENTLY LOST record {i}")),
            Err(_) => reported += 1,
        }
    }
    // It answers its own process like any other.
    let verified = Store::read(directory).unwrap().verify(|_, _| Vec::new());
    let corrupt = verified.as_ref().map_or(0, |found| found.corrupt_records.len());
    if corrupt != reported {
        return say(format!("VERIFY found {corrupt} of {reported} corrupt records"));
    }
    match store.study("sweep") {
        Ok(Some(study)) if study == b"mu = [0.1, 0.3]" && store.study_names() == ["sweep"] => {}
        Ok(study) => return say(format!("WRONG study {study:?} among {:?}", store.study_names())),
        Err(error) => return say(format!("study: {error}")),
    }
    say(if reported == 0 {
        "sound".to_owned()
    } else {
        format!("{sound} sound, {reported} reported")
    });
}

/// Commits groups of large records until it fails. Then it says why a commit fails again, and
/// whether a blob fits.
fn fill(directory: &Path, first: u64) {
    let store = Store::open(directory).unwrap();
    let start = Instant::now();
    let group = |group: u64| -> Vec<_> {
        (0..10).map(|i| (key(first + 10 * group + i), vec![group as u8; 16 << 10])).collect()
    };
    let mut number = 0;
    while let Ok(()) = store.commit(&group(number)) {
        assert!(start.elapsed() < Duration::from_secs(50), "the disk does not fill");
        say(format!("committed {number}"));
        number += 1;
    }
    if let Err(error) = store.commit(&group(number)) {
        say(format!("failed: {error}"));
    }
    let mut noise = vec![0; 1 << 20];
    blake3::Hasher::new().finalize_xof().fill(&mut noise);
    if let Err(error) = store.blobs().put(&noise) {
        say(format!("failed: {error}"));
    }
    drop(store);
    say("closed");
}

/// Adds records to an export without end and says after every flush how many are in it.
fn export(directory: &Path) {
    let shard = Some(ShardName { study: "sweep".to_owned(), index: 1, count: 2 });
    let header = ExportHeader { program: "0.1.0".to_owned(), shard };
    let mut writer = ExportWriter::open(&directory.join("one.tribosweep"), &header).unwrap();
    let blobs = Store::read(&directory.join("one.tribosweep")).unwrap().blobs().clone();
    let first = (0..).find(|i| !writer.contains(&key(*i))).unwrap();
    for i in first.. {
        let outcome = writer.append(&key(i), &record(i), &blobs, []).and_then(|()| {
            let is_last = i % 10 == 9;
            if is_last { writer.flush().map(|()| say(i + 1)) } else { Ok(()) }
        });
        if let Err(error) = outcome {
            return say(format!("failed: {error}"));
        }
    }
}

/// Merges the exports beside the store into it.
fn merge(directory: &Path) {
    let store = Store::open(&directory.join("merged")).unwrap();
    let reader = Store::read_by(&directory.join("exports"), &RULES).unwrap();
    say("begins");
    let report = store.import(&[&reader], &RULES).unwrap();
    say(format!("added {}, already there {}", report.added, report.already_there));
}
