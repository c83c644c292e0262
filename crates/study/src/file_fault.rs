//! The faults of a file that a study names, all of them at once.

use std::fmt;

/// The number of faults that are shown; the others are counted only.
const SHOWN: usize = 10;

/// The number of characters of a file that a message repeats at most.
const QUOTED: usize = 40;

/// The faults of a file, in its order; the first ones with their places.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileFaults {
    shown: Vec<FileFault>,
    count: usize,
}

/// One fault of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FileFault {
    /// The line, counted from 1, and perhaps the value on it, likewise.
    place: Option<FilePlace>,
    /// The text that stands there, escaped and cut; empty if the fault is none of a text.
    found: String,
    /// The reason, which follows the text.
    reason: String,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FilePlace {
    /// The line, counted from 1.
    pub(crate) line: usize,
    /// The value on the line, counted from 1; 0 for the whole line.
    pub(crate) value: usize,
}

impl FilePlace {
    /// Returns the place of a whole line, counted from 1.
    pub(crate) fn line(line: usize) -> Self {
        FilePlace { line, value: 0 }
    }
}

impl FileFaults {
    /// Makes the fault of a whole file.
    pub(crate) fn whole(reason: impl Into<String>) -> Self {
        let mut faults = Self::default();
        faults.add(None, "", || reason.into());
        faults
    }

    /// Adds a fault at a place where `found` stands.
    pub(crate) fn add(
        &mut self,
        place: Option<FilePlace>,
        found: &str,
        reason: impl FnOnce() -> String,
    ) {
        if self.shown.len() < SHOWN {
            self.shown.push(FileFault { place, found: quoted(found), reason: reason() });
        }
        self.count += 1;
    }

    /// Adds the faults of another list behind these.
    pub(crate) fn append(&mut self, other: Self) {
        self.count += other.count;
        self.shown.extend(other.shown);
        self.shown.truncate(SHOWN);
    }

    /// Counts faults that are not shown.
    pub(crate) fn leave_out(&mut self, count: usize) {
        self.count += count;
    }

    /// Returns whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the value, if there are no faults.
    ///
    /// # Errors
    ///
    /// Returns the faults.
    pub(crate) fn or<T>(self, value: T) -> Result<T, Self> {
        if self.is_empty() { Ok(value) } else { Err(self) }
    }

    /// Says the faults in words, with the text at fault unless it must stay unsaid: a file that
    /// lies outside the study's directory may be none of the reader's business.
    pub fn words(&self, may_quote: bool) -> String {
        let mut words: Vec<String> =
            self.shown.iter().map(|fault| fault.words(may_quote)).collect();
        if self.count > self.shown.len() {
            words.push(format!("and {} more", self.count - self.shown.len()));
        }
        words.join("; ")
    }
}

impl FileFault {
    fn words(&self, may_quote: bool) -> String {
        let place = match self.place {
            None => String::new(),
            Some(FilePlace { line, value: 0 }) => format!("line {line}: "),
            Some(FilePlace { line, value }) => format!("line {line}, value {value}: "),
        };
        let found = match self.found.as_str() {
            "" => String::new(),
            found if may_quote => format!("`{found}` "),
            _ => "the text there ".to_owned(),
        };
        format!("{place}{found}{}", self.reason)
    }
}

impl fmt::Display for FileFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words(true))
    }
}

impl std::error::Error for FileFaults {}

/// Returns a text without anything that a terminal obeys, and not too long.
fn quoted(found: &str) -> String {
    let mut text: String = found.chars().take(QUOTED).flat_map(char::escape_debug).collect();
    if found.chars().nth(QUOTED).is_some() {
        text.push('…');
    }
    // Quotes need no escape within the marks of a message.
    text.replace("\\'", "'").replace("\\\"", "\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_counted_and_the_first_ones_shown() {
        let mut faults = FileFaults::default();
        assert_eq!(faults.clone().or(7), Ok(7));
        for line in 1..=12 {
            faults.add(Some(FilePlace { line, value: 2 }), "x\u{1b}[31m", || "is no number".into());
        }
        let words = faults.words(true);
        assert!(
            words.starts_with("line 1, value 2: `x\\u{1b}[31m` is no number; line 2,"),
            "{words}"
        );
        assert!(words.ends_with("line 10, value 2: `x\\u{1b}[31m` is no number; and 2 more"));
        assert!(faults.words(false).starts_with("line 1, value 2: the text there is no number;"));
        let long = FileFaults { shown: vec![], count: 0 };
        assert_eq!(long.words(true), "");
        assert_eq!(quoted(&"y".repeat(50)), "y".repeat(40) + "…");
    }
}
