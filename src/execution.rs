//! Runs what is left of a study, for `run`, `resume` and `cost`.

use std::collections::HashSet;
use std::path::Path;

use answers::{Results, choice, is_timed};
use anyhow::{Context, Result};
use runner::{Interrupt, Options};
use store::Store;
use study::Study;

use crate::cli::ExecutionArgs;
use crate::job_list::{JobList, JobsLeft};
use crate::ledger::StoreLedger;
use crate::output::{self, Finish};
use crate::progress::ProgressDisplay;
use crate::stored::{StoreSource, WrittenStore};
use crate::summary::{RunTally, resume_command, summarise};
use crate::time_left::{Calibration, TimeLeft};
use crate::words::count;

/// Runs the jobs of a study that a store has no results of, and says what came of them.
pub(crate) fn execute(study: Study, directory: &Path, args: &ExecutionArgs) -> Result<Finish> {
    let store = open_for(&study, directory)?;
    // A run that computes nothing still clears away what a killed one has left.
    runner::sweep_leftovers();
    let definition = study.definition();
    if !matches!(store.study(study.name()), Ok(Some(stored)) if stored == definition) {
        store.put_study(study.name(), &definition)?;
    }
    let interrupt = Interrupt::new().context("cannot prepare for Ctrl-C")?;
    let raised = interrupt.clone();
    ctrlc::set_handler(move || raised.raise()).context("cannot prepare for Ctrl-C")?;
    let written = WrittenStore::new(&store);
    let tally = compute(&study, &written, directory, args, &interrupt)?;
    let source = StoreSource::Store(&written);
    summarise(&Results::read(study, &source)?, directory, args.json, tally)
}

/// Checks a study and opens its store; a study that is refused leaves no store behind.
fn open_for(study: &Study, directory: &Path) -> Result<Store> {
    let jobs = JobList::of(study)?;
    let is_new = !directory.exists();
    if is_new {
        jobs.bind(study, |_| false)?;
    }
    let store = Store::open(directory)?;
    if !is_new {
        jobs.bind(study, |key| store.contains(key))?;
    }
    Ok(store)
}

/// Computes the jobs that are left; a study that chooses points by its results takes several
/// rounds.
fn compute(
    study: &Study,
    store: &WrittenStore,
    directory: &Path,
    args: &ExecutionArgs,
    interrupt: &Interrupt,
) -> Result<RunTally> {
    let mut tally = RunTally::default();
    let mut calibration = Calibration::default();
    let (mut requested, mut computed) = (HashSet::new(), HashSet::new());
    loop {
        let points = match study.adaptive() {
            None => study.points(),
            Some(_) => choice::gather(study, &StoreSource::Store(store))?.choice.points,
        };
        let jobs = JobList::of_points(study, points)?;
        requested.extend(jobs.keys());
        let JobsLeft { tasks, damaged, texts } =
            jobs.left(study, store, args.retry_failed, &computed)?;
        if damaged > 0 {
            output::say(&format!(
                "{} damaged or without its file of fields, and computed again",
                count(damaged, "result is", "results are")
            ));
        }
        computed.extend(tasks.iter().map(|task| task.key));
        (tally.jobs, tally.computing) = (requested.len(), computed.len());
        tally.cached = tally.jobs.saturating_sub(tally.computing);
        if tasks.is_empty() {
            return Ok(tally);
        }
        let options = options(args, study, tasks.len())?;
        let left = TimeLeft::new(&tasks, options.workers, calibration);
        let mut progress = ProgressDisplay::new(&tasks, tally.cached, args.json, left);
        let outcome = runner::run(
            tasks,
            &mut StoreLedger::new(store.store, texts),
            &options,
            interrupt,
            &mut |event| progress.show(event),
        );
        progress.finish();
        calibration = progress.calibration();
        let summary = outcome.map_err(|error| {
            anyhow::Error::new(error).context(format!(
                "the run stopped; what is done is kept: {}",
                resume_command(study, directory)
            ))
        })?;
        tally.interrupted = summary.unfinished > 0;
        tally.computed += summary.done + summary.quarantined;
        tally.seconds += summary.seconds;
        if tally.interrupted || study.adaptive().is_none() {
            return Ok(tally);
        }
    }
}

/// Returns the number of workers out of `wanted` that have something to do; nothing else may run
/// beside a job that is timed.
pub(crate) fn workers(study: &Study, wanted: usize, jobs: usize) -> usize {
    if is_timed(study.kind()) { 1 } else { wanted.min(jobs.max(1)) }
}

/// Returns the options of a run of so many jobs.
fn options(args: &ExecutionArgs, study: &Study, jobs: usize) -> Result<Options> {
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    let mut options = Options::new(Vec::new(), args.memory.unwrap_or_else(default_memory));
    let cores = options.workers;
    let is_timed = is_timed(study.kind());
    if is_timed && args.workers.is_some_and(|workers| workers > 1) {
        output::say("one worker: what is timed has the machine to itself");
    }
    options.workers = workers(study, args.workers.map_or(cores, |workers| workers as usize), jobs);
    // There is a core for each worker; when there are fewer jobs than cores, the spare ones help. A
    // job that is timed starts its threads itself.
    let threads = if is_timed { 1 } else { (cores / options.workers).max(1) };
    options.worker_command =
        vec![program.into(), "worker".into(), "--threads".into(), threads.to_string().into()];
    Ok(options)
}

/// Returns 80 % of the memory that is available now \[bytes\], or 1 GiB where the system does not
/// say.
fn default_memory() -> u64 {
    let available = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
        line.split_whitespace().nth(1)?.parse::<u64>().ok()
    });
    available.map_or(1 << 30, |kilobytes| kilobytes * 1024 / 10 * 8)
}
