//! The process that starts those that read inputs, and starts them anew when one ends early.

use std::error::Error;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::child::PATIENCE;

/// The faults among the inputs of one process, and the longest time between two looks at which it
/// was still at the same input.
#[derive(Default)]
struct Found {
    faults: Vec<String>,
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
    let faults: Vec<String> = found.into_iter().flat_map(|found| found.faults).collect();
    for fault in &faults {
        println!("{fault}");
    }
    println!("{}", serde_json::json!({ "inputs": count, "panics, aborts, hangs": faults.len() }));
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
        let mut child = Command::new(std::env::current_exe()?)
            .args(["--from", &from.to_string(), "--count", &count.to_string()])
            .args(["--seed", &seed.to_string(), "--processes", &processes.to_string()])
            .arg("--progress")
            .arg(progress)
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
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
        let output = child.wait_with_output()?;
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        found.faults.extend(said.lines().map(str::to_owned));
        if status.success() {
            break;
        }
        let Some(number) = number_in(progress) else {
            let words = String::from_utf8_lossy(&output.stderr).into_owned();
            return Err(format!("a process ended before its first input: {status}: {words}").into());
        };
        let words = String::from_utf8_lossy(&output.stderr);
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
