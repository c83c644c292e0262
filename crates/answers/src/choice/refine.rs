//! Doubles the mesh until a result holds still.
//!
//! Two meshes that are both too coarse may agree. No mesh is compared with one of fewer than four
//! elements along a side; warnings tell where the error that is estimated on the last one is larger
//! than the change.

use contact::model::Mesh;
use study::columns::find;
use study::{Column, Record, Study, StudyPoint};

use super::found::{Discovery, Finding, PointChoice};
use crate::error::AnswerError;
use crate::place::StudyPlace;
use crate::records::RecordMap;

/// The least number of elements along each side of a mesh that another one is compared with.
const LEAST_SIDE: u32 = 4;

/// The rule of a study with `[refine]`.
pub(super) struct MeshRefinement<'a> {
    pub(super) study: &'a Study,
    pub(super) records: &'a RecordMap,
    /// The column that is to hold still.
    pub(super) on: &'a str,
    /// The relative change from one mesh to the next that is small enough.
    pub(super) until: f64,
    /// The elements along a side beyond which no mesh goes.
    pub(super) at_most: u32,
}

impl MeshRefinement<'_> {
    /// Returns the meshes of the point with an index, as far as the records determine them.
    pub(super) fn choose(&self, index: usize) -> Result<PointChoice, AnswerError> {
        let columns = self.study.columns();
        let column = find(&columns, self.on)
            .ok_or(AnswerError::Inconsistent("the column of [refine] is gone"))?;
        let first = self
            .study
            .point(index)
            .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
        let place = StudyPlace::of(self.study, &first, |_| true);
        let mut points = Vec::new();
        let discovery = self.follow(index, column, first, &mut points);
        Ok(PointChoice { points, findings: vec![Finding { place, discovery }], more: None })
    }

    /// Follows the meshes from the `first` point on and adds each to `points`.
    fn follow(
        &self,
        index: usize,
        column: &Column,
        first: StudyPoint,
        points: &mut Vec<StudyPoint>,
    ) -> Discovery {
        let mut sides = first.job.mesh().sides();
        let mut point = first;
        let mut before: Option<f64> = None;
        loop {
            let record = self.records.get(&point.key);
            let value = column.value(&point, record).as_f64();
            let is_across = matches!(point.job.mesh(), Mesh::Across(_));
            points.push(point);
            let value = match (record.map(Record::is_certified), value) {
                (None, _) => return Discovery::Pending,
                (Some(true), Some(value)) => value,
                _ => return Discovery::Unsolved,
            };
            let change = before.map(|before| relative_change(before, value));
            if let Some(change) = change.filter(|change| *change <= self.until) {
                return Discovery::Still { mesh: sides, value, change };
            }
            let doubled = sides.map(|n| n.saturating_mul(2));
            let finer = if is_across { Mesh::Across(doubled[0]) } else { Mesh::Exact(doubled) };
            let is_allowed = doubled.iter().all(|n| *n <= self.at_most);
            // A mesh that some jobs can have is too fine for others.
            match self.study.point_on_mesh(index, finer).filter(|_| is_allowed) {
                Some(next) => {
                    before = sides.iter().all(|n| *n >= LEAST_SIDE).then_some(value);
                    (sides, point) = (doubled, next);
                }
                None => return Discovery::NotStill { mesh: sides, value, change },
            }
        }
    }
}

/// Returns the change of a value relative to what it becomes.
fn relative_change(before: f64, value: f64) -> f64 {
    if value == before { 0.0 } else { (value - before).abs() / value.abs() }
}
