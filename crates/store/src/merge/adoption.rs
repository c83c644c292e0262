//! This file brings blobs from the sources of a merge into its target.

use std::collections::BTreeMap;

use crate::digest::Digest;
use crate::error::ReadError;
use crate::merge::report::MergeError;
use crate::merge::source::MergeSource;
use crate::merge::target::MergeTarget;
use crate::rules::LostCompanion;

/// Stores a blob of the first of the sources that has a sound copy, and returns true if it was not
/// there.
pub(super) fn adopted(
    digest: &Digest,
    first: Option<&MergeSource>,
    sources: &[MergeSource],
    target: &mut MergeTarget,
) -> Result<Result<bool, ReadError>, MergeError> {
    let mut outcome = None;
    // The exports that one reader reads have their blobs together.
    let groups = sources.chunk_by(|one, next| std::ptr::eq(one.reader, next.reader));
    for source in first.into_iter().chain(groups.filter_map(<[_]>::first)) {
        match (target.adopt(digest, source.reader.blobs())?, &outcome) {
            (Ok(is_new), _) => return Ok(Ok(is_new)),
            // The fault of the source of the record says most.
            (Err(error), None) => outcome = Some(Err(error)),
            (Err(_), Some(_)) => {}
        }
    }
    Ok(outcome.unwrap_or(Ok(false)))
}

/// The blobs that go along with records, each of which is looked for once: `None` for one that the
/// target has, else the number of records without it and the reason.
#[derive(Default)]
pub(super) struct Companions(BTreeMap<Digest, Option<LostCompanion>>);

impl Companions {
    /// Brings a blob along with so many more records, and returns true if the target did not have
    /// it.
    pub(super) fn bring(
        &mut self,
        digest: &Digest,
        records: usize,
        first: Option<&MergeSource>,
        sources: &[MergeSource],
        target: &mut MergeTarget,
    ) -> Result<bool, MergeError> {
        if let Some(known) = self.0.get_mut(digest) {
            known.iter_mut().for_each(|lost| lost.records += records);
            return Ok(false);
        }
        let brought = adopted(digest, first, sources, target)?;
        let is_new = brought.as_ref().is_ok_and(|is_new| *is_new);
        let lost = brought.err().map(|error| {
            let reason = match error {
                ReadError::Blob { reason, .. } => reason,
                other => other.to_string(),
            };
            LostCompanion { digest: *digest, records, reason }
        });
        self.0.insert(*digest, lost);
        Ok(is_new)
    }

    /// Returns those that no source has.
    pub(super) fn lost(self) -> Vec<LostCompanion> {
        self.0.into_values().flatten().collect()
    }
}
