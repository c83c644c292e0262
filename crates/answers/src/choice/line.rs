//! The lines of a study along an axis: its points that differ in nothing else.

use study::axis::{Group, SweepAxis};
use study::{Study, StudyPoint, Value};

use crate::error::AnswerError;

/// The lines of a study along one axis, to which points are added.
pub(super) struct AxisLines<'a> {
    pub(super) axis: &'a SweepAxis,
    /// The index of the axis among all.
    pub(super) index: usize,
    /// The number of points of a line.
    pub(super) length: usize,
    /// The distance of the indices of neighbouring points of a line.
    pub(super) stride: usize,
}

impl<'a> AxisLines<'a> {
    pub(super) fn of(study: &'a Study, index: usize) -> Result<Self, AnswerError> {
        let axis = study
            .axes()
            .nth(index)
            .ok_or(AnswerError::Inconsistent("an axis of the study is gone"))?;
        let groups = study.groups();
        let group = groups.iter().position(|group| group.axes().contains(axis)).unwrap_or(0);
        let length = groups[group].len();
        let stride = groups[group + 1..].iter().map(Group::len).product();
        Ok(Self { axis, index, length, stride })
    }

    /// Tells whether the point with an index is the first of its line.
    pub(super) fn is_first(&self, index: usize) -> bool {
        (index / self.stride).is_multiple_of(self.length)
    }

    /// Returns the points of the line whose first point has an index.
    pub(super) fn points(&self, study: &Study, first: usize) -> Vec<StudyPoint> {
        (0..self.length).filter_map(|step| study.point(first + step * self.stride)).collect()
    }

    /// Returns the value of the axis at a point.
    pub(super) fn value(&self, point: &StudyPoint) -> f64 {
        point.values.get(self.index).and_then(Value::as_f64).unwrap_or(f64::NAN)
    }

    /// Returns the values of the axis that the study gives.
    pub(super) fn values(&self) -> Vec<f64> {
        self.axis.values().filter_map(Value::as_f64).collect()
    }

    /// Returns the distance between the first and the last of these values.
    pub(super) fn range(&self) -> f64 {
        let values = self.values();
        values.last().zip(values.first()).map_or(f64::NAN, |(last, first)| last - first)
    }
}
