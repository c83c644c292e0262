//! The jobs of a study, and those of them that are left.

use std::collections::{HashMap, HashSet};

use answers::effects::{Overview, overview};
use answers::perform::forecast;
use answers::{choice, convergence, cost};
use anyhow::{Result, anyhow};
use contact::Forecast;
use contact::model::SceneError;
use contact::problem::Problem;
use identity::JobKey;
use rayon::prelude::*;
use runner::Task;
use store::Store;
use study::{Job, Record, Study, StudyPoint};

use crate::wire::order;

/// The distinct jobs of a study with what they will take, in the order of their first points.
pub(crate) struct Jobs {
    pub(crate) points: Vec<StudyPoint>,
    pub(crate) distinct: Vec<(usize, Forecast)>,
}

impl Jobs {
    /// Refuses a study of which some point cannot be laid out, before anything runs.
    pub(crate) fn of(study: &Study) -> Result<Self> {
        choice::check(study)?;
        let jobs = Self::of_points(study, study.points())?;
        if let Some(ladder) = &study.ladder() {
            convergence::check(study, ladder, &jobs.points)?;
        }
        if let Some(cost) = &study.cost() {
            cost::check(study, cost, &jobs.points)?;
        }
        Ok(jobs)
    }

    pub(crate) fn of_points(study: &Study, points: Vec<StudyPoint>) -> Result<Self> {
        let mut seen = HashSet::new();
        let mut distinct = Vec::new();
        for (index, point) in points.iter().enumerate().filter(|(_, point)| seen.insert(point.key))
        {
            let forecast = forecast(&point.job, study.surfaces())
                .map_err(|error| refused(study, index, point, &error))?;
            distinct.push((index, forecast));
        }
        Ok(Self { points, distinct })
    }

    /// Refuses scenes that cannot be bound to their grids, those of jobs that are `done` aside.
    /// That takes less than a tenth of what solving them does, and no operator is assembled.
    pub(crate) fn bind(&self, study: &Study, done: impl Fn(&JobKey) -> bool + Sync) -> Result<()> {
        let bound = |(index, _): &(usize, Forecast)| {
            let point = &self.points[*index];
            let case = point.job.case().filter(|_| !done(&point.key))?;
            let error = Problem::new(&case.scene, &case.numerics, study.surfaces()).err()?;
            Some((*index, error))
        };
        match self.distinct.par_iter().find_map_first(bound) {
            Some((index, error)) => Err(refused(study, index, &self.points[index], &error)),
            None => Ok(()),
        }
    }

    /// The tasks that are left, those in `computed` aside, and the texts of their jobs.
    pub(crate) fn left(
        &self,
        study: &Study,
        store: &Store,
        retry_failed: bool,
        computed: &HashSet<JobKey>,
    ) -> Result<(Vec<Task>, HashMap<JobKey, String>)> {
        let (mut tasks, mut texts) = (Vec::new(), HashMap::new());
        for (index, forecast) in &self.distinct {
            let point = &self.points[*index];
            let again = || match store.get(&point.key) {
                Ok(Some(bytes)) => {
                    Record::decode(&bytes).map_or(true, |record| !record.is_certified())
                }
                _ => true,
            };
            if computed.contains(&point.key)
                || store.contains(&point.key) && !(retry_failed && again())
            {
                continue;
            }
            let text = point.job.canonical();
            tasks.push(Task {
                key: point.key,
                payload: order(&point.job, text.clone(), study.surfaces())?,
                group: forecast.operator,
                cost: forecast.seconds,
                memory: forecast.memory,
            });
            texts.insert(point.key, text);
        }
        Ok((tasks, texts))
    }

    /// The effects of all of them.
    pub(crate) fn effects(&self, study: &Study) -> Result<Overview> {
        let first: Vec<usize> = self.distinct.iter().map(|(index, _)| *index).collect();
        Ok(overview(study, &self.points, &first)?)
    }

    pub(crate) fn keys(&self) -> Vec<JobKey> {
        self.distinct.iter().map(|(index, _)| self.points[*index].key).collect()
    }
}

/// What is wrong with a point's scene, where it stands in the study file.
fn refused(study: &Study, index: usize, point: &StudyPoint, error: &SceneError) -> anyhow::Error {
    match study.point(index) {
        Some(own) if own.key == point.key => study.refuse(index, error).into(),
        // a point that the study chose
        _ => anyhow!("{}: {error}", study.path()),
    }
}

/// Increments of a job's loading path.
pub(crate) fn increments(job: &Job) -> u64 {
    job.case().map_or(0, |case| u64::from(case.scene.loading.increments()))
}
