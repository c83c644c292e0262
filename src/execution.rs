//! Runs what is left of a study, for `run`, `resume` and `cost`.

use std::collections::HashSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use answers::shards::Shard;
use answers::{Results, choice, is_timed};
use anyhow::{Context, Result, anyhow};
use identity::JobKey;
use indicatif::BinaryBytes;
use runner::{EarlyEnd, Interrupt, Jobs, Options, RunError, Want};
use store::{Glance, Store};
use study::account::HashedFile;
use study::{RunAccount, Study};

use crate::account::this_run;
use crate::cli::ExecutionArgs;
use crate::exporting::{ExportPlace, Exporter};
use crate::failure_limit::FailureCount;
use crate::kept_study::KeptStudy;
use crate::ledger::StoreLedger;
use crate::output::{self, Finish};
use crate::progress::ProgressDisplay;
use crate::run_jobs::{ExaminedJobs, JobsLeft, RunJobs};
use crate::stored::{StoreSource, WrittenStore};
use crate::summary::{FIGURES, RunEnd, RunTally, gathered, resume_command, summarise};
use crate::threads::usable;
use crate::time_left::{Calibration, TimeLeft};
use crate::words::count;

/// The directory in a store through which large jobs and results travel while a run lasts.
const IN_TRANSIT: &str = "in-transit";

/// The run of a shard, or of a whole study that is exported.
pub(crate) struct ShardRun {
    pub(crate) shard: Shard,
    /// The place where the results will be found.
    pub(crate) results: PathBuf,
    /// The export, if there is one.
    pub(crate) export: Option<ExportPlace>,
    /// The command that goes on with it.
    pub(crate) command: String,
}

/// A study that is to be run.
pub(crate) struct StudyToRun {
    pub(crate) study: Study,
    /// The file that it was read from; `None` if it came from a store.
    pub(crate) file: Option<HashedFile>,
}

/// Runs the jobs of a study that a store has no results of, and says what came of them.
pub(crate) fn execute(
    StudyToRun { study, file }: StudyToRun,
    directory: &Path,
    args: &ExecutionArgs,
    part: Option<ShardRun>,
) -> Result<Finish> {
    // A run that computes nothing still clears away what a killed one has left.
    runner::sweep_leftovers();
    if part.is_none()
        && let Some(finish) = said_before(&study, directory, args)?
    {
        return Ok(finish);
    }
    let account = this_run(&study, file);
    let OpenedStudy { store, of_axes, examined } = open_for(&study, directory)?;
    let in_transit = directory.join(IN_TRANSIT);
    runner::remove_bodies(&in_transit)
        .with_context(|| format!("cannot remove {}", in_transit.display()))?;
    let definition = study.definition();
    let stored = store.study(study.name());
    if let (Ok(Some(stored)), Some(_)) = (&stored, study.sample())
        && *stored != definition
        && let Ok(former) = Study::from_large_definition(stored)
    {
        study.require_kept_points(&former)?;
    }
    study.sample_note().iter().for_each(|note| output::say(&format!("note: {note}")));
    if !matches!(stored, Ok(Some(stored)) if stored == definition) {
        store.put_study(study.name(), &definition)?;
    }
    let interrupt = Interrupt::new().context("cannot prepare for Ctrl-C")?;
    runner::raise_on_signals(&interrupt).context("cannot prepare for Ctrl-C")?;
    let written = WrittenStore::new(&store);
    let shard = part.as_ref().map(|part| part.shard);
    let (place, continuation, shown) = match part {
        Some(ShardRun { export, command, results, .. }) => (export, command, results),
        None => (None, resume_command(&study, directory), directory.to_owned()),
    };
    let exporter =
        place.map(|place| Exporter::open(place, &study, &store, &interrupt)).transpose()?;
    let run = StudyRun {
        study: &study,
        store: &written,
        directory,
        args,
        interrupt: &interrupt,
        exporter: exporter.as_ref(),
        continuation: &continuation,
        account: &account,
    };
    let mut requested = Vec::new();
    let outcome = match study.adaptive() {
        None => compute(&run, &of_axes, examined, &mut requested),
        Some(_) => compute_chosen(&run, &mut requested),
    };
    drop(of_axes);
    if let Some(exporter) = exporter {
        let mut keys = requested;
        keys.sort_unstable();
        let is_finished = outcome.as_ref().is_ok_and(|tally| !tally.is_partial());
        let path = exporter.path().to_owned();
        match (exporter.close(&store, &keys, is_finished), &outcome) {
            (Ok(results), _) => output::say(&format!(
                "exported {} to {}",
                count(results, "result", "results"),
                path.display()
            )),
            (Err(error), Ok(_)) => return Err(error),
            // What stopped the run says more.
            (Err(error), Err(_)) => output::say(&format!("warning: {error:#}")),
        }
    }
    let ending = RunEnd { tally: outcome?, continuation, shard };
    let source = StoreSource::Store(&written);
    runner::return_freed();
    let results = Results::in_blocks(study, &source)?;
    let facts = gathered(&results, &shown, ending.tally.jobs, shard.is_some())?;
    let finish = summarise(&facts, &shown, args.json, ending)?;
    if shard.is_none() {
        KeptStudy::of(&results, facts).keep(&store, results.study());
    }
    Ok(finish)
}

/// Says what a run says that finds nothing to do, if the store keeps that in words which hold: then
/// neither its records are read nor its lock is taken.
fn said_before(study: &Study, directory: &Path, args: &ExecutionArgs) -> Result<Option<Finish>> {
    let kept = Glance::at(directory)
        .and_then(|glance| KeptStudy::at_a_glance(&glance, study.name()))
        .filter(|kept| kept.is_about(study))
        .filter(|kept| !args.retry_failed || kept.progress().failed == 0);
    let Some(facts) = kept.and_then(|kept| kept.into_facts(&directory.join(FIGURES))) else {
        return Ok(None);
    };
    study.sample_note().iter().for_each(|note| output::say(&format!("note: {note}")));
    let tally = RunTally { jobs: facts.jobs, cached: facts.jobs, ..RunTally::default() };
    let continuation = resume_command(study, directory);
    let ending = RunEnd { tally, continuation, shard: None };
    summarise(&facts, directory, args.json, ending).map(Some)
}

/// Everything that the rounds of a run share.
struct StudyRun<'a> {
    study: &'a Study,
    store: &'a WrittenStore<'a>,
    directory: &'a Path,
    args: &'a ExecutionArgs,
    interrupt: &'a Interrupt,
    exporter: Option<&'a Exporter>,
    /// The command that goes on with it.
    continuation: &'a str,
    /// The account that its results name.
    account: &'a RunAccount,
}

/// A store with the jobs at the axes of a study, and what was learnt of them.
struct OpenedStudy<'s> {
    store: Store,
    of_axes: RunJobs<'s>,
    examined: ExaminedJobs,
}

/// Checks a study and opens its store; a study that is refused leaves no store behind.
fn open_for<'s>(study: &'s Study, directory: &Path) -> Result<OpenedStudy<'s>> {
    let of_axes = RunJobs::of_axes(study)?;
    let examined = match directory.exists() {
        false => Some(of_axes.examine(|_| false)?),
        true => None,
    };
    let store = Store::open(directory)?;
    let examined = match examined {
        Some(examined) => examined,
        None => of_axes.examine(|key| store.contains(key))?,
    };
    Ok(OpenedStudy { store, of_axes, examined })
}

/// The state of a run over its rounds.
struct RunState {
    tally: RunTally,
    calibration: Calibration,
    failures: FailureCount,
}

impl RunState {
    fn new(args: &ExecutionArgs) -> Self {
        Self {
            tally: RunTally::default(),
            calibration: Calibration::default(),
            failures: FailureCount::new(args.max_failures),
        }
    }
}

/// Computes the jobs that are left of a study that chooses no points. The keys of all its jobs are
/// added to those that are `requested`, if they are exported.
fn compute(
    run: &StudyRun<'_>,
    jobs: &RunJobs<'_>,
    examined: ExaminedJobs,
    requested: &mut Vec<JobKey>,
) -> Result<RunTally> {
    let mut state = RunState::new(run.args);
    let left = jobs.left(examined, run.store, run.args.retry_failed, &HashSet::new())?;
    state.tally.jobs = jobs.len();
    state.tally.computing = left.count();
    if let Some(exporter) = run.exporter {
        requested.extend(jobs.keys());
        let mut cached: Vec<JobKey> = left.others().collect();
        cached.sort_unstable();
        exporter.expect(run.store.store, jobs.len(), &cached);
    }
    compute_left(run, left, true, &mut state)?;
    Ok(state.tally)
}

/// Computes the jobs that are left of a study that chooses points by its results, which takes
/// several rounds. The keys of all its jobs are added to those that are `requested`.
fn compute_chosen(run: &StudyRun<'_>, requested: &mut Vec<JobKey>) -> Result<RunTally> {
    let StudyRun { study, store, args, exporter, .. } = *run;
    let mut state = RunState::new(args);
    let (mut known, mut computed) = (HashSet::new(), HashSet::new());
    for round in 0.. {
        let points = choice::gather(study, &StoreSource::Store(store))?.choice.points;
        let jobs = RunJobs::of_points(study, points);
        requested.extend(jobs.keys().filter(|key| known.insert(*key)));
        let left = jobs.left(ExaminedJobs::default(), store, args.retry_failed, &computed)?;
        computed.extend(left.keys());
        (state.tally.jobs, state.tally.computing) = (known.len(), computed.len());
        if let Some(exporter) = exporter {
            let mut cached: Vec<JobKey> = known.difference(&computed).copied().collect();
            cached.sort_unstable();
            exporter.expect(store.store, known.len(), &cached);
        }
        if compute_left(run, left, round == 0, &mut state)? == RoundEnd::Last {
            break;
        }
    }
    Ok(state.tally)
}

/// The end of a round.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RoundEnd {
    /// Results came that may say which points there are.
    Results,
    /// Nothing was left to do, or nothing more is to be done.
    Last,
}

/// Computes the jobs that are left at the beginning of a round.
fn compute_left(
    run: &StudyRun<'_>,
    mut left: JobsLeft<'_>,
    is_first: bool,
    state: &mut RunState,
) -> Result<RoundEnd> {
    let StudyRun { study, args, interrupt, .. } = *run;
    let RunState { tally, calibration, failures } = state;
    if left.damaged > 0 {
        output::say(&format!(
            "{} damaged or without its file of fields, and computed again",
            count(left.damaged, "result is", "results are")
        ));
    }
    tally.cached = tally.jobs.saturating_sub(tally.computing);
    if left.count() == 0 {
        return Ok(RoundEnd::Last);
    }
    failures.jobs = tally.computing;
    let is_late = !is_first && args.until.as_ref().is_some_and(|time| time.left().is_zero());
    let most = if is_late || failures.are_too_many() { Some(0) } else { allowed(args, tally) };
    let left_out = left.split_off(most.unwrap_or(usize::MAX));
    tally.computing -= left_out.count();
    if left.count() == 0 {
        let workers = options(args, study, run.directory, left_out.count())?.workers;
        let time = TimeLeft::new(left_out.costs(), workers, std::mem::take(calibration));
        tally.seconds_left = Some(time.seconds_from_start());
        match args.max_jobs {
            _ if failures.are_too_many() => stop_for_failures(tally, failures),
            Some(most) if !is_late => stop_at(tally, most),
            _ => stop_in_time(tally, args, interrupt),
        }
        return Ok(RoundEnd::Last);
    }
    let round = Round { left, left_out: &left_out, is_first };
    run_round(run, round, tally, calibration, failures)?;
    if let (Some(most), false) = (args.max_jobs, left_out.count() == 0 || tally.is_partial()) {
        stop_at(tally, most);
    }
    Ok(if tally.is_partial() { RoundEnd::Last } else { RoundEnd::Results })
}

/// The jobs that a run does before it looks at their results.
struct Round<'a> {
    left: JobsLeft<'a>,
    /// The jobs that `--max-jobs` leaves for another run.
    left_out: &'a JobsLeft<'a>,
    is_first: bool,
}

/// Computes the jobs of a round, and adds to the counts what came of them.
fn run_round(
    run: &StudyRun<'_>,
    Round { left, left_out, is_first }: Round<'_>,
    tally: &mut RunTally,
    calibration: &mut Calibration,
    failures: &mut FailureCount,
) -> Result<()> {
    let StudyRun { study, store, directory, args, interrupt, exporter, continuation, account } =
        *run;
    let mut options = options(args, study, directory, left.count())?;
    let costs = left.costs().chain(left_out.costs());
    let time = TimeLeft::new(costs, options.workers, std::mem::take(calibration));
    let mut progress = ProgressDisplay::new(left.count(), tally.cached, args.json, time);
    if let Some(budget) = &args.until {
        (options.until, options.overtime) = (Some(budget.left()), budget.overtime());
        options.begins_one = is_first;
    }
    let texts = |job: usize| left.text(job);
    // The survey of many jobs leaves much that was freed in pieces.
    runner::return_freed();
    let outcome = runner::run(
        &left,
        &mut StoreLedger::new(store.store, &texts, exporter, account, failures),
        &options,
        interrupt,
        &mut |event| progress.show(event),
    );
    progress.finish();
    *calibration = progress.calibration();
    let summary = outcome.map_err(|error| {
        let advice = match error {
            RunError::Postponed { want: Want::Memory, .. } => "; give it more memory (--memory)",
            _ => "",
        };
        // The command stands last, so that it can be copied.
        anyhow!(
            "the run stopped: {:#}{advice}; what is done is kept, continue with: {}",
            anyhow::Error::new(error),
            continuation
        )
    })?;
    tally.computed += summary.done + summary.quarantined;
    tally.seconds += summary.seconds;
    match summary.early_end {
        Some(EarlyEnd::InTime) => stop_in_time(tally, args, interrupt),
        Some(EarlyEnd::Enough) => stop_for_failures(tally, failures),
        Some(EarlyEnd::Interrupted) => tally.interrupted = summary.unfinished > 0,
        None => {}
    }
    if summary.unfinished > 0 || left_out.count() > 0 {
        tally.seconds_left = progress.seconds_left();
    }
    Ok(())
}

/// Returns how many jobs `--max-jobs` still allows, if it is given.
fn allowed(args: &ExecutionArgs, tally: &RunTally) -> Option<usize> {
    args.max_jobs.map(|most| (most as usize).saturating_sub(tally.computed))
}

/// Notes that a run stopped after its number of jobs.
fn stop_at(tally: &mut RunTally, most: u32) {
    tally.stopped_in_time = true;
    tally.stopped_by = Some(format!("--max-jobs {most}"));
}

/// Notes that a run stopped because too many jobs failed.
fn stop_for_failures(tally: &mut RunTally, failures: &FailureCount) {
    let Some(limit) = failures.limit else { return };
    tally.too_many_failed = true;
    tally.stopped_by = Some(format!("--max-failures {limit}: {} failed", failures.failed()));
}

/// Notes that a run stopped in time, and why.
fn stop_in_time(tally: &mut RunTally, args: &ExecutionArgs, interrupt: &Interrupt) {
    tally.stopped_in_time = true;
    tally.stopped_by = Some(match &args.until {
        Some(budget) if interrupt.ends() == 0 => format!("--until {budget}"),
        _ => "a signal asked for it".to_owned(),
    });
}

/// Returns the number of workers out of `wanted` that have something to do; nothing else may run
/// beside a job that is timed.
pub(crate) fn workers(study: &Study, wanted: usize, jobs: usize) -> usize {
    if is_timed(study.kind()) { 1 } else { wanted.min(jobs.max(1)) }
}

/// Returns the options of a run of so many jobs.
fn options(args: &ExecutionArgs, study: &Study, directory: &Path, jobs: usize) -> Result<Options> {
    let mut options = Options::new(Vec::new(), directory.join(IN_TRANSIT), memory(args));
    let cores = options.workers;
    let is_timed = is_timed(study.kind());
    if is_timed && args.workers.is_some_and(|workers| workers > 1) {
        output::say("one worker: what is timed has the machine to itself");
    }
    options.workers = workers(study, args.workers.map_or(cores, |workers| workers as usize), jobs);
    // There is a core for each worker; when there are fewer jobs than cores, the spare ones help. A
    // job that is timed starts its threads itself.
    options.threads = if is_timed { 1 } else { (usable(cores) / options.workers).max(1) };
    options.worker_command = worker_command(options.threads)?;
    Ok(options)
}

/// Returns the options of a run on a store that has a single worker, with a single thread.
pub(crate) fn single_worker(directory: &Path) -> Result<Options> {
    let command = worker_command(1)?;
    let options = Options::new(command, directory.join(IN_TRANSIT), usual_memory());
    Ok(Options { workers: 1, threads: 1, ..options })
}

/// Returns the command that starts a worker whose jobs use so many threads.
fn worker_command(threads: usize) -> Result<Vec<OsString>> {
    let program = own_program()?;
    Ok(vec![program.into(), "worker".into(), "--threads".into(), threads.to_string().into()])
}

/// Returns the program that is running, even if its file has been replaced meanwhile: a worker of
/// another version would not understand its coordinator.
pub(crate) fn own_program() -> Result<PathBuf> {
    let image = Path::new(runner::RUNNING_IMAGE);
    if image.exists() {
        return Ok(image.to_owned());
    }
    std::env::current_exe()
        .ok()
        .or_else(|| std::env::args_os().next().map(PathBuf::from))
        .context("cannot find this program's own file")
}

/// Returns the memory that the jobs of a run may use together if nobody asks for another amount
/// \[bytes\]: 80 % of what is available now, or 1 GiB where the system does not say, within the
/// limits of the process.
pub(crate) fn usual_memory() -> u64 {
    let usual = runner::available_memory().map_or(1 << 30, |available| available / 10 * 8);
    usual.min(memory_limit())
}

fn memory_limit() -> u64 {
    runner::memory_within_limits().unwrap_or(u64::MAX)
}

/// Returns the memory that the jobs of a run may use together \[bytes\]: what was asked for, or
/// what is usual. It says so where that is less than was asked for, or more than there is.
fn memory(args: &ExecutionArgs) -> u64 {
    let Some(request) = args.memory else { return usual_memory() };
    let limit = memory_limit();
    if request > limit {
        output::say(&format!(
            "{} of memory for jobs instead of {}: a process may not reserve more here (`ulimit \
             -v` or `ulimit -d`)",
            BinaryBytes(limit),
            BinaryBytes(request)
        ));
    } else if let Some(available) =
        runner::available_memory().filter(|&available| request > available)
    {
        output::say(&format!(
            "warning: --memory {} is more than the {} that are available here",
            BinaryBytes(request),
            BinaryBytes(available)
        ));
    }
    request.min(limit)
}
