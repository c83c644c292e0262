//! This file says what a merge takes, what comes of it, and why there is none.

use std::collections::BTreeSet;
use std::path::PathBuf;

use identity::JobKey;

use crate::error::{OpenError, ReadError, WriteError};
use crate::export::ExportError;
use crate::exports::{ShardName, ShardState};
use crate::rules::LostCompanion;

/// The choice of what is merged.
#[derive(Clone, Debug, Default)]
pub struct MergeSelection {
    /// The names of the studies, if not all.
    pub studies: Option<BTreeSet<String>>,
    /// The jobs, if not all.
    pub keys: Option<BTreeSet<JobKey>>,
}

/// A job of which two sources have different results. Nothing of it is changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordConflict {
    /// The job.
    pub key: JobKey,
    /// A source with a result.
    pub first: PathBuf,
    /// A source with another result.
    pub second: PathBuf,
}

/// The result of a merge.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MergeReport {
    /// The number of jobs that had no record before.
    pub added: usize,
    /// The number of jobs whose record took the place of one of lower rank.
    pub replaced: usize,
    /// The number of records in the sources that repeat what is there.
    pub already_there: usize,
    /// The number of records that were added and that another version of the program wrote. They
    /// lie beside the others.
    pub foreign: usize,
    /// The number of blobs that were added, without the definitions of studies.
    pub blobs: usize,
    /// The number of studies that were added.
    pub studies: usize,
    /// The jobs with different results.
    pub conflicts: Vec<RecordConflict>,
    /// The faults of what was left out, in words.
    pub faults: Vec<String>,
    /// The records that are in the target without a blob that they refer to, in words.
    pub incomplete: Vec<String>,
    /// The blobs that go along with records of the target and that no source has.
    pub lost_companions: Vec<LostCompanion>,
    /// The shards whose results are in the target, with their last notes.
    pub shards: Vec<ShardState>,
    /// The shards of which nothing is remembered any more, because their study is in another number
    /// of shards now. Their results stay.
    pub forgotten: Vec<ShardName>,
}

/// The reason why nothing, or nothing more, is merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// Two sources have studies of one name that differ. Nothing was written.
    #[error(
        "{} and {} have different studies called {name:?}, and nothing was merged; rename one of \
         them, or merge them into different places",
        .first.display(), .second.display()
    )]
    StudiesDiffer {
        /// The name of the studies.
        name: String,
        /// A source with the study.
        first: PathBuf,
        /// A source with the other study.
        second: PathBuf,
    },
    /// A study came in shards of different numbers. Nothing was written.
    #[error(
        "{} is {first_shard} and {} is {second_shard}: the shards are of different numbers, and \
         nothing was merged; merge those of one number",
        .first.display(), .second.display()
    )]
    ShardCounts {
        /// A source with a shard.
        first: PathBuf,
        /// The shard.
        first_shard: ShardName,
        /// A source with a shard of another number.
        second: PathBuf,
        /// The other shard.
        second_shard: ShardName,
    },
    /// A source or the target cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A source cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The target cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The target cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
}
