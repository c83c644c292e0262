//! The reference of keys, columns and commands: in the shell and as pages of the book.

use std::fs;
use std::path::Path;

use crate::place::Place;

/// The pages of the book are what the program writes.
#[test]
fn the_pages_of_the_book_are_written_by_the_program() {
    let place = Place::empty();
    assert_eq!(place.call("reference pages").code, 0);
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/book/src/reference");
    for page in ["keys.md", "columns.md", "commands.md"] {
        let written = fs::read_to_string(place.path("pages").join(page)).unwrap();
        let kept = fs::read_to_string(book.join(page)).unwrap_or_default();
        let first = written.lines().zip(kept.lines()).position(|(written, kept)| written != kept);
        assert!(
            written == kept,
            "docs/book/src/reference/{page} is out of date from line {} on: write it anew with \
             `cargo run --locked -- reference docs/book/src/reference`",
            first.unwrap_or(kept.lines().count().min(written.lines().count())) + 1
        );
    }
}

#[test]
fn keys_and_columns_are_explained_in_the_shell() {
    let place = Place::empty();
    let lines: &[&[&str]] = &[
        &["keys", "friction.mu"],
        &["keys", "punch.radius"],
        &["keys", "loading.steps[1].increments"],
        &["keys", "search"],
        &["keys", "bisect"],
        &["keys", "fricton.mu"],
        &["keys", "weather"],
        &["columns", "stick_fraction"],
        &["columns", "residual"],
        &["columns", "weather"],
    ];
    insta::assert_snapshot!(place.transcript(lines));
    assert!(place.files().is_empty());
}

/// Programs get everything: each key has its bounds as numbers and its default as a value.
#[test]
fn the_reference_is_json_for_programs() {
    let place = Place::empty();
    let keys = place.json("keys --json");
    let all = keys.as_array().unwrap().iter().flat_map(|table| table["keys"].as_array().unwrap());
    assert!(all.count() > 150);
    let friction = place.json("keys friction.mu --json");
    let mu = &friction[0]["keys"][0];
    assert_eq!((&mu["default"], &mu["bounds"]["lower"]["number"]), (&"0".into(), &0.0.into()));
    let columns = place.json("columns --json");
    assert!(columns.as_array().unwrap().len() > 150);
}

/// The options of every command are on the page of commands, and those of hidden ones are not.
#[test]
fn every_command_and_option_is_on_its_page() {
    let place = Place::empty();
    assert_eq!(place.call("reference .").code, 0);
    let page = fs::read_to_string(place.path("commands.md")).unwrap();
    let help = place.call("--help").out;
    let listed = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let is_name = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    let names: Vec<&str> =
        listed.lines().filter(is_name).filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() > 20, "{names:?}");
    for name in names {
        assert!(page.contains(&format!("## `tribosweep {name}`")), "{name}");
        // What is said of an option stands further to the right.
        let help = place.words(&[name, "--help"]).out;
        for option in help.lines().filter_map(|line| line.strip_prefix("      --")) {
            let option = option.split_whitespace().next().unwrap();
            assert!(page.contains(&format!("`--{option}")), "{name} --{option}");
        }
    }
    assert!(!page.contains("tribosweep worker") && !page.contains("tribosweep measured"));
}
