//! The jobs of a study whose points are in memory.

use std::collections::HashSet;

use answers::effects::{Overview, overview};
use answers::{check, choice, forecast};
use anyhow::{Result, anyhow};
use contact::Forecast;
use contact::model::SceneError;
use contact::problem::Problem;
use identity::JobKey;
use rayon::prelude::*;
use study::{Study, StudyPoint};

/// The points of a study and their distinct jobs, in the order of their first points.
pub(crate) struct JobList {
    pub(crate) points: Vec<StudyPoint>,
    pub(crate) distinct: Vec<DistinctJob>,
}

/// A job that one or several points share.
pub(crate) struct DistinctJob {
    /// The index of the first point.
    pub(crate) point: usize,
    /// The prediction of what it takes.
    pub(crate) forecast: Forecast,
}

impl JobList {
    /// Lists the jobs of a study and refuses one of which some point cannot be laid out, before
    /// anything runs.
    pub(crate) fn of(study: &Study) -> Result<Self> {
        choice::check(study)?;
        let jobs = Self::of_points(study, study.points())?;
        check(study, &jobs.points)?;
        Ok(jobs)
    }

    /// Lists the jobs of some points of a study.
    pub(crate) fn of_points(study: &Study, points: Vec<StudyPoint>) -> Result<Self> {
        let mut seen = HashSet::new();
        let mut distinct = Vec::new();
        for (index, point) in points.iter().enumerate().filter(|(_, point)| seen.insert(point.key))
        {
            let forecast = forecast(&point.job, study.surfaces())
                .map_err(|error| refused(study, index, point, &error))?;
            distinct.push(DistinctJob { point: index, forecast });
        }
        Ok(Self { points, distinct })
    }

    /// Refuses scenes that cannot be bound to their grids, except those of jobs for which `is_done`
    /// holds. This takes less than a tenth of what solving them does, and assembles no operator.
    pub(crate) fn bind(
        &self,
        study: &Study,
        is_done: impl Fn(&JobKey) -> bool + Sync,
    ) -> Result<()> {
        let error = |job: &DistinctJob| {
            let point = &self.points[job.point];
            if is_done(&point.key) { None } else { bound(study, job.point, point).err() }
        };
        match self.distinct.par_iter().find_map_first(error) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Returns the effects of all jobs.
    pub(crate) fn effects(&self, study: &Study) -> Result<Overview> {
        Ok(overview(study, &self.points)?)
    }
}

/// Refuses the scene of the point at a position if it cannot be bound to its grid.
pub(crate) fn bound(study: &Study, position: usize, point: &StudyPoint) -> Result<()> {
    let Some(case) = point.job.case() else { return Ok(()) };
    match Problem::new(&case.scene, &case.numerics, study.surfaces()) {
        Ok(_) => Ok(()),
        Err(error) => Err(refused(study, position, point, &error)),
    }
}

/// Returns what is wrong with the scene of the point at a position, at its place in the study file.
pub(crate) fn refused(
    study: &Study,
    position: usize,
    point: &StudyPoint,
    error: &SceneError,
) -> anyhow::Error {
    let index = study.index(position);
    match index.and_then(|index| Some((index, study.point(index)?))) {
        Some((index, of_axes)) if of_axes.key == point.key => study.refuse(index, error).into(),
        // The study has chosen the point, so it has no place in the file.
        _ => anyhow!("{}: {error}", study.path()),
    }
}
