//! The time that a command may take, as `--until` gives it.

use std::fmt;
use std::time::{Duration, Instant};

/// The part of the time that jobs in flight may take beyond it.
const OVERTIME: u32 = 20;
/// The least of what they may take.
const LEAST_OVERTIME: Duration = Duration::from_secs(1);
/// The most of it. Batch systems kill 30 s after they have asked for an end.
const MOST_OVERTIME: Duration = Duration::from_secs(20);

/// A time that a command may take, which counts from when the command line is read.
#[derive(Clone, Debug)]
pub(crate) struct TimeBudget {
    /// The text on the command line.
    text: String,
    time: Duration,
    start: Instant,
}

impl TimeBudget {
    /// Reads a duration like `55m`, and says in words what is wrong with any other text.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let time = humantime::parse_duration(text)
            .map_err(|error| format!("{error}; write for example 55m, 90s or 1h30m"))?;
        if time.is_zero() {
            return Err("no job is done in no time; write for example 55m, 90s or 1h30m".into());
        }
        Ok(Self { text: text.to_owned(), time, start: Instant::now() })
    }

    /// Returns what is left of the time.
    pub(crate) fn left(&self) -> Duration {
        self.time.saturating_sub(self.start.elapsed())
    }

    /// Returns the time that jobs in flight may take beyond it.
    pub(crate) fn overtime(&self) -> Duration {
        (self.time / OVERTIME).clamp(LEAST_OVERTIME, MOST_OVERTIME)
    }
}

impl fmt::Display for TimeBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_read_as_people_write_them() {
        for (text, seconds, overtime) in [
            ("55m", 3300, 20),
            ("55 min", 3300, 20),
            ("90s", 90, 4),
            ("1h30m", 5400, 20),
            ("2h", 7200, 20),
            ("5 s", 5, 1),
        ] {
            let budget = TimeBudget::parse(text).unwrap();
            assert_eq!((budget.time.as_secs(), budget.overtime().as_secs()), (seconds, overtime));
            assert!(budget.left() <= budget.time && budget.to_string() == text);
        }
        let example = "; write for example 55m, 90s or 1h30m";
        for wrong in [
            "0s",
            "0",
            "55",
            "m",
            "",
            "soon",
            "55 apples",
            "-5m",
            "1e400h",
            "9".repeat(40).as_str(),
        ] {
            let words = TimeBudget::parse(wrong).unwrap_err();
            assert!(words.ends_with(example), "{wrong}: {words}");
        }
        assert!(
            TimeBudget::parse("500000000000 years").is_ok_and(|budget| !budget.left().is_zero())
        );
    }
}
