//! The arguments of the command line, with examples.

mod reference;
mod shared;
mod upkeep;

use std::path::PathBuf;

use answers::shards::Shard;
use clap::{Args, Parser, Subcommand, ValueEnum};
use study::MOST_SHARDS;

use crate::failure_limit::FailureLimit;
use crate::proposal::STORE_VARIABLE;
use crate::shard_choice::{ShardChoice, shard_choice};
use crate::slurm::TimeLimit;
use crate::time_budget::TimeBudget;

pub(crate) use reference::{ColumnsArgs, KeysArgs};
pub(crate) use shared::StoreArgs;
use shared::memory_size;
pub(crate) use upkeep::{
    DiffArgs, DifferenceFormat, DoctorArgs, GcArgs, NoteArgs, RmArgs, TagArgs,
};

/// Parameter studies of elastic contact with Coulomb friction.
#[derive(Parser)]
#[command(
    name = "tribosweep",
    version,
    about,
    disable_help_subcommand = true,
    after_help = "Start with:\n  tribosweep run sweeps/stick-zone.toml     launch or continue a study\n  tribosweep query stick-zone --sort mu     its results as a table\n\nExit codes: 0 all done, 1 a mistake in what was asked, 2 finished but some jobs failed, 3 stopped by --max-failures, 75 stopped by --until or --max-jobs (the same command goes on), 130 interrupted."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Launch a study or continue it; what is in the store is not computed again
    #[command(
        after_help = "Examples:\n  tribosweep run sweeps/stick-zone.toml\n  tribosweep run sweeps/stick-zone.toml --workers 4 --json > events.jsonl\n  tribosweep run sweeps/stick-zone.toml --retry-failed\n  tribosweep run sweeps/stick-zone.toml --until 55m\n  tribosweep run sweeps/stick-zone.toml --shard 3/16 --export exports     a part of it, on one of several machines\n\nCtrl-C once stops after the jobs in flight, twice stops now. SIGTERM and SIGUSR1 stop as --until does: no further job is begun, and jobs in flight are given up after 20 s. In every case the same command continues."
    )]
    Run(RunArgs),
    /// Hand a study to a cluster: an array of shards, and a merge after it
    #[command(
        after_help = "Examples:\n  tribosweep submit sweeps/stick-zone.toml --shards 16 --cpus-per-task 8 --time 2:00:00\n  tribosweep submit sweeps/stick-zone.toml --shards 16 --dry-run      shows the scripts, submits nothing\n  tribosweep submit sweeps/stick-zone.toml --shards 16 -- --qos=long --constraint=haswell\n\nThe scripts and a copy of the study go to NAME-shards, the results to NAME-shards/NAME.tribosweep. A shard that runs out of time queues itself again and continues. The same line again submits the shards that are not finished."
    )]
    Submit(SubmitArgs),
    /// Say what a study would run: jobs, cached ones, predicted time and memory; runs nothing
    #[command(
        after_help = "Examples:\n  tribosweep plan sweeps/stick-zone.toml\n  tribosweep plan sweeps/stick-zone.toml --json\n  tribosweep plan sweeps/stick-zone.toml --shards 16     what each of 16 machines would have\n  tribosweep plan sweeps/stick-zone.toml --shard 3/16"
    )]
    Plan(PlanArgs),
    /// Measure what leaving effects out saves, on the first job of each group of jobs that call for
    /// the same ones
    #[command(
        after_help = "Examples:\n  tribosweep effects sweeps/effects.toml\n  tribosweep effects sweeps/cattaneo-loop.toml --repeat 5 --json\n\nEach job is solved with every effect left out that its scene does not call for, then with each of those simulated, then with everything: in a process of its own, on one thread. Nothing is stored."
    )]
    Effects(EffectsArgs),
    /// Say what accuracy costs in time: a ladder of meshes and tolerances for a scene, each rung
    /// timed alone
    #[command(
        after_help = "Examples:\n  tribosweep cost sweeps/cost.toml\n  tribosweep cost sweeps/sphere.toml --set friction.mu=0.5\n\nA study of kind \"cost\" is run as it stands. Of any other the scene is taken, its axes fixed by --set, and a ladder made for it."
    )]
    Cost(CostArgs),
    /// Continue a study from the store alone; its file need not exist any more
    #[command(after_help = "Examples:\n  tribosweep resume stick-zone")]
    Resume(ResumeArgs),
    /// List the studies in the store: jobs done, failed, left
    #[command(after_help = "Examples:\n  tribosweep status\n  tribosweep status stick-zone --json")]
    Status(StatusArgs),
    /// Print what a study says beyond its rows: thresholds, orders of convergence, limits
    #[command(
        after_help = "Examples:\n  tribosweep answer sliding\n  tribosweep answer convergence --json\n  tribosweep answer uncertain-coating --column peak_pressure     of a sample: mean, deviation, quantiles; or the influence of each key"
    )]
    Answer(AnswerArgs),
    /// Print a study's results as a table
    #[command(
        after_help = "Examples:\n  tribosweep query stick-zone --where 'mu > 0.3 && mesh == 32' --select mu,poisson,stick_fraction --sort mu\n  tribosweep query stick-zone --sort=-peak_pressure --format csv > results.csv\n  tribosweep query stick-zone --format parquet --output results.parquet     every column, for pandas, DuckDB and others\n  tribosweep query stick-zone --steps --where 'step == 1'     every increment of the loading paths\n  tribosweep query stick-zone --columns      what can be selected"
    )]
    Query(QueryArgs),
    /// Show one result whole: scene, numbers, certificate, provenance, fields
    #[command(
        after_help = "Examples:\n  tribosweep show 3fa9c1\n  tribosweep show 3fa9c1 --steps     the increments of its loading path\n  tribosweep show 3fa9c1 --field pressure\n  tribosweep show 3fa9c1 --field state --output state.png     also .svg .npy .vti .csv\n  tribosweep show 3fa9c1 --output path.pvd     every field of every increment, for ParaView"
    )]
    Show(ShowArgs),
    /// Draw the figures that answer a study's question
    #[command(
        after_help = "Examples:\n  tribosweep plot stick-zone\n  tribosweep plot cattaneo-loop --figure loss --output loss.svg\n  tribosweep plot stick-zone --x mu --y load --series poisson --output load.svg\n  tribosweep plot wheel-on-rail --y hertz_a,hertz_b\n  tribosweep plot uncertain-coating --x stick_fraction --kind histogram --share\n\n--kind, --bins, --share, --x, --y, --series, --panels, --steps, --log-x and --log-y change one figure: that of --figure, else the study's first."
    )]
    Plot(PlotArgs),
    /// Write one page of HTML about a study: answer, figures, table, fields, failures, provenance
    #[command(
        after_help = "Examples:\n  tribosweep report stick-zone\n  tribosweep report stick-zone --where 'mu > 0.3' --output rough.html\n  tribosweep report stick-zone --fields 3fa9c1,77b02e     with the fields of these jobs\n  tribosweep report stick-zone --fields 0     without fields\n  tribosweep report stick-zone --crate stick-zone-crate     an RO-Crate for an archive\n\nThe page opens offline, asks nobody for anything and can be mailed. The same results give the same bytes."
    )]
    Report(ReportArgs),
    /// Print the references of the method and of every effect that a study uses, with their DOIs
    #[command(
        after_help = "Examples:\n  tribosweep cite stick-zone\n  tribosweep cite sweeps/stick-zone.toml --format bibtex > references.bib"
    )]
    Cite(CiteArgs),
    /// Compare the results of two studies, or those of one study in two stores
    #[command(
        after_help = "Examples:\n  tribosweep diff stick-zone stick-zone-fine --tolerance 0.1%\n  tribosweep diff stick-zone --other before/.tribosweep     what another store, or another version of the program, has\n  tribosweep diff stick-zone --other exports --select load,stick_fraction --format csv\n\nPoints are matched by the values of the axes of both. Numbers below 1e-9 of the largest quantity of their unit at a point are taken for noise; with --tolerance 0 every digit counts. Where a store has results of earlier physics only, these are compared.\n\nExit codes: 0 the same, 2 something differs, 1 nothing could be compared, or a mistake in what was asked."
    )]
    Diff(DiffArgs),
    /// Put words to a study, to tell it from others
    #[command(
        after_help = "Examples:\n  tribosweep tag stick-zone paper final\n  tribosweep tag stick-zone --remove final\n  tribosweep tag stick-zone     prints its tags\n\nTags stand in `status`, `answer` and `report`. They are kept in the store, and not in exports."
    )]
    Tag(TagArgs),
    /// Put a remark to a study
    #[command(
        after_help = "Examples:\n  tribosweep note stick-zone \"mesh 48 is enough, see figure 3\"\n  tribosweep note stick-zone --remove\n  tribosweep note stick-zone     prints it\n\nThe note stands in `status`, `answer` and `report`. It is kept in the store, and not in exports."
    )]
    Note(NoteArgs),
    /// Remove studies from the store; their results stay until `store gc`
    #[command(
        after_help = "Examples:\n  tribosweep rm stick-zone\n  tribosweep rm stick-zone sliding --dry-run\n\nNothing is asked. To run the study's file again brings it back, with every result that is still there."
    )]
    Rm(RmArgs),
    /// Solve one scene, here and now, in this process; nothing is stored
    #[command(
        after_help = "Examples:\n  tribosweep solve sweeps/sphere.toml\n  tribosweep solve sweeps/sphere.toml --set friction.mu=0.5 --set mesh=48 --field state"
    )]
    Solve(SolveArgs),
    /// Check and tidy the store, export and merge stores
    #[command(subcommand)]
    Store(StoreCommand),
    /// Say what this machine gives a run, what is short and what to do about it; solves one scene
    #[command(
        after_help = "Examples:\n  tribosweep doctor\n  tribosweep doctor --store /scratch/.tribosweep     where the results are to be kept\n  tribosweep doctor --json\n\nA worker is started and its result kept in a directory that is removed again.\n\nExit codes: 0 a run is possible, 1 it is not, 130 interrupted."
    )]
    Doctor(DoctorArgs),
    /// Say what a study file may have: keys with their values, bounds, defaults and meanings
    #[command(
        after_help = "Examples:\n  tribosweep keys friction.mu     all there is to say about one key\n  tribosweep keys loading     the keys of a table\n  tribosweep keys poisson     the keys with this in their paths\n  tribosweep keys --json     all of them, for other programs"
    )]
    Keys(KeysArgs),
    /// Say what tables of results may have: columns with their units and meanings
    #[command(
        after_help = "Examples:\n  tribosweep columns stick     the columns with this in their names\n  tribosweep columns --json\n\n`tribosweep query NAME --columns` lists those of one study, with its axes and keys."
    )]
    Columns(ColumnsArgs),
    /// Print a completion script for a shell
    #[command(
        after_help = "Examples:\n  tribosweep completions bash > /etc/bash_completion.d/tribosweep"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the pages of the book about keys, columns and commands
    #[command(hide = true)]
    Reference {
        /// The directory of the pages
        directory: PathBuf,
    },
    /// Solve the job on standard input several times, on one thread (started by `effects`)
    #[command(hide = true)]
    Measured {
        /// How often
        repeat: u32,
    },
    /// Run jobs for a coordinator (started by it)
    #[command(hide = true)]
    Worker {
        /// Threads that one job may use
        #[arg(long, default_value_t = 1)]
        threads: usize,
        /// What the coordinator tells its worker
        argument: String,
    },
}

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
pub(crate) struct PlanArgs {
    /// The study file
    pub(crate) study: PathBuf,
    /// Plan one of so many parts of the study, for example 3/16
    #[arg(long, value_name = "I/N", value_parser = shard_choice)]
    pub(crate) shard: Option<ShardChoice>,
    /// Say what each of so many parts of the study would have
    #[arg(long, value_name = "N", conflicts_with = "shard", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SHARDS)))]
    pub(crate) shards: Option<u32>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct EffectsArgs {
    /// The study file
    pub(crate) study: PathBuf,
    /// How often each is solved; the time is the median
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeat: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct CostArgs {
    /// A study file
    pub(crate) study: PathBuf,
    /// Set a key of the scene or the numerics, for example friction.mu=0.5
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) execution: ExecutionArgs,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
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

#[derive(Args)]
pub(crate) struct StatusArgs {
    /// Name of a study [default: all]
    pub(crate) name: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct AnswerArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Column that the points of a sample are to describe, in place of those of the figures; may be
    /// given several times
    #[arg(long, value_delimiter = ',')]
    pub(crate) column: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// The formats of a table.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum TableFormat {
    /// For reading
    Table,
    /// RFC 4180, numbers in full precision
    Csv,
    /// An array of objects
    Json,
    /// Parquet, with every column unless --select names some; needs --output
    Parquet,
}

#[derive(Args)]
pub(crate) struct QueryArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Keep the rows for which this holds, for example 'mu > 0.3 && mesh == 32'
    #[arg(long = "where", value_name = "EXPRESSION")]
    pub(crate) filter: Option<String>,
    /// Columns, separated by commas [default: the axes and the usual figures]
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS")]
    pub(crate) select: Vec<String>,
    /// Columns to sort by, separated by commas; -column sorts downwards (write --sort=-column)
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS", allow_hyphen_values = true)]
    pub(crate) sort: Vec<String>,
    /// Print it in this form
    #[arg(long, value_enum, default_value = "table")]
    pub(crate) format: TableFormat,
    /// The same as --format json
    #[arg(long, conflicts_with = "format")]
    pub(crate) json: bool,
    /// Write it to a file
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// List the columns that can be selected, and their units
    #[arg(long, conflicts_with_all = ["filter", "select", "sort"])]
    pub(crate) columns: bool,
    /// One row for each increment of the loading paths; columns step, cycle and increment say which
    #[arg(long)]
    pub(crate) steps: bool,
    /// Only the points of one of so many parts of the study, for example 3/16
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct ShowArgs {
    /// Key of the result, or its first characters
    pub(crate) key: String,
    /// Draw a field: pressure, traction_x, traction_y, traction, gap, slip_x, slip_y,
    /// friction_work, state, or wear_depth of a scene that wears
    #[arg(long, value_name = "FIELD")]
    pub(crate) field: Option<String>,
    /// Of a search that found several solutions, the index of the one whose field to draw [default:
    /// 0]
    #[arg(long, value_name = "INDEX", requires = "field")]
    pub(crate) solution: Option<usize>,
    /// Write the field to a file: .png .svg .npy .vti .csv, or the fields of all increments: .pvd
    /// (their path is solved again). Without --field, .vti .csv .pvd hold every field
    #[arg(long, value_name = "FILE", conflicts_with_all = ["steps", "json"])]
    pub(crate) output: Option<PathBuf>,
    /// Fields below the surface on a plane, "z=0.1 mm", or on a section, "y=0 mm": von_mises,
    /// tresca, stress_xx … stress_xz, stress_first … stress_third
    #[arg(long, value_name = "PLANE", conflicts_with_all = ["steps", "json", "solution"])]
    pub(crate) plane: Option<String>,
    /// Depth of a section, "0.5 mm" [default: twice the radius of the disk of the loaded area]
    #[arg(long, value_name = "DEPTH", requires = "plane")]
    pub(crate) down_to: Option<String>,
    /// Print the increments of its loading path as a table
    #[arg(long, conflicts_with = "field")]
    pub(crate) steps: bool,
    /// Print JSON
    #[arg(long, conflicts_with = "field")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct PlotArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Draw only the figure of this name; a figure without a name is called by its number [default:
    /// all]
    #[arg(long, value_name = "NAME")]
    pub(crate) figure: Option<String>,
    /// Form of the figure [default: that of the study's figure; scatter for a sample]
    #[arg(long, value_name = "KIND", value_parser = ["curves", "scatter", "histogram"])]
    pub(crate) kind: Option<String>,
    /// Number of bins of a histogram [default: by the rule of Freedman and Diaconis]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) bins: Option<u32>,
    /// Parts of the points in a histogram, and no counts
    #[arg(long)]
    pub(crate) share: bool,
    /// Column along x [default: the study's figure]
    #[arg(long)]
    pub(crate) x: Option<String>,
    /// Column along y, or several of one unit, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub(crate) y: Vec<String>,
    /// Columns that tell the curves apart, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub(crate) series: Option<Vec<String>>,
    /// Column that tells the panels apart
    #[arg(long)]
    pub(crate) panels: Option<String>,
    /// Draw every increment, joined along its loading path, for example --x at_shift_x --y force_x
    #[arg(long)]
    pub(crate) steps: bool,
    /// Keep the rows for which this holds
    #[arg(long = "where", value_name = "EXPRESSION")]
    pub(crate) filter: Option<String>,
    /// Logarithmic x
    #[arg(long)]
    pub(crate) log_x: bool,
    /// Logarithmic y
    #[arg(long)]
    pub(crate) log_y: bool,
    /// File to write, .svg or .png [default: NAME.svg and NAME.png in the current directory,
    /// NAME-FIGURE for the other figures]
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Print JSON: the files written
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct ReportArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Keep the jobs for which this holds, for example 'mu > 0.3 && mesh == 32'
    #[arg(long = "where", value_name = "EXPRESSION")]
    pub(crate) filter: Option<String>,
    /// The jobs whose fields the page has: keys, or their first characters, separated by commas, or
    /// how many at most, from 0 to 999 [default: a handful that tell most]
    #[arg(long, value_name = "KEYS|N", value_parser = FieldChoice::parse)]
    pub(crate) fields: Option<FieldChoice>,
    /// File to write [default: NAME.html in the current directory]
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write an RO-Crate into this new directory instead: the page with the study's files, its
    /// results, its figures, its references and what computed it
    #[arg(long = "crate", value_name = "DIR", conflicts_with_all = ["filter", "output"])]
    pub(crate) research_object: Option<PathBuf>,
    /// Licence of the RO-Crate, as the address of its text
    #[arg(long, value_name = "URL", requires = "research_object")]
    pub(crate) license: Option<String>,
    /// Author of the RO-Crate, as a name or as "NAME, https://orcid.org/…"; once for each author
    #[arg(long = "author", value_name = "NAME", requires = "research_object")]
    pub(crate) authors: Vec<String>,
    /// Print JSON: the file, its size, the jobs whose fields it has, what it leaves out
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// The jobs whose fields a page has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FieldChoice {
    /// At most so many, which tell most.
    Count(usize),
    /// The jobs whose keys begin so.
    Keys(Vec<String>),
}

impl FieldChoice {
    /// Parses a count of at most three digits, or beginnings of keys.
    fn parse(text: &str) -> Result<Self, String> {
        let is_digits = text.bytes().all(|byte| byte.is_ascii_digit());
        if let (true, 1..=3, Ok(count)) = (is_digits, text.len(), text.parse()) {
            return Ok(Self::Count(count));
        }
        let keys: Vec<String> =
            text.split(',').map(|key| key.trim().to_ascii_lowercase()).collect();
        match keys.iter().find(|key| {
            !(1..=64).contains(&key.len()) || !key.bytes().all(|byte| byte.is_ascii_hexdigit())
        }) {
            Some(key) => Err(format!(
                "`{key}` is neither a number up to 999 nor the beginning of a key, which has \
                 hexadecimal digits"
            )),
            None => Ok(Self::Keys(keys)),
        }
    }
}

/// The formats of a list of references.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum CitationFormat {
    /// For reading: what is used, by how many jobs, and the works
    Text,
    /// BibTeX, each work once
    Bibtex,
}

#[derive(Args)]
pub(crate) struct CiteArgs {
    /// Name of the study in the store, or a study file
    pub(crate) name: String,
    /// Print it in this form
    #[arg(long, value_enum, default_value = "text")]
    pub(crate) format: CitationFormat,
    /// Print JSON
    #[arg(long, conflicts_with = "format")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct SolveArgs {
    /// A study file; its axes must leave exactly one job, or be fixed by --set
    pub(crate) scene: PathBuf,
    /// Set a key of the scene or the numerics, for example friction.mu=0.5 or punch.radius="2 mm"
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Draw a field: pressure, traction_x, traction_y, traction, gap, slip_x, slip_y,
    /// friction_work, state, or wear_depth of a scene that wears
    #[arg(long, value_name = "FIELD")]
    pub(crate) field: Option<String>,
    /// Of a search that finds several solutions, the index of the one whose field to draw [default:
    /// 0]
    #[arg(long, value_name = "INDEX", requires = "field")]
    pub(crate) solution: Option<usize>,
    /// Write the field to a file: .png .svg .npy .vti .csv, or the fields of all increments: .pvd
    /// (their path is solved again). Without --field, .vti .csv .pvd hold every field
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub(crate) output: Option<PathBuf>,
    /// Print JSON
    #[arg(long, conflicts_with = "field")]
    pub(crate) json: bool,
}

#[derive(Subcommand)]
pub(crate) enum StoreCommand {
    /// Read every record and every file and say what is damaged
    #[command(
        after_help = "Examples:\n  tribosweep store verify\n  tribosweep store verify --deep"
    )]
    Verify {
        /// Also prove anew what records claim to have proved: the brackets of uniqueness sets
        #[arg(long)]
        deep: bool,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Rebuild a damaged store from what can still be verified; what is lost is computed again by
    /// the next run
    #[command(after_help = "Examples:\n  tribosweep store salvage")]
    Salvage {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Remove files that no record refers to
    #[command(after_help = "Examples:\n  tribosweep store compact")]
    Compact {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Remove results and files that no study refers to; the database shrinks
    #[command(
        after_help = "Examples:\n  tribosweep store gc --dry-run\n  tribosweep store gc\n  tribosweep store gc --older-than 30d --larger-than 10MB\n\nWhat is removed is listed first. Nothing that a study refers to is removed, also where a study chooses points or shares results with others. Results of earlier versions of the physics stay for `diff`, and those that an unfinished study may yet choose. A run that needs a removed result computes it again. While a run has the store, it is refused."
    )]
    Gc(GcArgs),
    /// Write a store, or some of its studies, into one checksummed file, also while a run goes on
    #[command(
        after_help = "Examples:\n  tribosweep store export backup.tribosweep\n  tribosweep store export zone.tribosweep --study stick-zone\n\nWhat an export of that name holds already stays. Every command that reads a store reads an export, or a directory of exports: --store backup.tribosweep. `tribosweep store merge STORE --into DIRECTORY` copies a store whole."
    )]
    Export {
        /// The file, whose name ends in .tribosweep
        file: PathBuf,
        /// Export this study with its results [default: everything]
        #[arg(long = "study", value_name = "NAME")]
        studies: Vec<String>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Bring exports, or other stores, into the store
    #[command(
        after_help = "Examples:\n  tribosweep store import backup.tribosweep\n  tribosweep store import exports/*.tribosweep --store .tribosweep\n\nTo import again changes nothing. Exit codes are those of `store merge`."
    )]
    Import {
        /// Exports, directories of exports or stores
        #[arg(required = true, value_name = "SOURCE")]
        sources: Vec<PathBuf>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        store: StoreArgs,
    },
    /// Merge exports and stores, in any order, any number of times, also when shards are missing
    #[command(
        after_help = "Examples:\n  tribosweep store merge exports --into .tribosweep\n  tribosweep store merge exports/*.tribosweep --into all.tribosweep     one file, for a parallel file system\n  tribosweep store merge .tribosweep --into backup     a copy of a whole store\n\nExit codes: 0 whole, 1 two machines have different results of a job (the rest is merged), 2 shards are missing or unfinished, or something is damaged; the commands that compute it are printed."
    )]
    Merge {
        /// Exports, directories of exports or stores
        #[arg(required = true, value_name = "SOURCE")]
        sources: Vec<PathBuf>,
        /// The store to merge into, or a file whose name ends in .tribosweep
        #[arg(long, value_name = "TARGET")]
        into: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
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
