//! The share of points that failed.

use super::ConfidenceInterval;

/// The quantile of the normal distribution at 97.5 %, for intervals of 95 %.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Returns Wilson's interval of the share of failures among independent trials, of which there is
/// at least one (1927, doi:10.1080/01621459.1927.10502953; recommended by Brown, Cai and DasGupta
/// 2001, doi:10.1214/ss/1009213286).
///
/// The upper end says how many might fail where none did.
pub(crate) fn share(failed: usize, trials: usize) -> ConfidenceInterval {
    let (failed, n) = (failed as f64, trials as f64);
    let square = NORMAL * NORMAL;
    let middle = failed + 0.5 * square;
    let half = NORMAL * (failed * (n - failed) / n + 0.25 * square).sqrt();
    // At the ends of the unit interval the two cancel, but for rounding.
    let end = |sum: f64| (sum / (n + square)).clamp(0.0, 1.0);
    ConfidenceInterval {
        low: if failed == 0.0 { 0.0 } else { end(middle - half) },
        high: if failed == n { 1.0 } else { end(middle + half) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected values are those of `scipy.stats.binomtest(…).proportion_ci(method="wilson")`
    /// (1.17).
    #[test]
    fn shares_are_those_of_wilson() {
        let expected = [
            (0, 20, [0.0, 0.161_125_158_052_819_35]),
            (3, 20, [0.052_368_745_896_216_62, 0.360_418_864_740_756_9]),
            (20, 20, [0.838_874_841_947_180_8, 1.0]),
        ];
        for (failed, trials, [low, high]) in expected {
            let found = share(failed, trials);
            assert!((found.low - low).abs() < 1e-14, "{failed}: {found:?}");
            assert!((found.high - high).abs() < 1e-14, "{failed}: {found:?}");
        }
    }
}
