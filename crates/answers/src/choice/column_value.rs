//! The value of a column at a point, as far as it is known.

use study::{Column, Record, StudyPoint};

use crate::records::RecordMap;

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

    /// Returns the value, if there is one.
    pub(super) fn value(self) -> Option<f64> {
        match self {
            ColumnValue::Value(value) => Some(value),
            ColumnValue::Pending | ColumnValue::Void => None,
        }
    }
}
