//! Finds every value of an axis at which a result takes a value, as far as the given values of the
//! axis tell the places apart.
//!
//! Every interval between two given values at whose ends the result lies on different sides is
//! [narrowed](super::narrowing), all of them in the same rounds. Where the result is the same
//! value at a point, that is said, and whether it crosses there. Where a job was not solved, the
//! interval beside it stays open.

use study::columns::find;
use study::{Column, RootSearch, Study, StudyPoint};

use super::column_value::ColumnValue;
use super::found::{Finding, PointChoice};
use super::line::AxisLines;
use super::roots::{LineRoots, RootLine};
use crate::error::AnswerError;
use crate::place::StudyPlace;
use crate::records::RecordMap;

/// The rule of a study with `[find]`.
pub(super) struct RootFinder<'a> {
    study: &'a Study,
    records: &'a RecordMap,
    search: &'a RootSearch,
    column: Column,
    lines: AxisLines<'a>,
}

impl<'a> RootFinder<'a> {
    pub(super) fn new(
        study: &'a Study,
        records: &'a RecordMap,
        search: &'a RootSearch,
    ) -> Result<Self, AnswerError> {
        let column = find(&study.columns(), &search.column)
            .cloned()
            .ok_or(AnswerError::Inconsistent("the column of [find] is gone"))?;
        let lines = AxisLines::of(study, search.axis)?;
        Ok(Self { study, records, search, column, lines })
    }

    /// Returns the points of every line as far as the records determine them.
    pub(super) fn choose(&self) -> Result<PointChoice, AnswerError> {
        let mut choice = PointChoice::bounded();
        for index in self.study.indices().filter(|index| self.lines.is_first(*index)) {
            choice.extend(self.choose_line(index)?);
        }
        Ok(choice)
    }

    fn choose_line(&self, first: usize) -> Result<PointChoice, AnswerError> {
        let mut points = self.lines.points(self.study, first);
        let is_other_axis = |axis: usize| axis != self.search.axis;
        let place = points.first().map(|point| StudyPlace::of(self.study, point, is_other_axis));
        let place = place.unwrap_or_default();
        let line = RootLine {
            xs: points.iter().map(|point| self.lines.value(point)).collect(),
            is_log: self.lines.axis.is_log(),
            value: self.search.value,
            to: self.search.to,
        };
        let value = |point: &StudyPoint| ColumnValue::of(&self.column, point, self.records);
        let given: Vec<ColumnValue> = points.iter().map(value).collect();
        let LineRoots { discoveries, more } = line.search(&given, |x| {
            let point = self.study.point_at(first, &[(self.search.axis, x)]).ok_or(
                AnswerError::Inconsistent("a value between two of the study cannot be made a job"),
            )?;
            let value = value(&point);
            points.push(point);
            Ok::<_, AnswerError>(value)
        })?;
        points.sort_by(|a, b| self.lines.value(a).total_cmp(&self.lines.value(b)));
        let finding = |discovery| Finding { place: place.clone(), discovery };
        let findings = discoveries.into_iter().map(finding).collect();
        Ok(PointChoice { points, findings, more: Some(more) })
    }
}
