//! The value of a column at a point, as far as it is known.

use study::{Column, Record, StudyPoint};

use crate::records::RecordMap;
use crate::variation::NOISE;

/// The value of a column at a point, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ColumnValue {
    /// The job of the point is left.
    Pending,
    /// The job was not solved, or its result has no value in the column.
    Void,
    /// The value.
    Value(f64),
}

impl ColumnValue {
    /// Reads a column at a point.
    pub(super) fn of(column: &Column, point: &StudyPoint, records: &RecordMap) -> Self {
        let Some(record) = records.get(&point.key) else { return ColumnValue::Pending };
        let value = Some(record).filter(|record| Record::is_certified(record));
        let value = value.and_then(|record| column.value(point, Some(record)).as_f64());
        value.filter(|value| value.is_finite()).map_or(ColumnValue::Void, ColumnValue::Value)
    }

    /// Returns 0 for a value that is noise beside the other `quantities` of its unit at its point:
    /// a force that is 0 is some 10⁻¹³ N. What is noise follows from the point's result alone.
    pub(super) fn above_noise(self, quantities: impl Iterator<Item = f64>) -> Self {
        let largest = quantities.map(f64::abs).filter(|size| size.is_finite()).fold(0.0, f64::max);
        match self {
            ColumnValue::Value(value) if value.abs() <= NOISE * largest => ColumnValue::Value(0.0),
            value => value,
        }
    }

    /// Returns the value, if there is one.
    pub(super) fn value(self) -> Option<f64> {
        match self {
            ColumnValue::Value(value) => Some(value),
            ColumnValue::Pending | ColumnValue::Void => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_beside_other_quantities_is_nothing() {
        let beside = |value: f64, others: &[f64]| {
            ColumnValue::Value(value).above_noise(others.iter().copied()).value()
        };
        assert_eq!(beside(-3e-13, &[20.0, -3e-13]), Some(0.0));
        assert_eq!(beside(1e-6, &[20.0, f64::INFINITY, f64::NAN]), Some(1e-6));
        assert_eq!(beside(1e-13, &[]), Some(1e-13));
        assert_eq!(ColumnValue::Void.above_noise([1.0].into_iter()), ColumnValue::Void);
    }
}
