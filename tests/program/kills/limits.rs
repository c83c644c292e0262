//! Runs within the limits and beside the misfortunes of a system: none ends in a signal, none
//! charges a job with what is no fault of it, and what was computed is kept.
//!
//! Tests that need rights that only root has skip themselves elsewhere.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File};
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rustix::process::{Pid, Signal};

use super::JOBS;
use super::place::{MARK, MarkedPlace, Running, belongings};
use crate::place::PROGRAM;

/// A study of four jobs whose results are too large for a message.
const LARGE: &str = r#"
name = "large"
question = "How do large results travel?"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "flat-disk", radius = "1 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 96
[sweep]
friction.mu = { from = 0.1, to = 0.8, count = 4 }
"#;

/// The end of a command.
struct Ended {
    code: Option<i32>,
    said: String,
}

/// Runs a line of shell in which `$T` is the program, in a place of its own.
fn shell(place: &MarkedPlace, line: &str) -> Ended {
    let output = Command::new("sh")
        .args(["-c", line])
        .current_dir(place.directory.path())
        .env("T", PROGRAM)
        .env("TRIBOSWEEP_STORE", place.store())
        .env(MARK, place.directory.path())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].concat();
    Ended { code: output.status.code(), said: String::from_utf8_lossy(&said).into_owned() }
}

fn is_root(what: &str) -> bool {
    let is_root = rustix::process::getuid().is_root();
    if !is_root {
        eprintln!("skipped, because only root can {what}");
    }
    is_root
}

/// Tells whether a file system may be mounted that these processes alone see.
fn can_mount(place: &MarkedPlace) -> bool {
    let mount = Command::new("unshare")
        .args(["-m", "mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs"])
        .arg(place.directory.path())
        .stderr(Stdio::null())
        .status();
    let can_mount = mount.is_ok_and(|status| status.success());
    if !can_mount {
        eprintln!("skipped, because no file system can be mounted here");
    }
    can_mount
}

/// Checks that a run either succeeded or said in words why it did not, and that the study is
/// finished by an ordinary run afterwards without any failure.
fn assert_no_harm(place: &MarkedPlace, ended: &Ended, line: &str) {
    assert!(matches!(ended.code, Some(0 | 1)), "{line}: {:?}\n{}", ended.code, ended.said);
    if ended.code == Some(1) {
        assert!(ended.said.contains("error: "), "{line}: {}", ended.said);
    }
    assert!(!ended.said.contains("panicked"), "{line}: {}", ended.said);
    place.succeed(&["run", "study.toml"]);
    place.assert_quiet();
    assert_eq!(belongings(&place.bodies()), Vec::<PathBuf>::new());
    assert!(!place.bodies().exists());
}

#[test]
fn a_limit_of_the_process_ends_in_words() {
    for (line, words) in [
        ("ulimit -v 250000; $T run study.toml", "`ulimit -v`"),
        ("ulimit -v 600000; $T run study.toml", "4 certified"),
        ("ulimit -v 800000; $T run study.toml", "4 certified"),
        ("ulimit -d 60000; $T run study.toml", "`ulimit -d`"),
        ("ulimit -d 140000; $T run study.toml", "4 certified"),
        ("ulimit -d 140000; $T run study.toml --memory 8GiB", "`ulimit -v` or `ulimit -d`"),
        ("ulimit -n 48; $T run study.toml", "`ulimit -n`"),
        ("ulimit -n 100; $T run study.toml --workers 8", "`ulimit -n`"),
        ("ulimit -s 200; $T run study.toml", "`ulimit -s`"),
    ] {
        let place = MarkedPlace::with(LARGE);
        let ended = shell(&place, line);
        assert!(ended.said.contains(words), "{line}: {}", ended.said);
        assert_no_harm(&place, &ended, line);
    }
}

/// The system counts the threads of a user, so this one has no others.
#[test]
fn few_threads_end_in_words() {
    if !is_root("be another user") {
        return;
    }
    let place = MarkedPlace::with(&LARGE.replace("96", "16"));
    let user = 200_000 + std::process::id();
    let program = place.path("tribosweep");
    fs::copy(PROGRAM, &program).unwrap();
    std::os::unix::fs::chown(place.directory.path(), Some(user), Some(user)).unwrap();
    let cores = std::thread::available_parallelism().unwrap().get();
    // Not every shell has `ulimit -u`.
    let line = |threads: usize, more: &str| {
        format!(
            "exec setpriv --reuid {user} --clear-groups prlimit --nproc={threads} \
             ./tribosweep run study.toml --store store-{threads} {more}"
        )
    };
    let mut codes = BTreeSet::new();
    for threads in [2, 9, 10, 12, 14, 15, 16, 19].map(|more| cores + more) {
        let line = line(threads, "");
        let ended = shell(&place, &line);
        assert!(matches!(ended.code, Some(0 | 1)), "{line}: {:?}\n{}", ended.code, ended.said);
        assert!(!ended.said.contains("panicked"), "{line}: {}", ended.said);
        assert!(ended.code == Some(0) || ended.said.contains("`ulimit -u`"), "{}", ended.said);
        codes.insert(ended.code);
    }
    assert!(codes.contains(&Some(1)), "no limit was felt");
    // The threads that the program itself has differ from one machine to another.
    let study = LARGE.replace("96", "16").replace("count = 4", "count = 12");
    fs::write(place.path("study.toml"), study).unwrap();
    let line = line(cores + 32, "--workers 12");
    let ended = shell(&place, &line);
    assert_eq!(ended.code, Some(0), "{}", ended.said);
    let notice =
        ended.said.lines().find(|line| line.contains(" at a time: a worker needs 3 threads"));
    let workers = notice.and_then(|notice| notice.split(' ').next()?.parse().ok()).unwrap_or(0);
    assert!((1..8).contains(&workers), "{}", ended.said);
}

#[test]
fn few_open_files_make_few_workers_and_a_soft_limit_is_raised() {
    let place = MarkedPlace::with(LARGE);
    let ended = shell(&place, "ulimit -n 100; $T run study.toml --workers 4");
    assert!(ended.said.contains(" at a time: a worker needs 26 open files"), "{}", ended.said);
    assert_eq!(ended.code, Some(0), "{}", ended.said);
    let place = MarkedPlace::with(LARGE);
    let ended = shell(&place, "ulimit -S -n 100; $T run study.toml --workers 4");
    assert!(!ended.said.contains("at a time"), "{}", ended.said);
    assert_eq!(ended.code, Some(0), "{}", ended.said);
}

#[test]
fn a_scene_that_needs_more_memory_than_there_is_is_refused_before_it_is_solved() {
    let place = MarkedPlace::with(LARGE);
    for line in [
        "ulimit -v 600000; $T solve study.toml --set friction.mu=0.3 --set mesh=2000",
        "$T run study.toml --memory 1MiB",
    ] {
        let ended = shell(&place, line);
        assert_eq!(ended.code, Some(1), "{line}: {}", ended.said);
        assert!(ended.said.contains("of memory by prediction, and "), "{line}: {}", ended.said);
    }
    let status = place.succeed(&["run", "study.toml"]);
    assert!(status.contains("4 points, 4 certified, 0 failed, 0 left; 4 of 4 jobs computed"));
}

#[test]
fn more_threads_than_the_machine_can_use_are_not_started() {
    let place = MarkedPlace::with(LARGE);
    for line in [
        "RAYON_NUM_THREADS=9999 $T run study.toml",
        "RAYON_NUM_THREADS=+9999 $T run study.toml",
        "RAYON_NUM_THREADS=99999999999999999999 $T plan study.toml",
    ] {
        let ended = shell(&place, line);
        assert!(ended.said.contains("threads instead of RAYON_NUM_THREADS="), "{}", ended.said);
        assert_eq!(ended.code, Some(0), "{}", ended.said);
    }
}

#[test]
fn directories_for_temporary_files_do_not_matter() {
    let place = MarkedPlace::with(LARGE);
    let odd = OsString::from_vec(b"/no such place/\xff\xc3\xa9 and so on".to_vec());
    let long = place.path(&"x".repeat(200)).join("y".repeat(200));
    fs::create_dir_all(&long).unwrap();
    for (number, temporary) in [odd, long.into(), "".into(), "/dev/null".into()].iter().enumerate()
    {
        let store = place.path(&format!("store-{number}"));
        let output = Command::new(PROGRAM)
            .args(["run", "study.toml", "--store"])
            .arg(&store)
            .current_dir(place.directory.path())
            .env_clear()
            .env("TMPDIR", temporary)
            .env("XDG_RUNTIME_DIR", temporary)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{temporary:?}: {output:?}");
    }
}

#[test]
fn a_store_with_any_name_can_be_run_in() {
    let place = MarkedPlace::with(LARGE);
    let name = OsString::from_vec(b"a b \xff\xc3\xa9, <*>?".to_vec());
    let mut store = place.path("deep").join("z".repeat(150)).join("z".repeat(150));
    fs::create_dir_all(&store).unwrap();
    store.push(name);
    let output = Command::new(PROGRAM)
        .args(["run", "study.toml", "--store"])
        .arg(&store)
        .current_dir(place.directory.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// The signals that a run hears, by name.
const SIGNALS: [(&str, Signal); 4] =
    [("HUP", Signal::HUP), ("INT", Signal::INT), ("TERM", Signal::TERM), ("USR1", Signal::USR1)];

#[test]
fn a_signal_that_is_ignored_at_the_start_stays_ignored() {
    for (name, signal) in SIGNALS {
        let place = MarkedPlace::new();
        let store = place.store();
        let mut child = Command::new("sh")
            .args(["-c", &format!("trap '' {name}; exec \"$0\" run study.toml --store \"$1\"")])
            .arg(PROGRAM)
            .arg(&store)
            .current_dir(place.directory.path())
            .env(MARK, place.directory.path())
            .stdout(Stdio::null())
            .stderr(File::create(place.path("err")).unwrap())
            .spawn()
            .unwrap();
        while child.try_wait().unwrap().is_none() && place.records().is_empty() {
            sleep(Duration::from_millis(2));
        }
        rustix::process::kill_process(Pid::from_child(&child), signal).unwrap();
        let status = child.wait().unwrap();
        let said = fs::read_to_string(place.path("err")).unwrap();
        assert_eq!(status.code(), Some(0), "SIG{name}: {status}\n{said}");
        assert_eq!(place.records().len(), JOBS);
    }
}

/// Nothing reads the output of this run, which waits for that and hears no request.
fn ends_at_the_third(signal: Signal, pause: Duration, code: i32) {
    let place = MarkedPlace::with(LARGE);
    let (_reader, mut writer) = std::io::pipe().unwrap();
    std::io::Write::write_all(&mut writer, &[0; 64 << 10]).unwrap();
    let mut child = Command::new(PROGRAM)
        .args(["run", "study.toml", "--store"])
        .arg(place.store())
        .current_dir(place.directory.path())
        .env(MARK, place.directory.path())
        .stdout(writer)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while place.records().is_empty() {
        assert!(child.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(5));
    }
    for _ in 0..3 {
        sleep(pause);
        let _ = rustix::process::kill_process(Pid::from_child(&child), signal);
    }
    assert_eq!(child.wait().unwrap().code(), Some(code));
    place.succeed(&["run", "study.toml"]);
    place.assert_quiet();
}

#[test]
fn who_asks_a_third_time_ends_a_process_that_does_not_hear() {
    ends_at_the_third(Signal::INT, Duration::from_millis(300), 130);
    // Requests for an end in time that follow each other within two seconds are one.
    ends_at_the_third(Signal::TERM, Duration::from_millis(2100), 75);
}

#[test]
fn a_pipe_or_a_link_in_the_place_of_a_figure_is_left_alone() {
    let place = MarkedPlace::with(LARGE);
    place.succeed(&["run", "study.toml"]);
    let figures = place.store().join("figures");
    let names = fs::read_dir(&figures).unwrap().map(|entry| entry.unwrap().path());
    let names: Vec<PathBuf> = names.collect();
    assert!(!names.is_empty());
    let precious = place.path("precious");
    for kind in ["mkfifo", "ln -s ../../precious"] {
        fs::write(&precious, "precious").unwrap();
        for name in &names {
            // The run before has written none of them.
            let _ = fs::remove_file(name);
        }
        let line = format!("{kind} {}; exec timeout 20 $T run study.toml", names[0].display());
        let ended = shell(&place, &line);
        assert_eq!(ended.code, Some(0), "{line}: {}", ended.said);
        assert!(ended.said.contains("is something else than a file; remove it"), "{}", ended.said);
        assert_eq!(fs::read_to_string(&precious).unwrap(), "precious");
    }
}

/// A run in another process-id namespace, as in a container that shares `/dev/shm`, is judged by the
/// lock that it holds.
#[test]
fn a_run_in_another_container_is_left_alone_and_cleaned_up_after() {
    if !is_root("make a namespace") {
        return;
    }
    let (place, other) = (MarkedPlace::with(&LARGE.replace("96", "192")), MarkedPlace::with(LARGE));
    let mut container = Command::new("unshare")
        .args(["--pid", "--fork", "--kill-child", "--mount-proc"])
        .args([PROGRAM, "run", "study.toml", "--store"])
        .arg(place.store())
        .current_dir(place.directory.path())
        .env(MARK, place.directory.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while belongings(&place.bodies()).len() < 10 {
        assert!(container.try_wait().unwrap().is_none(), "it is over before it was seen");
        sleep(Duration::from_millis(1));
    }
    other.succeed(&["run", "study.toml"]);
    assert!(container.try_wait().unwrap().is_none(), "the other run was not beside it");
    assert!(belongings(&place.bodies()).len() >= 10, "the files of a run that lives are gone");
    container.kill().unwrap();
    container.wait().unwrap();
    place.assert_quiet();
    other.succeed(&["run", "study.toml"]);
    assert_eq!(belongings(&place.bodies()), Vec::<PathBuf>::new());
}

/// Starts a run and waits until it has a first result and workers, or has ended.
fn begun(place: &MarkedPlace, more: &[&str]) -> Running {
    let mut running = place.start_run(more);
    while !running.has_ended() && (running.workers().is_empty() || place.records().is_empty()) {
        sleep(Duration::from_millis(2));
    }
    running
}

#[test]
fn a_run_whose_directory_is_removed_goes_on() {
    let place = MarkedPlace::new();
    let mut running = begun(&place, &["--json"]);
    for path in belongings(&place.bodies()).iter().filter(|path| path.is_dir()) {
        fs::remove_dir_all(path).unwrap();
    }
    // A new worker needs the directory.
    if let Some(worker) = running.workers().first() {
        running.kill_worker(*worker);
    }
    let status = running.wait();
    assert_eq!(status.code(), Some(0), "{status}\n{}", running.said());
    place.assert_undisturbed();
    assert_eq!(belongings(&place.bodies()), Vec::<PathBuf>::new());
}

#[test]
fn a_run_whose_program_is_replaced_starts_workers_of_its_own() {
    let place = MarkedPlace::new();
    let program = place.path("tribosweep");
    fs::copy(PROGRAM, &program).unwrap();
    let mut running =
        place.start_program(&program, &["run", "study.toml", "--workers", "2", "--json"]);
    while !running.has_ended() && (running.workers().is_empty() || place.records().is_empty()) {
        sleep(Duration::from_millis(2));
    }
    fs::remove_file(&program).unwrap();
    fs::write(&program, "#!/bin/sh\nexit 1\n").unwrap();
    if let Some(worker) = running.workers().first() {
        running.kill_worker(*worker);
    }
    let status = running.wait();
    assert_eq!(status.code(), Some(0), "{status}\n{}", running.said());
    place.assert_undisturbed();
}

#[test]
fn shared_memory_that_somebody_else_fills_ends_no_run_by_a_signal() {
    let place = MarkedPlace::with(LARGE);
    if !can_mount(&place) {
        return;
    }
    // The file system is seen by these processes alone.
    let line = "unshare -m sh -c 'mount -t tmpfs -o size=20m tmpfs /dev/shm; \
                $T run study.toml --workers 2 & run=$!; \
                while kill -0 $run 2>/dev/null; do cat /dev/zero > /dev/shm/stranger; sleep 0.02; \
                rm -f /dev/shm/stranger; done 2>/dev/null; wait $run'";
    let ended = shell(&place, line);
    assert_no_harm(&place, &ended, line);
}

#[test]
fn a_disk_that_somebody_else_fills_stops_the_run_and_charges_no_job() {
    let place = MarkedPlace::with(LARGE);
    if !can_mount(&place) {
        return;
    }
    fs::create_dir(place.store()).unwrap();
    let line = "unshare -m sh -c 'mount -t tmpfs -o size=20m tmpfs $TRIBOSWEEP_STORE; \
                $T run study.toml & run=$!; \
                until [ -e $TRIBOSWEEP_STORE/in-transit ] || ! kill -0 $run; \
                do sleep 0.01; done 2>/dev/null; \
                cat /dev/zero > $TRIBOSWEEP_STORE/stranger; wait $run; echo code $?; \
                rm $TRIBOSWEEP_STORE/stranger; $T run study.toml'";
    let ended = shell(&place, line);
    assert!(ended.said.contains("code 1"), "{}", ended.said);
    assert!(ended.said.contains("what is done is kept, continue with: tribosweep resume large"));
    assert!(ended.said.contains("4 points, 4 certified, 0 failed, 0 left"), "{}", ended.said);
    assert_eq!(ended.code, Some(0), "{}", ended.said);
}
