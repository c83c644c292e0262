//! The arguments of what runs a study, here or on a cluster.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use study::MOST_SHARDS;

use super::shared::{StoreArgs, memory_size};
use crate::failure_limit::FailureLimit;
use crate::proposal::STORE_VARIABLE;
use crate::shard_choice::{ShardChoice, shard_choice};
use crate::slurm::TimeLimit;
use crate::time_budget::TimeBudget;

#[derive(Args, Clone)]
pub(crate) struct ExecutionArgs {
    /// Worker processes [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) workers: Option<u32>,
    /// Compute failed and quarantined jobs again
    #[arg(long)]
    pub(crate) retry_failed: bool,
    /// Memory that all workers together may use, for example 8GiB [default: 80 % of what is
    /// available]
    #[arg(long, value_name = "SIZE", value_parser = memory_size)]
    pub(crate) memory: Option<u64>,
    /// Begin no job that would not end within this time, for example 55m or 1h30m, but always one,
    /// and exit with code 75 if some are left. Jobs in flight may take a twentieth of it longer, at
    /// most 20 s
    #[arg(long, value_name = "DURATION", value_parser = TimeBudget::parse)]
    pub(crate) until: Option<TimeBudget>,
    /// Compute so many jobs at most, and exit with code 75 if some are left
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_jobs: Option<u32>,
    /// Begin no further job once more than so many have failed, for example 5 or 10% of the jobs
    /// to compute, and exit with code 3
    #[arg(long, value_name = "LIMIT", value_parser = FailureLimit::parse)]
    pub(crate) max_failures: Option<FailureLimit>,
    /// Print events as JSON lines on standard output instead of a progress bar
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct RunArgs {
    /// The study file
    pub(crate) study: PathBuf,
    /// Run one of so many parts of the study, for example 3/16; auto takes both numbers from the
    /// job array of a scheduler, auto/16 only the index
    #[arg(long, value_name = "I/N", value_parser = shard_choice)]
    pub(crate) shard: Option<ShardChoice>,
    /// Write the results to a file in this directory while they come, and go on from what is there
    #[arg(long, value_name = "DIR")]
    pub(crate) export: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) execution: ExecutionArgs,
    /// Directory of the store [default: .tribosweep; with --export a directory for temporary files,
    /// which is removed when all is exported]
    #[arg(long, env = STORE_VARIABLE, value_name = "DIR")]
    pub(crate) store: Option<PathBuf>,
}

/// The schedulers of clusters.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Engine {
    /// An array of batch jobs by `sbatch`
    Slurm,
}

#[derive(Args)]
pub(crate) struct SubmitArgs {
    /// The study file
    pub(crate) study: PathBuf,
    /// The scheduler
    #[arg(long, value_enum, default_value = "slurm")]
    pub(crate) engine: Engine,
    /// Parts of the study, each a job on one node
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SHARDS)))]
    pub(crate) shards: u32,
    /// Submit only these shards, separated by commas [default: those that are not finished]
    #[arg(long, value_name = "SHARDS", value_delimiter = ',')]
    pub(crate) only: Vec<u32>,
    /// Shards that may run at the same time, each on a node [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) nodes: Option<u32>,
    /// Processors of a shard, and so its workers
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) cpus_per_task: u32,
    /// Memory of a shard as sbatch has it, for example 16G [default: the cluster's]
    #[arg(long, value_name = "SIZE", value_parser = slurm_memory)]
    pub(crate) mem: Option<String>,
    /// Time of a shard as sbatch has it, for example 2:00:00 [default: the cluster's]
    #[arg(long, value_name = "TIME")]
    pub(crate) time: Option<TimeLimit>,
    /// Memory of the merge as sbatch has it [default: that of --mem]
    #[arg(long, value_name = "SIZE", value_parser = slurm_memory)]
    pub(crate) merge_mem: Option<String>,
    /// Time of the merge as sbatch has it [default: that of --time]
    #[arg(long, value_name = "TIME")]
    pub(crate) merge_time: Option<TimeLimit>,
    /// Partition of the cluster
    #[arg(long, value_name = "NAME", value_parser = slurm_name)]
    pub(crate) partition: Option<String>,
    /// Account that pays
    #[arg(long, value_name = "NAME", value_parser = slurm_name)]
    pub(crate) account: Option<String>,
    /// Times that a shard may start again
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    pub(crate) restarts: u32,
    /// Directory for the scripts, the copy of the study and what the jobs say [default:
    /// NAME-shards]
    #[arg(long, value_name = "DIR")]
    pub(crate) directory: Option<PathBuf>,
    /// Directory for the results of the shards [default: exports in the directory of the scripts]
    #[arg(long, value_name = "DIR")]
    pub(crate) exports: Option<PathBuf>,
    /// Print the scripts and commands; write and submit nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Other options for sbatch, each one word
    #[arg(last = true, value_name = "SBATCH_OPTION")]
    pub(crate) passed: Vec<String>,
}

#[derive(Args)]
pub(crate) struct ResumeArgs {
    /// Name of the study
    pub(crate) name: String,
    #[command(flatten)]
    pub(crate) execution: ExecutionArgs,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// Checks a size of memory that `sbatch` takes.
fn slurm_memory(text: &str) -> Result<String, String> {
    let digits = text.strip_suffix(['K', 'M', 'G', 'T', 'k', 'm', 'g', 't']).unwrap_or(text);
    if !digits.is_empty() && digits.len() < 12 && digits.bytes().all(|byte| byte.is_ascii_digit()) {
        Ok(text.to_owned())
    } else {
        Err("must be a whole number with K, M, G or T, for example 16G".to_owned())
    }
}

/// Checks a name that `sbatch` takes.
fn slurm_name(text: &str) -> Result<String, String> {
    let is_name =
        !text.is_empty() && !text.contains(char::is_whitespace) && wording::one_line(text) == text;
    if is_name { Ok(text.to_owned()) } else { Err("must be a name without blanks".to_owned()) }
}
