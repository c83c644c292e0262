//! Chooses the points of a study as far as its results determine them: those of its axes, and those
//! that it adds.
//!
//! The files below hold a rule each, and what a rule found. They know records, rows and places, and
//! neither this face nor a comparison of points.

mod accuracy;
mod bisect;
mod branch;
mod column_value;
mod condition;
mod fill;
mod find;
mod found;
mod leaves;
mod line;
mod narrowing;
mod refine;
mod roots;

use std::collections::HashSet;

use identity::JobKey;
use study::{Adaptive, PointKeys, Study, StudyPoint};

use crate::error::AnswerError;
use crate::records::{RecordMap, Records};

use bisect::Bisection;
use branch::BracketNarrowing;
use fill::Filler;
use find::RootFinder;
use refine::MeshRefinement;

pub use condition::check;
pub use found::{Discovery, Finding, Passage, PointChoice, table};

/// Chooses a study's points by the records that there are.
///
/// # Errors
/// A condition cannot be evaluated on some result.
pub fn choose(study: &Study, records: &RecordMap) -> Result<PointChoice, AnswerError> {
    match study.adaptive() {
        None => Ok(PointChoice { points: study.points(), ..PointChoice::bounded() }),
        Some(Adaptive::Refine { on, until, at_most }) => {
            let refinement =
                MeshRefinement { study, records, on, until: *until, at_most: *at_most };
            let mut choice = PointChoice::default();
            for index in study.indices() {
                choice.extend(refinement.choose(index)?);
            }
            Ok(choice)
        }
        Some(Adaptive::Bisect { axis, on, to, .. }) => {
            Bisection::new(study, records, *axis, on, *to)?.choose()
        }
        Some(Adaptive::Find(search)) => RootFinder::new(study, records, search)?.choose(),
        Some(Adaptive::Fill(filling)) => Filler::new(study, records, filling)?.choose(),
        Some(Adaptive::Branch { to, at_most }) => {
            let narrowing = BracketNarrowing { study, records, to: *to, at_most: *at_most };
            let mut choice = PointChoice::default();
            for index in study.indices() {
                choice.extend(narrowing.choose(index)?);
            }
            Ok(choice)
        }
        Some(Adaptive::Accuracy(accuracy)) => accuracy::choose(study, accuracy, records),
    }
}

/// Visits the jobs that a study refers to: those of its points, as far as the results that `source`
/// keeps determine them, and those from which the choice has learnt. A job may come several times.
/// Returns the points of a choice that stops where a result is missing: what it would choose beyond
/// is not known. There is none where the choice is finished, or the study does not choose.
///
/// # Errors
/// A record cannot be read, or a condition cannot be evaluated on some result.
pub fn visit_jobs(
    study: &Study,
    source: &dyn Records,
    visitor: impl FnMut(JobKey),
) -> Result<Vec<StudyPoint>, AnswerError> {
    if study.adaptive().is_none() {
        let keys = PointKeys::of(study);
        study.indices().filter_map(|index| keys.key(index)).for_each(visitor);
        return Ok(Vec::new());
    }
    let Gathered { choice, records } = gather(study, source)?;
    let is_open = choice.points.iter().any(|point| !records.contains_key(&point.key));
    choice.points.iter().map(|point| point.key).chain(records.into_keys()).for_each(visitor);
    Ok(if is_open { choice.points } else { Vec::new() })
}

/// The points of a study as far as its results determine them, with these results.
pub struct Gathered {
    /// The points, and what was found in choosing them.
    pub choice: PointChoice,
    /// The records that the points have, and those that the choice has learnt from.
    pub records: RecordMap,
}

/// Chooses a study's points by the results that `source` keeps, as far as these go.
///
/// # Errors
/// A record cannot be read, or a condition cannot be evaluated on some result.
pub fn gather(study: &Study, source: &dyn Records) -> Result<Gathered, AnswerError> {
    let mut records = RecordMap::new();
    if let Some(Adaptive::Accuracy(_)) = study.adaptive() {
        // Any study may have left them. Damaged ones teach nothing; where one belongs to a point of
        // this study, it is met below.
        let scenes = accuracy::scenes(study);
        let is_wanted = |job: &str| accuracy::solves(&scenes, job);
        records = source.matching(&is_wanted).map_err(AnswerError::Records)?;
    }
    let mut requested: HashSet<JobKey> = records.keys().copied().collect();
    loop {
        let choice = choose(study, &records)?;
        let keys = choice.points.iter().map(|point| point.key);
        let mut keys: Vec<JobKey> = keys.filter(|key| requested.insert(*key)).collect();
        keys.sort_unstable();
        let before = records.len();
        records.extend(source.select(&keys).map_err(AnswerError::Records)?);
        // The choice depends on the records that are there.
        if study.adaptive().is_none() || records.len() == before {
            return Ok(Gathered { choice, records });
        }
    }
}
