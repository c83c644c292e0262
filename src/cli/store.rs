//! The arguments of `store`.

use std::path::PathBuf;

use clap::Subcommand;

use super::shared::StoreArgs;
use super::upkeep::GcArgs;

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
