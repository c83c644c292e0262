//! Time limits as `sbatch` writes them.

use std::fmt;
use std::str::FromStr;

/// The words that ask for no limit.
const NO_LIMIT: [&str; 2] = ["UNLIMITED", "INFINITE"];

/// A time limit that `sbatch` takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TimeLimit {
    /// The text as it was given.
    text: String,
    /// The time \[s\]; `None` for no limit.
    pub(crate) seconds: Option<u64>,
}

impl fmt::Display for TimeLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for TimeLimit {
    type Err = String;

    /// Reads minutes, minutes:seconds, hours:minutes:seconds, days-hours, days-hours:minutes or
    /// days-hours:minutes:seconds.
    fn from_str(text: &str) -> Result<Self, String> {
        let seconds = if NO_LIMIT.iter().any(|word| text.eq_ignore_ascii_case(word)) {
            None
        } else {
            // A limit of zero is none.
            Some(seconds(text).ok_or_else(|| refusal(text))?).filter(|seconds| *seconds > 0)
        };
        Ok(Self { text: text.to_owned(), seconds })
    }
}

/// Returns the seconds of a text in one of the six forms.
fn seconds(text: &str) -> Option<u64> {
    let (days, rest) = match text.split_once('-') {
        Some((days, rest)) => (Some(number(days)?), rest),
        None => (None, text),
    };
    let parts: Vec<u64> = rest.split(':').map(number).collect::<Option<_>>()?;
    let [hours, minutes, seconds] = match (days, parts[..].try_into()) {
        (_, Ok(whole)) => whole,
        (Some(_), Err(_)) => match parts[..] {
            [hours] => [hours, 0, 0],
            [hours, minutes] => [hours, minutes, 0],
            _ => return None,
        },
        (None, Err(_)) => match parts[..] {
            [minutes] => [0, minutes, 0],
            [minutes, seconds] => [0, minutes, seconds],
            _ => return None,
        },
    };
    Some(((days.unwrap_or(0) * 24 + hours) * 60 + minutes) * 60 + seconds)
}

/// Returns a number of at most seven digits, so that no sum of them overflows.
fn number(text: &str) -> Option<u64> {
    let is_number = (1..=7).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| text.parse().ok()).flatten()
}

/// Says what would be right in place of a text; a time with a unit is written as sbatch has it.
fn refusal(text: &str) -> String {
    let forms = "must be a time as sbatch has it: minutes, hours:minutes:seconds or \
                 days-hours:minutes:seconds";
    let split = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let meant = number(&text[..split]).and_then(|number| {
        Some(match text[split..].trim() {
            "s" => format!("0:{number:02}"),
            "m" | "min" => number.to_string(),
            "h" => format!("{number}:00:00"),
            "d" => format!("{number}-0"),
            _ => return None,
        })
    });
    match meant {
        Some(meant) => format!("{forms}; {text} is {meant}"),
        None => forms.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_six_forms_are_read() {
        for (text, seconds) in [
            ("30", Some(1800)),
            ("0:45", Some(45)),
            ("01:30:00", Some(5400)),
            ("2-0", Some(172_800)),
            ("1-12:30", Some(131_400)),
            ("1-01:01:01", Some(90_061)),
            ("0", None),
            ("unlimited", None),
            ("INFINITE", None),
        ] {
            let limit: TimeLimit = text.parse().unwrap();
            assert_eq!((limit.seconds, limit.to_string()), (seconds, text.to_owned()));
        }
    }

    #[test]
    fn other_texts_are_refused_with_what_was_meant() {
        for text in ["", "x", "1:2:3:4", "-1", "1-", "1.5", "5-1:2:3:4", "99999999", "1 0", "+5"] {
            let said = text.parse::<TimeLimit>().unwrap_err();
            assert!(said.ends_with("days-hours:minutes:seconds"), "{text}: {said}");
        }
        for (text, meant) in [("55m", "55"), ("2h", "2:00:00"), ("3d", "3-0"), ("90s", "0:90")] {
            let said = text.parse::<TimeLimit>().unwrap_err();
            assert!(said.ends_with(&format!("; {text} is {meant}")), "{said}");
            assert!(meant.parse::<TimeLimit>().is_ok());
        }
    }
}
