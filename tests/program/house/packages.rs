//! What a registry, an archive and a packager want to know of the workspace: its packages, the one
//! version that all files name, the manual pages, how the program is linked.

#[path = "../../../build/linking.rs"]
mod linking;
#[path = "../../../build/packed_commit.rs"]
mod packed_commit;
#[path = "../../../examples/manual/pages.rs"]
mod pages;

use std::collections::{BTreeMap, BTreeSet};
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

/// Otherwise a package that lacks a feature is compiled all the same in the workspace, where another
/// asks for it, and no more by itself.
#[test]
fn a_dependency_has_the_same_features_in_every_package() {
    let mut features: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for member in members() {
        for dependency in member["dependencies"].as_array().unwrap() {
            if dependency["kind"].is_null() {
                let name = dependency["name"].as_str().unwrap().to_owned();
                let asked_for =
                    format!("{} {}", dependency["uses_default_features"], dependency["features"]);
                features.entry(name).or_default().insert(asked_for);
            }
        }
    }
    assert!(features.len() > 30, "{features:?}");
    let differing = features.into_iter().filter(|(_, lists)| lists.len() > 1);
    let names: Vec<String> = differing.map(|(name, _)| name).collect();
    assert_none("the features of a dependency stand in [workspace.dependencies]", &names);
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

/// Returns the names of a command and of all below it that are shown, as pages have them.
fn names_of(command: &clap::Command, above: &str, names: &mut Vec<String>) {
    let name = format!("{above}{}", command.get_name());
    let shown = command.get_subcommands().filter(|below| !below.is_hide_set());
    shown.for_each(|below| names_of(below, &format!("{name}-"), names));
    names.push(name);
}

#[test]
fn every_command_that_is_shown_has_a_manual_page() {
    let usage = tribosweep::usage();
    let mut names = Vec::new();
    names_of(&usage, "", &mut names);
    let pages = pages::pages(usage).unwrap();
    let files: Vec<&str> = pages.iter().map(|page| page.file.as_str()).collect();
    let wanted: Vec<String> = names.iter().map(|name| format!("{name}.1")).collect();
    assert_eq!(files, wanted);
    assert!(files.contains(&"tribosweep-store-merge.1") && !files.contains(&"tribosweep-worker.1"));
    let mut lacking = Vec::new();
    for (page, name) in pages.iter().zip(&names) {
        let text = String::from_utf8(page.text.clone()).unwrap();
        let title = format!(".TH {name} 1");
        let command = name.replace('-', " ");
        for part in [title.as_str(), ".SH SYNOPSIS", &format!("\\fB{command}\\fR"), ".SH OPTIONS"] {
            if !text.contains(part) {
                lacking.push(format!("{} has no `{part}`", page.file));
            }
        }
        if text.contains(".SH EXTRA") {
            lacking.push(format!("{} has examples without a heading", page.file));
        }
    }
    assert_none("a manual page has all its parts", &lacking);
    let run = pages.iter().find(|page| page.file == "tribosweep-run.1").unwrap();
    let run = String::from_utf8_lossy(&run.text);
    assert!(
        run.contains(".SH EXAMPLES") && run.contains(".SH NOTES") && run.contains("\\-\\-until")
    );
}

#[test]
fn a_packager_can_leave_the_addresses_to_the_linker() {
    let gnu = ["x86_64", "linux", "gnu"];
    let argument = |target, variable| linking::linker_argument(target, variable);
    assert_eq!(["", "0"].map(|off| argument(gnu, off)), [Some("-no-pie"); 2]);
    assert_eq!(["1", "yes"].map(|on| argument(gnu, on)), [None; 2]);
    for other in [["x86_64", "linux", "musl"], ["aarch64", "linux", "gnu"], ["", "", ""]] {
        assert_eq!(argument(other, ""), None, "{other:?}");
    }
    let guide = read("docs/book/src/packaging.md");
    assert!(guide.contains(&format!("{}=1", linking::VARIABLE)));
    assert!(read("build.rs").contains("rerun-if-env-changed"));
}

#[test]
fn the_commit_of_a_package_is_the_one_that_cargo_noted() {
    let commit = "0123456789abcdef0123456789abcdef01234567";
    let note = |more: &str| {
        format!(
            "{{\n  \"git\": {{\n    \"sha1\": \"{commit}\"{more}\n  }},\n  \"path_in_vcs\": \"\"\n}}"
        )
    };
    let found = |text: &str| packed_commit::packed_commit(text);
    assert_eq!(found(&note("")), Some((commit.to_owned(), "false")));
    assert_eq!(found(&note(",\n    \"dirty\": true")), Some((commit.to_owned(), "true")));
    assert_eq!(found("{}"), None);
    assert_eq!(found("{\"git\": {\"sha1\": \"no commit\"}}"), None);
}

#[test]
fn the_script_for_releases_says_which_tools_are_missing() {
    // The file that is called by that name may be a script that needs others.
    let found = Command::new("python3").args(["-c", "import sys; print(sys.executable)"]).output();
    let Some(found) = found.ok().filter(|output| output.status.success()) else {
        return crate::place::skip("there is no python3");
    };
    let python = String::from_utf8(found.stdout).unwrap();
    let tools = tempfile::tempdir().unwrap();
    let done = Command::new(python.trim())
        .arg(root().join("scripts/package"))
        .env("PATH", tools.path())
        .output()
        .unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: not on the PATH: cargo (the Rust toolchain, "), "{said}");
    assert!(said.contains("strip (binutils)") && said.lines().count() == 1, "{said}");
}

/// Asks `scripts/package` for the value of an expression, or skips the test without a Python.
fn of_package_script(expression: &str) -> Option<String> {
    let line = format!(
        "import runpy; script = runpy.run_path('scripts/package'); print(script{expression})"
    );
    let asked = Command::new("python3").args(["-B", "-c", &line]).current_dir(root()).output();
    let Ok(asked) = asked else {
        crate::place::skip("there is no python3");
        return None;
    };
    assert!(asked.status.success(), "{}", String::from_utf8_lossy(&asked.stderr));
    Some(String::from_utf8_lossy(&asked.stdout).trim().to_owned())
}

#[test]
fn a_licence_that_holds_beside_others_needs_their_texts_too() {
    for (expression, met) in [
        ("MIT AND BSD-3-Clause", "[]"),
        ("BSD-3-Clause AND MIT OR Apache-2.0", "['Apache-2.0']"),
        ("BSD-3-Clause AND (MIT OR Apache-2.0)", "[]"),
        ("MIT AND Apache-2.0", "['Apache-2.0', 'MIT']"),
        ("MIT/Apache-2.0", "['Apache-2.0', 'MIT']"),
        ("Apache-2.0 WITH LLVM-exception OR MIT", "['MIT']"),
        ("(MIT", "[]"),
        ("", "[]"),
    ] {
        let known = "{'MIT', 'Apache-2.0'}";
        let question = format!("['sufficient']('{expression}', {known})");
        let Some(said) = of_package_script(&question) else { return };
        assert_eq!(said, met, "{expression}");
    }
    let nothing = of_package_script("['files_below']('nowhere')");
    assert_eq!(nothing.as_deref(), Some("[]"), "a folder without files has none");
}
