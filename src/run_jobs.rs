//! The jobs of a run. There may be a million, so little of each is in memory: those of a study that
//! chooses no points are enumerated, and their keys and texts are made whenever they are needed.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};
use std::error::Error;
use std::ops::Range;

use answers::{check, choice, forecast};
use anyhow::{Context, Result, anyhow};
use contact::Forecast;
use contact::model::SceneError;
use contact::problem::Problem;
use identity::JobKey;
use rayon::prelude::*;
use runner::Jobs;
use store::Store;
use study::{Job, Kind, PointKeys, PointLevels, Record, Study, StudyPoint};

use crate::stored::{RecordState, WrittenStore};
use crate::wire::order;

/// The error of a job that was listed and cannot be made again.
const NO_JOB: &str = "a job that was listed cannot be made again";

/// A kibibyte.
const KIB: u64 = 1024;

/// The number of jobs that are looked at together.
const AT_A_TIME: usize = 16_384;

/// The distinct jobs of some points of a study, in the order of their first points.
pub(crate) struct RunJobs<'s> {
    study: &'s Study,
    points: RunPoints<'s>,
    /// The position of the first point of each job among the points of the run.
    jobs: Vec<u32>,
    levels: PointLevels<'s>,
}

/// The points of a run.
enum RunPoints<'s> {
    /// The points of the axes.
    Enumerated(Box<PointKeys<'s>>),
    /// The points that the study has chosen.
    Chosen(Vec<StudyPoint>),
}

/// A job to be done, with its forecast in the room that a million of them leave.
#[derive(Clone, Copy)]
struct JobToDo {
    /// The number of the job among those of the run.
    job: u32,
    /// The predicted memory \[KiB\].
    memory: u32,
    /// The number of its operator.
    operator: u32,
    /// The predicted time \[s\].
    seconds: f32,
}

/// The jobs that were examined, in their order.
#[derive(Default)]
pub(crate) struct ExaminedJobs {
    list: Vec<JobToDo>,
    /// The part of the time of each job in which an operator is made that others may share \[s\].
    assemblies: Vec<f32>,
    /// The number of each operator.
    operators: HashMap<u64, u32>,
}

/// The jobs that are left to run.
pub(crate) struct JobsLeft<'j> {
    jobs: &'j RunJobs<'j>,
    list: Vec<JobToDo>,
    /// The number of those whose result is there but damaged.
    pub(crate) damaged: usize,
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
        (0..self.jobs.len()).filter_map(|job| self.key(job))
    }

    /// Returns the keys of a block of jobs.
    fn keys_of(&self, block: Range<usize>) -> Result<Vec<JobKey>> {
        block.into_par_iter().map(|job| self.key(job).context(NO_JOB)).collect()
    }

    /// Returns the numbers of the jobs, in blocks.
    fn blocks(&self) -> impl Iterator<Item = Range<usize>> {
        let count = self.jobs.len();
        (0..count).step_by(AT_A_TIME).map(move |start| start..count.min(start + AT_A_TIME))
    }

    /// Returns the key of a job.
    fn key(&self, job: usize) -> Option<JobKey> {
        let point = *self.jobs.get(job)? as usize;
        match &self.points {
            RunPoints::Enumerated(keys) => keys.key(self.study.index(point)?),
            RunPoints::Chosen(points) => Some(points.get(point)?.key),
        }
    }

    /// Returns a job.
    fn job(&self, job: usize) -> Option<Cow<'_, Job>> {
        let point = *self.jobs.get(job)? as usize;
        match &self.points {
            RunPoints::Enumerated(_) => {
                Some(Cow::Owned(self.study.job_at(self.study.index(point)?).ok()?))
            }
            RunPoints::Chosen(points) => Some(Cow::Borrowed(&points.get(point)?.job)),
        }
    }

    /// Returns the canonical text of a job.
    fn text(&self, job: usize) -> Option<String> {
        match &self.points {
            RunPoints::Enumerated(keys) => {
                keys.text(self.study.index(*self.jobs.get(job)? as usize)?)
            }
            RunPoints::Chosen(_) => Some(self.job(job)?.canonical()),
        }
    }

    /// Returns the order of a job to a worker.
    fn order(&self, job: usize) -> Result<Vec<u8>> {
        let surfaces = self.study.surfaces();
        let text = self.text(job).context(NO_JOB)?;
        let job = match surfaces.is_empty() {
            true => None,
            false => Some(self.job(job).context(NO_JOB)?),
        };
        order(job.as_deref(), text, surfaces)
    }

    /// Examines the jobs for which `is_done` does not hold, and refuses one whose scene cannot be
    /// laid out or bound to its grid, before anything runs. This takes less than a tenth of what
    /// solving them does, and assembles no operator.
    pub(crate) fn examine(&self, is_done: impl Fn(&JobKey) -> bool + Sync) -> Result<ExaminedJobs> {
        let mut examined = ExaminedJobs::default();
        for block in self.blocks() {
            let start = block.start;
            let keys = self.keys_of(block)?;
            let found = keys.par_iter().enumerate().map(|(offset, key)| match is_done(key) {
                true => Ok(None),
                false => self.examined(start + offset, true).map(Some),
            });
            let found: Vec<Result<Option<Forecast>>> = found.collect();
            for (job, forecast) in (start..).zip(found) {
                forecast?.iter().for_each(|forecast| examined.push(job, forecast));
            }
        }
        Ok(examined)
    }

    /// Forecasts a job and, if it is to be bound, tries that.
    fn examined(&self, number: usize, is_bound: bool) -> Result<Forecast> {
        let job = self.job(number).context(NO_JOB)?;
        let surfaces = self.study.surfaces();
        let refused = |error: SceneError| self.refused(number, &error);
        let forecast = forecast(&job, surfaces).map_err(refused)?;
        if let Some(case) = job.case().filter(|_| is_bound) {
            Problem::new(&case.scene, &case.numerics, surfaces).map_err(refused)?;
        }
        Ok(forecast)
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
        let mut damaged = 0;
        let mut to_do =
            ExaminedJobs { operators: examined.operators.clone(), ..Default::default() };
        for block in self.blocks() {
            let start = block.start;
            let keys = self.keys_of(block)?;
            let states = store.states(&keys)?;
            let found = keys.par_iter().zip(states).enumerate().map(|(offset, (key, state))| {
                let is_cached =
                    || state == RecordState::Present && !(retry_failed && has_failed(store, key));
                if computed.contains(key) || is_cached() {
                    return Ok(None);
                }
                let forecast = match examined.place(start + offset) {
                    Some(place) => JobForecast::Known(place),
                    None => JobForecast::New(self.examined(start + offset, false)?),
                };
                Ok(Some((forecast, state == RecordState::Damaged)))
            });
            let found: Vec<Result<Option<_>>> = found.collect();
            for (job, forecast) in (start..).zip(found) {
                let Some((forecast, is_damaged)) = forecast? else { continue };
                damaged += usize::from(is_damaged);
                match forecast {
                    JobForecast::Known(place) => {
                        to_do.list.push(examined.list[place]);
                        to_do.assemblies.push(examined.assemblies[place]);
                    }
                    JobForecast::New(forecast) => to_do.push(job, &forecast),
                }
            }
        }
        drop(examined);
        let ExaminedJobs { list, assemblies, .. } = to_do;
        let mut left = JobsLeft { jobs: self, list, damaged };
        left.share_operators(&assemblies);
        Ok(left)
    }

    /// Returns the rank of a job: a coarse grid of the axes goes first, so that there are answers
    /// early. Of what a study chooses all has the same rank.
    fn rank(&self, job: usize) -> u32 {
        match self.study.adaptive() {
            None => {
                let point = self.jobs.get(job).map(|point| *point as usize);
                let index = point.and_then(|point| self.study.index(point));
                index.map_or(0, |index| self.levels.level(index))
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
    fn refused(&self, job: usize, error: &SceneError) -> anyhow::Error {
        let point = self.jobs.get(job).map(|point| *point as usize);
        let index = point.and_then(|point| self.study.index(point));
        match index.and_then(|index| Some((index, self.study.point(index)?))) {
            Some((index, of_axes)) if Some(of_axes.key) == self.key(job) => {
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
    jobs: Vec<u32>,
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
            self.jobs.push(point);
        }
    }
}

/// The forecast of a job that is to be done.
enum JobForecast {
    /// The job was examined, at this place.
    Known(usize),
    New(Forecast),
}

impl ExaminedJobs {
    /// Adds the next job.
    fn push(&mut self, job: usize, forecast: &Forecast) {
        let Forecast { operator, seconds, assembly, memory, .. } = *forecast;
        let next = self.operators.len() as u32;
        self.list.push(JobToDo {
            job: job as u32,
            memory: u32::try_from(memory.div_ceil(KIB)).unwrap_or(u32::MAX),
            operator: *self.operators.entry(operator).or_insert(next),
            seconds: seconds as f32,
        });
        self.assemblies.push(assembly as f32);
    }

    /// Returns the place of a job if it was examined.
    fn place(&self, job: usize) -> Option<usize> {
        self.list.binary_search_by_key(&job, |examined| examined.job as usize).ok()
    }
}

impl JobsLeft<'_> {
    /// Returns the canonical text of a job.
    pub(crate) fn text(&self, job: usize) -> Option<String> {
        self.jobs.text(self.list.get(job)?.job as usize)
    }

    /// Returns the keys of the jobs.
    pub(crate) fn keys(&self) -> impl Iterator<Item = JobKey> + '_ {
        self.list.iter().filter_map(|job| self.jobs.key(job.job as usize))
    }

    /// Returns the keys of the jobs of the run that are not left.
    pub(crate) fn others(&self) -> impl Iterator<Item = JobKey> + '_ {
        // They are listed in their order.
        let is_left = |job: &usize| {
            let is_it = |left: &JobToDo| (left.job as usize).cmp(job);
            self.list.binary_search_by(is_it).is_ok()
        };
        let others = (0..self.jobs.len()).filter(move |job| !is_left(job));
        others.filter_map(|job| self.jobs.key(job))
    }

    /// Returns the predicted times of the jobs \[s\].
    pub(crate) fn costs(&self) -> impl Iterator<Item = f64> + '_ {
        self.list.iter().map(|job| f64::from(job.seconds))
    }

    /// Takes away all but so many jobs and returns them. A coarse grid of the axes stays, if there
    /// is one.
    pub(crate) fn split_off(&mut self, most: usize) -> Self {
        let jobs = self.jobs;
        let rest = match most < self.list.len() {
            true => {
                self.list.sort_by_cached_key(|job| jobs.rank(job.job as usize));
                self.list.split_off(most)
            }
            false => Vec::new(),
        };
        JobsLeft { jobs, list: rest, damaged: 0 }
    }

    /// Leaves the time that an operator takes with the first of the jobs that share it.
    /// `assemblies` has that time for each of the jobs \[s\].
    fn share_operators(&mut self, assemblies: &[f32]) {
        let mut first: HashMap<u32, usize> = HashMap::new();
        // Within a group, jobs of a low rank go first, and of these the long ones.
        let turn =
            |job: &JobToDo| (self.jobs.rank(job.job as usize), Reverse(job.seconds.to_bits()));
        for (index, job) in self.list.iter().enumerate() {
            let first = first.entry(job.operator).or_insert(index);
            if turn(job) < turn(&self.list[*first]) {
                *first = index;
            }
        }
        for (index, (job, assembly)) in self.list.iter_mut().zip(assemblies).enumerate() {
            if first.get(&job.operator) != Some(&index) {
                job.seconds -= assembly;
            }
        }
    }
}

impl Jobs for JobsLeft<'_> {
    fn count(&self) -> usize {
        self.list.len()
    }

    fn key(&self, job: usize) -> JobKey {
        self.jobs.key(self.list[job].job as usize).expect("a job that was listed has a key")
    }

    fn group(&self, job: usize) -> u64 {
        self.list[job].operator.into()
    }

    fn rank(&self, job: usize) -> u32 {
        self.jobs.rank(self.list[job].job as usize)
    }

    fn cost(&self, job: usize) -> f64 {
        self.list[job].seconds.into()
    }

    fn memory(&self, job: usize) -> u64 {
        u64::from(self.list[job].memory) * KIB
    }

    fn size(&self, job: usize) -> usize {
        self.jobs.order(self.list[job].job as usize).map_or(0, |order| order.len())
    }

    fn payload(&self, job: usize) -> Result<Cow<'_, [u8]>, Box<dyn Error + Send + Sync>> {
        Ok(Cow::Owned(self.jobs.order(self.list[job].job as usize)?))
    }
}

/// Tells whether the record of a job is not certified, or cannot be read.
fn has_failed(store: &WrittenStore<'_>, key: &JobKey) -> bool {
    match store.get(key) {
        Ok(Some(bytes)) => Record::decode(&bytes).map_or(true, |record| !record.is_certified()),
        _ => true,
    }
}
