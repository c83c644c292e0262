//! The process that starts those that read inputs, and starts them anew when one ends early.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::child::PATIENCE;

/// The words of the processes.
#[derive(Default)]
struct Found {
    faults: Vec<String>,
    /// The number of inputs that were accepted, by their kind.
    accepted: BTreeMap<String, u64>,
}

impl Found {
    /// Takes note of what a process has printed.
    fn hear(&mut self, said: &str) {
        for line in said.lines() {
            let mut words = line.strip_prefix("accepted ").unwrap_or_default().split(' ');
            match (words.next().and_then(|count| count.parse::<u64>().ok()), words.next()) {
                (Some(count), Some(kind)) => {
                    *self.accepted.entry(format!("{kind} inputs accepted")).or_default() += count;
                }
                _ => self.faults.push(line.to_owned()),
            }
        }
    }

    fn add(mut self, other: Found) -> Self {
        self.faults.extend(other.faults);
        for (kind, count) in other.accepted {
            *self.accepted.entry(kind).or_default() += count;
        }
        self
    }
}

/// Reads all inputs in a number of processes, prints the faults and a summary, and returns the
/// number of faults.
pub(crate) fn run(count: u64, seed: u64, processes: u64) -> Result<usize, Box<dyn Error>> {
    let directory = tempfile::tempdir()?;
    let found = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..processes)
            .map(|part| {
                let progress = directory.path().join(part.to_string());
                scope.spawn(move || {
                    read_all(part, count, seed, processes, &progress)
                        .map_err(|error| error.to_string())
                })
            })
            .collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|_| Err("a thread panicked".to_owned())))
            .collect::<Result<Vec<Found>, String>>()
    })?;
    let Found { faults, accepted } = found.into_iter().fold(Found::default(), Found::add);
    for fault in &faults {
        println!("{fault}");
    }
    let mut summary = serde_json::json!(accepted);
    summary["inputs"] = count.into();
    summary["panics, aborts, hangs"] = faults.len().into();
    println!("{summary}");
    Ok(faults.len())
}

/// Reads every `processes`-th input from `from` on, in one process after the other.
fn read_all(
    mut from: u64,
    count: u64,
    seed: u64,
    processes: u64,
    progress: &Path,
) -> Result<Found, Box<dyn Error>> {
    let mut found = Found::default();
    while from < count {
        std::fs::write(progress, [])?;
        // Files take any number of lines; a pipe that nobody empties would stop the child.
        let (mut out, mut err) = (tempfile::tempfile()?, tempfile::tempfile()?);
        let mut child = Command::new(std::env::current_exe()?)
            .args(["--from", &from.to_string(), "--count", &count.to_string()])
            .args(["--seed", &seed.to_string(), "--processes", &processes.to_string()])
            .arg("--progress")
            .arg(progress)
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::null())
            .stdout(out.try_clone()?)
            .stderr(err.try_clone()?)
            .spawn()?;
        let (mut at, mut since) = (None, Instant::now());
        let (status, hangs) = loop {
            if let Some(status) = child.try_wait()? {
                break (status, false);
            }
            let now = number_in(progress);
            if now != at {
                (at, since) = (now, Instant::now());
            } else if at.is_some() && since.elapsed() > 4 * PATIENCE {
                child.kill()?;
                break (child.wait()?, true);
            }
            sleep(Duration::from_millis(20));
        };
        found.hear(&text_of(&mut out)?);
        if status.success() {
            break;
        }
        let Some(number) = number_in(progress) else {
            let words = text_of(&mut err)?;
            return Err(format!("a process ended before its first input: {status}: {words}").into());
        };
        let words = text_of(&mut err)?;
        let end = words.lines().last().unwrap_or_default();
        let end = if hangs { "it hangs".to_owned() } else { format!("{status} {end}") };
        found.faults.push(format!("FAULT input {number}: {end}"));
        from = number + processes;
    }
    Ok(found)
}

/// Returns the number of the input that a child is at.
fn number_in(progress: &Path) -> Option<u64> {
    let bytes = std::fs::read(progress).ok()?;
    Some(u64::from_le_bytes(bytes.try_into().ok()?))
}

/// Returns what stands in a file from its beginning.
fn text_of(file: &mut File) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
