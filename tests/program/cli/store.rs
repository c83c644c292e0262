//! The store through the command: damage, tidying, and a run that holds it.

use std::fs;
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::place::{Place, SMALL, Said, without_hashes};

/// A store with a result of an earlier version opens; the result is reported as such, and nothing
/// is taken for damage.
#[test]
fn records_of_another_version_are_refused_by_name_and_hurt_nobody() {
    let place = Place::run();
    let key = identity::JobKey([0xee; 32]);
    store::Store::open(&place.path(".tribosweep"))
        .unwrap()
        .commit(&[(key, vec![1, 1, 0])])
        .unwrap();
    insta::assert_snapshot!(place.transcript(&[&["show", "eeee"], &["store", "compact"]]));
    let verified = place.json("store verify --json");
    assert_eq!(
        (&verified["sound"], &verified["records_of_other_versions"]),
        (&true.into(), &1.into())
    );
    assert!(place.call("store verify").out.contains("1 record is of another version"));
    assert_eq!(place.json("run small.toml --json")["run"]["cached"], 6);
}

#[test]
fn damage_to_a_file_of_fields_is_found() {
    // These fields are larger than those that a record keeps itself.
    let place = Place::with("small.toml", SMALL.replace("mesh = 6", "mesh = 40"));
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    assert_eq!(place.call("store verify").code, 0);
    let (fields, _) = place.blobs();
    assert_eq!(fields.len(), 6);
    let mut bytes = fs::read(&fields[0]).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&fields[0], bytes).unwrap();
    fs::remove_file(&fields[1]).unwrap();
    assert_eq!(place.call("store verify").code, 2);
    let verified = place.json("store verify --json");
    assert_eq!(verified["sound"], false);
    let faults: Vec<String> = verified["faults"]
        .as_array()
        .unwrap()
        .iter()
        .map(|fault| without_hashes(fault.as_str().unwrap()))
        .collect();
    // The effect of a changed byte depends on its place.
    assert!(
        faults[0].starts_with("file [hash]: ") && faults[0].len() > "file [hash]: ".len(),
        "{faults:?}"
    );
    assert_eq!(faults[1..], ["file [hash] is missing, job [hash] refers to it"]);
    // Exactly the two results concerned have no field to show any more, and say so.
    let shown: Vec<Said> =
        place.keys().iter().map(|key| place.words(&["show", key, "--field", "gap"])).collect();
    let errors: Vec<&str> =
        shown.iter().filter(|said| said.code == 1).map(|said| said.err.as_str()).collect();
    assert_eq!(errors.len(), 2);
    assert_eq!(errors.iter().filter(|error| error.contains("is corrupt")).count(), 1, "{errors:?}");
    assert_eq!(
        errors
            .iter()
            .filter(|error| error.contains("is missing; `tribosweep store verify`"))
            .count(),
        1,
        "{errors:?}"
    );
    assert_eq!(shown.iter().filter(|said| said.code == 0).count(), 4);
    // The numbers are whole.
    let before = place.call("query small --format csv --select mu,poisson,load,status");
    assert_eq!(before.code, 0);

    // A run computes again exactly what was damaged.
    let again = place.call("run small.toml --workers 2 --json");
    assert_eq!(again.code, 0, "{}", again.err);
    assert!(again.err.contains("2 results are damaged or without"), "{}", again.err);
    let summary: Value = serde_json::from_str(again.out.lines().last().unwrap()).unwrap();
    assert_eq!((&summary["run"]["computing"], &summary["run"]["cached"]), (&2.into(), &4.into()));
    assert_eq!(place.json("store verify --json")["sound"], true);
    let after = place.call("query small --format csv --select mu,poisson,load,status");
    assert_eq!(after.out, before.out);
    assert_eq!(place.json("run small.toml --json")["run"]["cached"], 6);
}

/// A record that no study asks for any more is healed by nobody's run.
#[test]
fn salvage_gives_up_a_result_whose_file_is_lost() {
    let place = Place::with("small.toml", SMALL.replace("mesh = 6", "mesh = 40"));
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    let (fields, _) = place.blobs();
    fs::remove_file(&fields[0]).unwrap();
    fs::write(&fields[1], b"rubbish").unwrap();
    place.write("small.toml", SMALL);
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    assert_eq!(place.call("store verify").code, 2);
    let salvaged = place.json("store salvage --json");
    assert_eq!((&salvaged["kept"], &salvaged["without_their_file"]), (&10.into(), &2.into()));
    assert_eq!(salvaged["damaged_files"], 1);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

#[test]
fn a_study_that_cannot_be_read_is_not_passed_over() {
    let place = Place::run();
    let (_, study) = place.blobs();
    for damage in [Some(&b"rubbish"[..]), None] {
        match damage {
            Some(rubbish) => fs::write(&study, rubbish).unwrap(),
            None => fs::remove_file(&study).unwrap(),
        }
        for line in ["status", "status --json", "status small"] {
            let said = place.call(line);
            assert_eq!(said.code, 1, "{line}: {}", said.out);
            assert!(
                said.err.contains("the definition of the study `small` is damaged"),
                "{}",
                said.err
            );
        }
    }
    place.write("large.toml", SMALL.replace("\"small\"", "\"large\""));
    assert_eq!(place.call("run large.toml --workers 2").code, 0);
    let said = place.call("status");
    assert_eq!(said.code, 1);
    assert!(said.out.contains("large"), "one damaged study hides no other: {}", said.out);
}

/// Every command that only looks leaves the store as it was, beside tables of one's own studies,
/// and the store of another user is read like one's own.
#[test]
fn commands_that_only_look_write_nothing() {
    let place = Place::run();
    let key = place.keys().remove(0);
    let lines: &[&[&str]] = &[
        &["query", "small"],
        &["status"],
        &["answer", "small"],
        &["show", &key],
        &["show", &key, "--field", "gap"],
        &["plan", "small.toml"],
        &["plot", "small", "--output", "figure.svg"],
        &["store", "verify"],
    ];
    let stored = || -> Vec<_> {
        let files = place.files().into_iter();
        files.filter(|(path, _)| path.starts_with(place.path(".tribosweep"))).collect()
    };
    let without_tables = |files: Vec<(PathBuf, Vec<u8>)>| -> Vec<_> {
        let tables = place.path(".tribosweep/tables");
        files.into_iter().filter(|(path, _)| !path.starts_with(&tables)).collect()
    };
    let before = without_tables(stored());
    let own: Vec<Said> = lines.iter().map(|words| place.words(words)).collect();
    for (said, words) in own.iter().zip(lines) {
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{words:?}");
    }
    assert_eq!(without_tables(stored()), before);

    let before = stored();
    let stranger = |words: &[&str]| {
        let inner = place.command(words);
        let mut outer = Command::new("setpriv");
        outer.args(["--reuid=54321", "--regid=54321", "--clear-groups"]);
        outer.arg(inner.get_program()).args(inner.get_args()).current_dir(place.path(""));
        outer.stdin(Stdio::null()).output()
    };
    let is_root = rustix::process::geteuid().is_root();
    fs::set_permissions(place.path(""), fs::Permissions::from_mode(0o777)).unwrap();
    if !is_root || !stranger(&["--version"]).is_ok_and(|said| said.status.success()) {
        eprintln!("skipped: acting as another user takes privileges that this user lacks");
        return;
    }
    fs::remove_file(place.path("figure.svg")).unwrap();
    for (words, own) in lines.iter().zip(&own) {
        let said = stranger(words).unwrap();
        let err = String::from_utf8(said.stderr).unwrap();
        assert!(said.status.success(), "{words:?}: {err}");
        assert_eq!(String::from_utf8(said.stdout).unwrap(), own.out, "{words:?}");
        assert!(
            err.starts_with("read from a private copy of the records: the store belongs to root;")
                && err.lines().count() == 1,
            "{words:?}: {err}"
        );
    }
    assert_eq!(stored(), before);
    let refused = stranger(&["run", "small.toml"]).unwrap();
    let err = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1), "{err}");
    assert!(err.contains("belongs to root; this user (user 54321) may not write to it"), "{err}");
}

#[test]
fn an_export_is_read_like_a_store() {
    let place = Place::run();
    insta::assert_snapshot!(place.transcript(&[
        &["store", "export", "copy.tribosweep"],
        &["store", "verify", "--store", "copy.tribosweep"],
        &["status", "--store", "copy.tribosweep"],
        &["store", "export", "copy.tribosweep"],
        &["store", "export", "some.tribosweep", "--study", "small", "--study", "small"],
        &["store", "export", "some.tribosweep", "--study", "large"],
        &["store", "import", "copy.tribosweep", "--store", "again"],
        &["store", "import", "copy.tribosweep", "--store", "again"],
        &["store", "merge", ".tribosweep", "--into", "whole"],
        &["store", "verify", "--store", "whole"],
        &["store", "export", "copy"],
        &["store", "export", "elsewhere.tribosweep", "--store", "nowhere"],
        &["store", "merge", "nowhere", "--into", "elsewhere"],
        &["store", "merge", "small.toml", "--into", "elsewhere"],
        &["run", "small.toml", "--store", "copy.tribosweep"],
        &["resume", "small", "--store", "copy.tribosweep"],
        &["store", "compact", "--store", "copy.tribosweep"],
    ]));
    let keys = place.keys();
    for line in [
        "query small --format csv".to_owned(),
        "query small --json".to_owned(),
        "answer small".to_owned(),
        "plan small.toml".to_owned(),
        format!("show {} --json", keys[0]),
        format!("show {} --field gap", keys[0]),
    ] {
        let said = |store: &str| place.call(&format!("{line} --store {store}"));
        let own = said(".tribosweep");
        for store in ["copy.tribosweep", "some.tribosweep", "again", "whole"] {
            let other = said(store);
            // Proposed commands name the store.
            let out = other.out.replace(&format!(" --store {store}"), "");
            assert_eq!((other.code, &out), (own.code, &own.out), "{line} of {store}");
        }
    }
    assert!(!place.path("elsewhere").exists() && !place.path("copy").exists());
}

#[test]
fn a_damaged_study_is_found() {
    let place = Place::run();
    let (_, study) = place.blobs();
    fs::write(&study, b"rubbish").unwrap();
    let verified = place.call("store verify");
    assert_eq!(verified.code, 2);
    let queried = place.call("query small");
    assert_eq!(queried.code, 1);
    insta::assert_snapshot!(without_hashes(&format!(
        "{}{}",
        verified.transcript(),
        queried.transcript()
    )));
    // The study file is still there, and so are the results.
    let again = place.call("run small.toml --json");
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(serde_json::from_str::<Value>(&again.out).unwrap()["run"]["cached"], 6);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

#[test]
fn a_truncated_database_is_never_read_as_a_smaller_one() {
    let place = Place::run();
    let database = place.path(".tribosweep/records/db");
    let whole = fs::metadata(&database).unwrap().len();
    fs::File::options().write(true).open(&database).unwrap().set_len(whole / 2).unwrap();
    for line in [
        "store verify",
        "store compact",
        "status",
        "query small",
        "plan small.toml",
        "run small.toml",
        "resume small",
    ] {
        let refused = place.call(line);
        assert_eq!(refused.code, 1, "{line}: {}", refused.out);
        assert!(
            refused.err.contains("is damaged") && refused.err.contains("salvage"),
            "{line}: {}",
            refused.err
        );
    }
    let salvaged = place.json("store salvage --json");
    assert_eq!(salvaged["studies"], 1);
    assert!(place.path(salvaged["former_database"].as_str().unwrap()).exists());
    let run = place.call("run small.toml --workers 1 --json");
    assert_eq!(run.code, 0, "{}", run.err);
    let summary: Value = serde_json::from_str(run.out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["run"]["cached"], salvaged["kept"]);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

#[test]
fn compact_removes_what_nothing_refers_to() {
    let place = Place::run();
    let before = place.call("query small --format csv").out;
    assert_eq!(place.call("run small.toml --workers 1").code, 0);
    // An edited study leaves its former definition behind.
    place.write("small.toml", SMALL.replace("Does it slip?", "Does it stick?"));
    assert_eq!(place.call("run small.toml").code, 0);
    insta::assert_snapshot!(place.transcript(&[
        &["store", "verify"],
        &["store", "compact"],
        &["store", "compact"],
        &["store", "verify"],
        &["store", "salvage"],
        &["store", "verify"],
    ]));
    assert_eq!(place.call("query small --format csv").out, before);
}

#[test]
fn a_directory_of_other_things_is_not_a_store() {
    let place = Place::with("small.toml", SMALL);
    fs::create_dir(place.path("holiday")).unwrap();
    place.write("holiday/photo.jpg", b"beach");
    let before = place.files();
    let lines: Vec<Vec<&str>> = [
        &["run", "small.toml"][..],
        &["resume", "small"],
        &["status"],
        &["query", "small"],
        &["store", "verify"],
        &["store", "compact"],
        &["store", "salvage"],
    ]
    .iter()
    .flat_map(|words| {
        ["holiday", "small.toml"].map(|store| [words, &["--store", store][..]].concat())
    })
    .collect();
    let lines: Vec<&[&str]> = lines.iter().map(Vec::as_slice).collect();
    insta::assert_snapshot!(place.transcript(&lines));
    for words in lines {
        assert_eq!(place.words(words).code, 1, "{words:?}");
    }
    assert_eq!(place.files(), before);
}

/// A process that does not outlive its test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_store_in_use_is_read_through_the_run() {
    // There is far more work than the test waits for: the test ends the run.
    let many = SMALL
        .replace("mesh = 6", "mesh = 96")
        .replace("[0.05, 0.2, 0.6]", "{ from = 0.05, to = 0.6, count = 2000 }");
    let place = Place::with("many.toml", many.replace("\"small\"", "\"many\""));
    place.write("small.toml", SMALL);
    let log = place.path("events.jsonl");
    let words = ["run", "many.toml", "--workers", "1", "--json"];
    let mut run = Running(
        place
            .command(&words)
            .stdout(fs::File::create(&log).unwrap())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let deadline = Instant::now() + Duration::from_secs(60);
    while !fs::read_to_string(&log).unwrap().contains("\"committed\"") {
        assert!(
            Instant::now() < deadline && run.0.try_wait().unwrap().is_none(),
            "the run commits nothing"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    insta::assert_snapshot!(place.transcript(&[
        &["run", "small.toml"],
        &["resume", "many"],
        &["store", "salvage"]
    ]));

    let served = format!("served by the running process {} (", run.0.id());
    let status = place.call("status --json");
    assert!(status.err.starts_with(&served), "{}", status.err);
    let listed: Value = serde_json::from_str(&status.out).unwrap();
    assert_eq!(
        (&listed[0]["study"], &listed[0]["progress"]["points"]),
        (&"many".into(), &4000.into())
    );
    assert!(listed[0]["progress"]["done"].as_u64().unwrap() > 0);
    let query = place.words(&[
        "query",
        "many",
        "--where",
        "status == \"certified\"",
        "--select",
        "key",
        "--format",
        "csv",
    ]);
    assert!(query.err.starts_with(&served), "{}", query.err);
    let key = query.out.lines().nth(1).expect("one result is there").to_owned();
    let shown = place.words(&["show", &key, "--field", "pressure"]);
    assert_eq!((shown.code, shown.err.starts_with(&served)), (0, true), "{}", shown.err);
    assert_eq!(place.json("plan many.toml --json")["points"], 4000);
    let verified = place.call("store verify --json");
    assert_eq!((verified.code, verified.err.starts_with(&served)), (0, true), "{}", verified.err);
    let exported = place.call("store export copy.tribosweep --json");
    assert_eq!(exported.code, 0, "{}", exported.err);
    let exported: Value = serde_json::from_str(&exported.out).unwrap();
    assert_eq!(
        place.json("store verify --json --store copy.tribosweep")["records"],
        exported["added"]
    );

    let interrupted =
        Command::new("sh").args(["-c", &format!("kill -INT {}", run.0.id())]).status().unwrap();
    assert!(interrupted.success());
    assert_eq!(run.0.wait().unwrap().code(), Some(130));
    let mut err = String::new();
    run.0.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!(err, "");
    let text = fs::read_to_string(&log).unwrap();
    let summary: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    assert_eq!(
        (&summary["event"], &summary["run"]["interrupted"]),
        (&"summary".into(), &true.into())
    );
    // Every result that was reported done is there, and the store is free again.
    let done = text.lines().filter(|line| line.contains("\"event\":\"done\"")).count();
    assert_eq!(place.json("status --json")[0]["progress"]["done"], done);
    assert_eq!(place.json("plan many.toml --json")["cached"], done);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

/// What a finished run says is kept, and said again without opening the database.
#[test]
fn a_finished_study_is_not_read_again_until_something_changes() {
    let place = Place::run();
    let said = |line: &str| {
        let said = place.call(line);
        assert_eq!(said.code, 0, "{}", said.err);
        said.out
    };
    let log = place.path(".tribosweep/records/db");
    let changed = || fs::metadata(&log).unwrap().modified().unwrap();
    let (before, again) = (changed(), said("run small.toml"));
    assert!(again.contains("6 certified"), "{again}");
    let json = place.json("run small.toml --json");
    assert_eq!(json["run"]["cached"], 6);
    let status = place.json("status --json");
    assert_eq!(changed(), before, "nobody has opened the database for writing");
    let proved = place.json("store verify --json");
    assert_eq!(proved["kept_counts"], serde_json::json!({ "proved": 1, "notes": [] }));

    // Without the words everything is read, and says the same.
    fs::remove_file(place.path(".tribosweep/kept")).unwrap();
    assert_eq!(place.json("status --json"), status);
    assert_eq!(said("run small.toml"), again);
    assert!(changed() > before);
    // A figure that is gone is drawn again, and another study is another one.
    let figure = place.path(".tribosweep/figures/small.svg");
    let drawn = fs::read(&figure).unwrap();
    fs::remove_file(&figure).unwrap();
    assert_eq!(said("run small.toml"), again);
    assert_eq!(fs::read(&figure).unwrap(), drawn);
    place.write("small.toml", SMALL.replace("0.6]", "0.5, 0.6]"));
    assert!(said("run small.toml --workers 2").contains("2 of 8 jobs computed"));
    assert_eq!(place.json("status --json")[0]["progress"]["points"], 8);
}

/// A run that has results left to compute, or results that failed, is not taken for finished.
#[test]
fn an_unfinished_study_is_examined_by_every_run() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(place.call("run small.toml --workers 1 --max-jobs 4").code, 75);
    assert_eq!(place.json("status --json")[0]["progress"]["left"], 2);
    // The rest comes by way of another study, which shares its points.
    let shared = SMALL.replace("\"small\"", "\"shared\"");
    place.write("shared.toml", shared);
    assert_eq!(place.call("run shared.toml --workers 1").code, 0);
    assert_eq!(place.json("status small --json")[0]["progress"]["left"], 0);
    let again = place.call("run small.toml").out;
    assert!(again.contains("0 of 6 jobs computed"), "{again}");
}
