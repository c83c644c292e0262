//! `report --crate`: a study as an RO-Crate. `scripts/check-crate` holds one against the validator
//! of the format.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::place::{ONE, Place, SMALL};

/// Returns the description of an RO-Crate.
fn description(place: &Place, directory: &str) -> Value {
    let text = fs::read_to_string(place.path(directory).join("ro-crate-metadata.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn entity<'d>(description: &'d Value, id: &str) -> &'d Value {
    let graph = description["@graph"].as_array().unwrap();
    graph.iter().find(|entity| entity["@id"] == id).unwrap_or_else(|| panic!("no {id}"))
}

/// Returns the files below a directory with their bytes.
fn files(place: &Place, directory: &str) -> Vec<(String, Vec<u8>)> {
    let root = place.path(directory);
    let inside = |(path, bytes): (std::path::PathBuf, Vec<u8>)| {
        Some((path.strip_prefix(&root).ok()?.to_str()?.to_owned(), bytes))
    };
    place.files().into_iter().filter_map(inside).collect()
}

#[test]
fn a_crate_holds_the_study_and_describes_every_file() {
    let place = Place::run();
    let arguments = "--license https://creativecommons.org/licenses/by/4.0/";
    let said = place.call(&format!("report small --crate object {arguments}"));
    assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "object\n", ""));
    let names: Vec<String> = files(&place, "object").into_iter().map(|(name, _)| name).collect();
    assert_eq!(
        names,
        [
            "figures/small.svg",
            "references.bib",
            "report.html",
            "results.csv",
            "results.parquet",
            "ro-crate-metadata.json",
            "study/small.toml",
        ]
    );
    let read = |file: &str| fs::read_to_string(place.path("object").join(file)).unwrap();
    assert_eq!(read("study/small.toml"), SMALL);
    assert!(
        read("report.html").starts_with("<!DOCTYPE html>")
            || read("report.html").starts_with("<!doctype html>")
    );
    assert_eq!(read("references.bib"), place.call("cite small --format bibtex").out);
    assert_eq!(read("results.csv").lines().count(), 7);

    let described = description(&place, "object");
    assert_eq!(described["@context"], "https://w3id.org/ro/crate/1.1/context");
    let root = entity(&described, "./");
    let parts: BTreeSet<&str> = root["hasPart"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| part["@id"].as_str().unwrap())
        .collect();
    let expected: BTreeSet<&str> =
        names.iter().map(String::as_str).filter(|name| *name != "ro-crate-metadata.json").collect();
    assert_eq!(parts, expected);
    for part in parts {
        let file = entity(&described, part);
        let size = fs::metadata(place.path("object").join(part)).unwrap().len();
        assert_eq!(
            (&file["@type"], &file["contentSize"]),
            (&json!("File"), &json!(size.to_string()))
        );
    }
    assert!(root["license"]["@id"].as_str().unwrap().contains("creativecommons"));
    // The run is the action that made the results of the study file, by this program.
    let actions = root["mentions"].as_array().unwrap();
    let run = entity(&described, actions[0]["@id"].as_str().unwrap());
    assert_eq!(run["name"], "tribosweep run small.toml --workers 2");
    assert_eq!(run["object"], json!([{ "@id": "study/small.toml" }]));
    assert_eq!(run["result"].as_array().unwrap().len(), 2);
    let program = entity(&described, run["instrument"]["@id"].as_str().unwrap());
    assert_eq!(program["softwareVersion"], env!("CARGO_PKG_VERSION"));
    // The study in it runs where it lies.
    let plan = place.call("plan object/study/small.toml");
    assert!(plan.code == 0 && plan.out.contains("6"), "{}", plan.err);
}

#[test]
fn the_same_store_gives_the_same_crate() {
    let place = Place::run();
    for directory in ["one", "two"] {
        assert_eq!(place.call(&format!("report small --crate {directory}")).code, 0);
    }
    assert!(files(&place, "one") == files(&place, "two"));
    assert_eq!(place.call("store merge .tribosweep --into merged").code, 0);
    assert_eq!(place.call("report small --crate three --store merged").code, 0);
    assert!(files(&place, "one") == files(&place, "three"));
}

#[test]
fn a_crate_brings_the_files_that_a_study_names() {
    let place = Place::empty();
    let map = "0,0,0,0\n0,1,1,0\n0,1,1,0\n0,0,0,0\n";
    for directory in ["maps", "studies"] {
        fs::create_dir(place.path(directory)).unwrap();
    }
    place.write("maps/rough map.csv", map);
    let absolute = place.path("maps/rough map.csv");
    for (number, name) in ["../maps/rough map.csv", absolute.to_str().unwrap()].iter().enumerate() {
        place.write("studies/one.toml", ONE.replace("rough.csv", name));
        assert!([0, 2].contains(&place.call("run studies/one.toml --workers 1").code));
        let said = place.call(&format!("report one --crate object{number}"));
        assert_eq!(said.code, 0, "{}", said.err);
        let all = files(&place, &format!("object{number}"));
        let (path, _) = all.iter().find(|(_, bytes)| bytes == map.as_bytes()).unwrap();
        let described = description(&place, &format!("object{number}"));
        let file = entity(&described, &path.replace(' ', "%20"));
        assert_eq!(file["contentSize"], map.len().to_string());
        assert!(file["name"].as_str().unwrap().contains("rough map.csv"));
    }
}

#[test]
fn a_place_where_something_is_is_refused() {
    let place = Place::run();
    fs::create_dir(place.path("full")).unwrap();
    place.write("full/mine.txt", "mine");
    let before = place.files();
    insta::assert_snapshot!(place.transcript(&[
        &["report", "small", "--crate", "full"],
        &["report", "small", "--crate", "small.toml"],
        &["report", "small", "--crate", "no/object"],
        &["report", "large", "--crate", "object"],
        &["report", "small", "--crate", "object", "--output", "page.html"],
        &["report", "small", "--license", "https://example.org/licence"],
    ]));
    assert!(place.files() == before, "a refusal has written something");
    assert!(!Path::exists(&place.path("object")));
    // An empty directory is taken.
    fs::create_dir(place.path("empty")).unwrap();
    assert_eq!(place.call("report small --crate empty").code, 0);
    let written = place.json("report small --crate other --json --author A.Person");
    assert_eq!(written["files"].as_array().unwrap().len(), 7);
    assert_eq!(entity(&description(&place, "other"), "#author-1")["name"], "A.Person");
    let left = fs::read_dir(place.path("")).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.into_iter().all(|name| !name.to_string_lossy().starts_with(".unfinished")));
}
