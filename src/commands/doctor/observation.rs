//! This file holds an observation of one thing, and its words.

use serde::Serialize;

/// The degree to which something serves a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Soundness {
    /// Nothing is to be done about it.
    Fine,
    /// A run gets on with it, but not with everything.
    Short,
    /// Nothing can be run with it.
    Missing,
}

/// An observation of one thing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Observation {
    pub(super) subject: &'static str,
    pub(super) soundness: Soundness,
    /// The thing as it was found, in words.
    pub(super) found: String,
    /// The words that say what can be done about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) advice: Option<String>,
}

impl Observation {
    pub(super) fn fine(subject: &'static str, found: impl Into<String>) -> Self {
        Self { subject, soundness: Soundness::Fine, found: found.into(), advice: None }
    }

    pub(super) fn short(
        subject: &'static str,
        found: impl Into<String>,
        advice: impl Into<String>,
    ) -> Self {
        let advice = Some(advice.into());
        Self { subject, soundness: Soundness::Short, found: found.into(), advice }
    }

    pub(super) fn missing(subject: &'static str, found: impl Into<String>) -> Self {
        Self { subject, soundness: Soundness::Missing, found: found.into(), advice: None }
    }

    /// Adds what can be done about it.
    pub(super) fn advised(self, advice: impl Into<String>) -> Self {
        Self { advice: Some(advice.into()), ..self }
    }

    /// Returns it as a line of a table, with the advice below.
    pub(super) fn words(&self) -> String {
        let mark = match self.soundness {
            Soundness::Fine => "ok",
            Soundness::Short => "short",
            Soundness::Missing => "missing",
        };
        let found = self.found.replace('\n', " ");
        let mut text = format!("{mark:<8} {:<16} {found}\n", self.subject);
        if let Some(advice) = &self.advice {
            text += &format!("{:<26}so: {advice}\n", "");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_to_be_done_stands_below_what_was_found() {
        let seen = Observation::short("locale", "LANG=C", "export LC_ALL=C.UTF-8");
        assert_eq!(
            seen.words(),
            "short    locale           LANG=C\n                          so: export LC_ALL=C.UTF-8\n"
        );
        let seen = Observation::missing("a run", "no\nroom").advised("make some");
        assert!(seen.words().starts_with("missing  a run            no room\n"));
        assert_eq!(Observation::fine("cores", "2").words().lines().count(), 1);
    }
}
