//! Measures how fast jobs that do nothing pass through two real workers, and how much processor
//! time a waiting worker uses.
//!
//! The ledger appends to a file and syncs it, as a store would. `cargo bench -p tribosweep-runner`
//! prints the figures.

use std::error::Error;
use std::fs::File;
use std::io::Write;
use std::time::{Duration, Instant};

use identity::JobKey;
use runner::{Done, Executor, Interrupt, Ledger, Options, Task, Verdict, WorkerArguments, work};

struct Echo;

impl Executor for Echo {
    fn run(&mut self, payload: &[u8]) -> Vec<u8> {
        if payload == b"wait" {
            std::thread::sleep(Duration::from_secs(5));
        }
        payload.to_vec()
    }
}

struct Journal {
    file: File,
    commits: usize,
    kept: usize,
    syncing: Duration,
}

impl Ledger for Journal {
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>> {
        let mut lines = Vec::new();
        for done in &results {
            if let Verdict::Completed(bytes) = &done.verdict {
                lines.extend_from_slice(&done.key.0);
                lines.extend_from_slice(bytes);
            }
        }
        let start = Instant::now();
        self.file.write_all(&lines)?;
        self.file.sync_data()?;
        self.syncing += start.elapsed();
        self.commits += 1;
        self.kept += results.len();
        Ok(())
    }
}

fn tasks(count: u64, payload: &[u8], cost: f64) -> Vec<Task> {
    let task = |number: u64| {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&number.to_be_bytes());
        Task {
            key: JobKey(key),
            payload: payload.to_vec(),
            group: number / 100,
            rank: 0,
            cost,
            memory: 1 << 20,
        }
    };
    (0..count).map(task).collect()
}

/// Returns the processor time that a process used so far, in clock ticks.
fn ticks(pid: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).expect("the process lives");
    let fields: Vec<_> =
        stat.rsplit(')').next().expect("it has fields").split_ascii_whitespace().collect();
    fields[11].parse::<u64>().expect("user time") + fields[12].parse::<u64>().expect("system time")
}

fn main() -> Result<(), Box<dyn Error>> {
    let last = std::env::args().next_back().unwrap_or_default();
    if let Ok(arguments) = WorkerArguments::parse(&last) {
        return Ok(work(&arguments, || Echo)?);
    }
    let command = vec![std::env::current_exe()?.into(), "worker".into()];
    let place = tempfile::tempdir()?;
    let bodies = place.path().join("bodies");
    let options = Options { workers: 2, ..Options::new(command, bodies, 1 << 30) };
    for cost in [1e-5, 0.01, 1.0] {
        let mut journal =
            Journal { file: tempfile::tempfile()?, commits: 0, kept: 0, syncing: Duration::ZERO };
        let start = Instant::now();
        let summary = runner::run(
            &tasks(10_000, b"payload", cost),
            &mut journal,
            &options,
            &Interrupt::new()?,
            &mut |_| {},
        )?;
        let seconds = start.elapsed().as_secs_f64();
        let Journal { commits, kept, syncing, .. } = journal;
        println!(
            "{kept} jobs predicted at {cost} s: {seconds:.3} s, {:.0} jobs/s, {commits} commits taking {syncing:.3?}, {} lost",
            kept as f64 / seconds,
            summary.workers_lost
        );
    }
    // One job sleeps, and a second worker waits for it.
    let mut pids = Vec::new();
    let mut idle = Vec::new();
    let mut journal =
        Journal { file: tempfile::tempfile()?, commits: 0, kept: 0, syncing: Duration::ZERO };
    let mut waiting = tasks(2, b"wait", 1.0);
    waiting[1].payload = b"quick".to_vec();
    let me = std::process::id();
    let before = ticks(me);
    runner::run(
        &waiting,
        &mut journal,
        &options,
        &Interrupt::new()?,
        &mut |event| match event.kind {
            runner::EventKind::WorkerStarted { pid, .. } => pids.push(pid),
            runner::EventKind::Done { .. } => {
                idle.push(pids.iter().map(|&pid| (pid, ticks(pid))).collect::<Vec<_>>())
            }
            _ => {}
        },
    )?;
    for (pid, ticks) in &idle[0] {
        let later = idle[1].iter().find(|(other, _)| other == pid).map_or(0, |(_, ticks)| *ticks);
        println!(
            "worker {pid} used {} ticks of 10 ms in 5 s, one asleep in its job, one without a job",
            later - ticks
        );
    }
    println!("the coordinator used {} ticks of 10 ms in that run", ticks(me) - before);
    Ok(())
}
