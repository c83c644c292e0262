//! `run`, `resume` and `plan`: from a study to the jobs that are left, and running them.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use contact::Forecast;
use contact::problem::Problem;
use contact::scene::SceneError;
use indicatif::BinaryBytes;
use rayon::prelude::*;
use report::DataTable;
use runner::{Interrupt, Options, Task};
use serde::Serialize;
use store::{OpenError, Store};
use study::{Job, JobKey, Point, Record, Study};

use crate::cli::{CostArgs, ExecutionArgs, PlanArgs, ResumeArgs, RunArgs};
use crate::effects::{Group, Overview, overview};
use crate::ledger::Ledger;
use crate::output::{self, Finish, count};
use crate::progress::{Progress, duration};
use crate::results::{self, Results, Source};
use crate::solve::with_cost_ladder;
use crate::work::{forecast, order};
use crate::{adaptive, compare, cost, draw};

/// Rows of the table at the end of a run; more are for `query`.
const SUMMARY_ROWS: usize = 24;
/// Failed jobs listed at the end of a run; more are for `query`.
const LISTED_FAILURES: usize = 10;

/// Reads a study file; files that it names are looked for beside it.
pub(crate) fn read_study(path: &Path) -> Result<Study> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the study file {}", path.display()))?;
    Ok(parse_study(&text, path)?)
}

/// Parses the text of a study file as if it stood at `path`.
pub(crate) fn parse_study(text: &str, path: &Path) -> Result<Study, study::StudyError> {
    let beside = path.parent().unwrap_or(Path::new("."));
    Study::parse(text, &path.display().to_string(), &mut |name| {
        std::fs::read(beside.join(name)).map_err(|error| error.to_string())
    })
}

pub(crate) fn run(args: &RunArgs) -> Result<Finish> {
    execute(read_study(&args.study)?, &args.store.store, &args.execution)
}

pub(crate) fn cost(args: &CostArgs) -> Result<Finish> {
    let path = &args.study;
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the study file {}", path.display()))?;
    let study = parse_study(&with_cost_ladder(&text, path, &args.set)?, path)?;
    execute(study, &args.store.store, &args.execution)
}

pub(crate) fn resume(args: &ResumeArgs) -> Result<Finish> {
    // a resume that finds no study must not leave an empty store behind
    let study = results::stored_study(&Store::read(&args.store.store)?, &args.name)?;
    execute(study, &args.store.store, &args.execution)
}

/// The distinct jobs of a study with what they will take, in the order of their first points.
pub(crate) struct Jobs {
    pub(crate) points: Vec<Point>,
    distinct: Vec<(usize, Forecast)>,
}

impl Jobs {
    /// Refuses a study of which some point cannot be laid out, before anything runs.
    pub(crate) fn of(study: &Study) -> Result<Self> {
        adaptive::check(study)?;
        let jobs = Self::of_points(study, study.points())?;
        if let Some(ladder) = study.ladder() {
            compare::check(study, ladder, &jobs.points)?;
        }
        if let Some(cost) = study.cost() {
            cost::check(study, cost, &jobs.points)?;
        }
        Ok(jobs)
    }

    fn of_points(study: &Study, points: Vec<Point>) -> Result<Self> {
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
    fn bind(&self, study: &Study, done: impl Fn(&JobKey) -> bool + Sync) -> Result<()> {
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
    fn left(
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
        overview(study, &self.points, &first)
    }

    fn keys(&self) -> Vec<JobKey> {
        self.distinct.iter().map(|(index, _)| self.points[*index].key).collect()
    }
}

/// What is wrong with a point's scene, where it stands in the study file.
fn refused(study: &Study, index: usize, point: &Point, error: &SceneError) -> anyhow::Error {
    match study.point(index) {
        Some(own) if own.key == point.key => study.refuse(index, error).into(),
        // a point that the study chose
        _ => anyhow!("{}: {error}", study.path()),
    }
}

fn execute(study: Study, directory: &Path, args: &ExecutionArgs) -> Result<Finish> {
    let jobs = Jobs::of(&study)?;
    // what is refused leaves no store behind
    let is_new = !directory.exists();
    if is_new {
        jobs.bind(&study, |_| false)?;
    }
    let store = Store::open(directory)?;
    if !is_new {
        jobs.bind(&study, |key| store.contains(key))?;
    }
    // a run that computes nothing still clears away what a killed one left
    runner::sweep_leftovers();
    let definition = study.definition();
    if !matches!(store.study(study.name()), Ok(Some(stored)) if stored == definition) {
        store.put_study(study.name(), &definition)?;
    }
    let interrupt = Interrupt::new().context("cannot prepare for Ctrl-C")?;
    let raised = interrupt.clone();
    ctrlc::set_handler(move || raised.raise()).context("cannot prepare for Ctrl-C")?;

    let mut tally =
        Tally { jobs: 0, cached: 0, computing: 0, computed: 0, seconds: 0.0, interrupted: false };
    let (mut asked, mut computed) = (HashSet::new(), HashSet::new());
    // a study that chooses points by its results takes several rounds
    loop {
        let points = match study.adaptive() {
            None => study.points(),
            Some(_) => Results::chosen(&study, Source::Store(&store))?.points,
        };
        let jobs = Jobs::of_points(&study, points)?;
        asked.extend(jobs.keys());
        let (tasks, texts) = jobs.left(&study, &store, args.retry_failed, &computed)?;
        computed.extend(tasks.iter().map(|task| task.key));
        (tally.jobs, tally.computing) = (asked.len(), computed.len());
        tally.cached = tally.jobs.saturating_sub(tally.computing);
        if tasks.is_empty() {
            break;
        }
        let mut progress = Progress::new(&tasks, tally.cached, args.json);
        let outcome = runner::run(
            tasks,
            &mut Ledger::new(&store, texts),
            &options(args, &study, progress.jobs())?,
            &interrupt,
            &mut |event| progress.show(event),
        );
        progress.finish();
        let summary = outcome.map_err(|error| {
            anyhow::Error::new(error).context(format!(
                "the run stopped; what is done is kept: {}",
                again(&study, directory)
            ))
        })?;
        tally.interrupted = summary.unfinished > 0;
        tally.computed += summary.done + summary.quarantined;
        tally.seconds += summary.seconds;
        if tally.interrupted || study.adaptive().is_none() {
            break;
        }
    }
    report(&Results::read(Source::Store(&store), study)?, directory, args.json, tally)
}

/// How many workers of those asked for have something to do.
fn workers(study: &Study, asked: usize, jobs: usize) -> usize {
    // nothing else runs while a job is timed
    if study.cost().is_some() { 1 } else { asked.min(jobs.max(1)) }
}

/// How the workers for so many jobs are to run.
fn options(args: &ExecutionArgs, study: &Study, jobs: usize) -> Result<Options> {
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    let mut options = Options::new(Vec::new(), args.memory.unwrap_or_else(default_memory));
    let cores = options.workers;
    if study.cost().is_some() && args.workers.is_some_and(|workers| workers > 1) {
        output::say("one worker: what is timed has the machine to itself");
    }
    options.workers = workers(study, args.workers.map_or(cores, |workers| workers as usize), jobs);
    // a core for each worker; when there are fewer jobs than cores, the spare ones help; what is
    // timed starts its threads itself
    let threads = if study.cost().is_some() { 1 } else { (cores / options.workers).max(1) };
    options.worker_command =
        vec![program.into(), "worker".into(), "--threads".into(), threads.to_string().into()];
    Ok(options)
}

/// What a run did.
#[derive(Serialize)]
struct Tally {
    jobs: usize,
    cached: usize,
    computing: usize,
    /// Of these, the jobs that ended.
    #[serde(skip)]
    computed: usize,
    seconds: f64,
    interrupted: bool,
}

/// Says at the end of a run what came of it.
fn report(results: &Results, directory: &Path, json: bool, tally: Tally) -> Result<Finish> {
    let study = &results.study;
    let progress = results.progress();
    let figures = if progress.done > 0 { draw_figures(results, directory) } else { Vec::new() };
    let finish = match (tally.interrupted, progress.failed + results.inaccurate) {
        (true, _) => Finish::Interrupted,
        (_, 0) => Finish::AllDone,
        _ => Finish::SomeFailed,
    };
    let store_option = store_option(directory);
    let mut failures = Vec::new();
    let mut listed = BTreeSet::new();
    for record in results
        .points
        .iter()
        .filter_map(|point| results.record(point))
        .filter(|record| !record.is_certified())
    {
        if listed.insert(record.key()) {
            let key = record.key().to_string();
            failures.push(serde_json::json!({ "key": key, "status": record.status(), "show": format!("tribosweep show {}{store_option}", &key[..12]) }));
        }
    }
    if json {
        let files: Vec<_> = figures.iter().flatten().flatten().collect();
        let line = serde_json::json!({
            "event": "summary", "study": study.name(), "progress": progress, "run": tally, "failures": failures, "figures": files,
            "answers": results.answers_json()?, "inaccurate": results.inaccurate,
        });
        output::print(&format!("{line}\n"))?;
        return Ok(finish);
    }

    let mut text = String::new();
    let mut table = results.table()?.select(&results.usual_columns(false))?;
    let all = table.rows().len();
    if all > SUMMARY_ROWS {
        table = DataTable::new(table.columns().to_vec(), table.rows()[..SUMMARY_ROWS].to_vec())?;
    }
    text += &table.terminal(&crate::query::layout());
    if all > SUMMARY_ROWS {
        let more = count(all - SUMMARY_ROWS, "more row", "more rows");
        text += &format!("… {more}: tribosweep query {}{store_option}\n", study.name());
    }
    text += &results.answers_words();
    text += &format!(
        "\n{}: {}, {} certified, {} failed, {} left; {} of {} computed in {}, {} from the store\n",
        study.name(),
        count(progress.points, "point", "points"),
        progress.done,
        progress.failed,
        progress.left,
        tally.computed,
        count(tally.jobs, "job", "jobs"),
        duration(tally.seconds),
        tally.cached,
    );
    for figure in figures {
        match figure {
            Ok(files) => {
                files.iter().for_each(|file| text += &format!("figure: {}\n", file.display()))
            }
            Err(error) => text += &format!("no figure: {error:#}\n"),
        }
    }
    for warning in &results::WARNINGS {
        let concerned: Vec<&Record> = results
            .points
            .iter()
            .filter_map(|point| results.record(point))
            .filter(|record| warning.concerns(record))
            .collect();
        if !concerned.is_empty() {
            let (name, column, words) = (study.name(), warning.column, warning.words);
            let points = count(concerned.len(), "point", "points");
            // a row without them is the end of a path
            let is_path = concerned
                .iter()
                .any(|record| record.outcome().is_some_and(|outcome| outcome.steps.len() > 1));
            let steps = if is_path { " --steps" } else { "" };
            text += &format!(
                "warning: elements of {points} {words}: tribosweep query {name}{steps} --where '{column} > 0'{store_option}\n"
            );
        }
    }
    if results.inaccurate > 0 {
        let (points, name) =
            (count(results.inaccurate, "point misses", "points miss"), study.name());
        text += &format!(
            "warning: {points} the accuracy asked for: tribosweep answer {name}{store_option}\n"
        );
    }
    for failure in failures.iter().take(LISTED_FAILURES) {
        text += &format!(
            "{}: {}\n",
            failure["status"].as_str().unwrap_or_default(),
            failure["show"].as_str().unwrap_or_default()
        );
    }
    if failures.len() > LISTED_FAILURES {
        text += &format!(
            "… {} more: tribosweep query {} --where 'status != \"certified\"'{store_option}\n",
            failures.len() - LISTED_FAILURES,
            study.name()
        );
    }
    if tally.interrupted {
        text += &format!("interrupted; continue with: {}\n", again(study, directory));
    }
    output::print(&text)?;
    Ok(finish)
}

/// Each of the study's figures as files in the store's own folder of figures; one that cannot be
/// drawn hinders no other.
fn draw_figures(results: &Results, directory: &Path) -> Vec<Result<Vec<PathBuf>>> {
    let folder = directory.join("figures");
    let draw = |figure: &study::Figure| {
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make {}", folder.display()))?;
        let files = draw::figure_files(&folder.join(figure.stem(results.study.name())));
        draw::draw(results, figure, None, &files).map(|()| files)
    };
    results.study.figures().iter().map(draw).collect()
}

fn again(study: &Study, directory: &Path) -> String {
    format!("tribosweep resume {}{}", study.name(), store_option(directory))
}

/// The option that names the store, unless it is where every command looks.
pub(crate) fn store_option(directory: &Path) -> String {
    if directory == Path::new(".tribosweep") {
        String::new()
    } else {
        format!(" --store {}", directory.display())
    }
}

/// 80 % of the memory that is available now \[bytes\].
fn default_memory() -> u64 {
    let available = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
        line.split_whitespace().nth(1)?.parse::<u64>().ok()
    });
    available.map_or(1 << 30, |kilobytes| kilobytes * 1024 / 10 * 8)
}

/// Increments of a job's loading path.
pub(crate) fn increments(job: &Job) -> u64 {
    job.case().map_or(0, |case| {
        case.scene.loading.legs().iter().map(|leg| u64::from(leg.increments)).sum()
    })
}

/// What a plan says.
#[derive(Serialize)]
struct Plan<'a> {
    study: &'a str,
    question: &'a str,
    points: usize,
    jobs: usize,
    cached: usize,
    to_run: usize,
    increments: u64,
    operators: usize,
    predicted_worker_seconds: f64,
    predicted_seconds: f64,
    workers: usize,
    largest_job_bytes: u64,
    effects: &'a [Group],
    /// Of a study that chooses points, what it found so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    chosen: Option<serde_json::Value>,
}

pub(crate) fn plan(args: &PlanArgs) -> Result<Finish> {
    let study = read_study(&args.study)?;
    let mut jobs = Jobs::of(&study)?;
    let reader = match Store::read(&args.store.store) {
        Ok(reader) => Some(reader),
        Err(OpenError::Missing { .. }) => None,
        Err(error) => bail!(error),
    };
    let mut chosen = None;
    if study.adaptive().is_some() {
        let known = match &reader {
            Some(reader) => Results::chosen(&study, Source::Reader(reader))?,
            None => adaptive::choose(&study, &HashMap::new())?,
        };
        jobs = Jobs::of_points(&study, known.points)?;
        chosen = Some(adaptive::table(&study, &known.findings)?);
    }
    let keys = jobs.keys();
    let overview = jobs.effects(&study)?;
    let cached = match &reader {
        Some(reader) => reader.contains(&keys)?,
        None => vec![false; keys.len()],
    };
    let done: HashSet<JobKey> =
        keys.iter().zip(&cached).filter(|(_, cached)| **cached).map(|(key, _)| *key).collect();
    jobs.bind(&study, |key| done.contains(key))?;
    let left: Vec<&(usize, Forecast)> = jobs
        .distinct
        .iter()
        .zip(&cached)
        .filter(|(_, cached)| !**cached)
        .map(|(job, _)| job)
        .collect();
    let seconds: f64 = left.iter().map(|(_, forecast)| forecast.seconds).sum();
    let longest = left.iter().map(|(_, forecast)| forecast.seconds).fold(0.0, f64::max);
    let workers =
        workers(&study, std::thread::available_parallelism().map_or(1, usize::from), left.len());
    let operators: BTreeSet<u64> = left.iter().map(|(_, forecast)| forecast.operator).collect();
    let plan = Plan {
        study: study.name(),
        question: study.question(),
        points: jobs.points.len(),
        jobs: keys.len(),
        cached: keys.len() - left.len(),
        to_run: left.len(),
        increments: left.iter().map(|(index, _)| increments(&jobs.points[*index].job)).sum(),
        operators: operators.len(),
        predicted_worker_seconds: seconds,
        predicted_seconds: longest.max(seconds / workers as f64),
        workers,
        largest_job_bytes: left.iter().map(|(_, forecast)| forecast.memory).max().unwrap_or(0),
        effects: &overview.groups,
        chosen: chosen.as_ref().map(|table| serde_json::from_str(&table.json())).transpose()?,
    };
    if args.json {
        return output::print_json(&plan);
    }
    let mut text = format!("{}\n", plan.study);
    if !plan.question.is_empty() {
        text += &format!("{}\n", plan.question);
    }
    let (points, distinct) =
        (count(plan.points, "point", "points"), count(plan.jobs, "distinct job", "distinct jobs"));
    text +=
        &format!("\n{points}, {distinct}: {} in the store, {} to run", plan.cached, plan.to_run);
    text += &if plan.increments > plan.to_run as u64 {
        format!(" with {} increments\n", plan.increments)
    } else {
        "\n".to_owned()
    };
    if plan.to_run > 0 {
        text += &format!(
            "about {} on {} ({} of work), {}, up to {} per job\n",
            duration(plan.predicted_seconds),
            count(plan.workers, "worker", "workers"),
            duration(plan.predicted_worker_seconds),
            count(plan.operators, "operator", "operators"),
            BinaryBytes(plan.largest_job_bytes)
        );
        let mut by_mesh: BTreeMap<[usize; 2], (usize, f64)> = BTreeMap::new();
        for (_, forecast) in &left {
            let entry = by_mesh.entry(forecast.elements).or_default();
            entry.0 += 1;
            entry.1 += forecast.seconds;
        }
        for ([nx, ny], (jobs, seconds)) in by_mesh {
            text += &format!(
                "  {nx} x {ny} elements: {}, {} of work\n",
                count(jobs, "job", "jobs"),
                duration(seconds)
            );
        }
    }
    if let Some(table) = chosen {
        text += if plan.to_run > 0 { "more follow, as the results demand\n" } else { "" };
        text += &format!("\nfound so far\n{}", table.terminal(&crate::query::layout()));
    }
    text += &format!("\n{}", overview.words());
    if std::io::stdout().is_terminal() && plan.to_run > 0 {
        text += &format!(
            "run it with: tribosweep run {}{}\n",
            args.study.display(),
            store_option(&args.store.store)
        );
    }
    output::print(&text)
}
