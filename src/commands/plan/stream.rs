//! The sums of a plan, of points that pass by in blocks. Of each job only the 16 bytes stay that
//! tell it from others, with eight for its effects where points are listed, and of each operator
//! eight.

use std::collections::HashSet;

use answers::effects::{Overview, OverviewDraft};
use answers::{check, forecast};
use anyhow::{Result, bail};
use contact::Forecast;
use identity::JobKey;
use rayon::prelude::*;
use store::StoreReader;
use study::{HoldingCounts, PointDecision, Study, StudyPoint};

use super::tally::PlanTally;
use crate::job_list::{bound, refused};

/// The largest number of points of a plan, which then takes about half a GiB.
const MOST_PLANNED: usize = 10_000_000;

/// The number of points that are laid out at a time.
const POINTS_AT_A_TIME: usize = 4096;

/// The number of points whose forecasts alone are made at a time.
const FORECASTS_AT_A_TIME: usize = 16_384;

/// The number of points whose effects and whose scenes are looked at in a study of more points than
/// are listed.
const LOOKED_AT: usize = 256;

/// The number of lines about files that a plan shows; the others are only counted.
const MOST_FILES: usize = 12;

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

/// The jobs of a study as far as its points have passed by.
pub(super) struct PlanSurvey<'s> {
    study: &'s Study,
    reader: Option<&'s StoreReader>,
    pub(super) tally: PlanTally,
    effects: OverviewDraft<'s>,
    /// The lines about files, each once.
    files: HashSet<String>,
    first_files: Vec<String>,
}

/// The facts of a plan about all points.
pub(super) struct PlanFacts {
    pub(super) tally: PlanTally,
    pub(super) overview: Overview,
    /// The lines about files.
    pub(super) files: Vec<String>,
}

impl<'s> PlanSurvey<'s> {
    /// Returns that of no point.
    pub(super) fn of(study: &'s Study, reader: Option<&'s StoreReader>) -> Self {
        PlanSurvey {
            study,
            reader,
            tally: PlanTally::default(),
            effects: OverviewDraft::of(study),
            files: HashSet::new(),
            first_files: Vec::new(),
        }
    }

    /// Adds all points of a study that chooses none.
    pub(super) fn add_all(&mut self) -> Result<()> {
        self.tally.excluded = self.study.excluded();
        if !self.study.has_independent_points() {
            return self.add(&self.study.points());
        }
        self.study.point_blocks(POINTS_AT_A_TIME).try_for_each(|points| self.add(&points))
    }

    /// Adds the next points. One that cannot be laid out or bound to its grid is an error.
    pub(super) fn add(&mut self, points: &[StudyPoint]) -> Result<()> {
        let (study, before) = (self.study, self.tally.points);
        let first = self.effects.first_of_jobs(points);
        let forecasts: Vec<Result<Forecast>> = first
            .par_iter()
            .map(|index| {
                let point = &points[*index];
                forecast(&point.job, study.surfaces())
                    .map_err(|error| refused(study, before + index, point, &error))
            })
            .collect();
        let mut distinct = Vec::with_capacity(first.len());
        for (index, forecast) in first.iter().zip(forecasts) {
            distinct.push(PlannedPoint { key: points[*index].key, forecast: forecast? });
        }
        check(study, points)?;
        self.effects.add(points)?;
        self.tally.points += points.len();
        let is_cached = self.count(&distinct)?;
        let left = first.par_iter().zip(&is_cached).filter(|(_, is_cached)| !**is_cached);
        let error =
            left.find_map_first(|(index, _)| bound(study, before + index, &points[*index]).err());
        if let Some(error) = error {
            return Err(error);
        }
        for (index, PlannedPoint { forecast, .. }) in first.iter().zip(&distinct) {
            for line in study.file_words(&points[*index].job, forecast.elements) {
                if self.files.insert(line.clone()) && self.files.len() <= MOST_FILES {
                    self.first_files.push(line);
                }
            }
        }
        Ok(())
    }

    /// Counts jobs that were not there before, and says of each whether the store has its result.
    fn count(&mut self, distinct: &[PlannedPoint]) -> Result<Vec<bool>> {
        let keys: Vec<JobKey> = distinct.iter().map(|point| point.key).collect();
        let is_cached = match self.reader {
            Some(reader) => reader.contains(&keys)?,
            None => vec![false; keys.len()],
        };
        self.tally.jobs += distinct.len();
        for (point, is_cached) in distinct.iter().zip(&is_cached) {
            self.tally.forecast += point.forecast.seconds;
            if !is_cached {
                self.tally.add(&point.forecast);
            }
        }
        Ok(is_cached)
    }

    /// Counts the points of a study that has more of them than are listed; a point without meaning
    /// is an error. The effects and the scenes are those of some points, evenly spread, whose
    /// number it returns.
    pub(super) fn add_streamed(&mut self) -> Result<usize> {
        let study = self.study;
        let mut looked_at = PlanSurvey::of(study, None);
        looked_at.add(&spread(study))?;
        (self.effects, self.files, self.first_files) =
            (looked_at.effects, looked_at.files, looked_at.first_files);
        if study.len() > MOST_PLANNED {
            bail!(
                "the study has {} points, and {MOST_PLANNED} at most are planned at once; `plan \
                 --shards COUNT` counts them in shards, and `plan --shard 1/COUNT` plans one of \
                 these",
                study.len()
            );
        }
        // Half of each job's digest tells 10⁷ jobs apart but for one chance in 10²⁴.
        let mut seen: HashSet<u128> = HashSet::new();
        let mut holding = HoldingCounts::default();
        for first in (0..study.len()).step_by(FORECASTS_AT_A_TIME) {
            let last = study.len().min(first + FORECASTS_AT_A_TIME);
            let steps: Vec<Result<PlannedStep>> =
                (first..last).into_par_iter().map(|index| planned(study, index)).collect();
            let mut distinct = Vec::with_capacity(steps.len());
            for step in steps {
                let PlannedStep { point, holding: of_point } = step?;
                holding = holding.with(of_point);
                let Some(point) = point else {
                    self.tally.excluded += 1;
                    continue;
                };
                self.tally.points += 1;
                if seen.insert(point.key.half()) {
                    distinct.push(point);
                }
            }
            self.count(&distinct)?;
        }
        self.tally.remarks = study.idle_conditions(self.tally.excluded, &holding)?;
        Ok(looked_at.tally.jobs)
    }

    /// Returns what came of all points.
    pub(super) fn facts(self) -> PlanFacts {
        let mut files = self.first_files;
        if let Some(rest) = self.files.len().checked_sub(MOST_FILES).filter(|rest| *rest > 0) {
            files.push(format!("and {rest} more lines about files"));
        }
        PlanFacts { tally: self.tally, overview: self.effects.overview(), files }
    }
}

/// Returns some points of a study, evenly spread.
fn spread(study: &Study) -> Vec<StudyPoint> {
    let count = LOOKED_AT.min(study.len());
    let index = |point: usize| point * (study.len() - 1) / (count - 1).max(1);
    let kept = |index: &usize| study.decision(*index).is_ok_and(|decision| !decision.is_excluded);
    let indices = (0..count).into_par_iter().map(index).filter(kept);
    indices.filter_map(|index| study.point(index)).collect()
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
