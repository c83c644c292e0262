//! This file says what a reader finds out about an export: whose it is, and what is wrong with it.

use std::path::PathBuf;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::exports::shard::{ShardName, ShardState};

/// The first words of an export: whose it is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExportHeader {
    /// The version of the program that began it.
    pub program: String,
    /// The shard whose results it holds, if it is that of a shard.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardName>,
}

/// An export as a reader found it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportSummary {
    /// The path of the file.
    pub path: PathBuf,
    /// The header of the file; that of nobody if the header is damaged.
    pub header: ExportHeader,
    /// The number of jobs that have a record in the file.
    pub records: usize,
    /// The last note that the writer left. A reader that has
    /// [rules](crate::MergeRules::unfinished) does not believe that a shard is finished whose file
    /// is not closed, or has lost something.
    pub note: Option<Vec<u8>>,
    /// The shards that were merged into the file, with their last notes.
    pub parts: Vec<ShardState>,
    /// The time of the last change.
    pub changed: Option<SystemTime>,
    /// True if the writer has said that nothing more will come.
    pub is_closed: bool,
    /// False if nothing of the file can be read, and the damage says why. A file that is named
    /// alone must be readable.
    pub is_readable: bool,
    /// The length of what stands at the end and is no whole frame yet \[bytes\].
    pub unfinished: u64,
    /// The damage in words.
    pub damage: Vec<String>,
}

impl ExportSummary {
    /// Lists the shards whose results are in the file, with their last notes.
    pub fn shards(&self) -> Vec<ShardState> {
        let shard = self.header.shard.clone();
        let state = shard.map(|shard| ShardState { shard, note: self.note.clone() });
        state.into_iter().chain(self.parts.iter().cloned()).collect()
    }
}
