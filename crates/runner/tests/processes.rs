//! Real worker processes over real shared memory are killed in every way.
//!
//! This binary is also the worker, and the coordinator to be killed: children run the two ignored
//! tests.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
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
        runner::run(tasks, &mut kept, options, &Interrupt::new().unwrap(), &mut |event| {
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

/// Lists what runs whose large bodies travel through a directory left: their directories, and
/// shared memory of the same tags.
fn leftovers(bodies: &Path) -> Vec<PathBuf> {
    let entries = |path: &Path| {
        let found = std::fs::read_dir(path).into_iter().flatten().flatten();
        found.map(|entry| entry.path()).collect::<Vec<_>>()
    };
    let shared = entries(Path::new("/dev/shm"));
    let ours = shared.iter().filter(|path| {
        std::fs::read_link(path.join("bodies")).is_ok_and(|target| target == bodies)
    });
    let mut found = Vec::new();
    for run in ours {
        let name = run.file_name().unwrap().to_str().unwrap();
        let of_run =
            |path: &&PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(name);
        found.extend(shared.iter().filter(of_run).cloned());
    }
    // Shared memory without its directory belongs to nobody, and nobody would remove it.
    let is_orphan = |path: &&PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let tag = name.strip_prefix("tribo-").and_then(|rest| rest.get(..18));
        let is_left = |path: &PathBuf| std::fs::symlink_metadata(path).is_ok();
        tag.is_some_and(|tag| !Path::new(&format!("/dev/shm/tribo-{tag}")).exists())
            && is_left(path)
    };
    found.extend(shared.iter().filter(is_orphan).cloned());
    found.extend(bodies.exists().then(|| bodies.to_owned()));
    found
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
    let mut child = exe.unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(leftovers(&bodies), Vec::<PathBuf>::new());
}

#[test]
#[ignore = "run in a process of its own by another test, which looks at what it leaves"]
fn a_clean_run() {
    let (summary, kept, events) = run(squares(500), &options());
    let summary = summary.unwrap();
    assert_squares(&kept, 500);
    assert_eq!(
        (summary.done, summary.failures, summary.workers_lost, summary.stale_results),
        (500, 0, 0, 0)
    );
    assert!(matches!(events[0].kind, EventKind::RunStarted));
    let last = events.last().unwrap();
    assert_eq!((&last.kind, last.counts.done, last.counts.workers), (&EventKind::Finished, 500, 0));
    for (number, done) in &kept.results {
        assert_eq!(done.attempts, 1, "job {number}");
    }
}

#[test]
fn a_job_that_kills_its_worker_is_tried_again() {
    let dir = tempfile::tempdir().unwrap();
    let mut tasks = squares(40);
    tasks.push(task(40, format!("crash-once {}", dir.path().join("mark").display())));
    let (summary, kept, events) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.failures, summary.workers_lost), (41, 1, 1));
    assert_eq!((kept.text(40).as_str(), kept.results[&40].attempts), ("survived", 2));
    let lost = events.iter().find_map(|event| {
        if let EventKind::WorkerLost { how, .. } = &event.kind { Some(how.as_str()) } else { None }
    });
    assert_eq!(lost, Some("signal 9, SIGKILL"));
    assert!(
        kept.results.values().all(|done| number(done.key) == 40 || done.attempts == 1),
        "only the culprit is charged"
    );
}

#[test]
fn a_job_that_always_kills_is_set_aside_and_the_rest_goes_on() {
    let mut tasks = squares(60);
    tasks.push(task(60, "crash"));
    let (summary, mut kept, events) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!(
        (summary.done, summary.quarantined, summary.failures, summary.workers_lost),
        (60, 1, 3, 3)
    );
    let set_aside = kept.results.remove(&60).unwrap();
    assert_eq!(set_aside.attempts, 3);
    assert_eq!(
        set_aside.verdict,
        Verdict::Quarantined { reason: "its worker was lost: signal 9, SIGKILL".into() }
    );
    assert_squares(&kept, 60);
    assert!(events.iter().any(|event| matches!(event.kind, EventKind::WorkerReplaced { .. })));
}

#[test]
fn a_panic_costs_the_attempt_and_not_the_worker() {
    let mut tasks = squares(20);
    tasks.push(task(20, "panic"));
    let (summary, kept, _) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!(
        (summary.done, summary.quarantined, summary.failures, summary.workers_lost),
        (20, 1, 3, 0)
    );
    let reason = kept.text(20);
    assert!(
        reason.starts_with("panicked at ")
            && reason.contains("processes.rs:")
            && reason.ends_with(": no such punch"),
        "{reason}"
    );
}

#[test]
fn a_job_that_hangs_misses_its_deadline() {
    let options =
        Options { grace: Duration::from_secs(3), patience: 1.0, attempts: 1, ..options() };
    let mut tasks = squares(20);
    tasks.push(task(20, "hang"));
    let (summary, kept, _) = run(tasks, &options);
    assert_eq!(summary.unwrap().quarantined, 1);
    assert!(
        kept.text(20).contains("finished nothing within its deadline of 3."),
        "{}",
        kept.text(20)
    );
}

#[test]
fn a_stopped_worker_is_noticed_by_its_silence() {
    let options = Options {
        heartbeat: Duration::from_millis(200),
        silence: Duration::from_secs(4),
        attempts: 1,
        ..options()
    };
    let (summary, kept, _) =
        run(vec![task(0, "stop"), task(1, "square 3"), task(2, "sleep 6000 x")], &options);
    assert_eq!(summary.unwrap().quarantined, 1);
    assert!(
        kept.text(0).contains("gave no sign of life for 4s (signal 9, SIGKILL)"),
        "{}",
        kept.text(0)
    );
    assert_eq!(
        (kept.text(1).as_str(), kept.text(2).as_str()),
        ("9", "x"),
        "a job longer than the silence is no silence"
    );
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
fn a_job_cannot_take_more_memory_than_its_worker_may() {
    let options =
        Options { memory_limit: 1 << 30, address_space_margin: 1 << 30, attempts: 2, ..options() };
    let mut hungry = task(2, "square 2");
    hungry.memory = 2 << 30;
    let (summary, kept, events) =
        run(vec![task(0, "allocate 3000000000"), task(1, "allocate 1000"), hungry], &options);
    let error = summary.unwrap_err().to_string();
    assert!(error.starts_with("2 jobs are left for another run: "), "{error}");
    assert_eq!(kept.text(1), "1000");
    assert_eq!(kept.results.len(), 1, "nothing is recorded of what had too little memory");
    let reasons: BTreeMap<u64, &str> = events
        .iter()
        .filter_map(|event| match &event.kind {
            EventKind::Postponed { key, reason } => Some((number(*key), reason.as_str())),
            _ => None,
        })
        .collect();
    assert!(reasons[&0].ends_with("SIGABRT: out of memory"), "{reasons:?}");
    assert_eq!(reasons[&2], "needs 2.0 GiB of memory by prediction, and the run may use 1.0 GiB");
}

#[test]
fn a_job_that_aborts_its_worker_is_set_aside_unless_it_lacked_memory() {
    let mut tasks = squares(20);
    tasks.extend([task(20, "abort"), task(21, "recurse")]);
    let (summary, mut kept, _) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.quarantined, summary.failures), (20, 2, 6));
    let lost = "its worker was lost: signal 6, SIGABRT: ";
    assert_eq!(kept.text(20), format!("{lost}a panic in a panic, or a call of abort"));
    assert_eq!(kept.text(21), format!("{lost}a stack overflow"));
    kept.results.retain(|&number, _| number < 20);
    assert_squares(&kept, 20);
}

#[test]
fn many_jobs_that_lack_memory_are_left_one_by_one_and_the_rest_is_done() {
    let options =
        Options { workers: 1, memory_limit: 1 << 30, address_space_margin: 1 << 30, ..options() };
    let mut tasks = squares(5);
    tasks.extend((5..12).map(|number| Task { cost: 9.0, ..task(number, "allocate 3000000000") }));
    let (summary, kept, events) = run(tasks, &options);
    let error = summary.unwrap_err().to_string();
    assert!(error.starts_with("7 jobs are left for another run: "), "{error}");
    assert!(error.ends_with("SIGABRT: out of memory"), "{error}");
    assert_squares(&kept, 5);
    assert_eq!(events.last().unwrap().counts.failures, 0);
}

#[test]
fn a_job_whose_worker_always_leaves_is_left_for_another_run_and_the_rest_is_done() {
    let mut tasks = squares(20);
    tasks.push(Task { cost: 9.0, ..task(20, "leave") });
    let (summary, kept, _) = run(tasks, &options());
    assert_eq!(
        summary.unwrap_err().to_string(),
        "1 job is left for another run: its worker was lost: exit status 3 (3 times)"
    );
    assert_squares(&kept, 20);
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
        runner::run(squares(200), &mut kept, &options(), &Interrupt::new().unwrap(), &mut |_| {})
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
    let summary = runner::run(tasks, &mut kept, &options(), &interrupt, &mut |event| {
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
    let summary = runner::run(tasks, &mut kept, &options(), &interrupt, &mut |event| {
        if matches!(event.kind, EventKind::Leased { .. } | EventKind::Interrupted { now: false })
            && interrupt.raised() < 2
        {
            interrupt.raise();
        }
    });
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.failures, summary.unfinished), (0, 0, 5));
}

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
        runner::run(tasks, &mut kept, &options, &Interrupt::new().unwrap(), &mut |event| {
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
const BODIES: &str = "RUNNER_TEST_BODIES";

#[test]
#[ignore = "the coordinator that other tests disturb"]
fn coordinator() {
    let (Some(path), Ok(jobs)) = (std::env::var_os(JOURNAL), std::env::var(JOBS)) else { return };
    let mut journal =
        Journal(std::fs::File::options().append(true).create(true).open(path).unwrap());
    let tasks = (0..jobs.parse().unwrap())
        .map(|number| task(number, format!("sleep 2 {number}")))
        .collect();
    // The attempts have no end: the killer is outside, and no job is to blame.
    let options = Options { attempts: u32::MAX, ..options() };
    runner::run(tasks, &mut journal, &options, &Interrupt::new().unwrap(), &mut |event| {
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
    let command = ourselves(test);
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
fn a_result_that_cannot_be_handed_over_stops_the_run_and_charges_no_job() {
    // A write beyond the limit is an error, and not a signal, once the process is prepared.
    runner::prepare_process().unwrap();
    let mut command = vec!["prlimit".into(), "--fsize=2000000".into()];
    command.extend(ourselves("worker"));
    let options = Options { worker_command: command, ..options() };
    let mut tasks = squares(20);
    tasks.extend((20..24).map(|number| Task { cost: 9.0, ..task(number, "huge 3000000") }));
    let (summary, kept, events) = run(tasks, &options);
    let error = summary.unwrap_err().to_string();
    assert!(
        error.contains("cannot be handed over: cannot write 3000000 bytes to ")
            && error.ends_with("File too large (os error 27)"),
        "{error}"
    );
    assert!(kept.results.keys().all(|&number| number < 20), "nothing is recorded as failed");
    assert_eq!(events.last().unwrap().counts.failures, 0);
    assert!(!options.bodies.exists());
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
    let tasks = (0..2).map(|number| task(number, format!("sleep 300 {number}"))).collect();
    runner::run(tasks, &mut journal, &options, &Interrupt::new().unwrap(), &mut |event| {
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

#[test]
fn a_job_that_the_system_kills_for_want_of_memory_is_left_for_another_run() {
    let group = PathBuf::from(format!("/sys/fs/cgroup/memory/runner-test-{}", std::process::id()));
    if std::fs::create_dir(&group).is_err() {
        eprintln!("skipped, because no group of limited memory can be made here");
        return;
    }
    std::fs::write(group.join("memory.limit_in_bytes"), "200000000").unwrap();
    let join = format!("echo $$ > {}/cgroup.procs; exec \"$0\" \"$@\"", group.display());
    let mut command = vec!["sh".into(), "-c".into(), join.into()];
    command.extend(ourselves("worker"));
    let options = Options { worker_command: command, ..options() };
    let mut tasks: Vec<_> =
        (0..20).map(|number| task(number, format!("sleep 20 {number}"))).collect();
    tasks.push(Task { cost: 9.0, ..task(20, "allocate 600000000") });
    let (summary, kept, events) = run(tasks, &options);
    let error = summary.unwrap_err().to_string();
    assert!(error.contains("the system had too little memory and killed it"), "{error}");
    assert_eq!(kept.results.len(), 20, "the others are done");
    let last = events.last().unwrap();
    assert_eq!((last.counts.postponed, last.counts.failures), (1, 0));
    assert!(
        events.iter().any(|event| matches!(&event.kind, EventKind::Returned { reason, .. }
            if reason.ends_with("it will run while no other job does"))),
        "it is tried alone before"
    );
    std::fs::remove_dir(&group).unwrap();
}
