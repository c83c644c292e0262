//! The failures that a run may have, as `--max-failures` gives them.

use std::fmt;

/// A number of failed jobs, or a part of all, that a run may have and still go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FailureLimit {
    /// So many jobs.
    Count(usize),
    /// So many of a hundred jobs.
    Percent(f64),
}

impl FailureLimit {
    /// Reads a text like `5` or `10%`, and says in words what is wrong with any other.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let limit = match text.trim_end().strip_suffix('%') {
            None => text.parse().ok().map(Self::Count),
            Some(number) => {
                let percent = number.trim_end().parse().ok();
                percent.filter(|percent| (0.0..100.0).contains(percent)).map(Self::Percent)
            }
        };
        limit.ok_or_else(|| {
            "this is neither a number of jobs nor a part of them below 100%; write for example 5 \
             or 10%"
                .to_owned()
        })
    }

    /// Returns whether so many failures of so many jobs are more than it allows.
    pub(crate) fn is_exceeded(self, failed: usize, jobs: usize) -> bool {
        match self {
            Self::Count(most) => failed > most,
            Self::Percent(most) => 100.0 * failed as f64 > most * jobs as f64,
        }
    }
}

impl fmt::Display for FailureLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(most) => write!(f, "{most}"),
            Self::Percent(most) => write!(f, "{most}%"),
        }
    }
}

/// The failures of a run beside what it may have.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FailureCount {
    /// The limit, if there is one.
    pub(crate) limit: Option<FailureLimit>,
    /// The jobs that are to be computed, as far as they are known.
    pub(crate) jobs: usize,
    failed: usize,
    are_too_many: bool,
}

impl FailureCount {
    /// Returns the count of a run that has not begun, with its limit.
    pub(crate) fn new(limit: Option<FailureLimit>) -> Self {
        Self { limit, ..Self::default() }
    }

    /// Counts more failures. Once there were too many it stays so, however many jobs follow.
    pub(crate) fn add(&mut self, failed: usize) {
        self.failed += failed;
        let is_exceeded = |limit: FailureLimit| limit.is_exceeded(self.failed, self.jobs);
        self.are_too_many |= failed > 0 && self.limit.is_some_and(is_exceeded);
    }

    /// Returns the number of failures.
    pub(crate) fn failed(&self) -> usize {
        self.failed
    }

    /// Returns whether there were more failures than the limit allows.
    pub(crate) fn are_too_many(&self) -> bool {
        self.are_too_many
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_many_failures_stay_too_many() {
        let limit = Some(FailureLimit::Percent(10.0));
        let mut count = FailureCount { jobs: 5, ..FailureCount::new(limit) };
        assert!(!count.are_too_many());
        count.add(1);
        count.jobs = 15;
        count.add(0);
        assert!(count.are_too_many() && count.failed() == 1);
        let mut unlimited = FailureCount::default();
        unlimited.add(1000);
        assert!(!unlimited.are_too_many());
    }

    #[test]
    fn limits_are_read_and_held() {
        let read = |text: &str| FailureLimit::parse(text).unwrap();
        assert_eq!(read("0"), FailureLimit::Count(0));
        assert!(read("0").is_exceeded(1, 10) && !read("0").is_exceeded(0, 10));
        assert!(read("5").is_exceeded(6, 10) && !read("5").is_exceeded(5, 10));
        assert!(read("10%").is_exceeded(2, 10) && !read("10 %").is_exceeded(1, 10));
        // The product of 29/100 and 100 is below 29 in floating point.
        assert!(read("29%").is_exceeded(30, 100) && !read("29%").is_exceeded(29, 100));
        assert!(read("0%").is_exceeded(1, 1_000_000) && !read("0.5%").is_exceeded(5, 1000));
        assert_eq!(read("2.5 %").to_string(), "2.5%");
        for wrong in ["", "%", "-1", "1.5", "100%", "-1%", "nan%", "many", "5 apples"] {
            assert!(FailureLimit::parse(wrong).unwrap_err().contains("5 or 10%"), "{wrong}");
        }
    }
}
