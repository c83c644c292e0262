//! Real worker processes over real shared memory are killed in every way.
//!
//! This binary is also the worker, and the coordinator to be killed: children run the ignored tests
//! by their paths.

mod losses;
mod outside;

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use identity::JobKey;
use runner::{
    Done, EarlyEnd, Event, EventKind, Executor, Interrupt, Ledger, Options, RunError, Summary,
    Task, Verdict, WorkerArguments,
};

/// An executor whose job is a line of text: a verb and its arguments.
struct Script;

impl Executor for Script {
    fn run(&mut self, payload: &[u8]) -> Vec<u8> {
        let text = String::from_utf8(payload.to_vec()).unwrap();
        let words: Vec<_> = text.split(' ').collect();
        match words[..] {
            ["square", x] => x.parse::<u64>().unwrap().pow(2).to_string().into(),
            ["sleep", ms, x] => {
                std::thread::sleep(Duration::from_millis(ms.parse().unwrap()));
                x.into()
            }
            ["crash"] => kill(std::process::id(), Signal::KILL),
            ["crash-once", mark] => {
                if Path::new(mark).exists() {
                    return b"survived".into();
                }
                std::fs::write(mark, "").unwrap();
                kill(std::process::id(), Signal::KILL)
            }
            ["end"] => {
                send(std::process::id(), Signal::TERM);
                send(std::process::id(), Signal::USR1);
                b"deaf".into()
            }
            ["abort"] => std::process::abort(),
            ["leave"] => std::process::exit(3),
            ["recurse"] => recurse(0).to_string().into(),
            ["stop"] => kill(std::process::id(), Signal::STOP),
            ["hang"] => loop {
                std::thread::sleep(Duration::from_secs(1));
            },
            ["huge", length] => (0..length.parse::<u32>().unwrap())
                .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
                .collect(),
            ["allocate", bytes] => vec![1u8; bytes.parse().unwrap()]
                .iter()
                .map(|&b| u64::from(b))
                .sum::<u64>()
                .to_string()
                .into(),
            ["length", ref rest @ ..] => rest.join(" ").len().to_string().into(),
            ["panic"] => panic!("no such punch"),
            _ => panic!("no such verb: {text}"),
        }
    }
}

/// Calls itself until the stack is full.
#[allow(unconditional_recursion)]
fn recurse(depth: u64) -> u64 {
    let room = std::hint::black_box([depth; 512]);
    recurse(depth + 1) + room[511]
}

fn kill(pid: u32, signal: Signal) -> ! {
    send(pid, signal);
    loop {
        std::thread::sleep(Duration::from_secs(1));
    }
}

fn send(pid: u32, signal: Signal) {
    let _ = kill_process(Pid::from_raw(pid.try_into().unwrap()).unwrap(), signal);
}

#[test]
#[ignore = "what the workers of the other tests run"]
fn worker() {
    if let Ok(arguments) = WorkerArguments::parse(&std::env::args().next_back().unwrap()) {
        runner::work(&arguments, || Script).unwrap();
    }
}

fn ourselves(test: &str) -> Vec<std::ffi::OsString> {
    let exe = std::env::current_exe().unwrap();
    vec![exe.into(), test.into(), "--exact".into(), "--ignored".into(), "--nocapture".into()]
}

fn options() -> Options {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let bodies = std::env::temp_dir().join(format!("runner-test-{}-{number}", std::process::id()));
    let bodies = std::env::var_os(BODIES).map_or(bodies, PathBuf::from);
    Options { workers: 2, ..Options::new(ourselves("worker"), bodies, 4 << 30) }
}

fn task(number: u64, payload: impl Into<String>) -> Task {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&number.to_be_bytes());
    Task {
        key: JobKey(key),
        payload: payload.into().into_bytes(),
        group: number % 7,
        rank: 0,
        cost: 0.01,
        memory: 1 << 20,
    }
}

fn squares(count: u64) -> Vec<Task> {
    (0..count).map(|number| task(number, format!("square {number}"))).collect()
}

fn number(key: JobKey) -> u64 {
    u64::from_be_bytes(key.0[..8].try_into().unwrap())
}

/// A ledger that keeps results in memory and refuses a second result for a job.
#[derive(Default)]
struct Kept {
    results: BTreeMap<u64, Done>,
    fail_after: Option<usize>,
}

impl Ledger for Kept {
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>> {
        for done in results {
            if self.fail_after.is_some_and(|limit| self.results.len() >= limit) {
                return Err("no space left on device".into());
            }
            let number = number(done.key);
            if self.results.insert(number, done).is_some() {
                return Err(format!("job {number} was committed twice").into());
            }
        }
        Ok(())
    }
}

impl Kept {
    fn text(&self, number: u64) -> String {
        match &self.results[&number].verdict {
            Verdict::Completed(bytes) => String::from_utf8_lossy(bytes).into_owned(),
            Verdict::Quarantined { reason } => reason.clone(),
        }
    }
}

fn run(tasks: Vec<Task>, options: &Options) -> (Result<Summary, RunError>, Kept, Vec<Event>) {
    let (mut kept, mut events) = (Kept::default(), Vec::new());
    let summary =
        runner::run(&tasks, &mut kept, options, &Interrupt::new().unwrap(), &mut |event| {
            events.push(event.clone())
        });
    (summary, kept, events)
}

fn assert_squares(kept: &Kept, count: u64) {
    assert_eq!(kept.results.len(), count as usize);
    for number in 0..count {
        assert_eq!(kept.text(number), (number * number).to_string());
    }
}

fn within(limit: Duration, condition: impl Fn() -> bool) -> bool {
    let start = Instant::now();
    while start.elapsed() < limit {
        if condition() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    condition()
}

/// The tags of runs that were seen to live, by the directory of their large bodies.
static TAGS: Mutex<BTreeMap<PathBuf, BTreeSet<String>>> = Mutex::new(BTreeMap::new());

/// Lists what runs have whose large bodies travel through a directory: shared memory with the tag
/// of a run that this function has seen before or sees now, and that directory.
fn leftovers(bodies: &Path) -> Vec<PathBuf> {
    let found = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let shared: Vec<PathBuf> = found.map(|entry| entry.path()).collect();
    let tag = |path: &PathBuf| {
        let name = path.file_name()?.to_str()?.strip_prefix("tribo-")?;
        Some(name.get(..18)?.to_owned())
    };
    let leads_here = |path: &&PathBuf| {
        std::fs::read_link(path.join("bodies")).is_ok_and(|target| target == bodies)
    };
    let mut tags = TAGS.lock().unwrap_or_else(PoisonError::into_inner);
    let known = tags.entry(bodies.to_owned()).or_default();
    known.extend(shared.iter().filter(leads_here).filter_map(tag));
    let is_own = |path: &&PathBuf| {
        let is_left = std::fs::symlink_metadata(path).is_ok();
        is_left && tag(path).is_some_and(|tag| known.contains(&tag))
    };
    let mut left: Vec<PathBuf> = shared.iter().filter(is_own).cloned().collect();
    left.extend(bodies.exists().then(|| bodies.to_owned()));
    left
}

#[test]
fn every_job_runs_once_and_nothing_is_left() {
    let place = tempfile::tempdir().unwrap();
    let bodies = place.path().join("bodies");
    let exe = Command::new(&ourselves("a_clean_run")[0])
        .args(&ourselves("a_clean_run")[1..])
        .env(BODIES, &bodies)
        .stdout(Stdio::null())
        .spawn();
    let (mut child, mut most) = (exe.unwrap(), 0);
    while child.try_wait().unwrap().is_none() {
        most = most.max(leftovers(&bodies).len());
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(child.wait().unwrap().success());
    assert!(most > 1, "it had nothing, so the search for it is wrong");
    assert_eq!(leftovers(&bodies), Vec::<PathBuf>::new());
}

#[test]
#[ignore = "run in a process of its own by another test, which looks at what it leaves"]
fn a_clean_run() {
    let mut tasks = squares(500);
    // It gives the test that looks the time to see the run alive.
    tasks.push(task(500, "sleep 700 x"));
    let (summary, mut kept, events) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!(kept.results.remove(&500).map(|done| done.attempts), Some(1));
    assert_squares(&kept, 500);
    assert_eq!(
        (summary.done, summary.failures, summary.workers_lost, summary.stale_results),
        (501, 0, 0, 0)
    );
    assert!(matches!(events[0].kind, EventKind::RunStarted));
    assert!(events.windows(2).all(|pair| pair[0].seconds <= pair[1].seconds), "one clock");
    let last = events.last().unwrap();
    assert_eq!((&last.kind, last.counts.done, last.counts.workers), (&EventKind::Finished, 501, 0));
    for (number, done) in &kept.results {
        assert_eq!(done.attempts, 1, "job {number}");
    }
}

#[test]
fn large_results_and_payloads_travel_as_files() {
    let mut tasks: Vec<_> =
        (0..8).map(|number| task(number, format!("huge {}", 200_000 + number * 300_000))).collect();
    tasks.push(task(8, format!("length {}", "x".repeat(3_000_000))));
    let (summary, kept, _) = run(tasks, &options());
    assert_eq!(summary.unwrap().done, 9);
    for number in 0..8 {
        let Verdict::Completed(bytes) = &kept.results[&number].verdict else {
            panic!("job {number} failed")
        };
        assert_eq!(bytes, &Script.run(format!("huge {}", 200_000 + number * 300_000).as_bytes()));
    }
    assert_eq!(kept.text(8), "3000000");
}

#[test]
fn signals_raise_one_request_of_a_process() {
    let command = ourselves("two_requests_on_signals");
    let mut child = Command::new(&command[0]);
    let output = child.args(&command[1..]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
#[ignore = "run in a process of its own by another test, because it changes its signals"]
fn two_requests_on_signals() {
    let [first, second] = [(), ()].map(|()| Interrupt::new().unwrap());
    runner::raise_on_signals(&first).unwrap();
    let error = runner::raise_on_signals(&second).unwrap_err().to_string();
    assert_eq!(error, "the signals of this process raise another request already");
    send(std::process::id(), Signal::INT);
    send(std::process::id(), Signal::USR1);
    // Another thread may hear them, and a little later.
    let is_heard = || (first.raised(), first.ends()) == (1, 1);
    assert!(within(Duration::from_secs(60), is_heard), "{first:?}");
    assert_eq!((second.raised(), second.ends()), (0, 0));
}

#[test]
fn workers_that_cannot_start_are_an_error_in_words() {
    let missing = Options { worker_command: vec!["/no/such/program".into()], ..options() };
    let error = run(squares(3), &missing).0.unwrap_err().to_string();
    assert_eq!(
        error,
        "workers cannot be started with `/no/such/program`: 10 in a row ended before asking for a job, the last: No such file or directory (os error 2)"
    );
    let failing = Options { worker_command: vec!["false".into()], ..options() };
    let error = run(squares(3), &failing).0.unwrap_err().to_string();
    assert_eq!(
        error,
        "workers cannot be started with `false`: 10 in a row ended before asking for a job, the last: exit status 1"
    );
}

#[test]
fn a_worker_that_never_asks_is_given_up() {
    let command = vec!["sh".into(), "-c".into(), "exec sleep 1000".into()];
    let options =
        Options { worker_command: command, start_timeout: Duration::from_millis(20), ..options() };
    let error = run(squares(3), &options).0.unwrap_err().to_string();
    assert!(
        error.contains("asked for no job within 20ms of its start (signal 9, SIGKILL)"),
        "{error}"
    );
}

#[test]
fn nonsense_is_refused_before_anything_runs() {
    let two = vec![task(1, "square 1"), task(1, "square 2")];
    assert!(matches!(run(two, &options()).0, Err(RunError::Duplicate(_))));
    assert!(matches!(
        run(squares(1), &Options { workers: 0, ..options() }).0,
        Err(RunError::Options { .. })
    ));
    assert!(WorkerArguments::parse("x").is_err());
    assert_eq!(run(Vec::new(), &options()).0.unwrap().done, 0);
}

#[test]
fn a_ledger_that_fails_ends_the_run() {
    let mut kept = Kept { fail_after: Some(10), ..Kept::default() };
    let error =
        runner::run(&squares(200), &mut kept, &options(), &Interrupt::new().unwrap(), &mut |_| {})
            .unwrap_err();
    assert!(
        matches!(&error, RunError::Ledger(source) if source.to_string() == "no space left on device")
    );
    assert_eq!(kept.results.len(), 10);
}

#[test]
fn an_interrupt_keeps_what_is_in_flight_and_begins_nothing() {
    let tasks: Vec<_> = (0..50)
        .map(|number| Task { cost: 1.0, ..task(number, format!("sleep 300 {number}")) })
        .collect();
    let interrupt = Interrupt::new().unwrap();
    let (mut kept, mut leased) = (Kept::default(), 0);
    let summary = runner::run(&tasks, &mut kept, &options(), &interrupt, &mut |event| {
        if matches!(event.kind, EventKind::Leased { .. }) {
            leased += 1;
            if leased == 2 {
                interrupt.raise();
            }
        }
    });
    let summary = summary.unwrap();
    assert_eq!(summary.early_end, Some(EarlyEnd::Interrupted));
    assert_eq!((summary.done, summary.unfinished, kept.results.len(), leased), (2, 48, 2, 2));
}

#[test]
fn what_is_in_flight_when_the_time_is_over_is_given_up_and_charged_with_nothing() {
    let mut tasks = squares(20);
    tasks.extend((20..24).map(|number| Task { cost: 1e-3, ..task(number, "hang") }));
    let (until, overtime) = (Some(Duration::from_secs(2)), Duration::from_millis(500));
    let (summary, kept, events) = run(tasks, &Options { until, overtime, ..options() });
    let summary = summary.unwrap();
    assert_eq!(summary.early_end, Some(EarlyEnd::InTime));
    assert_eq!((summary.failures, summary.workers_lost, summary.quarantined), (0, 0, 0));
    assert_eq!((summary.done + summary.unfinished, summary.done), (24, kept.results.len()));
    assert!(kept.results.keys().all(|&number| number < 20), "what hangs has no result");
    let times: Vec<_> = events
        .iter()
        .filter_map(|event| match event.kind {
            EventKind::TimeUp { now } => Some((now, event.seconds)),
            _ => None,
        })
        .collect();
    assert!(matches!(times[..], [(false, stop), (true, end)] if stop >= 2.0 && end >= stop + 0.5));
}

#[test]
fn a_worker_leaves_it_to_its_coordinator_to_end_in_time() {
    let mut tasks = squares(20);
    tasks.push(task(20, "end"));
    let (summary, kept, _) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.workers_lost, summary.failures), (21, 0, 0));
    assert_eq!(kept.text(20), "deaf");
}

#[test]
fn two_interrupts_end_the_run_now() {
    let tasks: Vec<_> = (0..5).map(|number| task(number, "hang")).collect();
    let interrupt = Interrupt::new().unwrap();
    let mut kept = Kept::default();
    let summary = runner::run(&tasks, &mut kept, &options(), &interrupt, &mut |event| {
        if matches!(event.kind, EventKind::Leased { .. } | EventKind::Interrupted { now: false })
            && interrupt.raised() < 2
        {
            interrupt.raise();
        }
    });
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.failures, summary.unfinished), (0, 0, 5));
}

/// The variable of the environment that names the directory of large bodies.
const BODIES: &str = "RUNNER_TEST_BODIES";
