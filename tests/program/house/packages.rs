//! What a registry and an archive want to know of the packages of the workspace, and that all
//! files that name the version name the same.

use std::process::Command;

use serde_json::Value;

use super::assert_none;
use super::source::root;

/// Returns what Cargo knows of the packages of the workspace.
fn members() -> Vec<Value> {
    let done = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--locked", "--format-version", "1"])
        .current_dir(root())
        .output()
        .expect("cargo can be run");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let metadata: Value = serde_json::from_slice(&done.stdout).expect("cargo writes JSON");
    metadata["packages"].as_array().expect("a workspace has packages").clone()
}

fn read(file: &str) -> String {
    let read = std::fs::read_to_string(root().join(file));
    read.unwrap_or_else(|error| panic!("{file} cannot be read: {error}"))
}

/// Returns the rest of the first line that begins with a text.
fn after<'a>(text: &'a str, beginning: &str) -> Option<&'a str> {
    text.lines().find_map(|line| line.trim_start().strip_prefix(beginning)).map(str::trim)
}

#[test]
fn every_file_that_names_the_version_names_the_same() {
    let version = env!("CARGO_PKG_VERSION");
    let mut named: Vec<(String, String)> = Vec::new();
    for member in members() {
        let name = member["name"].as_str().unwrap().to_owned();
        named.push((name.clone(), member["version"].as_str().unwrap().to_owned()));
        for dependency in member["dependencies"].as_array().unwrap() {
            if !dependency["path"].is_null() {
                // Packages of one release belong together, so none takes another's later one.
                let wanted = dependency["req"].as_str().unwrap().trim_start_matches('=');
                named.push((format!("{name} for {}", dependency["name"]), wanted.to_owned()));
            }
        }
    }
    let metadata: Value = serde_json::from_str(&read("codemeta.json")).expect("it is JSON");
    named.push(("codemeta.json".to_owned(), metadata["version"].as_str().unwrap().to_owned()));
    for (file, beginning) in [
        ("CITATION.cff", "version:"),
        ("containers/tribosweep.def", "org.opencontainers.image.version"),
    ] {
        let said = read(file);
        let said = after(&said, beginning).unwrap_or_default().trim_matches('"').to_owned();
        named.push((file.to_owned(), said));
    }
    assert!(read("python/pyproject.toml").contains("dynamic = [\"version\"]"));
    let differ: Vec<String> = named
        .into_iter()
        .filter(|(_, said)| said != version)
        .map(|(place, said)| format!("{place} has `{said}`, the program {version}"))
        .collect();
    assert_none("one release has one version", &differ);
}

#[test]
fn every_package_says_what_a_registry_asks_for() {
    let mut lacking = Vec::new();
    for member in members() {
        let name = member["name"].as_str().unwrap();
        if member["publish"].as_array().is_some_and(Vec::is_empty) {
            assert_eq!(name, "tribosweep-python", "all but the wheel's part can be published");
            continue;
        }
        if name != "tribosweep" && !name.starts_with("tribosweep-") {
            lacking.push(format!("{name} has no name that is the project's own"));
        }
        for field in ["description", "license", "repository", "readme", "rust_version"] {
            if member[field].as_str().is_none_or(str::is_empty) {
                lacking.push(format!("{name} has no `{field}`"));
            }
        }
        for (field, most) in [("keywords", 5), ("categories", 5)] {
            let words = member[field].as_array().unwrap();
            if words.is_empty() || words.len() > most {
                lacking.push(format!("{name} has {} {field}, not 1 to {most}", words.len()));
            }
            if words.iter().any(|word| field == "keywords" && word.as_str().unwrap().len() > 20) {
                lacking.push(format!("{name} has a keyword of more than 20 characters"));
            }
        }
        let place = std::path::Path::new(member["manifest_path"].as_str().unwrap());
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let whole = read(licence);
            if std::fs::read_to_string(place.with_file_name(licence)).ok() != Some(whole) {
                lacking.push(format!("{name} does not bring the text {licence}"));
            }
        }
    }
    assert_none("a registry takes every package", &lacking);
}
