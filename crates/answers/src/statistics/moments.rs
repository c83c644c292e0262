//! The mean and the standard deviation of numbers.

/// The mean of numbers, and their deviation from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moments {
    /// The arithmetic mean.
    pub(crate) mean: f64,
    /// The standard deviation of a sample, with n − 1 below the sum of squares; NaN for one number.
    pub(crate) deviation: f64,
}

/// Returns the moments of numbers, each of which counts as often as `drawn` says; NaN if none does.
///
/// Distances from the first number are summed, and squares of distances from the mean over the
/// largest of them: numbers that differ in their last digits lose none of these, and squares are
/// neither too large nor too small for a number.
pub(crate) fn moments(numbers: &[f64], drawn: &[u32]) -> Moments {
    let counted =
        || numbers.iter().zip(drawn).filter(|(_, n)| **n > 0).map(|(x, n)| (*x, f64::from(*n)));
    let count: f64 = counted().map(|(_, n)| n).sum();
    let first = counted().next().map_or(f64::NAN, |(x, _)| x);
    // Halves, for the distance of two numbers may be too large for one.
    let mean =
        first + 2.0 * counted().map(|(x, n)| (0.5 * x - 0.5 * first) * (n / count)).sum::<f64>();
    let distance = |x: f64| 0.5 * x - 0.5 * mean;
    let largest = counted().map(|(x, _)| distance(x).abs()).fold(0.0, f64::max);
    if largest == 0.0 {
        let deviation = if count > 1.0 { 0.0 } else { f64::NAN };
        return Moments { mean, deviation };
    }
    let squares: f64 = counted().map(|(x, n)| n * (distance(x) / largest).powi(2)).sum();
    Moments { mean, deviation: 2.0 * (largest * (squares / (count - 1.0)).sqrt()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_definition() {
        let Moments { mean, deviation } = moments(&[2.0, 4.0, 4.0, 5.0], &[1; 4]);
        assert_eq!(mean, 3.75);
        assert!((deviation - (4.75f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(moments(&[2.0, 4.0, 9.0, 5.0], &[1, 2, 0, 1]), Moments { mean, deviation });
    }

    #[test]
    fn the_last_digits_of_large_numbers_are_not_lost() {
        let Moments { mean, deviation } = moments(&[1e15 + 1.0, 1e15 + 2.0, 1e15 + 3.0], &[1; 3]);
        assert_eq!((mean, deviation), (1e15 + 2.0, 1.0));
        // 0.1 has no exact multiples.
        assert_eq!(moments(&[0.1; 7], &[1; 7]), Moments { mean: 0.1, deviation: 0.0 });
        for size in [1e-300, 1e300] {
            let Moments { mean, deviation } = moments(&[size, -size], &[1; 2]);
            assert_eq!(mean, 0.0);
            assert!((deviation / size - 2.0f64.sqrt()).abs() < 1e-15);
        }
    }

    #[test]
    fn one_number_has_no_deviation_and_none_no_mean() {
        let one = moments(&[3.0], &[1]);
        assert!(one.mean == 3.0 && one.deviation.is_nan());
        assert!(moments(&[], &[]).mean.is_nan() && moments(&[1.0], &[0]).mean.is_nan());
    }
}
