//! A store remembers the shards whose exports were merged into it, so that a later merge can say
//! which are missing. The list says nothing of results: it may be lost.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::access::read_within;
use crate::durable;
use crate::exports::{ShardName, ShardState, require_possible};

/// The name of the list in the directory of a store.
pub(crate) const FILE: &str = "shards.json";

/// The largest list that is read \[bytes\].
const LIMIT: u64 = 64 << 20;

/// An entry of the list.
#[derive(Serialize, Deserialize)]
struct ListedShard {
    #[serde(flatten)]
    shard: ShardName,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

/// Reads the shards that were merged into the store in `directory`. A list that is gone or cannot
/// be read has none.
pub(crate) fn read(directory: &Path) -> Vec<ShardState> {
    let listed: Vec<ListedShard> = read_within(&directory.join(FILE), LIMIT)
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok())
        .unwrap_or_default();
    let possible = listed.into_iter().filter(|listed| require_possible(&listed.shard).is_ok());
    possible
        .map(|ListedShard { shard, note }| ShardState { shard, note: note.map(String::into_bytes) })
        .collect()
}

/// Replaces the list durably, unless it is the same.
pub(crate) fn write(directory: &Path, shards: &[ShardState]) -> io::Result<()> {
    if read(directory) == shards {
        return Ok(());
    }
    let listed: Vec<ListedShard> = shards
        .iter()
        .map(|state| ListedShard {
            shard: state.shard.clone(),
            note: state.note.as_ref().map(|note| String::from_utf8_lossy(note).into_owned()),
        })
        .collect();
    let mut text = serde_json::to_vec_pretty(&listed)?;
    text.push(b'\n');
    durable::write(&directory.join(FILE), &text)
}

/// Unites lists of shards. Of several notes of one shard the one that is furthest by `progress`
/// counts.
pub(crate) fn united(
    shards: impl IntoIterator<Item = ShardState>,
    progress: fn(&[u8]) -> u64,
) -> Vec<ShardState> {
    let mut best: BTreeMap<ShardName, Option<Vec<u8>>> = BTreeMap::new();
    for ShardState { shard, note } in shards {
        let found = best.entry(shard).or_default();
        let rank = |note: &Option<Vec<u8>>| (note.as_deref().map(progress), note.clone());
        if rank(&note) > rank(found) {
            *found = note;
        }
    }
    best.into_iter().map(|(shard, note)| ShardState { shard, note }).collect()
}
