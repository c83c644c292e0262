//! Studies are removed and compared, get tags and notes; what none refers to is collected.

use std::collections::BTreeSet;
use std::fs;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use identity::JobKey;
use serde_json::Value;
use store::{ReadError, Store, StoreReader};
use study::Record;
use study::job::PHYSICS_VERSION;

use crate::place::{Place, SMALL};

/// A second study, which shares three of the six points of the small one.
fn shared() -> String {
    SMALL.replace("\"small\"", "\"shared\"").replace("[0.0, 0.3]", "[0.3]")
}

fn keys_in_store(place: &Place) -> BTreeSet<JobKey> {
    Store::read(&place.path(".tribosweep")).unwrap().keys().unwrap().into_iter().collect()
}

/// Returns the records of a store as an earlier version of the physics would have left them.
fn earlier_records(reader: &StoreReader) -> Vec<(JobKey, Vec<u8>)> {
    let earlier = |(_, bytes): (JobKey, Result<Vec<u8>, ReadError>)| {
        let mut record = Record::decode(&bytes.unwrap()).unwrap();
        record.physics = PHYSICS_VERSION - 1;
        (record.key(), record.encode())
    };
    reader.records().unwrap().map(earlier).collect()
}

#[test]
fn a_removed_study_leaves_what_others_share() {
    let place = Place::run();
    place.write("shared.toml", shared());
    assert_eq!(place.call("run shared.toml --workers 2").code, 0);
    assert_eq!(keys_in_store(&place).len(), 6);
    let before = place.call("query shared --format csv").out;
    insta::assert_snapshot!(place.transcript(&[
        &["rm", "smal"],
        &["rm", "unheard-of"],
        &["rm", "small", "smal"],
        &["rm", "small", "--dry-run"],
        &["status"],
        &["rm", "small"],
        &["status"],
        &["query", "small"],
    ]));
    assert_eq!(keys_in_store(&place).len(), 6, "results stay until they are collected");

    let listed = place.json("store gc --dry-run --json");
    assert_eq!(listed["removed"], false);
    let unused = listed["results"].as_array().unwrap();
    assert_eq!(unused.len(), 3);
    assert!(unused.iter().all(|result| result["bytes"].as_u64().unwrap() > 500), "{unused:?}");
    assert_eq!(listed["files"].as_array().unwrap().len(), 1, "the definition of the study");
    assert_eq!(keys_in_store(&place).len(), 6, "a dry run removes nothing");
    let said = place.call("store gc");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.starts_with("3 results that no study refers to, "), "{}", said.out);
    assert!(said.out.contains("tribosweep run small.toml --workers 2"), "{}", said.out);
    assert!(said.out.contains("\nremoved 3 results and "), "{}", said.out);
    assert_eq!(keys_in_store(&place).len(), 3);
    assert_eq!(place.call("query shared --format csv").out, before);
    let verified = place.json("store verify --json");
    assert_eq!((&verified["sound"], &verified["unreferenced_files"]), (&true.into(), &0.into()));
    assert_eq!(verified["provenance_notes"], Value::Array(Vec::new()));
    assert_eq!(place.call("store gc").out, "nothing to remove\n");

    // What is wanted again is computed again.
    let again = place.call("run small.toml --workers 2 --json");
    let again: Value = serde_json::from_str(again.out.lines().last().unwrap()).unwrap();
    assert_eq!((&again["run"]["computing"], &again["run"]["cached"]), (&3.into(), &3.into()));
}

#[test]
fn a_collection_has_limits_of_age_and_size() {
    let place = Place::with("large.toml", SMALL.replace("mesh = 6", "mesh = 40"));
    assert_eq!(place.call("run large.toml --workers 2").code, 0);
    place.write("small.toml", SMALL);
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    place.write("tiny.toml", shared().replace("mesh = 6", "mesh = 7"));
    assert_eq!(place.call("run tiny.toml --workers 2").code, 0);
    assert_eq!(place.call("rm small").code, 0);
    let count = |line: &str| {
        let found = place.json(line);
        (
            found["results"].as_array().unwrap().len(),
            found["files_of_results"].as_array().unwrap().len(),
        )
    };
    // The coarse results have their fields in them, the fine ones have files. The account of a run
    // goes with its last result.
    assert_eq!(count("store gc --dry-run --json"), (12, 8));
    assert_eq!(count("store gc --dry-run --json --older-than 1h"), (0, 0));
    assert_eq!(count("store gc --dry-run --json --older-than 0s --larger-than 12KiB"), (6, 7));
    assert_eq!(count("store gc --dry-run --json --larger-than 1GB"), (0, 0));
    assert_eq!(place.call("store gc --larger-than 12KiB").code, 0);
    assert_eq!(keys_in_store(&place).len(), 9);
    assert_eq!(place.json("store verify --json")["sound"], true);
    assert_eq!(count("store gc --dry-run --json"), (6, 1));
    insta::assert_snapshot!(place.transcript(&[
        &["store", "gc", "--older-than", "30"],
        &["store", "gc", "--larger-than", "big"],
        &["store", "gc", "--store", "nowhere"],
    ]));
}

#[test]
fn what_has_no_known_age_is_not_older() {
    let place = Place::run();
    let store = Store::open(&place.path(".tribosweep")).unwrap();
    let undated = |(key, bytes): (JobKey, Result<Vec<u8>, ReadError>)| {
        let mut record = Record::decode(&bytes.unwrap()).unwrap();
        record.provenance.finished = 0;
        (key, record.encode())
    };
    let records: Vec<_> = store.records().take(2).map(undated).collect();
    store.commit(&records).unwrap();
    drop(store);
    assert_eq!(place.call("rm small").code, 0);
    let found = |line: &str| place.json(line)["results"].as_array().unwrap().len();
    assert_eq!(found("store gc --dry-run --json --older-than 0s"), 4);
    assert_eq!(found("store gc --dry-run --json"), 6);
    let said = place.call("store gc --dry-run").out;
    assert!(said.contains("\n1 file goes with them\n"), "{said}");
}

/// A database elsewhere would be left there, whole, and a smaller one put into the store.
#[test]
fn a_linked_database_is_not_collected() {
    let place = Place::run();
    assert_eq!(place.call("rm small").code, 0);
    let records = place.path(".tribosweep/records");
    fs::rename(&records, place.path("elsewhere")).unwrap();
    std::os::unix::fs::symlink(place.path("elsewhere"), &records).unwrap();
    let said = place.call("store gc");
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.err.contains("records is a symbolic link"), "{}", said.err);
    assert_eq!(keys_in_store(&place).len(), 6);
}

/// A study that chooses its points refers to all that its choice has.
#[test]
fn points_that_a_study_chose_are_kept() {
    let found =
        "[find]\naxis = \"friction.mu\"\ncolumn = \"stick_fraction\"\nvalue = 0.5\nto = \"1%\"\n";
    let refined = "[refine]\non = \"load\"\nuntil = \"0.1%\"\nat_most = 24\n";
    for rule in [refined, found] {
        let place = Place::with("small.toml", format!("{SMALL}\n{rule}"));
        let run = place.call("run small.toml --workers 2");
        assert!([0, 2].contains(&run.code), "{}", run.err);
        let all = keys_in_store(&place);
        assert!(all.len() > 6, "the study has chosen points: {}", all.len());
        assert_eq!(place.call("store gc").out, "nothing to remove\n");
        assert_eq!(keys_in_store(&place), all);
        assert_eq!(place.json("run small.toml --json")["run"]["cached"], all.len());
    }
}

/// The choice of a study stops where a result is missing. What it had chosen beyond is kept.
#[test]
fn what_an_unfinished_study_may_choose_is_kept() {
    let found =
        "[find]\naxis = \"friction.mu\"\ncolumn = \"stick_fraction\"\nvalue = 0.5\nto = \"5%\"\n";
    let refined = "[refine]\non = \"load\"\nuntil = \"0.1%\"\nat_most = 24\n";
    for rule in [refined, found] {
        let place = Place::with("small.toml", format!("{SMALL}\n{rule}"));
        let run = place.call("run small.toml --workers 2");
        assert!([0, 2].contains(&run.code), "{}", run.err);
        let all = keys_in_store(&place);
        let mut awaited = 0;
        for key in &all {
            let store = Store::open(&place.path(".tribosweep")).unwrap();
            let record = store.get(key).unwrap().unwrap();
            store.remove(&[*key]).unwrap();
            drop(store);
            let found = place.json("store gc --dry-run --json");
            assert_eq!(found["results"], Value::Array(Vec::new()), "{found}");
            let kept = &found["kept_for_unfinished_studies"]["small"]["results"];
            awaited += kept.as_u64().unwrap_or(0);
            Store::open(&place.path(".tribosweep")).unwrap().commit(&[(*key, record)]).unwrap();
        }
        assert!(awaited > 0, "some result decides about others");
    }
}

/// `diff` holds results of earlier physics against those of this one.
#[test]
fn results_of_earlier_physics_stay_unless_they_are_given_up() {
    let refined = "[refine]\non = \"load\"\nuntil = \"0.1%\"\nat_most = 24\n";
    for rule in ["", refined] {
        let place = Place::with("small.toml", format!("{SMALL}\n{rule}"));
        let run = place.call("run small.toml --workers 2");
        assert!([0, 2].contains(&run.code), "{}", run.err);
        let reader = Store::read(&place.path(".tribosweep")).unwrap();
        let earlier: Vec<(JobKey, Vec<u8>)> = earlier_records(&reader);
        let definition = reader.study("small").unwrap().unwrap();
        drop(reader);
        let before = Store::open(&place.path("before")).unwrap();
        before.commit(&earlier).unwrap();
        before.put_study("small", &definition).unwrap();
        drop(before);
        Store::open(&place.path(".tribosweep")).unwrap().commit(&earlier).unwrap();
        let current = keys_in_store(&place).len() - earlier.len();
        for (store, all) in [(".tribosweep", 2 * current), ("before", current)] {
            let keys = || Store::read(&place.path(store)).unwrap().keys().unwrap().len();
            let said = place.call(&format!("store gc --store {store}"));
            let stay = format!("{current} results of earlier versions of the physics, ");
            assert!(said.out.starts_with(&stay), "{}", said.out);
            assert!(said.out.ends_with("nothing to remove\n"), "{}", said.out);
            assert_eq!(keys(), all);
            let said = place.call(&format!("store gc --earlier-physics --store {store}"));
            assert!(said.out.starts_with(&stay), "{}", said.out);
            assert_eq!(keys(), all - current);
        }
    }
}

#[test]
fn what_cannot_be_understood_is_not_removed() {
    let place = Place::run();
    place.write("shared.toml", shared());
    assert_eq!(place.call("run shared.toml --workers 2").code, 0);
    assert_eq!(place.call("rm shared").code, 0);
    // A record of another version may refer to any file.
    let key = JobKey([0xee; 32]);
    Store::open(&place.path(".tribosweep")).unwrap().commit(&[(key, vec![1, 1, 0])]).unwrap();
    let before = place.files();
    let listed = place.json("store gc --dry-run --json");
    assert_eq!(listed["unread_records"], 1);
    assert_eq!(place.files(), before);
    assert!(place.call("store gc").out.contains("1 record cannot be read"));
    assert!(keys_in_store(&place).contains(&key));
    let blobs = |files: &[(std::path::PathBuf, Vec<u8>)]| {
        files.iter().filter(|(path, _)| path.extension().is_some_and(|e| e == "zst")).count()
    };
    assert_eq!(blobs(&place.files()), blobs(&before));

    // The needs of a study whose definition is damaged are not known. It can be given up.
    let place = Place::run();
    let (_, study) = place.blobs();
    fs::write(study, b"rubbish").unwrap();
    let said = place.call("store gc");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("nobody knows what the study `small` needs"), "{}", said.err);
    assert_eq!(keys_in_store(&place).len(), 6);
    assert_eq!(place.call("rm small").code, 0);
    assert_eq!(place.json("store gc --json")["results"].as_array().unwrap().len(), 6);
    assert!(keys_in_store(&place).is_empty());
}

#[test]
fn a_store_that_a_run_has_is_left_alone() {
    let place = Place::run();
    let slow = SMALL.replace("\"small\"", "\"slow\"").replace("mesh = 6", "mesh = 128");
    place.write("slow.toml", slow);
    let mut run: Child = place
        .command(&["run", "slow.toml", "--workers", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !place.call("status").out.contains("slow") {
        assert!(start.elapsed() < Duration::from_secs(60), "the run does not begin");
        std::thread::sleep(Duration::from_millis(20));
    }
    let lines: &[&[&str]] =
        &[&["rm", "small"], &["store", "gc"], &["tag", "small", "x"], &["note", "small", "x"]];
    let said: Vec<_> = lines.iter().map(|words| place.words(words)).collect();
    let looked: Vec<_> = [&["rm", "small", "--dry-run"][..], &["store", "gc", "--dry-run"]]
        .iter()
        .map(|words| place.words(words))
        .collect();
    rustix::process::kill_process(
        rustix::process::Pid::from_child(&run),
        rustix::process::Signal::TERM,
    )
    .unwrap();
    run.wait().unwrap();
    for (said, words) in said.iter().zip(lines) {
        assert_eq!(said.code, 1, "{words:?}: {}", said.out);
        assert!(said.err.contains("is in use by process"), "{words:?}: {}", said.err);
    }
    assert!(looked.iter().all(|said| said.code == 0));
    assert!(place.call("status").out.contains("small"));
}

#[test]
fn tags_and_notes_are_shown_wherever_a_study_is() {
    let place = Place::run();
    let plain = place.call("status").out;
    place.words(&["note", "small", "mesh 6 is enough\nsee \u{1b}[2Jfigure 3"]);
    insta::assert_snapshot!(place.transcript(&[
        &["tag", "small", "paper", "draft"],
        &["tag", "small", "paper"],
        &["tag", "small", "two words"],
        &["tag", "smal", "x"],
        &["tag", "small", "--remove", "final"],
        &["note", "small"],
        &["status"],
        &["answer", "small"],
        &["tag", "small", "--remove", "draft"],
        &["note", "small", ""],
        &["tag", "small"],
        &["note", "small", "--remove"],
        &["note", "smal"],
    ]));
    place.call("note small remark");
    let listed = place.json("status --json");
    assert_eq!((&listed[0]["tags"][0], &listed[0]["note"]), (&"paper".into(), &"remark".into()));
    let answer = place.json("answer small --json");
    assert_eq!((&answer["tags"][0], &answer["note"]), (&"paper".into(), &"remark".into()));
    assert_eq!(place.call("report small").code, 0);
    let page = fs::read_to_string(place.path("small.html")).unwrap();
    assert!(page.contains("Tags: paper.") && page.contains("Note: remark"));
    // A run, a salvage and a collection leave them.
    for line in ["run small.toml", "store salvage", "store gc"] {
        assert_eq!(place.call(line).code, 0, "{line}");
        assert_eq!(place.json("tag small --json")["tags"][0], "paper", "{line}");
    }
    place.call("tag small --remove");
    place.call("note small --remove");
    assert_eq!(place.call("status").out, plain);
    let manifest = fs::read_to_string(place.path(".tribosweep/manifest.json")).unwrap();
    assert!(manifest.contains("\"format\": 1,"), "an earlier program reads it: {manifest}");
}

#[test]
fn studies_are_held_against_each_other() {
    let place = Place::run();
    let finer = SMALL.replace("\"small\"", "\"finer\"").replace("mesh = 6", "mesh = 8");
    place.write("finer.toml", finer.replace("[0.0, 0.3]", "[0.3, 0.4]"));
    assert_eq!(place.call("run finer.toml --workers 2").code, 0);
    let other = SMALL.replace("\"small\"", "\"other\"");
    place.write("other.toml", other.replace("[0.0, 0.3]", "[0.2, 0.4]"));
    assert_eq!(place.call("run other.toml --workers 2").code, 0);
    // A study without results.
    let definition = Store::read(&place.path(".tribosweep")).unwrap().study("small").unwrap();
    let none = Store::open(&place.path("none")).unwrap();
    none.put_study("small", &definition.unwrap()).unwrap();
    drop(none);
    insta::assert_snapshot!(place.transcript(&[
        &["diff", "small", "small"],
        &["diff", "small", "finer", "--select", "load,stick_elements,status"],
        &["diff", "small", "finer", "--select", "load,status", "--tolerance", "50%", "--common"],
        &["diff", "small", "finer", "--select", "load", "--format", "csv"],
        &["diff", "small"],
        &["diff", "small", "fine"],
        &["diff", "small", "finer", "--select", "lod"],
        &["diff", "small", "finer", "--tolerance", "much"],
        &["diff", "small", "--other", "nowhere"],
        &["diff", "small", "other", "--select", "load", "--common"],
        &["diff", "small", "small", "--select", "load", "--tolerance", "0"],
        &["diff", "small", "--store", "none", "--other", "none"],
    ]));
    let found = place.json("diff small finer --json --select load,status");
    assert_eq!((&found["same"], &found["common"]), (&false.into(), &3.into()));
    assert_eq!(found["only_first"]["rows"].as_array().unwrap().len(), 3);
    let values = found["values"]["rows"].as_array().unwrap();
    assert!(values.iter().all(|row| row["difference"].as_f64().unwrap() > 1e-6), "{values:?}");
}

/// Results of an earlier physics stand under keys of their own; they are compared all the same.
#[test]
fn versions_of_the_program_are_held_against_each_other() {
    let place = Place::run();
    let reader = Store::read(&place.path(".tribosweep")).unwrap();
    let earlier = earlier_records(&reader);
    let definition = reader.study("small").unwrap().unwrap();
    let store = Store::open(&place.path("before")).unwrap();
    store.commit(&earlier).unwrap();
    store.put_study("small", &definition).unwrap();
    drop(store);
    let same = place.call("diff small --other before");
    assert_eq!(same.code, 0, "{}{}", same.out, same.err);
    let version = PHYSICS_VERSION - 1;
    let said = format!("6 points with results of version {version} of the physics");
    assert!(same.out.contains(&said), "{}", same.out);

    // One that has none at all differs in everything.
    let store = Store::open(&place.path("none")).unwrap();
    store.put_study("small", &definition).unwrap();
    drop(store);
    let differs = place.json("diff small --other none --select status,load --json");
    assert_eq!(differs["values"]["rows"].as_array().unwrap().len(), 12);
    assert_eq!(place.call("diff small --other none").code, 2);
}
