//! The rules of the house that a program can check, so that they hold for the next change as well:
//! the layers that ARCHITECTURE.md shows, names with one meaning each, comments that are sentences,
//! packages that a registry would take.
//!
//! Every file of every crate is read as text and parsed; nothing is compiled or run. Code for tests
//! is left out.

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
