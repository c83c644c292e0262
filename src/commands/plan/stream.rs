//! The sums of a plan of more points than are listed: they pass one by one, and of each only 24
//! bytes stay, which tell its job and its operator from others.

use std::collections::HashSet;

use answers::forecast;
use anyhow::{Result, bail};
use contact::Forecast;
use identity::JobKey;
use rayon::prelude::*;
use store::StoreReader;
use study::{HoldingCounts, PointDecision, Study, StudyPoint};

use super::tally::PlanTally;

/// The largest number of points of a plan, which then takes about half a GiB.
const MOST_PLANNED: usize = 10_000_000;

/// The number of points whose forecasts are made at a time.
const AT_A_TIME: usize = 16_384;

/// The number of points whose effects and whose scenes are looked at more closely.
const LOOKED_AT: usize = 256;

/// A point of a plan.
struct PlannedPoint {
    key: JobKey,
    forecast: Forecast,
}

/// A step of the axes with the point that it makes.
struct PlannedStep {
    /// The point; `None` if the study's conditions leave it out.
    point: Option<PlannedPoint>,
    /// The conditions that hold there.
    holding: HoldingCounts,
}

/// Returns some points of a study, evenly spread.
pub(super) fn spread(study: &Study) -> Vec<StudyPoint> {
    let count = LOOKED_AT.min(study.len());
    let index = |point: usize| point * (study.len() - 1) / (count - 1).max(1);
    let kept = |index: &usize| study.decision(*index).is_ok_and(|decision| !decision.is_excluded);
    let indices = (0..count).into_par_iter().map(index).filter(kept);
    indices.filter_map(|index| study.point(index)).collect()
}

/// Returns the sums over all points of a study; a point without meaning is an error.
pub(super) fn tally(study: &Study, reader: Option<&StoreReader>) -> Result<PlanTally> {
    if study.len() > MOST_PLANNED {
        bail!(
            "the study has {} points, and {MOST_PLANNED} at most are planned at once; `plan \
             --shards COUNT` counts them in shards, and `plan --shard 1/COUNT` plans one of these",
            study.len()
        );
    }
    let mut tally = PlanTally::default();
    // Half of a digest tells 10⁷ jobs apart but for one chance in 10²⁴.
    let mut seen: HashSet<u128> = HashSet::new();
    let mut holding = HoldingCounts::default();
    for first in (0..study.len()).step_by(AT_A_TIME) {
        let last = study.len().min(first + AT_A_TIME);
        let points: Vec<Result<PlannedStep>> =
            (first..last).into_par_iter().map(|index| planned(study, index)).collect();
        let mut distinct = Vec::with_capacity(points.len());
        for point in points {
            let PlannedStep { point, holding: of_point } = point?;
            holding = holding.with(of_point);
            let Some(point) = point else {
                tally.excluded += 1;
                continue;
            };
            tally.points += 1;
            if seen.insert(point.key.half()) {
                distinct.push(point);
            }
        }
        let keys: Vec<JobKey> = distinct.iter().map(|point| point.key).collect();
        let is_cached = match reader {
            Some(reader) => reader.contains(&keys)?,
            None => vec![false; keys.len()],
        };
        tally.jobs += distinct.len();
        for (point, _) in distinct.iter().zip(is_cached).filter(|(_, cached)| !cached) {
            tally.add(&point.forecast);
        }
    }
    tally.remarks = study.idle_conditions(tally.excluded, &holding)?;
    Ok(tally)
}

/// Returns what a plan needs to know of a point.
fn planned(study: &Study, index: usize) -> Result<PlannedStep> {
    let PointDecision { is_excluded, holding } = study.decision(index)?;
    if is_excluded {
        return Ok(PlannedStep { point: None, holding });
    }
    let job = study.job_at(index)?;
    let forecast = forecast(&job, study.surfaces()).map_err(|error| study.refuse(index, &error))?;
    let point = PlannedPoint { key: job.key(), forecast };
    Ok(PlannedStep { point: Some(point), holding })
}
