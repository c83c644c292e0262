//! Runs with what a container gives, and the recipes of images.
//!
//! What a container has as `/dev/shm` is mounted in a name space that only the run sees. Where that
//! is not permitted, the tests say so and are skipped.

mod recipes;

use std::process::{Command, Stdio};

use serde_json::Value;

use crate::place::{PROGRAM, Place, skip};

/// Eight jobs whose results are too large for a message.
const STUDY: &str = r#"
name = "contained"
question = "How do large results travel in little shared memory?"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "flat-disk", radius = "1 mm" }
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 80
[sweep]
friction.mu = { from = 0.1, to = 0.8, count = 8 }
"#;

/// The end of what ran in a container.
struct Contained {
    code: i32,
    said: String,
}

/// Returns the options by which `unshare` lets this user mount file systems, if any do.
fn mount_options(test: &str) -> Option<&'static str> {
    let may_mount = |options: &&str| {
        let tried = Command::new("unshare")
            .args([*options, "mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", "/dev/shm"])
            .stderr(Stdio::null())
            .status();
        tried.is_ok_and(|status| status.success())
    };
    let options = ["-m", "-rm"].into_iter().find(|options| may_mount(options));
    if options.is_none() {
        skip(&format!("{test} needs a file system that only its processes see"));
    }
    options
}

/// Runs a line of shell in which `$T` is the program, where `/dev/shm` is as Docker makes it, of a
/// size. Afterwards nothing may be left there.
fn contained(place: &Place, options: &str, size: &str, line: &str) -> Contained {
    let script = format!(
        "mount -t tmpfs -o nosuid,nodev,noexec,size={size} shm /dev/shm || exit 99; {line}; \
         code=$?; ls -A /dev/shm | sed 's/^/left: /'; exit $code"
    );
    let mut command = place.program("unshare");
    let output = command.args([options, "sh", "-c", &script]).env("T", PROGRAM).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8(said).unwrap();
    assert!(!said.contains("left: "), "{line} leaves something in /dev/shm:\n{said}");
    assert!(!said.contains("panicked"), "{line}: {said}");
    Contained { code: output.status.code().expect("no signal ends it"), said }
}

#[test]
fn several_workers_run_in_the_shared_memory_of_a_container() {
    let Some(options) = mount_options("a container") else { return };
    let place = Place::with("study.toml", STUDY);
    let line = "$T run study.toml --workers 6";
    let ended = contained(&place, options, "65536k", line);
    assert_eq!(ended.code, 0, "{}", ended.said);
    assert!(ended.said.contains("8 certified"), "{}", ended.said);
    assert!(!ended.said.contains("at a time"), "{}", ended.said);
}

#[test]
fn a_run_narrows_in_words_where_shared_memory_is_short() {
    let Some(options) = mount_options("a container") else { return };
    let place = Place::with("study.toml", STUDY);
    let ended = contained(&place, options, "18m", "$T run study.toml --workers 6");
    assert_eq!(ended.code, 0, "{}", ended.said);
    let narrowed = " at a time: a worker needs 1.0 MiB in /dev/shm";
    assert!(ended.said.contains(narrowed), "{}", ended.said);
    assert!(ended.said.contains("8 certified"), "{}", ended.said);
    let ended = contained(&place, options, "8m", "$T run study.toml --store other");
    assert_eq!(ended.code, 1, "{}", ended.said);
    assert!(ended.said.contains("no worker can be started: a worker needs 1.0 MiB in /dev/shm"));
}

#[test]
fn the_doctor_says_what_a_container_gives() {
    let Some(options) = mount_options("a container") else { return };
    let place = Place::empty();
    let seen = |size: &str| {
        let ended = contained(&place, options, size, "$T doctor --json 2>/dev/null");
        let said: Value = serde_json::from_str(&ended.said)
            .unwrap_or_else(|error| panic!("{error}: {}", ended.said));
        (ended.code, said)
    };
    let of = |said: &Value, subject: &str| -> Value {
        let all = said["observations"].as_array().unwrap();
        all.iter().find(|one| one["subject"] == subject).unwrap_or(&Value::Null).clone()
    };
    let (code, said) = seen("65536k");
    assert_eq!((code, &said["possible"]), (0, &Value::from(true)), "{said}");
    let memory = of(&said, "shared memory");
    assert_eq!(memory["soundness"], "fine", "{said}");
    assert!(memory["found"].as_str().unwrap().contains("/dev/shm has 64.00 MiB"), "{said}");
    assert_eq!(of(&said, "a run")["soundness"], "fine", "{said}");
    let (code, said) = seen("8m");
    assert_eq!((code, &said["possible"]), (1, &Value::from(false)), "{said}");
    assert_eq!(of(&said, "workers")["soundness"], "missing", "{said}");
    assert_eq!(of(&said, "a run")["soundness"], "missing", "{said}");
    assert!(of(&said, "shared memory")["advice"].as_str().unwrap().contains("--shm-size"));
}
