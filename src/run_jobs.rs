//! The jobs of a run. Those of a study that chooses no points are enumerated: of each the key is
//! in memory, and its text is made when a worker gets it and when its result is kept.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::error::Error;

use answers::{check, choice, forecast};
use anyhow::{Context, Result, anyhow};
use contact::model::SceneError;
use contact::problem::Problem;
use identity::JobKey;
use rayon::prelude::*;
use runner::{Payload, Task};
use store::Store;
use study::{Job, Kind, PointKeys, PointLevels, Record, Study, StudyPoint};

use crate::stored::{RecordState, WrittenStore};
use crate::wire::order;

/// The number of jobs that are looked at together.
const AT_A_TIME: usize = 16_384;

/// The distinct jobs of some points of a study, in the order of their first points.
pub(crate) struct RunJobs<'s> {
    study: &'s Study,
    points: RunPoints<'s>,
    jobs: Vec<RunJob>,
    levels: PointLevels<'s>,
}

/// The points of a run.
enum RunPoints<'s> {
    /// The points of the axes.
    Enumerated(Box<PointKeys<'s>>),
    /// The points that the study has chosen.
    Chosen(Vec<StudyPoint>),
}

/// A job of a run.
#[derive(Clone, Copy)]
struct RunJob {
    key: JobKey,
    /// The position of the first point among those of the run.
    point: u32,
}

/// The part of a forecast on which the order of jobs depends.
#[derive(Clone, Copy)]
struct JobForecast {
    operator: u64,
    /// The predicted time \[s\].
    seconds: f64,
    /// The part of that time in which an operator is made that other jobs may share \[s\].
    assembly: f64,
    /// The predicted memory \[bytes\].
    memory: u64,
}

/// The forecasts of the jobs that were examined; empty if none were.
#[derive(Default)]
pub(crate) struct ExaminedJobs(Vec<Option<JobForecast>>);

/// The jobs that are left to run.
pub(crate) struct JobsLeft<'j> {
    pub(crate) tasks: Vec<Task<JobOrder<'j>>>,
    /// The number of those whose result is there but damaged.
    pub(crate) damaged: usize,
}

/// The order of a job to a worker, which is made when it is sent.
#[derive(Clone, Copy)]
pub(crate) struct JobOrder<'j> {
    jobs: &'j RunJobs<'j>,
    /// The index of the job.
    job: u32,
    /// The size of the order \[bytes\].
    bytes: u32,
}

impl<'s> RunJobs<'s> {
    /// Lists the jobs at the points of the axes, and refuses a study that asks its scenes for what
    /// they do not have.
    pub(crate) fn of_axes(study: &'s Study) -> Result<Self> {
        choice::check(study)?;
        if study.kind() != Kind::Solve {
            check(study, &study.points())?;
        }
        let keys = PointKeys::of(study);
        let mut list = JobCollector::default();
        let indices: Vec<usize> = study.indices().collect();
        for block in indices.chunks(AT_A_TIME) {
            let found: Vec<_> = block.par_iter().map(|index| keys.key(*index)).collect();
            found.into_iter().for_each(|key| list.add(key));
        }
        let points = RunPoints::Enumerated(Box::new(keys));
        Ok(Self { study, points, jobs: list.jobs, levels: study.levels() })
    }

    /// Lists the jobs at points that the study has chosen.
    pub(crate) fn of_points(study: &'s Study, points: Vec<StudyPoint>) -> Self {
        let mut list = JobCollector::default();
        points.iter().for_each(|point| list.add(Some(point.key)));
        let (points, levels) = (RunPoints::Chosen(points), study.levels());
        Self { study, points, jobs: list.jobs, levels }
    }

    /// Returns the number of jobs.
    pub(crate) fn len(&self) -> usize {
        self.jobs.len()
    }

    /// Returns the keys of the jobs.
    pub(crate) fn keys(&self) -> impl Iterator<Item = JobKey> + '_ {
        self.jobs.iter().map(|job| job.key)
    }

    /// Returns a job.
    fn job(&self, RunJob { point, .. }: RunJob) -> Option<Cow<'_, Job>> {
        let position = point as usize;
        match &self.points {
            RunPoints::Enumerated(_) => {
                Some(Cow::Owned(self.study.job_at(self.study.index(position)?).ok()?))
            }
            RunPoints::Chosen(points) => Some(Cow::Borrowed(&points.get(position)?.job)),
        }
    }

    /// Returns the canonical text of a job.
    fn text(&self, job: RunJob) -> Option<String> {
        match &self.points {
            RunPoints::Enumerated(keys) => keys.text(self.study.index(job.point as usize)?),
            RunPoints::Chosen(_) => Some(self.job(job)?.canonical()),
        }
    }

    /// Examines the jobs for which `is_done` does not hold, and refuses one whose scene cannot be
    /// laid out or bound to its grid, before anything runs. This takes less than a tenth of what
    /// solving them does, and assembles no operator.
    pub(crate) fn examine(&self, is_done: impl Fn(&JobKey) -> bool + Sync) -> Result<ExaminedJobs> {
        let mut forecasts = Vec::with_capacity(self.jobs.len());
        for block in self.jobs.chunks(AT_A_TIME) {
            let examined = block.par_iter().map(|job| match is_done(&job.key) {
                true => Ok(None),
                false => self.examined(*job, true).map(Some),
            });
            let examined: Vec<Result<Option<JobForecast>>> = examined.collect();
            for forecast in examined {
                forecasts.push(forecast?);
            }
        }
        Ok(ExaminedJobs(forecasts))
    }

    /// Forecasts a job and, if it is to be bound, tries that.
    fn examined(&self, listed: RunJob, is_bound: bool) -> Result<JobForecast> {
        let job = self.job(listed).context("a point of the study has no job")?;
        let surfaces = self.study.surfaces();
        let refused = |error: SceneError| self.refused(listed, &error);
        let forecast = forecast(&job, surfaces).map_err(refused)?;
        if let Some(case) = job.case().filter(|_| is_bound) {
            Problem::new(&case.scene, &case.numerics, surfaces).map_err(refused)?;
        }
        let contact::Forecast { operator, seconds, assembly, memory, .. } = forecast;
        Ok(JobForecast { operator, seconds, assembly, memory })
    }

    /// Returns the jobs that are left, without those in `computed`. Those that were not examined
    /// are forecast now.
    pub(crate) fn left(
        &self,
        examined: ExaminedJobs,
        store: &WrittenStore<'_>,
        retry_failed: bool,
        computed: &HashSet<JobKey>,
    ) -> Result<JobsLeft<'_>> {
        let mut left = JobsLeft { tasks: Vec::new(), damaged: 0 };
        let mut assemblies = Vec::new();
        for (block, jobs) in self.jobs.chunks(AT_A_TIME).enumerate() {
            let keys: Vec<JobKey> = jobs.iter().map(|job| job.key).collect();
            let states = store.states(&keys)?;
            let tasks = jobs.par_iter().zip(states).enumerate().map(|(offset, (job, state))| {
                let is_cached = || {
                    state == RecordState::Present && !(retry_failed && has_failed(store, &job.key))
                };
                if computed.contains(&job.key) || is_cached() {
                    return Ok(None);
                }
                let index = block * AT_A_TIME + offset;
                let forecast = match examined.0.get(index).copied().flatten() {
                    Some(forecast) => forecast,
                    None => self.examined(*job, false)?,
                };
                let task = self.task(index, *job, &forecast)?;
                Ok(Some((task, forecast.assembly, state == RecordState::Damaged)))
            });
            let tasks: Vec<Result<Option<_>>> = tasks.collect();
            for task in tasks {
                if let Some((task, assembly, is_damaged)) = task? {
                    left.damaged += usize::from(is_damaged);
                    left.tasks.push(task);
                    assemblies.push(assembly);
                }
            }
        }
        share_operators(&mut left.tasks, &assemblies);
        Ok(left)
    }

    fn task(
        &self,
        index: usize,
        job: RunJob,
        forecast: &JobForecast,
    ) -> Result<Task<JobOrder<'_>>> {
        let JobForecast { operator, seconds, memory, .. } = *forecast;
        let mut order = JobOrder { jobs: self, job: index as u32, bytes: 0 };
        order.bytes = u32::try_from(order.made()?.len()).unwrap_or(u32::MAX);
        Ok(Task {
            key: job.key,
            payload: order,
            group: operator,
            rank: self.rank(job),
            cost: seconds,
            memory,
        })
    }

    /// Returns the rank of a job: a coarse grid of the axes goes first, so that there are answers
    /// early. Of what a study chooses all has the same rank.
    fn rank(&self, job: RunJob) -> u32 {
        match self.study.adaptive() {
            None => {
                self.study.index(job.point as usize).map_or(0, |index| self.levels.level(index))
            }
            Some(_) => 0,
        }
    }

    /// Fails if a job has no certified result in a store.
    pub(crate) fn require_certified(&self, store: &Store) -> Result<()> {
        for key in self.keys() {
            let bytes = store.get(&key)?.context("its result is not in the store")?;
            let record = Record::decode(&bytes)?;
            if !record.is_certified() {
                return Err(anyhow!("its result is not certified, but {}", record.standing()));
            }
        }
        Ok(())
    }

    /// Returns what is wrong with the scene of a job, at its place in the study file.
    fn refused(&self, job: RunJob, error: &SceneError) -> anyhow::Error {
        let position = job.point as usize;
        let index = self.study.index(position);
        match index.and_then(|index| Some((index, self.study.point(index)?))) {
            Some((index, of_axes)) if of_axes.key == job.key => {
                self.study.refuse(index, error).into()
            }
            // The study has chosen the point, so it has no place in the file.
            _ => anyhow!("{}: {error}", self.study.path()),
        }
    }
}

/// Collects distinct jobs.
#[derive(Default)]
struct JobCollector {
    /// Half of each key.
    seen: HashSet<u128>,
    jobs: Vec<RunJob>,
    /// The number of points so far.
    points: u32,
}

impl JobCollector {
    /// Adds the job of the next point, if that has one.
    fn add(&mut self, key: Option<JobKey>) {
        let point = self.points;
        self.points += 1;
        let Some(key) = key else { return };
        if self.seen.insert(key.half()) {
            self.jobs.push(RunJob { key, point });
        }
    }
}

impl JobOrder<'_> {
    /// Returns the canonical text of the job.
    pub(crate) fn text(&self) -> Option<String> {
        self.jobs.text(*self.jobs.jobs.get(self.job as usize)?)
    }

    fn made(&self) -> Result<Vec<u8>> {
        let none = "a job that was listed cannot be made again";
        let surfaces = self.jobs.study.surfaces();
        let text = self.text().context(none)?;
        let job = match surfaces.is_empty() {
            true => None,
            false => {
                let listed = self.jobs.jobs.get(self.job as usize).context(none)?;
                Some(self.jobs.job(*listed).context(none)?)
            }
        };
        order(job.as_deref(), text, surfaces)
    }
}

impl Payload for JobOrder<'_> {
    fn size(&self) -> usize {
        self.bytes as usize
    }

    fn bytes(&self) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>> {
        Ok(Cow::Owned(self.made()?))
    }
}

/// Leaves the time that an operator takes with the first of the jobs that share it. `assemblies`
/// has that time for each of the tasks \[s\].
fn share_operators<P>(tasks: &mut [Task<P>], assemblies: &[f64]) {
    let mut first: HashMap<u64, usize> = HashMap::new();
    // Within a group, jobs of a low rank go first, and of these the long ones.
    let turn = |task: &Task<P>| (task.rank, Reverse(task.cost.to_bits()));
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
fn has_failed(store: &WrittenStore<'_>, key: &JobKey) -> bool {
    match store.get(key) {
        Ok(Some(bytes)) => Record::decode(&bytes).map_or(true, |record| !record.is_certified()),
        _ => true,
    }
}
