//! Quantiles of the seventh type of Hyndman and Fan (1996, doi:10.1080/00031305.1996.10473566),
//! which numpy and R give unless asked for another: between the two numbers around place
//! p (n − 1) of the sorted ones, counted from 0, the quantile is linear.

/// Returns the quantile of ascending numbers at a probability; `None` if there are no numbers.
pub(crate) fn quantile(sorted: &[f64], probability: f64) -> Option<f64> {
    at_place(sorted.len(), probability, |place| sorted.get(place).copied())
}

/// Returns the quantiles of ascending numbers, each of which occurs as often as `drawn` says; NaN
/// if there are none.
pub(crate) fn drawn_quantiles(sorted: &[f64], drawn: &[u32], probabilities: &[f64]) -> Vec<f64> {
    // The place after the last one that each number has.
    let mut ends = Vec::with_capacity(drawn.len());
    let mut count = 0;
    for times in drawn {
        count += *times as usize;
        ends.push(count);
    }
    let number = |place: usize| sorted.get(ends.partition_point(|end| *end <= place)).copied();
    let quantile = |probability: &f64| at_place(count, *probability, number).unwrap_or(f64::NAN);
    probabilities.iter().map(quantile).collect()
}

fn at_place(count: usize, probability: f64, number: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    let place = probability * count.saturating_sub(1) as f64;
    let (low, high) = (number(place.floor() as usize)?, number(place.ceil() as usize)?);
    let part = place - place.floor();
    // The two are weighed, for their difference may be infinite.
    Some(if low == high { low } else { low * (1.0 - part) + high * part })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected values are those of `numpy.quantile` (2.4) with its usual method.
    #[test]
    fn quantiles_are_those_of_numpy() {
        let sorted = [-1.5, 0.25, 0.5, 2.0, 7.0, 7.0, 11.0];
        let expected =
            [(0.0, -1.5), (0.05, -0.975), (0.25, 0.375), (0.5, 2.0), (0.9, 8.6), (1.0, 11.0)];
        for (probability, expected) in expected {
            let found = quantile(&sorted, probability).unwrap();
            assert!((found - expected).abs() < 1e-14, "{probability}: {found}");
        }
        assert_eq!(quantile(&[3.0], 0.3), Some(3.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn numbers_that_are_drawn_several_times_count_so_often() {
        let (sorted, drawn) = ([1.0, 2.0, 5.0, 8.0], [2, 0, 3, 1]);
        let listed = [1.0, 1.0, 5.0, 5.0, 5.0, 8.0];
        let probabilities = [0.0, 0.05, 0.2, 0.25, 0.3, 0.5, 0.75, 0.95, 1.0];
        let expected = probabilities.map(|probability| quantile(&listed, probability).unwrap());
        assert_eq!(drawn_quantiles(&sorted, &drawn, &probabilities), expected);
        assert!(drawn_quantiles(&[], &[], &[0.5])[0].is_nan());
    }

    #[test]
    fn the_largest_numbers_have_quantiles() {
        assert_eq!(quantile(&[-f64::MAX, f64::MAX], 0.5), Some(0.0));
    }
}
