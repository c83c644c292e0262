//! The provenance of a record: the part of it that differs from run to run.

use serde::{Deserialize, Serialize};

/// Who computed a record, when and how fast. Nothing in here is reproducible.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub program: String,
    /// Time that solving took \[s\]; of several times, the median.
    pub seconds: f64,
    /// Each time by itself, of a job that is solved several times \[s\].
    pub times: Vec<f64>,
    /// Number of the worker in its run.
    pub worker: u32,
    /// The attempt that gave this record, counted from 1.
    pub attempt: u32,
    /// When it was finished [s since 1970-01-01 UTC].
    pub finished: u64,
}

impl Provenance {
    /// Returns the provenance of a job that a version of the program computed in `seconds`, or
    /// several times over, which took these `times` \[s\].
    pub fn timed(program: &str, seconds: f64, times: Vec<f64>) -> Provenance {
        Provenance {
            program: program.to_owned(),
            seconds: if times.is_empty() { seconds } else { median(times.clone()) },
            times,
            ..Provenance::default()
        }
    }
}

/// Returns the median of numbers, of an even number of them the mean of the middle two; NaN of
/// none.
pub fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => numbers[middle],
        _ => 0.5 * (numbers[middle - 1] + numbers[middle]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
