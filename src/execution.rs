//! Runs what is left of a study: `run`, `resume` and `cost`.

use std::collections::HashSet;
use std::path::Path;

use answers::{Results, choice};
use anyhow::{Context, Result};
use runner::{Interrupt, Options};
use store::Store;
use study::Study;

use crate::cli::ExecutionArgs;
use crate::job_list::Jobs;
use crate::ledger::Ledger;
use crate::output::{self, Finish};
use crate::progress::Progress;
use crate::stored::Source;
use crate::summary::{Tally, again, report};

pub(crate) fn execute(study: Study, directory: &Path, args: &ExecutionArgs) -> Result<Finish> {
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
    let source = Source::Store(&store);
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
            Some(_) => choice::gather(&study, &source)?.chosen.points,
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
    report(&Results::read(study, &source)?, directory, args.json, tally)
}

/// How many workers of those asked for have something to do.
pub(crate) fn workers(study: &Study, asked: usize, jobs: usize) -> usize {
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

/// 80 % of the memory that is available now \[bytes\].
fn default_memory() -> u64 {
    let available = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
        line.split_whitespace().nth(1)?.parse::<u64>().ok()
    });
    available.map_or(1 << 30, |kilobytes| kilobytes * 1024 / 10 * 8)
}
