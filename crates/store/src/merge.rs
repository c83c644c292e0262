//! This folder merges stores and exports into a store or into one export.
//!
//! The order of the sources does not matter, and neither does it how often they are merged, as long
//! as no two of them have different results of one job. Of such results none is taken if they are
//! merged at once; in several steps the one that came first stays, and every merge reports it.
//! First it is decided what is taken of each record, and then every source is read once more, from
//! its beginning to its end, and what it has to give is written. A merge keeps no record and no key
//! of an export: it takes one byte for each record, some 100 bytes for each blob that is a file of
//! its own, and a few tens of MiB. A store that is merged takes 32 bytes more for each record.

mod adoption;
mod copy;
mod decision;
mod losses;
mod report;
mod shards;
mod source;
mod studies;
mod target;

use std::path::Path;

use crate::durable;
use crate::error::WriteError;
use crate::export::{ExportAppender, ExportError};
use crate::exports::{ExportHeader, FileIdentity};
use crate::parts;
use crate::reader::StoreReader;
use crate::rules::MergeRules;
use crate::store::Store;

use self::losses::MergeLosses;
pub use self::report::{MergeError, MergeReport, MergeSelection, RecordConflict};
use self::source::MergeInput;
use self::target::MergeTarget;

/// The use of what the sources say of shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ShardUse {
    /// The target remembers the shards, and words can be said about what is missing.
    Remember,
    /// The results count, and whose they were does not matter.
    Ignore,
}

/// Merges what was opened into the target.
fn merge(
    mut input: MergeInput,
    target: &mut MergeTarget,
    shards: ShardUse,
) -> Result<MergeReport, MergeError> {
    let store = match target {
        MergeTarget::Store(store) => Some(*store),
        MergeTarget::Export(_) => None,
    };
    let (mut report, mut losses) = (MergeReport::default(), MergeLosses::default());
    if shards == ShardUse::Remember {
        shards::unite(&input, store, &mut report)?;
    }
    let studies = studies::compare(&input, store, &mut report)?;
    let decision = decision::decide(&mut input, target, &mut report, &mut losses)?;
    copy::copy(&input, &decision, target, &mut report, &mut losses)?;
    shards::doubt(&input, target, &losses, &mut report)?;
    // The studies are named last: a merge that was cut short shows none that is not whole.
    studies::put(&input, studies, target, &mut report)?;
    let shards = &report.shards;
    match target {
        MergeTarget::Store(store) if !shards.is_empty() => {
            let directory = store.blobs().store();
            parts::write(directory, shards)
                .map_err(|source| WriteError::io("write", &directory.join(parts::FILE), source))?;
        }
        MergeTarget::Store(_) => {}
        MergeTarget::Export(writer) => {
            shards.iter().try_for_each(|shard| writer.put_part(shard))?;
        }
    }
    Ok(report)
}

impl Store {
    /// Adds the studies, the records and the blobs of stores and exports to this store. The order
    /// of the sources does not matter, and to do it again changes nothing. A merge that was cut
    /// short is completed by the next one. Two different results of one job are a conflict: nothing
    /// of that job is changed. What is damaged is left out and said.
    ///
    /// # Errors
    /// [`MergeError::StudiesDiffer`] and [`MergeError::ShardCounts`] before anything is written,
    /// and others if reading or writing fails as a whole.
    pub fn import(
        &self,
        sources: &[&StoreReader],
        rules: &MergeRules,
    ) -> Result<MergeReport, MergeError> {
        import(self, sources, rules, ShardUse::Remember)
    }

    /// Adds what stores and exports hold like [`import`](Store::import), without regard to whose
    /// shards they are: no number of shards is refused, and the store does not remember them.
    ///
    /// # Errors
    /// Those of [`import`](Store::import), but for [`MergeError::ShardCounts`].
    pub fn import_results(
        &self,
        sources: &[&StoreReader],
        rules: &MergeRules,
    ) -> Result<MergeReport, MergeError> {
        import(self, sources, rules, ShardUse::Ignore)
    }
}

fn import(
    store: &Store,
    sources: &[&StoreReader],
    rules: &MergeRules,
    shards: ShardUse,
) -> Result<MergeReport, MergeError> {
    let selection = MergeSelection::default();
    let input = MergeInput::new(sources, rules, &selection, store.blobs().store(), None);
    merge(input, &mut MergeTarget::Store(store), shards)
}

/// Checks that stores and exports belong together before there is a store to merge them into.
///
/// # Errors
/// [`MergeError::StudiesDiffer`] and [`MergeError::ShardCounts`], and [`MergeError::Read`] if a
/// source cannot be read.
pub fn require_mergeable(sources: &[&StoreReader], rules: &MergeRules) -> Result<(), MergeError> {
    let all = MergeSelection::default();
    let input = MergeInput::new(sources, rules, &all, Path::new(""), None);
    let mut report = MergeReport::default();
    shards::unite(&input, None, &mut report)?;
    studies::compare(&input, None, &mut report).map(drop)
}

/// Merges stores and exports into the export `target`, which takes its place when it is whole. What
/// an export there holds already stays. Otherwise it is like [`Store::import`].
///
/// # Errors
/// Those of [`Store::import`], and [`ExportError`] if the file at `target` is the export of a shard
/// or no export at all, or if another process writes it meanwhile.
pub fn merge_into_export(
    target: &Path,
    program: &str,
    sources: &[&StoreReader],
    rules: &MergeRules,
    selection: &MergeSelection,
) -> Result<MergeReport, MergeError> {
    // A merge that goes on at the same time and ends first removes this file, and so this one ends
    // without having taken the place of what it has not read.
    let header = ExportHeader { program: program.to_owned(), shard: None };
    let mut writer = ExportAppender::beside(target, &header)?;
    let before = FileIdentity::of_path(target);
    let earlier = durable::is_present(target).then(|| Store::read_by(target, rules)).transpose()?;
    if let Some(shard) =
        earlier.iter().flat_map(StoreReader::exports).find_map(|export| export.header.shard)
    {
        return Err(ExportError::OtherShard {
            path: target.to_owned(),
            found: shard.to_string(),
            wanted: "a merge".to_owned(),
        }
        .into());
    }
    let input = MergeInput::new(sources, rules, selection, target, earlier.as_ref());
    let mut report = merge(input, &mut MergeTarget::Export(&mut writer), ShardUse::Remember)?;
    for export in earlier.iter().flat_map(StoreReader::exports) {
        let words = export.damage.iter().map(|reason| format!("{}: {reason}", target.display()));
        report.faults.extend(words);
    }
    // No job is written twice.
    writer.write_end(writer.added())?;
    let changed = || ExportError::Changed { path: target.to_owned() };
    if FileIdentity::of_path(target) != before {
        return Err(changed().into());
    }
    writer.settle().map_err(|error| match error {
        ExportError::TakenOver { .. } => changed(),
        error => error,
    })?;
    Ok(report)
}
