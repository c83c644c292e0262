//! The rules of the house that a program can check, so that they hold for the next change as well:
//! the layers that ARCHITECTURE.md shows, names with one meaning each, comments that are sentences,
//! packages that a registry would take, and few packages of others.
//!
//! Every file of every crate is read as text and parsed, once for all rules, and cargo is asked for
//! its tree of packages; nothing is compiled. Code for tests is left out.

use std::sync::LazyLock;

mod dependencies;
mod layers;
mod names;
mod packages;
mod paper;
mod source;
mod words;

/// The findings of the rules for sources, a list for each rule.
struct SourceFindings {
    upward_imports: Vec<String>,
    circles: Vec<String>,
    repeated_types: Vec<String>,
    pronouns: Vec<String>,
    tuples: Vec<String>,
    half_sentences: Vec<String>,
    silent_errors: Vec<String>,
    missing_verbs: Vec<String>,
    long_comments: Vec<String>,
}

/// Made by the first test that asks, since to parse the sources takes longer than all rules. A
/// parsed file stays on its thread, so the rules are all asked there.
static SOURCE_FINDINGS: LazyLock<SourceFindings> = LazyLock::new(|| {
    let packages = source::packages();
    SourceFindings {
        upward_imports: layers::upward_imports(&packages),
        circles: layers::circles(&packages),
        repeated_types: names::repeated_types(&packages),
        pronouns: names::pronouns(&packages),
        tuples: names::tuples(&packages),
        half_sentences: words::half_sentences(&packages),
        silent_errors: words::silent_errors(&packages),
        missing_verbs: words::missing_verbs(&packages),
        long_comments: words::long_comments(&packages),
    }
});

/// Fails with a list of what breaks a rule, one finding a line.
#[track_caller]
fn assert_none(rule: &str, findings: &[String]) {
    assert!(findings.is_empty(), "{rule}; {} break this:\n{}", findings.len(), findings.join("\n"));
}
