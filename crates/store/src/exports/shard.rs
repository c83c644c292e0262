//! This file names shards and says how far they are.

use std::io;

use serde::{Deserialize, Serialize};

/// The largest number of shards that a study may be in. What is missing is listed one by one.
pub const SHARD_LIMIT: u32 = 1 << 16;

/// The name of a shard: a part of a study that one machine computes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ShardName {
    /// The name of the study.
    pub study: String,
    /// The number of the shard, counted from 1.
    pub index: u32,
    /// The number of shards that the study is in.
    pub count: u32,
}

impl std::fmt::Display for ShardName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "shard {}/{} of the study `{}`", self.index, self.count, self.study)
    }
}

/// A shard whose results are in a file, and how far it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardState {
    /// The shard.
    pub shard: ShardName,
    /// The last note that the shard left.
    pub note: Option<Vec<u8>>,
}

/// Refuses the name of a shard that cannot be.
pub(crate) fn require_possible(shard: &ShardName) -> Result<(), String> {
    let ShardName { index, count, .. } = shard;
    if *count > SHARD_LIMIT {
        return Err(format!("is of {count} shards, and a study may be in {SHARD_LIMIT}"));
    }
    match (1..=*count).contains(index) {
        true => Ok(()),
        false => Err(format!("is of shard {index} of {count}, which cannot be")),
    }
}

/// Returns the table of the frame that says that a shard was merged into a file.
pub(crate) fn part_table(part: &ShardState) -> io::Result<Vec<u8>> {
    let name = serde_json::to_vec(&part.shard)?;
    let mut table = (name.len() as u32).to_le_bytes().to_vec();
    table.extend_from_slice(&name);
    // A part without a note differs from one whose note is empty.
    if let Some(note) = &part.note {
        table.push(1);
        table.extend_from_slice(note);
    }
    Ok(table)
}

pub(super) fn part_of(table: &[u8]) -> Result<ShardState, String> {
    let unreadable = || "names a part in words that cannot be read".to_owned();
    let (length, rest) = table.split_first_chunk::<4>().ok_or_else(unreadable)?;
    let (name, note) =
        rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(unreadable)?;
    let shard: ShardName = serde_json::from_slice(name).map_err(|_| unreadable())?;
    require_possible(&shard)?;
    Ok(ShardState { shard, note: note.split_first().map(|(_, note)| note.to_vec()) })
}
