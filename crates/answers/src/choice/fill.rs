//! Adds points to a curve or a map where it bends most.

use std::collections::BTreeMap;

use study::columns::{Role, find};
use study::{Column, Filling, Study, StudyPoint};

use super::column_value::ColumnValue;
use super::found::{Discovery, Finding, PointChoice};
use super::leaves::{FillingEnd, FillingEnds, GridPlace, Leaves, index_and_part};
use super::line::AxisLines;
use crate::error::AnswerError;
use crate::place::StudyPlace;
use crate::records::RecordMap;
use crate::variation::{DIMENSIONLESS, noise};

/// The rule of a study with `[fill]`.
pub(super) struct Filler<'a> {
    study: &'a Study,
    records: &'a RecordMap,
    filling: &'a Filling,
    column: Column,
    /// The quantities beside which a value of the column may be noise.
    beside: Vec<Column>,
    /// The lines along each axis.
    lines: Vec<AxisLines<'a>>,
}

impl<'a> Filler<'a> {
    pub(super) fn new(
        study: &'a Study,
        records: &'a RecordMap,
        filling: &'a Filling,
    ) -> Result<Self, AnswerError> {
        let columns = study.columns();
        let column = find(&columns, &filling.column)
            .cloned()
            .ok_or(AnswerError::Inconsistent("the column of [fill] is gone"))?;
        let is_beside = |other: &Column| {
            other.role == Role::Observable
                && other.unit() == column.unit()
                && !DIMENSIONLESS.contains(&other.unit())
        };
        let beside = columns.iter().filter(|other| is_beside(other)).cloned().collect();
        let axes = filling.axes.iter();
        let lines = axes.map(|axis| AxisLines::of(study, *axis)).collect::<Result<_, _>>()?;
        Ok(Self { study, records, filling, column, beside, lines })
    }

    /// Returns the points of every curve or map as far as the records determine them.
    pub(super) fn choose(&self) -> Result<PointChoice, AnswerError> {
        let mut choice = PointChoice::bounded();
        let is_first = |index: &usize| self.lines.iter().all(|lines| lines.is_first(*index));
        for index in self.study.indices().filter(is_first) {
            choice.extend(self.choose_one(index)?);
        }
        Ok(choice)
    }

    /// Chooses the points of the curve or map whose first point has an index.
    fn choose_one(&self, first: usize) -> Result<PointChoice, AnswerError> {
        let point = self
            .study
            .point(first)
            .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
        let noise = noise(std::slice::from_ref(&point));
        let place = StudyPlace::of(self.study, &point, |axis| !self.filling.axes.contains(&axis));
        let measured: Vec<Vec<f64>> = self.lines.iter().map(measured_values).collect();
        let only = [0.0];
        let across = measured.get(1).map_or(&only[..], |values| values);
        let mut leaves = Leaves::new([&measured[0], across]);
        let mut points = BTreeMap::new();
        let Filling { to, at_most, .. } = *self.filling;
        let end = leaves.fill(&FillingEnds { to, at_most, noise }, |place| {
            let point = self
                .point(first, place)
                .ok_or(AnswerError::Inconsistent("a value between two of the study is no job"))?;
            let read = |column: &Column| ColumnValue::of(column, &point, self.records);
            let value = read(&self.column)
                .above_noise(self.beside.iter().filter_map(|other| read(other).value()));
            points.insert(place, point);
            Ok::<_, AnswerError>(value)
        })?;
        let given: usize = self.lines.iter().map(|lines| lines.length).product();
        let added = points.len() - given;
        let more = if end == FillingEnd::Pending { at_most - added } else { 0 };
        let discovery = match end {
            FillingEnd::Pending => Discovery::Pending,
            _ => Discovery::Filled { added, deviation: leaves.deviation(), reason: reason(end) },
        };
        let findings = vec![Finding { place, discovery }];
        Ok(PointChoice { points: points.into_values().collect(), findings, more: Some(more) })
    }

    /// Returns the point at a place.
    fn point(&self, first: usize, place: GridPlace) -> Option<StudyPoint> {
        let places =
            || self.lines.iter().zip(place).map(|(lines, along)| (lines, index_and_part(along)));
        if places().all(|(_, (_, part))| part == 0.0) {
            let steps = places().map(|(lines, (index, _))| index * lines.stride);
            return self.study.point(first + steps.sum::<usize>());
        }
        let values: Vec<(usize, f64)> = places()
            .map(|(lines, (index, part))| (lines.index, value_between(lines, index, part)))
            .collect();
        self.study.point_at(first, &values)
    }
}

/// Returns the given values of an axis as the drawing measures them.
fn measured_values(lines: &AxisLines<'_>) -> Vec<f64> {
    let values = lines.values().into_iter();
    if lines.axis.is_log() { values.map(f64::ln).collect() } else { values.collect() }
}

/// Returns the value at a part of the way from the given value with an index to the next one,
/// rounded as the values of ranges are.
fn value_between(lines: &AxisLines<'_>, index: usize, part: f64) -> f64 {
    let values = lines.values();
    if part == 0.0 {
        return values[index];
    }
    let (low, high) = (values[index], values[index + 1]);
    let (value, digits) = match lines.axis.is_log() {
        true => ((low.ln() * (1.0 - part) + high.ln() * part).exp(), 12),
        false => (low * (1.0 - part) + high * part, 14),
    };
    format!("{value:.digits$e}").parse::<f64>().unwrap_or(value) + 0.0
}

fn reason(end: FillingEnd) -> &'static str {
    match end {
        FillingEnd::Pending => "jobs are left",
        FillingEnd::Smooth => "bends by no more",
        FillingEnd::Flat => "does not vary",
        FillingEnd::Steep => "bends by no more, but for steps within that part of the axis",
        FillingEnd::Void => "a job was not solved; nothing was added beside it",
        FillingEnd::Full => "as many as may be added",
    }
}
