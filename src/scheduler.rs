//! Talks with the programs of a cluster's Slurm: what it allows, what is queued, and what is to be
//! submitted or cancelled.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::output;
use crate::patience::answer_within;
use crate::slurm::{ControllerConfig, Resources, SbatchCall};

/// Returns the limits of the controller. A dry run does without one.
pub(crate) fn controller_config(is_dry_run: bool) -> Result<ControllerConfig> {
    config_of(controller_question().output(), is_dry_run)
}

/// Returns the limits of a controller that answers in time.
pub(crate) fn controller_config_within(limit: Duration) -> Result<ControllerConfig> {
    config_of(answer_within(&mut controller_question(), limit), false)
}

/// Returns the program that asks the controller for its limits.
fn controller_question() -> Command {
    let mut scontrol = slurm_program("scontrol");
    scontrol.args(["show", "config"]);
    scontrol
}

fn config_of(answer: std::io::Result<Output>, is_dry_run: bool) -> Result<ControllerConfig> {
    match answer {
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

/// Returns a line for each of some jobs that is queued or runs.
pub(crate) fn queued(jobs: &[String]) -> Result<String> {
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

/// Cancels jobs, or says why that cannot be.
pub(crate) fn cancel(jobs: &[String]) -> Result<(), String> {
    if jobs.is_empty() {
        return Ok(());
    }
    match slurm_program("scancel").args(jobs).output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(said(&output.stderr)),
        Err(error) => Err(error.to_string()),
    }
}

/// Submits a job and returns its number.
pub(crate) fn sbatch(call: &SbatchCall, resources: &Resources, directory: &Path) -> Result<String> {
    let mut sbatch = slurm_program("sbatch");
    sbatch.args(&call.words).current_dir(directory);
    let is_merge = call.shards.is_empty();
    let (memory, time) = match is_merge {
        true => (&resources.merge_memory, &resources.merge_time),
        false => (&resources.memory, &resources.time),
    };
    // What these say would overrule the scripts, or be taken for what the job's own Slurm says.
    let given = [
        ("SBATCH_TIMELIMIT", time.is_some()),
        ("SBATCH_MEM_PER_NODE", memory.is_some()),
        ("SBATCH_MEM_PER_CPU", memory.is_some()),
        ("SBATCH_MEM_PER_GPU", memory.is_some()),
        ("SBATCH_PARTITION", resources.partition.is_some()),
        ("SBATCH_ACCOUNT", resources.account.is_some()),
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
