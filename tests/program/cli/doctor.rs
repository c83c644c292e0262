//! The doctor where nothing is short, and where something is.

use serde_json::Value;

use crate::place::{PROGRAM, Place, Said};

/// Runs a line of shell in which `$T` is the program.
fn shell(place: &Place, line: &str) -> Said {
    place.said(place.program("sh").args(["-c", line]).env("T", PROGRAM).env("LC_ALL", "C.UTF-8"))
}

/// Returns what was seen of a thing.
fn seen(said: &Said, subject: &str) -> Value {
    let json: Value = serde_json::from_str(&said.out)
        .unwrap_or_else(|error| panic!("{error}: {}{}", said.out, said.err));
    let all = json["observations"].as_array().unwrap();
    all.iter().find(|one| one["subject"] == subject).unwrap_or(&Value::Null).clone()
}

#[test]
fn a_machine_on_which_everything_can_be_run_is_found_so() {
    let place = Place::empty();
    let said = shell(&place, "$T doctor --json");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let json: Value = serde_json::from_str(&said.out).unwrap();
    assert!(json["possible"].as_bool().unwrap() && json["workers"].as_u64().unwrap() > 0);
    for subject in ["program", "cores", "open files", "threads", "store", "clock", "a run"] {
        assert_eq!(seen(&said, subject)["soundness"], "fine", "{subject}: {}", said.out);
    }
    assert_eq!(seen(&said, "locale")["found"], "C.UTF-8");
    let told = shell(&place, "$T doctor");
    assert_eq!(told.code, 0, "{}{}", told.out, told.err);
    assert!(told.out.contains("\nA run is possible here, with "), "{}", told.out);
    assert!(told.out.contains("ok       cores "), "{}", told.out);
    assert!(place.files().is_empty(), "the doctor leaves something behind");
}

#[test]
fn what_is_short_is_said_with_what_to_do() {
    let place = Place::with("file", "no directory");
    let line = "env -u LC_CTYPE -u LANG LC_ALL=C TMPDIR=/nowhere $T doctor --json";
    let said = shell(&place, line);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    for (subject, advice) in [("locale", "export LC_ALL=C.UTF-8"), ("temporary files", "TMPDIR")] {
        let seen = seen(&said, subject);
        assert_eq!(seen["soundness"], "short", "{}", said.out);
        assert!(seen["advice"].as_str().unwrap().contains(advice), "{}", said.out);
    }
    for (line, subject, words) in [
        ("ulimit -n 40; $T doctor --json", "limits", "`ulimit -n`"),
        ("ulimit -n 56; $T doctor --json", "workers", "`ulimit -n`"),
        ("ulimit -v 250000; $T doctor --json", "limits", "`ulimit -v`"),
        ("ulimit -d 60000; $T doctor --json", "limits", "`ulimit -d`"),
        ("$T doctor --json --store file", "store", "file: "),
        ("$T doctor --json --store file/below", "store", "file/below: "),
        ("$T doctor --json --store /proc/self/store", "a run", "cannot write in /proc/"),
    ] {
        let said = shell(&place, line);
        assert_eq!(said.code, 1, "{line}: {}{}", said.out, said.err);
        let seen = seen(&said, subject);
        assert_eq!(seen["soundness"], "missing", "{line}: {}", said.out);
        assert!(seen["found"].as_str().unwrap().contains(words), "{line}: {}", said.out);
    }
    let said = shell(&place, "$T doctor --store file");
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.out.ends_with("\nNo run is possible here: store, a run.\n"), "{}", said.out);
}

#[test]
fn limits_that_a_run_gets_on_with_are_no_fault() {
    let place = Place::empty();
    // A hard limit for two workers, whatever the number of cores.
    let said = shell(&place, "ulimit -n 100; $T doctor --json");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert_eq!(seen(&said, "a run")["soundness"], "fine", "{}", said.out);
    let said = shell(&place, "ulimit -v 800000; $T doctor --json");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let memory = seen(&said, "memory");
    assert!(memory["found"].as_str().unwrap().contains("`ulimit -v`"), "{memory}");
}

#[test]
fn a_store_that_a_run_has_can_be_examined() {
    let place = Place::run();
    let before = place.files();
    let said = shell(&place, "$T doctor --json");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(!seen(&said, "store")["found"].as_str().unwrap().contains("(new)"));
    assert_eq!(place.files(), before);
}

#[test]
fn python_does_not_take_files_of_the_working_directory_for_modules() {
    let place = Place::empty();
    for module in ["platform.py", "site.py", "importlib.py"] {
        place.write(module, "open('taken', 'w')\n");
    }
    let said = shell(&place, "$T doctor --json");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(!place.has("taken"), "python3 has run a file of the working directory");
    assert!(!place.has("__pycache__"), "python3 has written into the working directory");
}
