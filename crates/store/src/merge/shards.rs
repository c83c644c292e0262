//! This file unites what the sources of a merge know of shards.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use identity::JobKey;

use crate::digest::Digest;
use crate::exports::{ShardName, ShardState};
use crate::merge::losses::MergeLosses;
use crate::merge::report::{MergeError, MergeReport};
use crate::merge::source::{MergeInput, MergeSource};
use crate::merge::target::MergeTarget;
use crate::parts;
use crate::store::Store;

/// A shard that is known, and from where.
struct KnownShard {
    path: PathBuf,
    state: ShardState,
    origin: ShardOrigin,
}

/// The origin of the knowledge of a shard. What comes later in this list counts more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ShardOrigin {
    /// The target remembers it.
    Target,
    /// A store that is merged remembers it.
    Store,
    /// An export that is merged names it.
    Export,
}

/// Unites what the sources and the target know of shards.
pub(super) fn unite(
    input: &MergeInput,
    target: Option<&Store>,
    report: &mut MergeReport,
) -> Result<(), MergeError> {
    let mut shards: Vec<KnownShard> = Vec::new();
    if let Some(store) = target {
        let path = store.blobs().store().to_owned();
        let origin = ShardOrigin::Target;
        let known = parts::read(&path).into_iter();
        shards.extend(known.map(|state| KnownShard { path: path.clone(), state, origin }));
    }
    for source in &input.sources {
        let names = input.study_names(source);
        let found = source.shards().into_iter();
        let chosen =
            found.filter(|state| names.is_none_or(|names| names.contains(&state.shard.study)));
        let origin = match source.is_export() {
            _ if source.is_target => ShardOrigin::Target,
            true => ShardOrigin::Export,
            false => ShardOrigin::Store,
        };
        let known = |state| KnownShard { path: source.path.clone(), state, origin };
        shards.extend(chosen.map(known));
    }
    // A study may be divided anew: what stores remember of another division is forgotten.
    let mut valid: BTreeMap<String, (ShardOrigin, u32)> = BTreeMap::new();
    for found in &shards {
        let ShardName { study, count, .. } = &found.state.shard;
        let weight = (found.origin, *count);
        let known = valid.entry(study.clone()).or_insert(weight);
        *known = weight.max(*known);
    }
    let is_valid = |found: &KnownShard| {
        let ShardName { study, count, .. } = &found.state.shard;
        valid.get(study).is_some_and(|(_, valid)| valid == count)
    };
    let of_exports = || shards.iter().filter(|found| found.origin == ShardOrigin::Export);
    if let Some(odd) = of_exports().find(|found| !is_valid(found)) {
        let of_study =
            || of_exports().filter(|found| found.state.shard.study == odd.state.shard.study);
        let first = of_study().next().unwrap_or(odd);
        let differs = |found: &&KnownShard| found.state.shard.count != first.state.shard.count;
        let second = of_study().find(differs).unwrap_or(odd);
        return Err(MergeError::ShardCounts {
            first: first.path.clone(),
            first_shard: first.state.shard.clone(),
            second: second.path.clone(),
            second_shard: second.state.shard.clone(),
        });
    }
    let (kept, others): (Vec<_>, Vec<_>) = shards.into_iter().partition(is_valid);
    let forgotten: BTreeSet<_> = others.into_iter().map(|found| found.state.shard).collect();
    report.forgotten = forgotten.into_iter().collect();
    let states = kept.into_iter().map(|found| found.state);
    report.shards = parts::united(states, input.rules.progress);
    Ok(())
}

/// Takes for unfinished the shards of sources that have a job of which the target lacks
/// something.
pub(super) fn doubt(
    input: &MergeInput,
    target: &MergeTarget,
    losses: &MergeLosses,
    report: &mut MergeReport,
) -> Result<(), MergeError> {
    let is_lost = |(key, blobs): &(&JobKey, &BTreeSet<Digest>)| {
        !target.has(key, blobs, losses.written.contains(key), input.rules)
    };
    let mut lost: Vec<JobKey> = losses.jobs.iter().filter(is_lost).map(|(key, _)| *key).collect();
    if lost.is_empty() && losses.doubted.is_empty() {
        return Ok(());
    }
    let names = |source: &MergeSource| source.shards().into_iter().map(|state| state.shard);
    let doubted = losses.doubted.iter().map(|source| &input.sources[*source]);
    let mut doubtful: BTreeSet<ShardName> = doubted.flat_map(names).collect();
    // What an earlier file of the target has lost is a loss of its own if no other source has
    // it; otherwise that one says more precisely whose it was.
    let of_target = input.sources.iter().filter(|source| source.is_target);
    let others = input.sources.iter().filter(|source| !source.is_target);
    let mut explained: BTreeSet<JobKey> = BTreeSet::new();
    for source in others.chain(of_target) {
        if source.is_target {
            lost.retain(|key| !explained.contains(key));
        }
        if lost.is_empty() {
            break;
        }
        let (found, is_whole) = source.having(&lost)?;
        if !found.is_empty() || !is_whole {
            doubtful.extend(names(source));
        }
        explained.extend(found);
    }
    for state in &mut report.shards {
        if let Some(note) = state.note.as_mut().filter(|_| doubtful.contains(&state.shard)) {
            *note = (input.rules.unfinished)(note);
        }
    }
    Ok(())
}
