//! The origin of results: every record names its run, whose account travels with it and may be
//! lost without harm.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use store::{Digest, Store};
use study::Record;

use crate::place::{ONE, Place, SMALL};

fn host() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

/// Returns what `show --json` says of the origin of the first result.
fn origin(place: &Place) -> Value {
    let key = place.keys().remove(0);
    place.json(&format!("show {key} --json"))["provenance"].clone()
}

#[test]
fn every_result_names_the_run_that_computed_it() {
    let place = Place::run();
    let said = origin(&place);
    assert_eq!(said["command"], json!(["tribosweep", "run", "small.toml", "--workers", "2"]));
    assert_eq!(said["program"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(said["machine"]["host"], host());
    assert!(said["machine"]["cores"].as_u64().unwrap() > 0);
    assert!(!said["machine"]["processor"].as_str().unwrap().is_empty());
    assert!(said["machine"]["system"].as_str().unwrap().contains("Linux"));
    let file = json!({
        "name": "small.toml",
        "blake3": Digest::of(SMALL.as_bytes()).to_string(),
        "bytes": SMALL.len(),
    });
    assert_eq!((&said["study"]["name"], &said["study"]["file"]), (&json!("small"), &file));
    assert_eq!(said["study"]["files"], json!([]));
    // It is kept once for all six results.
    assert_eq!(place.accounts().len(), 1);
    assert_eq!(place.json("store compact --json")["files"], 0);

    let key = place.keys().remove(0);
    let shown = place.call(&format!("show {key}")).out;
    for line in [
        "command              tribosweep run small.toml --workers 2".to_owned(),
        format!("host                 {}", host()),
        format!("study_file           small.toml, {} B, blake3 ", SMALL.len()),
        "definition           blake3 ".to_owned(),
    ] {
        assert!(shown.contains(&format!("\n  {line}")), "{line}: {shown}");
    }
}

#[test]
fn results_are_found_by_what_computed_them() {
    let place = Place::run();
    let rows = |filter: &str| {
        let line = ["query", "small", "--select", "run,commit,host,processor", "--json"];
        let said = place.words(&[&line[..], &["--where", filter]].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        serde_json::from_str::<Value>(&said.out).unwrap()["rows"].as_array().unwrap().clone()
    };
    let found = rows(&format!("host == \"{}\"", host()));
    assert_eq!(found.len(), 6);
    assert!(found.iter().all(|row| *row == found[0]), "{found:?}");
    let run = found[0]["run"].as_str().unwrap();
    assert_eq!(rows(&format!("run == '{run}'")).len(), 6);
    assert_eq!(rows("host == 'elsewhere'").len(), 0);
    // The file of a table says it in its metadata.
    assert_eq!(place.call("query small --format parquet --output small.parquet").code, 0);
    let bytes = fs::read(place.path("small.parquet")).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    for part in ["tribosweep.provenance", run, &format!("\"host\":\"{}\"", host())] {
        assert!(text.contains(part), "{part}");
    }
    // What a study chooses must not depend on where it is computed.
    let bisect = "\n[bisect]\naxis = \"friction.mu\"\non = \"host == 'a'\"\nto = \"1%\"\n";
    place.write("chosen.toml", format!("{SMALL}{bisect}"));
    let refused = place.call("plan chosen.toml");
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("`host` says by whom a result was computed"), "{}", refused.err);
}

#[test]
fn a_study_that_is_resumed_from_the_store_has_no_file() {
    let place = Place::run();
    let before = origin(&place);
    let keys: Vec<identity::JobKey> = place.keys()[..2]
        .iter()
        .map(|key| identity::JobKey(key.parse::<Digest>().unwrap().0))
        .collect();
    let store = Store::open(&place.path(".tribosweep")).unwrap();
    assert_eq!(store.remove(&keys).unwrap(), 2);
    drop(store);
    assert_eq!(place.call("resume small").code, 0);
    let said = origin(&place);
    assert_eq!(said["command"], json!(["tribosweep", "resume", "small"]));
    assert_eq!(said["study"]["file"], Value::Null);
    assert_eq!(said["study"]["definition"], before["study"]["definition"]);
    assert_eq!(place.accounts().len(), 2);
    // The page lists both runs.
    assert_eq!(place.call("report small").code, 0);
    let page = fs::read_to_string(place.path("small.html")).unwrap();
    for part in ["tribosweep run small.toml --workers 2", "tribosweep resume small", "2 jobs"] {
        assert!(page.contains(part), "{part}");
    }
}

/// No result is lost, and none is computed again, whatever becomes of the account.
#[test]
fn an_account_that_is_lost_or_damaged_costs_no_result() {
    for damage in [None, Some(&b"rubbish"[..])] {
        let place = Place::run();
        let key = place.keys().remove(0);
        let account = place.accounts().remove(0);
        match damage {
            None => fs::remove_file(&account).unwrap(),
            Some(bytes) => fs::write(&account, bytes).unwrap(),
        }
        let verified = place.call("store verify");
        assert_eq!(verified.code, 0, "{}", verified.out);
        assert!(
            verified.out.contains("all sound\nnote: the account of a run, file "),
            "{}",
            verified.out
        );
        assert!(
            verified.out.contains("6 results do not say what computed them"),
            "{}",
            verified.out
        );
        let json = place.json("store verify --json");
        assert_eq!((&json["sound"], &json["faults"]), (&json!(true), &json!([])));
        assert_eq!(json["provenance_notes"].as_array().unwrap().len(), 1);
        assert_eq!(place.json("run small.toml --json")["run"]["computing"], 0);
        let shown = place.call(&format!("show {key}"));
        assert_eq!(shown.code, 0);
        assert!(shown.out.contains("is lost or damaged"), "{}", shown.out);
        assert!(place.call("query small --select host,load --format csv").out.contains("\n,"));
        assert_eq!(place.call("report small").code, 0);
        assert!(
            fs::read_to_string(place.path("small.html"))
                .unwrap()
                .contains("Of 6 jobs the run is not known")
        );
        for target in ["merged", "merged.tribosweep"] {
            let merged = place.call(&format!("store merge .tribosweep --into {target}"));
            assert_eq!((merged.code, merged.err.as_str()), (0, ""));
            assert_eq!(
                merged.out.matches("note: the account of a run").count(),
                1,
                "{}",
                merged.out
            );
            assert_eq!(place.json(&format!("store verify --json --store {target}"))["records"], 6);
        }
        let ran = place.call("run small.toml --export exports --workers 1");
        assert_eq!((ran.code, ran.err.contains("not whole")), (0, false), "{}", ran.err);
        assert_eq!(place.json("store salvage --json")["kept"], 6);
        assert_eq!(place.json("run small.toml --json")["run"]["computing"], 0);
    }
}

#[test]
fn a_record_without_a_run_says_that_it_is_unknown() {
    let place = Place::run();
    let key = place.keys().remove(0);
    let store = Store::open(&place.path(".tribosweep")).unwrap();
    let job = identity::JobKey(key.parse::<Digest>().unwrap().0);
    let mut record = Record::decode(&store.get(&job).unwrap().unwrap()).unwrap();
    record.provenance.run = None;
    store.commit(&[(job, record.encode())]).unwrap();
    drop(store);
    let shown = place.call(&format!("show {key}"));
    assert!(shown.out.contains("unknown: the record names no run"), "{}", shown.out);
    assert!(origin(&place)["unknown"].as_str().unwrap().starts_with("unknown"));
    let rows = place.call("query small --select run,host --format csv").out;
    assert_eq!(rows.lines().filter(|line| *line == ",").count(), 1, "{rows}");
    assert_eq!(place.json("store verify --json")["provenance_notes"], json!([]));
}

/// The words of a command line may hold anything that a file name may.
#[test]
fn a_command_line_is_kept_as_it_is_and_shown_escaped() {
    let place = Place::empty();
    let name = "a b\u{1b}[2J'\".toml";
    place.write(name, SMALL);
    assert_eq!(place.words(&["run", name, "--workers", "1"]).code, 0);
    assert_eq!(origin(&place)["command"][2], name);
    let key = place.keys().remove(0);
    for line in
        [format!("show {key}"), format!("show {key} --json"), "report small --json".to_owned()]
    {
        assert!(!place.call(&line).out.contains('\u{1b}'), "{line}");
    }
    assert!(!fs::read_to_string(place.path("small.html")).unwrap().contains('\u{1b}'));
}

#[test]
fn every_file_that_a_study_names_has_its_digest() {
    let place = Place::with("one.toml", ONE);
    let map = "0,0,0,0\n0,1,1,0\n0,1,1,0\n0,0,0,0\n";
    place.write("rough.csv", map);
    let said = place.call("solve one.toml --json");
    assert!([0, 2].contains(&said.code), "{}", said.err);
    let solved: Value = serde_json::from_str(&said.out).unwrap();
    let files = solved["provenance"]["study"]["files"].as_array().unwrap();
    let [file] = &files[..] else { panic!("{files:?}") };
    assert_eq!(file["blake3"], Digest::of(map.as_bytes()).to_string());
    assert_eq!(
        solved["provenance"]["command"],
        json!(["tribosweep", "solve", "one.toml", "--json"])
    );
    let file = &solved["provenance"]["study"]["file"];
    assert_eq!(file["blake3"], Digest::of(ONE.as_bytes()).to_string());
}

#[test]
fn accounts_travel_with_shards_exports_and_merges() {
    let place = Place::with("small.toml", SMALL);
    for shard in ["1/2", "2/2"] {
        let said =
            place.call(&format!("run small.toml --shard {shard} --export exports --workers 1"));
        assert_eq!(said.code, 0, "{}", said.err);
    }
    assert_eq!(place.call("store merge exports --into .tribosweep").code, 0);
    assert_eq!(place.call("store export all.tribosweep").code, 0);
    assert_eq!(place.accounts().len(), 2);
    assert!(place.accounts().iter().all(|path| Path::exists(path)));
    let rows = |store: &str| {
        let said = place
            .call(&format!("query small --select run,host,commit --format csv --store {store}"));
        assert_eq!(said.code, 0, "{}", said.err);
        said.out
    };
    let merged = rows(".tribosweep");
    assert_eq!(merged.matches(&host()).count(), 6, "{merged}");
    for store in ["exports", "all.tribosweep"] {
        assert_eq!(rows(store), merged, "{store}");
    }
    assert_eq!(place.json("store verify --json --store exports")["provenance_notes"], json!([]));
}
