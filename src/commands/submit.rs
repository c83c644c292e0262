//! `submit`: hands the shards of a study to a cluster's scheduler.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use answers::is_timed;
use answers::shards::{Partition, Shard};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use store::{ExportSummary, Store};
use study::{MOST_POINTS, Study};
use wording::{file_argument, shell_word};

use crate::cli::{Engine, SubmitArgs};
use crate::frozen_study::fixed_files;
use crate::job_list::JobList;
use crate::merge_rules::{RULES, ShardNote};
use crate::output::{self, Finish};
use crate::scheduler::{cancel, controller_config, sbatch};
use crate::slurm::{
    ARRAY_SCRIPT, Array, ControllerConfig, MERGE_SCRIPT, Resources, SbatchCall, Scripts,
    array_call, arrays, check_passed, merge_call,
};
use crate::study_file::read_large_study;
use crate::submission::{
    Submission, check_directory, submission, write_directory, write_submission,
};
use crate::words::{count, duration};

/// The time before the end of its limit at which a shard is told to stop \[s\]. Slurm may do it a
/// minute earlier, and the shard gives up jobs in flight after 20 s.
const LONGEST_LEAD: u64 = 120;

/// The report of a submission.
#[derive(Serialize)]
struct SubmissionReport<'r> {
    study: &'r str,
    shards: u32,
    directory: &'r Path,
    exports: PathBuf,
    merged: PathBuf,
    max_array_size: u32,
    dry_run: bool,
    arrays: &'r [SbatchCall],
    merge: &'r SbatchCall,
}

/// Writes the scripts of a study's shards and submits them.
pub(crate) fn submit(args: &SubmitArgs) -> Result<Finish> {
    let Engine::Slurm = args.engine;
    for word in &args.passed {
        check_passed(word).map_err(anyhow::Error::msg)?;
    }
    let study = read_large_study(&args.study)?;
    let extent = StudyExtent::of(&study, args.shards)?;
    check_shards(args, &extent)?;
    let config = controller_config(args.dry_run)?;
    let lead = lead(args.time.as_ref().and_then(|time| time.seconds));
    warn(args, &study, extent.longest, lead);

    let directory = args.directory.clone();
    let directory = directory.unwrap_or_else(|| format!("{}-shards", study.name()).into());
    check_directory(&directory)?;
    let submission = submission(args, &study, &directory)?;
    let shards = chosen_shards(args, &study, &directory.join(&submission.exports))?;
    check_limits(&config, shards.len())?;
    let arrays = arrays(&shards, config.array_size);
    let resources = resources(args, is_timed(study.kind()));
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    let scripts = Scripts {
        name: study.name(),
        shards: args.shards,
        program: &program,
        study: &submission.file,
        exports: &submission.exports,
        merged: &submission.merged,
        resources: &resources,
        lead,
        restarts: args.restarts,
    };
    let mut calls: Vec<SbatchCall> = Vec::new();
    if args.dry_run {
        for array in &arrays {
            calls.push(array_call(array, args.nodes, calls.last()));
        }
    } else {
        let is_new = !directory.exists();
        write_directory(&study, &submission, &scripts, &directory)?;
        let anew = Submission { jobs: Vec::new(), ..submission.clone() };
        let place = SubmissionPlace { submission: anew, directory: &directory, is_new };
        submit_all(args, &resources, &arrays, place, &mut calls)?;
    }
    let merge = match calls.pop_if(|call| call.shards.is_empty()) {
        Some(merge) => merge,
        None => merge_call(&calls),
    };
    let report = SubmissionReport {
        study: study.name(),
        shards: args.shards,
        directory: &directory,
        exports: directory.join(&submission.exports),
        merged: directory.join(&submission.merged),
        max_array_size: config.array_size,
        dry_run: args.dry_run,
        arrays: &calls,
        merge: &merge,
    };
    if args.json {
        return output::print_json(&report);
    }
    let mut text = report.words();
    if args.dry_run {
        for (file, script) in [(ARRAY_SCRIPT, scripts.array()), (MERGE_SCRIPT, scripts.merge())] {
            text += &format!("\n== {} ==\n{script}", directory.join(file).display());
        }
    }
    output::print(&text)
}

impl SubmissionReport<'_> {
    fn words(&self) -> String {
        let arrays = count(self.arrays.len(), "array", "arrays");
        let submitted: usize = self.arrays.iter().map(|call| call.shards.len()).sum();
        let shards = match submitted == self.shards as usize {
            true => count(submitted, "shard", "shards"),
            false => format!("{submitted} of {} shards", self.shards),
        };
        let directory = shell_word(file_argument(self.directory));
        let verb = if self.dry_run { "would be submitted" } else { "submitted" };
        let mut text = match submitted {
            0 => format!("{}: all shards are finished, only their merge {verb}\n", self.study),
            _ => format!("{}: {shards} {verb} in {arrays}, with a merge after them\n", self.study),
        };
        if self.dry_run {
            text += &format!("\nin {directory}, where array.sh and merge.sh would be:\n");
        } else {
            text += &format!("\nin {directory}:\n");
        }
        for call in self.arrays.iter().chain([self.merge]) {
            let job = call.job.as_ref().map_or(String::new(), |job| format!("    # job {job}"));
            text += &format!("  {}{job}\n", call.command);
        }
        let store = |path: &Path, words: &[&str]| {
            let words = words.iter().map(OsStr::new).chain([OsStr::new("--store")]);
            wording::command(words.chain([&*file_argument(path)]))
        };
        text += &format!(
            "\nhow far the shards are:  {}\nthe results, when done:  {}\n",
            store(&self.exports, &["status"]),
            store(&self.merged, &["query", self.study]),
        );
        text
    }
}

/// The extent of a study, as far as its submission asks.
struct StudyExtent {
    /// The number of the sequences, of which each stays in one shard.
    sequences: u64,
    /// The forecast of the longest job, or of the longest sequence if there are too many jobs to
    /// list \[s\].
    longest: f64,
}

impl StudyExtent {
    /// Cuts a study into shards, and refuses what cannot be run.
    fn of(study: &Study, shards: u32) -> Result<Self> {
        let partition = Partition::of(study, shards)?;
        let mut sequences = 0;
        for index in 1..=shards.into() {
            let shard = Shard::new(index, shards.into())?;
            let load = partition.load(shard);
            if load.points > MOST_POINTS as u64 {
                bail!(
                    "shard {shard} would have {} points, and a run takes {MOST_POINTS} at most; \
                     --shards must be larger, at least {}",
                    load.points,
                    study.len().div_ceil(MOST_POINTS).max(shards as usize + 1)
                );
            }
            sequences += load.sequences;
        }
        if !study.is_listed() {
            // What is wrong with a point of so many, its shard says.
            return Ok(Self { sequences, longest: partition.longest() });
        }
        let jobs = JobList::of(study)?;
        jobs.bind(study, |_| false)?;
        let seconds = jobs.distinct.iter().map(|job| job.forecast.seconds);
        Ok(Self { sequences, longest: seconds.fold(0.0, f64::max) })
    }
}

/// Refuses shards that there are not, or that would have nothing to do.
fn check_shards(args: &SubmitArgs, extent: &StudyExtent) -> Result<()> {
    if u64::from(args.shards) > extent.sequences {
        bail!(
            "the study has {} that may be apart, which cannot fill {} shards; --shards must be at \
             most {}",
            count(extent.sequences as usize, "part", "parts"),
            args.shards,
            extent.sequences
        );
    }
    match args.only.iter().find(|shard| !(1..=args.shards).contains(*shard)) {
        Some(shard) => bail!("--only {shard}: shards are numbered from 1 to {}", args.shards),
        None => Ok(()),
    }
}

/// Returns the numbers of the shards that are to be submitted: those that were chosen, or those
/// that are not finished.
fn chosen_shards(args: &SubmitArgs, study: &Study, exports: &Path) -> Result<Vec<u32>> {
    if !args.only.is_empty() {
        return Ok(BTreeSet::from_iter(args.only.iter().copied()).into_iter().collect());
    }
    let finished = finished_shards(study, args.shards, exports);
    Ok((1..=args.shards).filter(|shard| !finished.contains(shard)).collect())
}

/// Returns the shards of a study that are finished by what they exported. Their files are opened
/// one after another, so that the records of one shard alone are in memory.
fn finished_shards(study: &Study, shards: u32, exports: &Path) -> BTreeSet<u32> {
    let content = Study::definition_content(&study.definition());
    let is_finished = |index: &u32| {
        let file = exports.join(format!("{}.{index}-of-{shards}.tribosweep", study.name()));
        file.is_file() && is_finished(&file, study.name(), content.as_deref())
    };
    (1..=shards).filter(is_finished).collect()
}

/// Tells whether a file is the whole export of a shard of the study with this content. What cannot
/// be read, or is damaged, is not: its shard computes it again, or says what is wrong.
fn is_finished(file: &Path, study: &str, content: Option<&[u8]>) -> bool {
    let Ok(reader) = Store::read_by(file, &RULES) else { return false };
    let is_whole = |export: &ExportSummary| {
        let note = export.note.as_deref().and_then(ShardNote::of);
        export.is_closed && export.damage.is_empty() && note.is_some_and(|note| note.finished)
    };
    let Ok(Some(definition)) = reader.study(study) else { return false };
    reader.exports().iter().all(is_whole)
        && Study::definition_content(&definition).as_deref() == content
}

fn check_limits(config: &ControllerConfig, shards: usize) -> Result<()> {
    if config.array_size == 0 {
        bail!("this cluster allows no arrays: its MaxArraySize is 0");
    }
    // The merge is a job as well.
    if shards >= config.jobs as usize {
        bail!(
            "the controller keeps at most {} jobs at a time (MaxJobCount), and {shards} shards with \
             their merge are more; a shard runs any number of jobs, so take fewer shards",
            config.jobs
        );
    }
    Ok(())
}

/// Says what deserves attention, though it is no mistake.
fn warn(args: &SubmitArgs, study: &Study, longest: f64, lead: u64) {
    let mut warnings = Vec::new();
    for file in fixed_files(study) {
        warnings.push(format!(
            "{} is named by an absolute path and not copied: it must be there on every node, and \
             stay as it is until the merge",
            wording::excerpt(file, 200)
        ));
    }
    if is_timed(study.kind()) && args.shards > 1 {
        warnings.push(
            "the study measures times, and those of different nodes do not compare; --shards 1 \
             measures all of them on one node"
                .to_owned(),
        );
    }
    if let Some(seconds) = args.time.as_ref().and_then(|time| time.seconds)
        && longest > seconds.saturating_sub(lead) as f64
    {
        warnings.push(format!(
            "the longest job is predicted to take {}, which a limit of {} may not leave it; a job \
             that is cut off begins anew",
            duration(longest),
            duration(seconds as f64)
        ));
    }
    warnings.iter().for_each(|warning| output::say(&format!("warning: {warning}")));
}

/// Returns the time before the end of a time limit at which a shard is told to stop \[s\]: less
/// than half of the limit. Slurm rounds a limit up to whole minutes.
fn lead(limit: Option<u64>) -> u64 {
    limit.map_or(LONGEST_LEAD, |limit| LONGEST_LEAD.min((limit.div_ceil(60) * 60 - 1) / 2))
}

fn resources(args: &SubmitArgs, exclusive: bool) -> Resources {
    Resources {
        cpus: args.cpus_per_task,
        memory: args.mem.clone(),
        time: args.time.clone(),
        merge_memory: args.merge_mem.clone().or_else(|| args.mem.clone()),
        merge_time: args.merge_time.clone().or_else(|| args.time.clone()),
        partition: args.partition.clone(),
        account: args.account.clone(),
        exclusive,
        passed: args.passed.clone(),
    }
}

/// A submission that is being made, and where it is written down.
struct SubmissionPlace<'p> {
    submission: Submission,
    directory: &'p Path,
    /// True if nothing was submitted there before.
    is_new: bool,
}

/// Submits the arrays and the merge, and writes down the number of each at once. If one is refused,
/// those before it are cancelled.
fn submit_all(
    args: &SubmitArgs,
    resources: &Resources,
    arrays: &[Array],
    place: SubmissionPlace<'_>,
    calls: &mut Vec<SbatchCall>,
) -> Result<()> {
    let SubmissionPlace { mut submission, directory, is_new } = place;
    let mut submit = |mut call: SbatchCall, calls: &mut Vec<SbatchCall>| {
        let job = sbatch(&call, resources, directory)?;
        submission.jobs.push(job.clone());
        call.job = Some(job);
        calls.push(call);
        write_submission(&submission, directory)
    };
    let mut submit_each = || -> Result<()> {
        for array in arrays {
            submit(array_call(array, args.nodes, calls.last()), calls)?;
        }
        submit(merge_call(calls), calls)
    };
    let Err(error) = submit_each() else { return Ok(()) };
    let jobs = &submission.jobs;
    let cancelled = cancel(jobs);
    if cancelled.is_ok() && is_new {
        // The refusal of the scheduler matters more than a directory that stays.
        let _ = fs::remove_dir_all(directory);
    }
    let submitted = match &jobs[..] {
        [job] => format!("job {job}, submitted before, "),
        jobs => format!("jobs {}, submitted before, ", jobs.join(", ")),
    };
    Err(match cancelled {
        Ok(()) if jobs.is_empty() => error,
        Ok(()) if jobs.len() == 1 => error.context(format!("{submitted}was cancelled")),
        Ok(()) => error.context(format!("{submitted}were cancelled")),
        Err(reason) => error.context(format!(
            "{submitted}could not be cancelled (scancel says {reason}); cancel by: scancel {}",
            jobs.join(" ")
        )),
    })
}
