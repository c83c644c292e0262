//! The bootstrap (Efron 1979, doi:10.1214/aos/1176344552): how much figures of rows that were drawn
//! vary is told by drawing as many of these rows again, with replacement. An interval lies between
//! the percentiles of what the figures are then (Efron and Tibshirani 1993,
//! doi:10.1201/9780429246593, chapter 13).
//!
//! Rows are taken to be independent. Those of a low-discrepancy sequence or a Latin hypercube are
//! spread more evenly, so that most figures are closer to the truth than their intervals say.

use contact::SplitMix64;
use rayon::prelude::*;

use super::quantile::quantile;
use super::{ConfidenceInterval, LEVEL};

/// The number of resamples. The ends of an interval then vary by some 4 % of its length from one
/// seed to another.
const RESAMPLES: u64 = 1000;

/// The seed of the resamples: the same rows have the same intervals for ever.
const SEED: u64 = 0x7472_6962_6f73_7765;

/// The work from which on resamples are spread over threads \[rows drawn\].
const WORTH_THREADS: usize = 1 << 16;

/// Returns the interval of each of the figures that `figures` makes of rows, given how often each
/// row was drawn.
///
/// There is no interval for a figure that is not finite for some resample: then too few rows decide
/// it. The result does not depend on the number of threads.
pub(crate) fn intervals(
    rows: usize,
    figures: impl Fn(&[u32]) -> Vec<f64> + Sync,
) -> Vec<Option<ConfidenceInterval>> {
    resampled(rows, RESAMPLES, SEED, figures)
}

/// Returns the intervals by so many resamples of a seed.
pub(crate) fn resampled(
    rows: usize,
    resamples: u64,
    seed: u64,
    figures: impl Fn(&[u32]) -> Vec<f64> + Sync,
) -> Vec<Option<ConfidenceInterval>> {
    let resample = |resample: u64| {
        // The state of a generator is a counter: its first number keeps the streams apart.
        let start = SplitMix64(seed).next() ^ resample;
        let mut random = SplitMix64(SplitMix64(start).next());
        let mut drawn = vec![0; rows];
        for _ in 0..rows {
            drawn[below(&mut random, rows)] += 1;
        }
        figures(&drawn)
    };
    let all: Vec<Vec<f64>> = if rows.saturating_mul(resamples as usize) < WORTH_THREADS {
        (0..resamples).map(resample).collect()
    } else {
        (0..resamples).into_par_iter().map(resample).collect()
    };
    let count = all.first().map_or(0, Vec::len);
    (0..count).map(|figure| percentiles(all.iter().map(|figures| figures[figure]))).collect()
}

/// Returns a random index below `length`; its probabilities are equal within 2⁻⁴⁰ of them.
fn below(random: &mut SplitMix64, length: usize) -> usize {
    ((u128::from(random.next()) * length as u128) >> 64) as usize
}

fn percentiles(figures: impl Iterator<Item = f64>) -> Option<ConfidenceInterval> {
    let mut sorted: Vec<f64> = figures.collect();
    if !sorted.iter().all(|figure| figure.is_finite()) {
        return None;
    }
    sorted.sort_by(f64::total_cmp);
    let end = |probability: f64| quantile(&sorted, probability);
    Some(ConfidenceInterval { low: end((1.0 - LEVEL) / 2.0)?, high: end((1.0 + LEVEL) / 2.0)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(rows: &[f64]) -> impl Fn(&[u32]) -> Vec<f64> + Sync {
        move |drawn| {
            let sum: f64 = rows.iter().zip(drawn).map(|(x, n)| x * f64::from(*n)).sum();
            vec![sum / rows.len() as f64]
        }
    }

    #[test]
    fn the_number_of_threads_leaves_no_trace() {
        let rows: Vec<f64> = (0..500).map(|i| f64::from(i).sqrt()).collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| intervals(rows.len(), mean(&rows)))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn intervals_of_a_mean_are_those_of_the_normal_distribution() {
        let mut random = SplitMix64(1);
        let rows: Vec<f64> = (0..400).map(|_| random.unit()).collect();
        let ConfidenceInterval { low, high } = intervals(400, mean(&rows))[0].unwrap();
        let expected = 2.0 * 1.959_964 / (12.0f64 * 400.0).sqrt();
        assert!(((high - low) / expected - 1.0).abs() < 0.1, "{low} {high}");
    }

    #[test]
    fn a_figure_that_few_rows_decide_has_no_interval() {
        // Without the one row that differs, the figure is 0/0.
        let figures = |drawn: &[u32]| vec![f64::from(drawn[0]) / f64::from(drawn[0]), 1.0];
        let intervals = intervals(3, figures);
        assert_eq!(intervals, [None, Some(ConfidenceInterval { low: 1.0, high: 1.0 })]);
        assert_eq!(super::intervals(0, |_| vec![f64::NAN]), [None]);
    }
}
