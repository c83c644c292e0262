//! The provenance of a record: the part of it that differs from run to run.

use serde::{Deserialize, Serialize};

/// The worker that computed a record, the time and the speed, and the run that it belongs to.
/// Nothing in it is reproducible.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The version of the program.
    pub program: String,
    /// The time that solving took \[s\]; the median of several times.
    pub seconds: f64,
    /// Each time of a job that is solved several times \[s\].
    pub times: Vec<f64>,
    /// The number of the worker in its run.
    pub worker: u32,
    /// The attempt that gave this record, counted from 1.
    pub attempt: u32,
    /// The time at which the job was finished [s since 1970-01-01 UTC].
    pub finished: u64,
    /// The digest of the [account](crate::RunAccount) of the run; `None` for a job that was solved
    /// alone, and in records of formats before 5.
    pub run: Option<[u8; 32]>,
}

/// The provenance of formats before 5.
#[derive(Deserialize)]
pub(crate) struct OlderProvenance {
    program: String,
    seconds: f64,
    times: Vec<f64>,
    worker: u32,
    attempt: u32,
    finished: u64,
}

impl From<OlderProvenance> for Provenance {
    fn from(older: OlderProvenance) -> Self {
        let OlderProvenance { program, seconds, times, worker, attempt, finished } = older;
        Self { program, seconds, times, worker, attempt, finished, run: None }
    }
}

impl Provenance {
    /// Returns the provenance of a job that a version of the program computed in `seconds`, or
    /// several times over in these `times` \[s\].
    pub fn timed(program: &str, seconds: f64, times: Vec<f64>) -> Provenance {
        Provenance {
            program: program.to_owned(),
            seconds: if times.is_empty() { seconds } else { median(times.clone()) },
            times,
            ..Provenance::default()
        }
    }
}

/// Returns the median of numbers: the mean of the middle two if their number is even, and NaN if
/// there are none.
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
