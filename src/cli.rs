//! The arguments of the command line, with examples.

mod reference;
mod results;
mod running;
mod shared;
mod store;
mod upkeep;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use study::MOST_SHARDS;

use crate::shard_choice::{ShardChoice, shard_choice};

pub(crate) use reference::{ColumnsArgs, KeysArgs};
pub(crate) use results::{
    AnswerArgs, CitationFormat, CiteArgs, FieldChoice, PlotArgs, QueryArgs, ReportArgs, ShowArgs,
    StatusArgs, TableFormat,
};
pub(crate) use running::{Engine, ExecutionArgs, ResumeArgs, RunArgs, SubmitArgs};
pub(crate) use shared::StoreArgs;
pub(crate) use store::StoreCommand;
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
        /// Number of times
        repeat: u32,
    },
    /// Run jobs for a coordinator (started by it)
    #[command(hide = true)]
    Worker {
        /// Threads that one job may use
        #[arg(long, default_value_t = 1)]
        threads: usize,
        /// Message of the coordinator to its worker
        argument: String,
    },
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
    /// Number of times that each is solved; the time is the median
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
    /// Draw the field of the solution with this index, where a search finds several [default: 0]
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
