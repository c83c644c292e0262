//! This file verifies everything in a store and removes what nothing refers to.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::PathBuf;

use identity::JobKey;

use crate::blob::BlobFile;
use crate::digest::Digest;
use crate::durable;
use crate::error::{ReadError, WriteError};
use crate::reader::StoreReader;
use crate::rules::{LostCompanion, References};
use crate::store::Store;

/// The result of verifying a store.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verification {
    /// The number of sound records.
    pub records: usize,
    /// The records that differ from what was written, with the reason.
    pub corrupt_records: Vec<(JobKey, String)>,
    /// The number of sound blobs.
    pub blobs: usize,
    /// The space that the sound blobs take on the disk \[bytes\].
    pub blob_bytes: u64,
    /// The blobs that differ from what was written, with the reason.
    pub corrupt_blobs: Vec<(Digest, String)>,
    /// The blobs that go along with records and are damaged or not there. The records are whole.
    pub lost_companions: Vec<LostCompanion>,
    /// The blobs that a record refers to and that are not there, with the first job that refers to
    /// them.
    pub missing_blobs: Vec<(Digest, JobKey)>,
    /// The number of blobs that no record and no study refers to. [`Store::compact`] removes them.
    pub unreferenced_blobs: usize,
    /// The number of studies whose definition is sound.
    pub studies: usize,
    /// The names of the studies whose definition cannot be read, with the reason.
    pub lost_studies: Vec<(String, String)>,
    /// The damage of exports that is neither in a record nor in a blob, in words.
    pub damaged_exports: Vec<String>,
    /// The exports that do not end as a whole one does: they are being written, their writer was
    /// killed, or the file was cut short.
    pub open_exports: Vec<PathBuf>,
    /// The files among the blobs that do not belong to the store.
    pub stray_files: Vec<PathBuf>,
}

impl Verification {
    /// Returns true if every result and every study that was ever stored is there and unchanged.
    pub fn is_sound(&self) -> bool {
        self.corrupt_records.is_empty()
            && self.corrupt_blobs.is_empty()
            && self.missing_blobs.is_empty()
            && self.lost_studies.is_empty()
            && self.damaged_exports.is_empty()
    }
}

/// The result of [`Store::compact`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compaction {
    /// The number of removed blobs that nothing referred to.
    pub blobs: usize,
    /// The number of removed half-written files, which killed processes had left.
    pub unfinished: usize,
    /// The freed space \[bytes\].
    pub bytes: u64,
}

impl StoreReader {
    /// Reads and verifies everything. Records are opaque to the store, so `references` names the
    /// blobs that a record refers to.
    ///
    /// # Errors
    /// [`ReadError`] if a fault hides everything else. Damage to single records, blobs and studies
    /// is part of the result.
    pub fn verify<Referred: Into<References>>(
        &self,
        mut references: impl FnMut(&JobKey, &[u8]) -> Referred,
    ) -> Result<Verification, ReadError> {
        let mut answer = Verification::default();
        let mut referenced = BTreeMap::new();
        let mut companions: BTreeMap<Digest, usize> = BTreeMap::new();
        // What a run adds meanwhile has its blobs before its record, and is not missed.
        for (key, record) in self.records()? {
            match record {
                Ok(record) => {
                    answer.records += 1;
                    let References { needed, companions: along } = references(&key, &record).into();
                    for digest in needed {
                        referenced.entry(digest).or_insert(key);
                    }
                    for digest in along {
                        *companions.entry(digest).or_default() += 1;
                    }
                }
                Err(ReadError::Corrupt { reason, .. }) => {
                    answer.corrupt_records.push((key, reason))
                }
                Err(gone @ (ReadError::Gone(_) | ReadError::Unanswered { .. })) => {
                    return Err(gone);
                }
                Err(other) => answer.corrupt_records.push((key, other.to_string())),
            }
        }
        if let Some(set) = self.export_set() {
            answer.damaged_exports = set.faults_of_replaced()?;
        }
        for export in self.exports() {
            let path = export.path.display();
            let words = export.damage.iter().map(|reason| format!("{path}: {reason}"));
            answer.damaged_exports.extend(words);
            if !export.is_closed && export.is_readable {
                answer.open_exports.push(export.path);
            }
        }
        let studies = self.studies()?;
        let mut present = BTreeSet::new();
        let mut damaged_companions: BTreeMap<Digest, String> = BTreeMap::new();
        for found in self.blobs().files()? {
            match found {
                BlobFile::Blob { digest, bytes, .. } => {
                    present.insert(digest);
                    let is_study = studies.values().any(|study| *study == digest);
                    let is_needed = referenced.contains_key(&digest) || is_study;
                    let is_companion = companions.contains_key(&digest) && !is_needed;
                    match self.blobs().is_sound(&digest) {
                        Ok(true) => {
                            answer.blobs += 1;
                            answer.blob_bytes += bytes;
                        }
                        Ok(false) => drop(present.remove(&digest)),
                        Err(error) => {
                            let reason = match error {
                                ReadError::Blob { reason, .. } => reason,
                                other => other.to_string(),
                            };
                            if is_companion {
                                damaged_companions.insert(digest, reason);
                            } else {
                                answer.corrupt_blobs.push((digest, reason));
                            }
                        }
                    }
                    answer.unreferenced_blobs += usize::from(!is_needed && !is_companion);
                }
                BlobFile::Unfinished { .. } => {}
                BlobFile::Stray(path) => answer.stray_files.push(path),
            }
        }
        for (digest, records) in companions {
            let reason = match damaged_companions.remove(&digest) {
                Some(reason) => reason,
                None if present.contains(&digest) => continue,
                None => "it is missing".to_owned(),
            };
            answer.lost_companions.push(LostCompanion { digest, records, reason });
        }
        answer.missing_blobs =
            referenced.into_iter().filter(|(digest, _)| !present.contains(digest)).collect();
        for (name, digest) in studies {
            match self.blobs().definition(&name, &digest) {
                Ok(_) => answer.studies += 1,
                Err(error) => answer.lost_studies.push((name, error.to_string())),
            }
        }
        Ok(answer)
    }
}

impl Store {
    /// Removes the blobs that are neither in `referenced` nor the definition of a study, and the
    /// leftovers of killed writers. It may be called only while nobody writes blobs whose digests
    /// are yet to appear in a record.
    ///
    /// # Errors
    /// [`CompactError`] if the blobs cannot be listed or removed.
    pub fn compact(&self, referenced: &BTreeSet<Digest>) -> Result<Compaction, CompactError> {
        let studies: BTreeSet<Digest> = self.core().manifest().studies.values().copied().collect();
        let mut removed = Compaction::default();
        for found in self.blobs().files()? {
            let (path, bytes) = match found {
                BlobFile::Blob { digest, .. }
                    if referenced.contains(&digest) || studies.contains(&digest) =>
                {
                    continue;
                }
                BlobFile::Blob { path, bytes, .. } => {
                    removed.blobs += 1;
                    (path, bytes)
                }
                BlobFile::Unfinished { path, bytes } => {
                    removed.unfinished += 1;
                    (path, bytes)
                }
                BlobFile::Stray(_) => continue,
            };
            match durable::remove(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(WriteError::io("remove the blob", &path, error).into());
                }
                _ => removed.bytes += bytes,
            }
        }
        Ok(removed)
    }
}

/// The reason why a store cannot be compacted.
#[derive(Debug, thiserror::Error)]
pub enum CompactError {
    /// The blobs cannot be listed.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A blob cannot be removed.
    #[error(transparent)]
    Write(#[from] WriteError),
}
