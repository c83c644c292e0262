//! Halves the intervals of an axis in which a condition begins or ceases to hold.

use study::{Column, Study, StudyPoint};

use super::found::{Discovery, Finding, PointChoice};
use super::line::AxisLines;
use crate::error::AnswerError;
use crate::place::StudyPlace;
use crate::records::RecordMap;
use crate::rows::single;

/// The rule of a study with `[bisect]`.
pub(super) struct Bisection<'a> {
    study: &'a Study,
    records: &'a RecordMap,
    columns: Vec<Column>,
    /// The lines along the axis that is halved.
    lines: AxisLines<'a>,
    /// The condition.
    on: &'a str,
    /// The length of an interval that is short enough, relative to its upper end.
    to: f64,
}

/// The points of one line along the axis, and whether the condition holds at each, if that is
/// known.
#[derive(Default)]
struct AxisLine {
    points: Vec<StudyPoint>,
    holds: Vec<Option<bool>>,
}

impl<'a> Bisection<'a> {
    pub(super) fn new(
        study: &'a Study,
        records: &'a RecordMap,
        axis: usize,
        on: &'a str,
        to: f64,
    ) -> Result<Self, AnswerError> {
        let lines = AxisLines::of(study, axis)?;
        Ok(Self { study, records, columns: study.columns(), lines, on, to })
    }

    /// Returns the points of every line as far as the records determine them.
    pub(super) fn choose(&self) -> Result<PointChoice, AnswerError> {
        let mut choice = PointChoice::default();
        for index in self.study.indices().filter(|index| self.lines.is_first(*index)) {
            choice.extend(self.choose_line(index)?);
        }
        Ok(choice)
    }

    fn choose_line(&self, first: usize) -> Result<PointChoice, AnswerError> {
        let points = self.lines.points(self.study, first);
        let holds = points.iter().map(|point| self.holds(point)).collect::<Result<_, _>>()?;
        let mut line = AxisLine { points, holds };
        let is_other_axis = |axis: usize| axis != self.lines.index;
        let place =
            line.points.first().map(|point| StudyPlace::of(self.study, point, is_other_axis));
        let place = place.unwrap_or_default();
        let changes = self.halve(first, &mut line)?;
        let is_pending = line.points.iter().any(|point| !self.records.contains_key(&point.key));
        let known: Option<Vec<bool>> = line.holds.iter().copied().collect();
        let discoveries = match (is_pending, known) {
            (true, _) => vec![Discovery::Pending],
            (false, None) if changes.is_empty() => vec![Discovery::Unsolved],
            (false, Some(all)) if changes.is_empty() => {
                vec![Discovery::Everywhere { holds: all[0] }]
            }
            // There may be more changes beside the values that were not solved.
            (false, None) => changes.into_iter().chain([Discovery::Unsolved]).collect(),
            (false, Some(_)) => changes,
        };
        let finding = |discovery: Discovery| Finding { place: place.clone(), discovery };
        Ok(PointChoice {
            points: line.points,
            findings: discoveries.into_iter().map(finding).collect(),
            more: None,
        })
    }

    /// Halves the intervals of a line in which the condition changes, and returns those that are
    /// short enough.
    fn halve(&self, first: usize, line: &mut AxisLine) -> Result<Vec<Discovery>, AnswerError> {
        let mut changes = Vec::new();
        let mut from = 0;
        while from + 1 < line.points.len() {
            let (low, high) =
                (self.lines.value(&line.points[from]), self.lines.value(&line.points[from + 1]));
            let (Some(before), Some(after)) = (line.holds[from], line.holds[from + 1]) else {
                from += 1;
                continue;
            };
            let between = self.middle(low, high);
            if before == after {
                from += 1;
            } else if self.is_short(low, high) || !(low < between && between < high) {
                changes.push(Discovery::Changes { from: low, to: high, becomes: after });
                from += 1;
            } else {
                let point = self.study.point_at(first, &[(self.lines.index, between)]).ok_or(
                    AnswerError::Inconsistent(
                        "a value between two of the study cannot be made a job",
                    ),
                )?;
                line.holds.insert(from + 1, self.holds(&point)?);
                line.points.insert(from + 1, point);
            }
        }
        Ok(changes)
    }

    /// Tells whether the condition holds at a point; `None` where it is not solved.
    fn holds(&self, point: &StudyPoint) -> Result<Option<bool>, AnswerError> {
        match self.records.get(&point.key) {
            Some(record) if record.is_certified() => {
                let row = single(&self.columns, point, Some(record))?;
                Ok(Some(!row.filter(self.on)?.rows().is_empty()))
            }
            _ => Ok(None),
        }
    }

    /// Tells whether an interval is short enough, relative to its upper end; or, where that could
    /// never be since the interval begins at 0 or below, relative to the whole axis.
    fn is_short(&self, low: f64, high: f64) -> bool {
        high - low <= self.to * if low > 0.0 { high } else { self.lines.range() }
    }

    fn middle(&self, low: f64, high: f64) -> f64 {
        if self.lines.axis.is_log() { (low * high).sqrt() } else { 0.5 * (low + high) }
    }
}
