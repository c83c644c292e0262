//! The tags and the remark of a study: which words may be some, and how they are shown.

use anyhow::{Result, bail};
use report::{Cell, TableColumn};
use store::StudyLabels;
use wording::one_line;

/// The largest number of tags of a study.
const MOST_TAGS: usize = 32;
/// The largest number of characters of a tag.
const LONGEST_TAG: usize = 64;
/// The largest number of characters of a remark.
const LONGEST_NOTE: usize = 4000;

/// Checks a word that is to be a tag.
pub(crate) fn tag(word: &str) -> Result<String, String> {
    let is_plain = one_line(word) == word && !word.contains([' ', ',']);
    if word.is_empty() || !is_plain {
        return Err("a tag is one word, without blanks, commas and control characters".to_owned());
    }
    match word.chars().count() {
        0..=LONGEST_TAG => Ok(word.to_owned()),
        length => Err(format!("a tag has at most {LONGEST_TAG} characters, and not {length}")),
    }
}

/// Checks a text that is to be a remark.
pub(crate) fn note(text: &str) -> Result<String, String> {
    match text.chars().count() {
        _ if text.trim().is_empty() => Err("a note needs words; --remove takes it away".to_owned()),
        0..=LONGEST_NOTE => Ok(text.to_owned()),
        length => Err(format!("a note has at most {LONGEST_NOTE} characters, and not {length}")),
    }
}

/// Refuses more tags than a study may have.
pub(crate) fn check(labels: &StudyLabels) -> Result<()> {
    let count = labels.tags.len();
    if count > MOST_TAGS {
        bail!("a study has at most {MOST_TAGS} tags, and it would have {count}");
    }
    Ok(())
}

/// Returns the tags as words, separated by commas.
pub(crate) fn tag_words(labels: &StudyLabels) -> String {
    labels.tags.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// Returns what is said of the labels of a study, in lines; none if it has none.
pub(crate) fn lines(labels: &StudyLabels) -> Vec<String> {
    let tags = (!labels.tags.is_empty()).then(|| format!("tags: {}", tag_words(labels)));
    // A line end in it could make a line that looks like one of ours.
    let note = labels.note.as_ref().map(|note| format!("note: {}", one_line(note)));
    tags.into_iter().chain(note).collect()
}

/// Adds the labels to the JSON about a study.
pub(crate) fn add_json(entry: &mut serde_json::Value, labels: &StudyLabels) {
    entry["tags"] = serde_json::json!(labels.tags);
    entry["note"] = serde_json::json!(labels.note);
}

/// Returns the heads and the cells that labels add to the rows of a table of studies, of which only
/// those columns are there that have something in them.
pub(crate) fn columns(all: &[StudyLabels]) -> (Vec<TableColumn>, Vec<Vec<Cell>>) {
    let has_tags = all.iter().any(|labels| !labels.tags.is_empty());
    let has_notes = all.iter().any(|labels| labels.note.is_some());
    let named = [("tags", has_tags), ("note", has_notes)];
    let is_there = named.iter().filter(|(_, is_there)| *is_there);
    let heads = is_there.map(|(name, _)| TableColumn::new(*name, "")).collect();
    let cells = all.iter().map(|labels| {
        let tags = has_tags.then(|| Cell::Text(tag_words(labels)));
        let note = has_notes.then(|| Cell::Text(labels.note.clone().unwrap_or_default()));
        tags.into_iter().chain(note).collect()
    });
    (heads, cells.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_words_and_notes_are_sentences() {
        for word in ["draft", "2026-11", "für", "a/b", "#1"] {
            assert_eq!(tag(word).as_deref(), Ok(word));
        }
        for word in ["", "two words", "a,b", "a\nb", "\u{1b}[2J", "\u{202e}x", &"x".repeat(65)] {
            tag(word).unwrap_err();
        }
        assert_eq!(note("for the paper\nsecond line").as_deref(), Ok("for the paper\nsecond line"));
        for text in ["", "  ", &"x".repeat(4001)] {
            note(text).unwrap_err();
        }
        let labels = StudyLabels {
            tags: ["b", "a"].map(str::to_owned).into(),
            note: Some("one\ntags: c".to_owned()),
        };
        assert_eq!(lines(&labels), ["tags: a, b", r"note: one\ntags: c"]);
        let many = (0..40).map(|number| format!("t{number}")).collect();
        check(&StudyLabels { tags: many, note: None }).unwrap_err();
    }
}
