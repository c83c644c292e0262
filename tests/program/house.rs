//! The rules of the house that a program can check, so that they hold for the next change as well:
//! the layers that ARCHITECTURE.md shows, names with one meaning each, comments that are sentences,
//! packages that a registry would take, and few packages of others.
//!
//! Every file of every crate is read as text and parsed, and cargo is asked for its tree of
//! packages; nothing is compiled. Code for tests is left out.

mod dependencies;
mod layers;
mod names;
mod packages;
mod paper;
mod source;
mod words;

/// Fails with a list of what breaks a rule, one finding a line.
#[track_caller]
fn assert_none(rule: &str, findings: &[String]) {
    assert!(findings.is_empty(), "{rule}; {} break this:\n{}", findings.len(), findings.join("\n"));
}
