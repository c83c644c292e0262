//! The book in `docs/book` holds: its commands are run and print what it shows, its studies can be
//! planned, its links lead somewhere.
//!
//! A reader follows a page from top to bottom in a directory of its own, and so does [`follow`]. What
//! the blocks of a page mean is said in `docs/book/src/introduction.md`. After a change of the
//! program's words `UPDATE_BOOK=1 cargo test --test program book::` writes what is printed now into
//! the pages; look at the difference.
//!
//! `trycmd` reads Markdown too, but knows neither the files that a page makes nor a shell.

mod built;
mod expected;
mod follow;
mod links;
mod page;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use page::Page;

/// The directory of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Returns every page of the book, and README.md.
fn pages() -> Vec<Page> {
    let mut paths = files_below(&Path::new(ROOT).join("docs/book/src"));
    paths.retain(|path| path.extension().is_some_and(|end| end == "md"));
    assert!(paths.len() > 4);
    paths.push(Path::new(ROOT).join("README.md"));
    paths.into_iter().map(Page::read).collect()
}

/// Returns the files in a directory and those below it, in the order of their names.
fn files_below(directory: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files.extend(files_below(&path)) } else { files.push(path) }
    }
    files.sort();
    files
}

#[track_caller]
fn assert_none(rule: &str, findings: Vec<String>) {
    assert!(findings.is_empty(), "{rule}:\n\n{}", findings.join("\n"));
}

/// Every page is followed literally: from an empty directory, command by command.
#[test]
fn pages_print_what_they_show() {
    let findings = pages().par_iter().flat_map_iter(follow::follow).collect();
    assert_none("a page differs from what the program does", findings);
}

/// The commands that are only named, with placeholders or for long runs, are at least understood.
/// The reference, which the program writes of itself, is held by `cli::reference`.
#[test]
fn commands_that_are_only_named_are_understood() {
    let mut pages = pages();
    pages.retain(|page| !page.directory().ends_with("reference"));
    let findings = pages.iter().flat_map(follow::misunderstood).collect();
    assert_none("a command is none of the program", findings);
}

#[test]
fn links_lead_somewhere() {
    let mut pages = pages();
    for name in ["CONTRIBUTING.md", "ARCHITECTURE.md"] {
        pages.push(Page::read(Path::new(ROOT).join(name)));
    }
    assert_none("a link leads nowhere", pages.iter().flat_map(links::broken).collect());
}

/// The asterisk of μ* ends or begins an emphasis unless a backslash stands before it.
#[test]
fn no_name_has_its_asterisk_taken_for_an_emphasis() {
    let of = |page: Page| page.nested.iter().map(|line| page.place(*line)).collect::<Vec<_>>();
    assert_none("an emphasis begins within another", pages().into_iter().flat_map(of).collect());
}

#[test]
fn the_summary_has_every_page_once() {
    assert_none("the table of contents is not the book's", links::unlisted(&pages()));
}

#[test]
fn the_book_can_be_built() {
    built::build();
}
