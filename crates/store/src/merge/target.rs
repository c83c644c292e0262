//! This file holds the place into which a merge puts records.

use std::collections::BTreeSet;
use std::io;
use std::path::Path;

use identity::JobKey;

use crate::blob::Blobs;
use crate::digest::Digest;
use crate::error::{ReadError, WriteError};
use crate::export::{ExportAppender, ExportError, directory_of};
use crate::merge::report::MergeError;
use crate::rules::MergeRules;
use crate::store::Store;

/// The place into which is merged.
pub(super) enum MergeTarget<'t> {
    Store(&'t Store),
    Export(&'t mut ExportAppender),
}

impl MergeTarget<'_> {
    pub(super) fn keeps(&self, key: &JobKey) -> bool {
        match self {
            MergeTarget::Store(store) => store.contains(key),
            MergeTarget::Export(_) => false,
        }
    }

    /// Returns true if a sound record of the job is there, and those blobs. An export has what
    /// `was_written` by this merge.
    pub(super) fn has(
        &self,
        key: &JobKey,
        blobs: &BTreeSet<Digest>,
        was_written: bool,
        rules: &MergeRules,
    ) -> bool {
        match self {
            MergeTarget::Store(store) => {
                let record = store.get(key).ok().flatten();
                record.is_some_and(|record| (rules.examine)(key, &record).is_ok())
                    && blobs.iter().all(|digest| store.blobs().contains(digest))
            }
            MergeTarget::Export(writer) => {
                was_written && blobs.iter().all(|digest| writer.has_blob(digest))
            }
        }
    }

    /// Returns the directory in which there is room for what the merge cannot keep in memory.
    pub(super) fn directory(&self) -> &Path {
        match self {
            MergeTarget::Store(_) => self.path(),
            MergeTarget::Export(_) => directory_of(self.path()),
        }
    }

    /// Returns the error of a merge that could not sort in that directory.
    pub(super) fn unsorted(&self, source: io::Error) -> MergeError {
        const ACTION: &str = "sort the keys of the merge beside";
        match self {
            MergeTarget::Store(_) => WriteError::io(ACTION, self.path(), source).into(),
            MergeTarget::Export(_) => ExportError::io(ACTION, self.path(), source).into(),
        }
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            MergeTarget::Store(store) => store.blobs().store(),
            MergeTarget::Export(writer) => writer.path(),
        }
    }

    /// Stores a blob of `source` and returns true if it was not there.
    pub(super) fn adopt(
        &mut self,
        digest: &Digest,
        source: &Blobs,
    ) -> Result<Result<bool, ReadError>, MergeError> {
        match self {
            MergeTarget::Store(store) => Ok(store.blobs().adopt(digest, source)?),
            MergeTarget::Export(writer) => match writer.put_blob(digest, source) {
                Ok(is_new) => Ok(Ok(is_new)),
                Err(ExportError::Blob(fault)) => Ok(Err(fault)),
                Err(error) => Err(error.into()),
            },
        }
    }

    pub(super) fn commit(&mut self, group: &mut Vec<(JobKey, Vec<u8>)>) -> Result<(), MergeError> {
        match self {
            MergeTarget::Store(store) => {
                group.sort_unstable_by_key(|(key, _)| *key);
                store.commit(group)?;
            }
            MergeTarget::Export(writer) => {
                for (key, record) in group.iter() {
                    writer.put_record(key, record)?;
                }
            }
        }
        group.clear();
        Ok(())
    }
}
