//! Sends jobs that compute nothing through the runner into a store, as `run` does: leases, shared
//! memory, durable records. `scripts/bench-runner` measures with them what a job costs beside its
//! own time.
//!
//! ```text
//! cargo run --release --example idle-jobs -- run STORE WORKERS LOG JOBSxMICROSECONDS...
//! cargo run --release --example idle-jobs -- burn MICROSECONDS LOG NUMBER
//! ```
//!
//! `run` does so many jobs of so many microseconds, those of each further group after those before:
//! of processor time, or asleep if a `~` stands before the microseconds. Each job adds a line to the
//! file LOG when it ends; `-` is no file. What the store has already is not done again. The last
//! line of the output is JSON. `burn` does a single job, for programs that start a process for each.

use std::borrow::Cow;
use std::error::Error;
use std::ffi::OsString;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::{Duration, Instant};

use identity::JobKey;
use runner::{
    Done, EventKind, Executor, Interrupt, Jobs, Ledger, Options, Verdict, WorkerArguments, run,
    work,
};
use rustix::time::{ClockId, clock_gettime};
use store::Store;

type Fault = Box<dyn Error + Send + Sync>;

/// The size of a record \[bytes\], about that of a small scene.
const RECORD: usize = 1024;

/// Jobs of one length.
#[derive(Clone, Copy)]
struct JobGroup {
    jobs: u64,
    pause: Pause,
}

/// The time that a job takes.
#[derive(Clone, Copy)]
struct Pause {
    microseconds: u64,
    /// It is true if the job leaves the processor to others.
    sleeps: bool,
}

impl FromStr for JobGroup {
    type Err = Fault;

    fn from_str(text: &str) -> Result<Self, Fault> {
        let wrong = || format!("`{text}` is not JOBSxMICROSECONDS, such as 1000x10 or 1000x~10");
        let (jobs, pause) = text.split_once('x').ok_or_else(wrong)?;
        let microseconds = pause.strip_prefix('~');
        Ok(JobGroup {
            jobs: jobs.parse().map_err(|_| wrong())?,
            pause: Pause {
                microseconds: microseconds.unwrap_or(pause).parse().map_err(|_| wrong())?,
                sleeps: microseconds.is_some(),
            },
        })
    }
}

impl Pause {
    /// Lets the time pass.
    fn pass(self) {
        let length = Duration::from_micros(self.microseconds);
        if self.sleeps {
            return std::thread::sleep(length);
        }
        let start = processor_time();
        while processor_time() - start < length {
            std::hint::spin_loop();
        }
    }
}

/// Returns the time that this thread has had a processor.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}

/// Adds the number of a job that has ended to a log; one write, so that lines of several processes
/// do not mix.
fn note(log: Option<&mut File>, number: u64) -> std::io::Result<()> {
    match log {
        Some(log) => log.write_all(format!("{number}\n").as_bytes()),
        None => Ok(()),
    }
}

fn open_log(path: &str) -> std::io::Result<Option<File>> {
    let open = || File::options().create(true).append(true).open(path);
    if path == "-" { Ok(None) } else { open().map(Some) }
}

/// The worker's side of a job. The payload is the number, the microseconds, 1 for a sleep, and the
/// path of the log.
#[derive(Default)]
struct IdleWorker {
    log: Option<(String, Option<File>)>,
}

impl IdleWorker {
    fn perform(&mut self, payload: &[u8]) -> Result<Vec<u8>, Fault> {
        let (numbers, path) = payload.split_at_checked(17).ok_or("the payload is short")?;
        let number = u64::from_le_bytes(numbers[..8].try_into()?);
        let microseconds = u64::from_le_bytes(numbers[8..16].try_into()?);
        Pause { microseconds, sleeps: numbers[16] == 1 }.pass();
        let path = std::str::from_utf8(path)?;
        if self.log.as_ref().is_none_or(|(open, _)| open != path) {
            self.log = Some((path.to_owned(), open_log(path)?));
        }
        note(self.log.as_mut().and_then(|(_, log)| log.as_mut()), number)?;
        Ok(random_bytes(number ^ u64::MAX, RECORD))
    }
}

impl Executor for IdleWorker {
    fn run(&mut self, payload: &[u8]) -> Vec<u8> {
        self.perform(payload).expect("a job that computes nothing succeeds")
    }
}

/// Returns bytes that do not compress, the same ones for the same number.
fn random_bytes(seed: u64, count: usize) -> Vec<u8> {
    let mut random = fastrand::Rng::with_seed(seed);
    std::iter::repeat_with(|| random.u8(..)).take(count).collect()
}

/// Keeps results in the store.
struct Records<'a>(&'a Store);

impl Ledger for Records<'_> {
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Fault> {
        let records: Result<Vec<_>, Fault> = results
            .into_iter()
            .map(|done| match done.verdict {
                Verdict::Completed(bytes) => Ok((done.key, bytes)),
                Verdict::Quarantined { reason } => Err(reason.into()),
            })
            .collect();
        Ok(self.0.commit(&records?)?)
    }
}

/// Jobs that compute nothing, of which the number alone is in memory.
struct IdleJobs<'a> {
    /// The numbers of the jobs that are left to do.
    left: Vec<u32>,
    groups: &'a [JobGroup],
    /// The path of the log.
    log: &'a str,
}

impl IdleJobs<'_> {
    /// Returns the place of the group of a job, which is its rank, and the time that the job takes.
    fn group_of(&self, job: usize) -> (usize, Pause) {
        let mut before = 0;
        let number = u64::from(self.left[job]);
        let place = self.groups.iter().position(|group| {
            before += group.jobs;
            number < before
        });
        let place = place.unwrap_or_default();
        (place, self.groups[place].pause)
    }
}

/// Returns the key of a job.
fn key(number: u32) -> JobKey {
    let mut key = JobKey([0; 32]);
    key.0.copy_from_slice(&random_bytes(number.into(), 32));
    key
}

impl Jobs for IdleJobs<'_> {
    fn count(&self) -> usize {
        self.left.len()
    }

    fn key(&self, job: usize) -> JobKey {
        key(self.left[job])
    }

    fn group(&self, _job: usize) -> u64 {
        0
    }

    fn rank(&self, job: usize) -> u32 {
        self.group_of(job).0 as u32
    }

    fn cost(&self, job: usize) -> f64 {
        (self.group_of(job).1.microseconds as f64 * 1e-6).max(1e-4)
    }

    fn memory(&self, _job: usize) -> u64 {
        1 << 20
    }

    fn size(&self, _job: usize) -> usize {
        17 + self.log.len()
    }

    fn payload(&self, job: usize) -> Result<Cow<'_, [u8]>, Fault> {
        let (_, pause) = self.group_of(job);
        let mut payload = u64::from(self.left[job]).to_le_bytes().to_vec();
        payload.extend(pause.microseconds.to_le_bytes());
        payload.push(u8::from(pause.sleeps));
        payload.extend(self.log.as_bytes());
        Ok(payload.into())
    }
}

/// Runs the jobs that the store has no record of.
fn run_jobs(store: &Path, workers: usize, log: &str, groups: &[JobGroup]) -> Result<(), Fault> {
    let begin = Instant::now();
    let bodies = store.join("in-transit");
    let store = Store::open(store)?;
    let count = u32::try_from(groups.iter().map(|group| group.jobs).sum::<u64>())?;
    let left: Vec<u32> = (0..count).filter(|number| !store.contains(&key(*number))).collect();
    let jobs = IdleJobs { left, groups, log };
    let command: Vec<OsString> = vec![runner::RUNNING_IMAGE.into(), "worker".into()];
    let memory = runner::available_memory().unwrap_or(1 << 30);
    let options = Options { workers, ..Options::new(command, bodies, memory) };
    let (mut all_started, mut started) = (None, 0);
    let mut first_result = None;
    let mut limited = None;
    let summary =
        run(&jobs, &mut Records(&store), &options, &Interrupt::new()?, &mut |event| match &event
            .kind
        {
            EventKind::WorkerStarted { .. } => {
                started += 1;
                if started == workers {
                    all_started = Some(begin.elapsed().as_secs_f64());
                    println!("all workers have started");
                }
            }
            EventKind::WorkersLimited { reason, .. } => limited = Some(reason.clone()),
            EventKind::Done { .. } if first_result.is_none() => {
                first_result = Some(begin.elapsed().as_secs_f64());
            }
            _ => {}
        })?;
    println!(
        "{}",
        serde_json::json!({
            "summary": summary, "cached": count as usize - jobs.count(), "first_result": first_result,
            "all_started": all_started, "limited": limited,
            "seconds": begin.elapsed().as_secs_f64(),
        })
    );
    Ok(())
}

fn main() -> Result<(), Fault> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["worker", argument] => Ok(work(&WorkerArguments::parse(argument)?, IdleWorker::default)?),
        ["burn", microseconds, log, number] => {
            Pause { microseconds: microseconds.parse()?, sleeps: false }.pass();
            Ok(note(open_log(log)?.as_mut(), number.parse()?)?)
        }
        ["run", store, workers, log, ref groups @ ..] if !groups.is_empty() => {
            runner::prepare_process()?;
            runner::keep_little();
            let groups: Result<Vec<_>, _> = groups.iter().map(|text| text.parse()).collect();
            run_jobs(&PathBuf::from(store), workers.parse()?, log, &groups?)
        }
        _ => Err("see the first lines of examples/idle-jobs.rs for its arguments".into()),
    }
}
