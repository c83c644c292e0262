//! `submit`: hands the shards of a study to a cluster's scheduler.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use answers::is_timed;
use answers::shards::{Partition, Shard};
use anyhow::{Context, Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use store::{ExportSummary, Store};
use study::{MOST_POINTS, Study};
use wording::{file_argument, shell_word};

use crate::cli::{Engine, SubmitArgs};
use crate::frozen_study::{fixed_files, freeze, is_same, place};
use crate::job_list::JobList;
use crate::merge_rules::{RULES, ShardNote};
use crate::output::{self, Finish};
use crate::slurm::{
    Array, ControllerConfig, Resources, Scripts, arrays, check_passed, option_word,
};
use crate::study_file::read_large_study;
use crate::words::{count, duration};

/// The time before the end of its limit at which a shard is told to stop \[s\]. Slurm may do it a
/// minute earlier, and the shard gives up jobs in flight after 20 s.
const LONGEST_LEAD: u64 = 120;

/// The file with what was submitted, in the directory of the scripts.
const SUBMISSION: &str = "submission.json";

/// The directory with the study and the files that it names.
const FROZEN: &str = "study";

/// The directory with what the jobs say.
const LOG: &str = "log";

const ARRAY_SCRIPT: &str = "array.sh";
const MERGE_SCRIPT: &str = "merge.sh";

/// The record of a submission, which stands in [`SUBMISSION`].
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Submission {
    study: String,
    shards: u32,
    /// The study file, below the directory.
    file: PathBuf,
    /// The directory of the exports, absolute or below the directory.
    exports: PathBuf,
    /// The file with the results of all shards.
    merged: PathBuf,
    /// The numbers that the scheduler gave to the arrays and the merge.
    jobs: Vec<String>,
}

/// A call of `sbatch`.
#[derive(Clone, Debug, Serialize)]
struct SbatchCall {
    /// The shards of an array, empty for the merge.
    shards: Vec<u32>,
    /// The words after `sbatch`.
    #[serde(skip)]
    words: Vec<String>,
    /// The command, ready to be pasted in the directory of the scripts.
    command: String,
    /// The number that the scheduler gave; `None` in a dry run.
    job: Option<String>,
}

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
    let config = config(args.dry_run)?;
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
        submit_all(args, &arrays, place, &mut calls)?;
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

/// Returns the limits of the controller. A dry run does without one.
fn config(is_dry_run: bool) -> Result<ControllerConfig> {
    match slurm_program("scontrol").args(["show", "config"]).output() {
        Ok(output) if output.status.success() => {
            Ok(ControllerConfig::parse(&String::from_utf8_lossy(&output.stdout)))
        }
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(error).context("cannot run scontrol")
        }
        answer if is_dry_run => {
            let config = ControllerConfig::default();
            let reason = match answer {
                Ok(_) => "the controller does not answer",
                Err(_) => "Slurm is not installed here",
            };
            output::say(&format!("{reason}: MaxArraySize is taken for {}", config.array_size));
            Ok(config)
        }
        Ok(output) => {
            bail!("Slurm's controller does not answer: scontrol says {}", said(&output.stderr))
        }
        Err(_) => bail!(
            "Slurm is not installed here: there is no scontrol on the PATH. Submit from a login node \
             of the cluster, or see with --dry-run what would be submitted"
        ),
    }
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

/// Refuses a directory in which Slurm would find no log.
fn check_directory(directory: &Path) -> Result<()> {
    let path = std::path::absolute(directory).context("cannot find the current directory")?;
    let Some(text) = path.to_str() else {
        bail!("--directory must be a path in UTF-8");
    };
    if text.contains(['%', '\\', '\n']) {
        bail!(
            "Slurm takes % and \\ in a path for patterns: {}; give a --directory without them",
            wording::excerpt(text, 200)
        );
    }
    Ok(())
}

/// Returns what is to be submitted. A directory of an earlier submission must be of the same study
/// and shards, whose jobs have ended.
fn submission(args: &SubmitArgs, study: &Study, directory: &Path) -> Result<Submission> {
    let exports = args.exports.as_deref().map(std::path::absolute).transpose()?;
    if exports.as_deref().is_some_and(|exports| exports.to_str().is_none()) {
        bail!("--exports must be a path in UTF-8");
    }
    let new = Submission {
        study: study.name().to_owned(),
        shards: args.shards,
        file: Path::new(FROZEN).join(place(study)),
        exports: exports.clone().unwrap_or_else(|| "exports".into()),
        merged: format!("{}.tribosweep", study.name()).into(),
        jobs: Vec::new(),
    };
    if !directory.exists() {
        return Ok(new);
    }
    let shown = directory.display();
    let path = directory.join(SUBMISSION);
    let bytes = fs::read(&path).map_err(|error| {
        anyhow!("{shown} is there, and not by `submit` ({SUBMISSION}: {error}); give another --directory")
    })?;
    let former: Submission = serde_json::from_slice(&bytes)
        .with_context(|| format!("{} is damaged; give another --directory", path.display()))?;
    let file = directory.join(&former.file);
    if former.study != new.study || !is_same(study, &file)? {
        bail!(
            "{shown} belongs to another study, or to this one before it was edited ({}); give another \
             --directory, or remove it",
            file.display()
        );
    }
    if former.shards != new.shards {
        bail!(
            "{shown} belongs to {} of this study; go on with --shards {}, or give another --directory",
            count(former.shards as usize, "shard", "shards"),
            former.shards
        );
    }
    if exports.is_some_and(|exports| exports != former.exports) {
        bail!("{shown} has its exports in {}; leave out --exports", former.exports.display());
    }
    if args.dry_run {
        return Ok(former);
    }
    let queued = queued(&former.jobs)?;
    if !queued.is_empty() {
        let jobs = former.jobs.join(",");
        bail!(
            "the shards in {shown} are still queued or running: {}; wait for them, or cancel them by: \
             scancel {jobs}",
            count(queued.lines().count(), "job", "jobs")
        );
    }
    Ok(former)
}

/// Returns a line for each of some jobs that is queued or runs.
fn queued(jobs: &[String]) -> Result<String> {
    if jobs.is_empty() {
        return Ok(String::new());
    }
    let mut squeue = slurm_program("squeue");
    squeue.args(["--noheader", "--format=%i %T"]).arg(format!("--jobs={}", jobs.join(",")));
    let output = squeue.output().context("cannot run squeue")?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let answer = said(&output.stderr);
    // A controller that does not know the job any more says so by failing.
    if answer.contains("Invalid job id specified") {
        return Ok(String::new());
    }
    bail!(
        "it is not known whether the jobs {} of the submission before are still queued or running: \
         squeue says {answer}; try again when the controller answers",
        jobs.join(", ")
    )
}

/// Returns a program of Slurm that speaks to the cluster on which this one runs, and to which the
/// user's variables give no options.
fn slurm_program(name: &str) -> Command {
    let mut program = Command::new(name);
    program.stdin(Stdio::null()).env_remove("SLURM_CLUSTERS");
    for (variable, _) in std::env::vars_os() {
        let bytes = variable.as_encoded_bytes();
        if bytes.starts_with(b"SQUEUE_") || bytes.starts_with(b"SCANCEL_") {
            program.env_remove(variable);
        }
    }
    program
}

/// Writes the directory of a submission: whole, or not at all if it is new. In one that is there,
/// only the scripts are written.
fn write_directory(
    study: &Study,
    submission: &Submission,
    scripts: &Scripts<'_>,
    directory: &Path,
) -> Result<()> {
    if directory.exists() {
        return write_scripts(scripts, directory);
    }
    // Without what may stand at the end of it, a slash.
    let mut draft = directory.components().as_path().as_os_str().to_owned();
    draft.push(format!(".{}", std::process::id()));
    let draft = PathBuf::from(draft);
    let write = || {
        fs::create_dir_all(draft.join(LOG))?;
        freeze(study, &draft.join(FROZEN))?;
        write_scripts(scripts, &draft)?;
        write_submission(submission, &draft)?;
        fs::create_dir_all(draft.join(&submission.exports))?;
        Ok(fs::rename(&draft, directory)?)
    };
    let written: Result<()> = write();
    if written.is_err() {
        // What is left of a draft is of no use; the error that made it so matters more.
        let _ = fs::remove_dir_all(&draft);
    }
    written.with_context(|| format!("cannot write {}", directory.display()))
}

fn write_scripts(scripts: &Scripts<'_>, directory: &Path) -> Result<()> {
    for (name, text) in [(ARRAY_SCRIPT, scripts.array()), (MERGE_SCRIPT, scripts.merge())] {
        let path = directory.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn write_submission(submission: &Submission, directory: &Path) -> Result<()> {
    let path = directory.join(SUBMISSION);
    let draft = directory.join(format!("{SUBMISSION}.{}", std::process::id()));
    fs::write(&draft, serde_json::to_string_pretty(submission)? + "\n")
        .and_then(|()| fs::rename(&draft, &path))
        .with_context(|| format!("cannot write {}", path.display()))
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
    arrays: &[Array],
    place: SubmissionPlace<'_>,
    calls: &mut Vec<SbatchCall>,
) -> Result<()> {
    let SubmissionPlace { mut submission, directory, is_new } = place;
    let mut submit = |mut call: SbatchCall, calls: &mut Vec<SbatchCall>| {
        let job = sbatch(args, &call, directory)?;
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
    let cancelled = match jobs.is_empty() {
        true => Ok(()),
        false => match slurm_program("scancel").args(jobs).output() {
            Ok(output) if output.status.success() => Ok(()),
            Ok(output) => Err(said(&output.stderr)),
            Err(error) => Err(error.to_string()),
        },
    };
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

/// Returns the call that submits an array. If only so many elements may run at a time, an array
/// waits for the one before it.
fn array_call(array: &Array, at_a_time: Option<u32>, before: Option<&SbatchCall>) -> SbatchCall {
    let mut words = vec!["--parsable".to_owned(), format!("--array={}", array.option(at_a_time))];
    if let (Some(before), Some(_)) = (before, at_a_time) {
        words.push(depend(&[before]));
    }
    words.extend([ARRAY_SCRIPT.to_owned(), array.first.to_string()]);
    call(array.shards().collect(), words)
}

/// Returns the call that submits the merge after all arrays, however they end; without an array,
/// every shard is finished.
fn merge_call(arrays: &[SbatchCall]) -> SbatchCall {
    let mut words = vec!["--parsable".to_owned()];
    if !arrays.is_empty() {
        words.push(depend(&arrays.iter().collect::<Vec<_>>()));
        words.push("--kill-on-invalid-dep=yes".to_owned());
    }
    words.push(MERGE_SCRIPT.to_owned());
    call(Vec::new(), words)
}

fn call(shards: Vec<u32>, words: Vec<String>) -> SbatchCall {
    let shown: Vec<String> = words.iter().map(|word| option_word(word)).collect();
    SbatchCall { shards, command: format!("sbatch {}", shown.join(" ")), words, job: None }
}

/// Returns the option that lets a job wait for the end of others. Jobs that have no number yet are
/// called by their place.
fn depend(calls: &[&SbatchCall]) -> String {
    let mut option = "--dependency=afterany".to_owned();
    for (index, call) in calls.iter().enumerate() {
        let job = call.job.clone().unwrap_or_else(|| match calls {
            [_] => "ARRAY".to_owned(),
            _ => format!("ARRAY{}", index + 1),
        });
        option += &format!(":{job}");
    }
    option
}

/// Submits a job and returns its number.
fn sbatch(args: &SubmitArgs, call: &SbatchCall, directory: &Path) -> Result<String> {
    let mut sbatch = slurm_program("sbatch");
    sbatch.args(&call.words).current_dir(directory);
    let is_merge = call.shards.is_empty();
    let has_memory = args.mem.is_some() || is_merge && args.merge_mem.is_some();
    let has_time = args.time.is_some() || is_merge && args.merge_time.is_some();
    // What these say would overrule the scripts, or be taken for what the job's own Slurm says.
    let given = [
        ("SBATCH_TIMELIMIT", has_time),
        ("SBATCH_MEM_PER_NODE", has_memory),
        ("SBATCH_MEM_PER_CPU", has_memory),
        ("SBATCH_MEM_PER_GPU", has_memory),
        ("SBATCH_PARTITION", args.partition.is_some()),
        ("SBATCH_ACCOUNT", args.account.is_some()),
    ];
    let given = given.iter().filter(|(_, is_given)| *is_given).map(|(variable, _)| *variable);
    for variable in given.chain(OVERRULING) {
        sbatch.env_remove(variable);
    }
    let output = match sbatch.output() {
        Ok(output) => output,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            bail!("there is no sbatch on the PATH; submit from a login node of the cluster")
        }
        Err(error) => return Err(error).context("cannot run sbatch"),
    };
    if !output.status.success() {
        bail!("sbatch refuses `{}`: {}", call.command, said(&output.stderr));
    }
    // The number stands first; the name of a cluster may follow.
    let answer = String::from_utf8_lossy(&output.stdout);
    let job = answer.lines().last().and_then(|line| line.split(';').next()).unwrap_or_default();
    if job.is_empty() || !job.bytes().all(|byte| byte.is_ascii_digit()) {
        bail!("sbatch did not say the number of the job, but `{}`", wording::excerpt(&answer, 200));
    }
    Ok(job.to_owned())
}

/// Variables that change what is submitted.
const OVERRULING: [&str; 15] = [
    "SBATCH_ARRAY_INX",
    "SBATCH_CLUSTERS",
    "SBATCH_CPUS_PER_TASK",
    "SBATCH_ERROR",
    "SBATCH_JOB_NAME",
    "SBATCH_NO_REQUEUE",
    "SBATCH_OPEN_MODE",
    "SBATCH_OUTPUT",
    "SBATCH_REQUEUE",
    "SBATCH_SIGNAL",
    "SBATCH_WAIT",
    "SLURM_CPUS_PER_TASK",
    "SLURM_MEM_PER_CPU",
    "SLURM_MEM_PER_NODE",
    "SLURM_RESTART_COUNT",
];

/// Returns what a program said on standard error, on one line.
fn said(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    match lines.is_empty() {
        true => "nothing".to_owned(),
        false => wording::excerpt(&lines.join("; "), 400),
    }
}
