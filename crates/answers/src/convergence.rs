//! Compares the rungs of the ladders of a convergence study with what they converge to.
//!
//! The files below gather and compare a ladder, and make the tables of orders and of limits. They
//! know [`comparison`](crate::comparison), places, rows and records, and no kind of study.

mod ladder;
mod limits;
mod orders;

use study::kind::convergence::{Ladder, Reference};
use study::{Study, StudyPoint};

use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::evidence::Evidence;
use crate::place::{PointGroup, group_points};

use ladder::{LadderRungs, exact};

/// Refuses a study that asks for a closed form if some scene has none, before anything is solved.
pub(crate) fn check(
    study: &Study,
    ladder: &Ladder,
    points: &[StudyPoint],
) -> Result<(), AnswerError> {
    if ladder.reference != Some(Reference::ClosedForm) {
        return Ok(());
    }
    for PointGroup { place, members } in ladders(study, ladder, points) {
        let mut cases = members.iter().filter_map(|point| points[*point].job.case());
        if cases.any(|case| exact(ladder, case).is_none()) {
            return Err(AnswerError::Refused(format!(
                "{}: {} has no closed form; leave `reference` out of [convergence] to compare with \
                 the finest",
                study.path(),
                place.scene()
            )));
        }
    }
    Ok(())
}

/// Gathers the ladders of a convergence study from what was solved, and compares their rungs.
pub(crate) fn compare(evidence: &Evidence<'_>, ladder: &Ladder) -> Result<Comparison, AnswerError> {
    let Evidence { study, points, .. } = *evidence;
    let mut comparison = Comparison::of_points(points.len());
    let mut compared_ladders: Vec<LadderRungs<'_>> = Vec::new();
    for group in ladders(study, ladder, points) {
        let rungs = ladder::compare(evidence, ladder, group, &mut comparison.compared)?;
        compared_ladders.extend(rungs);
    }
    let orders = orders::table(study, ladder, &compared_ladders, &comparison.compared)?;
    comparison.answers.push(AnswerTable { title: "orders".into(), table: orders });
    if let Some(limits) = limits::table(study, ladder, &compared_ladders)? {
        comparison.answers.push(AnswerTable { title: "limits".into(), table: limits });
    }
    Ok(comparison)
}

/// Returns the points of each ladder: those that differ in their rung only.
fn ladders(study: &Study, ladder: &Ladder, points: &[StudyPoint]) -> Vec<PointGroup> {
    group_points(study, points, |group| group == ladder.group)
}
