//! The jobs of a study, and those of them that are left.

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};

use answers::effects::{Overview, overview};
use answers::{check, choice, forecast};
use anyhow::{Result, anyhow};
use contact::Forecast;
use contact::model::SceneError;
use contact::problem::Problem;
use identity::JobKey;
use rayon::prelude::*;
use runner::Task;
use study::{Record, Study, StudyPoint};

use crate::stored::{RecordState, WrittenStore};
use crate::wire::order;

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

/// The jobs that are left to run.
pub(crate) struct JobsLeft {
    pub(crate) tasks: Vec<Task>,
    /// The number of those whose result is there but damaged.
    pub(crate) damaged: usize,
    /// The canonical text of each job.
    pub(crate) texts: HashMap<JobKey, String>,
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
            let case = point.job.case().filter(|_| !is_done(&point.key))?;
            let error = Problem::new(&case.scene, &case.numerics, study.surfaces()).err()?;
            Some(refused(study, job.point, point, &error))
        };
        match self.distinct.par_iter().find_map_first(error) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Returns the jobs that are left, without those in `computed`.
    pub(crate) fn left(
        &self,
        study: &Study,
        store: &WrittenStore,
        retry_failed: bool,
        computed: &HashSet<JobKey>,
    ) -> Result<JobsLeft> {
        let mut left = JobsLeft { tasks: Vec::new(), damaged: 0, texts: HashMap::new() };
        let mut assemblies = Vec::new();
        for (DistinctJob { point, forecast }, state) in
            self.distinct.iter().zip(store.states(&self.keys())?)
        {
            let StudyPoint { job, key, .. } = &self.points[*point];
            let is_cached =
                || state == RecordState::Present && !(retry_failed && has_failed(store, key));
            if computed.contains(key) || is_cached() {
                continue;
            }
            left.damaged += usize::from(state == RecordState::Damaged);
            let text = job.canonical();
            left.tasks.push(Task {
                key: *key,
                payload: order(job, text.clone(), study.surfaces())?,
                group: forecast.operator,
                rank: self.rank(study, *point),
                cost: forecast.seconds,
                memory: forecast.memory,
            });
            assemblies.push(forecast.assembly);
            left.texts.insert(*key, text);
        }
        share_operators(&mut left.tasks, &assemblies);
        Ok(left)
    }

    /// Returns the rank of the job of a point: a coarse grid of the axes goes first, so that there
    /// are answers early. Of what a study chooses all has the same rank.
    fn rank(&self, study: &Study, point: usize) -> u32 {
        match study.adaptive() {
            None => study.index(point).map_or(0, |index| study.level(index)),
            Some(_) => 0,
        }
    }

    /// Returns the effects of all jobs.
    pub(crate) fn effects(&self, study: &Study) -> Result<Overview> {
        let first: Vec<usize> = self.distinct.iter().map(|job| job.point).collect();
        Ok(overview(study, &self.points, &first)?)
    }

    /// Returns the keys of the distinct jobs.
    pub(crate) fn keys(&self) -> Vec<JobKey> {
        self.distinct.iter().map(|job| self.points[job.point].key).collect()
    }
}

/// Leaves the time that an operator takes with the first of the jobs that share it. `assemblies` has
/// that time for each of the tasks \[s\].
fn share_operators(tasks: &mut [Task], assemblies: &[f64]) {
    let mut first: HashMap<u64, usize> = HashMap::new();
    // Within a group, jobs of a low rank go first, and of these the long ones.
    let turn = |task: &Task| (task.rank, Reverse(task.cost.to_bits()));
    for (index, task) in tasks.iter().enumerate() {
        let first = first.entry(task.group).or_insert(index);
        if turn(task) < turn(&tasks[*first]) {
            *first = index;
        }
    }
    for (index, (task, assembly)) in tasks.iter_mut().zip(assemblies).enumerate() {
        if first.get(&task.group) != Some(&index) {
            task.cost -= assembly;
        }
    }
}

/// Tells whether the record of a job is not certified, or cannot be read.
fn has_failed(store: &WrittenStore, key: &JobKey) -> bool {
    match store.get(key) {
        Ok(Some(bytes)) => Record::decode(&bytes).map_or(true, |record| !record.is_certified()),
        _ => true,
    }
}

/// Returns what is wrong with the scene of the point at a position, at its place in the study file.
fn refused(
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
