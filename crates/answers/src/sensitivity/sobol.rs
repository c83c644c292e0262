//! Sobol' indices (Sobol' 2001, doi:10.1016/S0378-4754(00)00270-6): the share of an output's
//! variance that an input makes by itself (first order), and with all its interactions (total).
//!
//! They are estimated from the design of Saltelli et al. (2010, doi:10.1016/j.cpc.2009.09.018):
//! rows of two independent points A and B of the inputs, and of points AB_i, which are A but for
//! the i-th input, which is B's.

use crate::statistics::ConfidenceInterval;
use crate::statistics::bootstrap;
use crate::statistics::moments::{Moments, moments};

/// The outputs at the points of a design.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SaltelliOutputs {
    /// The outputs at A, one for each row.
    pub(crate) a: Vec<f64>,
    /// The outputs at B, one for each row.
    pub(crate) b: Vec<f64>,
    /// The outputs at AB_i, for each input one for each row.
    pub(crate) ab: Vec<Vec<f64>>,
}

/// The form of an estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EstimatorForm {
    /// Means of products: Saltelli et al. 2010, table 2, (b) for the first order and (e) for the
    /// total.
    Products,
    /// Means of squared differences (Jansen 1999, doi:10.1016/S0010-4655(98)00154-4): the same
    /// table, (c) and (f).
    Differences,
}

/// The estimators of the two indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Estimators {
    /// The form of that of the first order.
    pub(crate) first: EstimatorForm,
    /// The form of that of the total.
    pub(crate) total: EstimatorForm,
}

/// The indices of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SobolIndices {
    /// The index of first order.
    pub(crate) first: IndexEstimate,
    /// The total index.
    pub(crate) total: IndexEstimate,
}

/// An estimate with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IndexEstimate {
    /// The estimate. It may be below 0 or above 1, where no index is.
    pub(crate) value: f64,
    /// The interval; `None` if the rows give none.
    pub(crate) interval: Option<ConfidenceInterval>,
}

/// Estimates the indices of every input; `None` without two rows, or if the output does not vary.
pub(crate) fn indices(
    outputs: &SaltelliOutputs,
    estimators: Estimators,
) -> Option<Vec<SobolIndices>> {
    let scaled = outputs.scaled()?;
    let intervals =
        bootstrap::intervals(scaled.a.len(), |drawn| scaled.estimates(estimators, drawn));
    scaled.with(estimators, intervals)
}

impl SaltelliOutputs {
    /// Returns the outputs as distances from their mean over their deviation. The estimators by
    /// products are the better for it, and no square is too large for a number.
    fn scaled(&self) -> Option<SaltelliOutputs> {
        let all: Vec<f64> =
            self.a.iter().chain(&self.b).chain(self.ab.iter().flatten()).copied().collect();
        let Moments { mean, deviation } = moments(&all, &vec![1; all.len()]);
        let scale = |outputs: &Vec<f64>| -> Vec<f64> {
            outputs.iter().map(|output| (output - mean) / deviation).collect()
        };
        let is_varied = self.a.len() >= 2 && deviation > 0.0;
        is_varied.then(|| SaltelliOutputs {
            a: scale(&self.a),
            b: scale(&self.b),
            ab: self.ab.iter().map(scale).collect(),
        })
    }

    /// Returns the first and the total index of each input, from rows that count as often as
    /// `drawn` says; not finite if no A or B differs from another.
    fn estimates(&self, estimators: Estimators, drawn: &[u32]) -> Vec<f64> {
        let Self { a, b, ab } = self;
        let count: f64 = drawn.iter().map(|n| f64::from(*n)).sum();
        let mean = |term: &dyn Fn(usize) -> f64| -> f64 {
            drawn.iter().enumerate().map(|(row, n)| f64::from(*n) * term(row)).sum::<f64>() / count
        };
        let center = mean(&|row| 0.5 * (a[row] + b[row]));
        let variance = mean(&|row| 0.5 * ((a[row] - center).powi(2) + (b[row] - center).powi(2)));
        let of_input = |ab: &Vec<f64>| {
            let first = match estimators.first {
                EstimatorForm::Products => mean(&|row| b[row] * (ab[row] - a[row])),
                EstimatorForm::Differences => {
                    variance - mean(&|row| 0.5 * (b[row] - ab[row]).powi(2))
                }
            };
            let total = match estimators.total {
                EstimatorForm::Products => mean(&|row| a[row] * (a[row] - ab[row])),
                EstimatorForm::Differences => mean(&|row| 0.5 * (a[row] - ab[row]).powi(2)),
            };
            [first / variance, total / variance]
        };
        ab.iter().flat_map(of_input).collect()
    }

    fn with(
        &self,
        estimators: Estimators,
        intervals: Vec<Option<ConfidenceInterval>>,
    ) -> Option<Vec<SobolIndices>> {
        let estimates = self.estimates(estimators, &vec![1; self.a.len()]);
        let index = |(value, interval)| IndexEstimate { value, interval };
        let all: Vec<IndexEstimate> = estimates.into_iter().zip(intervals).map(index).collect();
        let is_finite = all.iter().all(|index| index.value.is_finite());
        let pairs = all.chunks_exact(2);
        let of_input = |pair: &[IndexEstimate]| SobolIndices { first: pair[0], total: pair[1] };
        is_finite.then(|| pairs.map(of_input).collect())
    }
}

#[cfg(test)]
mod tests;
