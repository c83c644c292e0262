//! Statistics of numbers that were drawn: means, deviations and quantiles with their intervals, and
//! the share of points that failed.
//!
//! Everything below is about numbers alone and knows no study. Intervals are of 95 % and, but for
//! that of the share, come from the [bootstrap], which takes the numbers for independent.

pub(crate) mod bootstrap;
pub(crate) mod description;
pub(crate) mod moments;
pub(crate) mod quantile;
pub(crate) mod share;

/// The ends of an interval that covers what it is about at a level of confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConfidenceInterval {
    /// The lower end.
    pub(crate) low: f64,
    /// The upper end.
    pub(crate) high: f64,
}

/// The level of every interval.
pub(crate) const LEVEL: f64 = 0.95;
