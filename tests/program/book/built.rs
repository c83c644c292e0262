//! The book as mdBook makes it.

use std::path::Path;
use std::process::Command;

use super::{ROOT, files_below};
use crate::place::{Place, skip};

/// Builds the book where mdBook is installed, and asserts that it warns of nothing.
pub(super) fn build() {
    if Command::new("mdbook").arg("--version").output().is_err() {
        return skip("mdbook is not installed");
    }
    let place = Place::empty();
    let target = place.path("book");
    let mut command = Command::new("mdbook");
    command.arg("build").arg(Path::new(ROOT).join("docs/book")).arg("--dest-dir").arg(&target);
    let said = place.said(&mut command);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(!said.err.contains("WARN") && !said.err.contains("ERROR"), "{}", said.err);
    let pages = files_below(&target);
    assert!(pages.iter().any(|path| path.ends_with("tutorial.html")), "{pages:?}");
}
