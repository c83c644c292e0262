//! The value of a key that a study leaves out. The code takes it from here, or a test holds it
//! against what the code takes.

use crate::units::Compact;

/// The value of a key that a study leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fallback {
    /// None: the study must give it.
    Needed,
    /// A number in SI units.
    Number(f64),
    /// A whole number.
    Count(u32),
    /// A word.
    Word(&'static str),
    /// True or false.
    Flag(bool),
    /// An empty list.
    Empty,
    /// A whole number for each kind of study that has the key, by the kind's name.
    ByKind(&'static [(&'static str, u32)]),
    /// Something that depends on what else is given, in words.
    Follows(&'static str),
}

impl Fallback {
    /// Returns the number that it is.
    pub(crate) fn number(self) -> Option<f64> {
        match self {
            Fallback::Number(x) => Some(x),
            _ => None,
        }
    }

    /// Returns the whole number that it is in every kind of study.
    pub(crate) fn count(self) -> Option<u32> {
        match self {
            Fallback::Count(n) => Some(n),
            _ => None,
        }
    }

    /// Returns the whole numbers that it is in kinds of study, by their names.
    pub(crate) fn of_kinds(self) -> &'static [(&'static str, u32)] {
        match self {
            Fallback::ByKind(counts) => counts,
            _ => &[],
        }
    }

    /// Returns it as a study file would write it, with numbers in `unit`; `None` if it is no value.
    pub(crate) fn written(self, unit: &str) -> Option<String> {
        Some(match self {
            Fallback::Number(x) if x == 0.0 || unit.is_empty() => Compact(x).to_string(),
            Fallback::Number(x) => format!("\"{} {unit}\"", Compact(x)),
            Fallback::Count(n) => n.to_string(),
            Fallback::Word(word) => format!("\"{word}\""),
            Fallback::Flag(yes) => yes.to_string(),
            Fallback::Empty => "[]".to_owned(),
            Fallback::Needed | Fallback::Follows(_) | Fallback::ByKind(_) => return None,
        })
    }

    /// Describes it.
    pub(crate) fn words(self, unit: &str) -> String {
        match self {
            Fallback::Needed => "must be given".to_owned(),
            Fallback::Follows(words) => words.to_owned(),
            Fallback::ByKind(counts) => {
                let of = |(kind, count): &(&str, u32)| format!("{count} in kind \"{kind}\"");
                counts.iter().map(of).collect::<Vec<_>>().join(", ")
            }
            _ => self.written(unit).unwrap_or_default(),
        }
    }
}
