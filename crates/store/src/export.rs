//! This file copies a store whole, also while a run is writing it.

use std::collections::BTreeMap;
use std::path::Path;

use identity::JobKey;

use crate::digest::Digest;
use crate::error::{OpenError, ReadError, WriteError};
use crate::reader::{StoreReader, is_there};
use crate::store::Store;

/// The size of the records that are committed together \[bytes\].
const GROUP_BYTES: usize = 4 << 20;

/// The result of [`StoreReader::export`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Export {
    /// The number of copied records.
    pub records: usize,
    /// The number of copied blobs, without the definitions of studies.
    pub blobs: usize,
    /// The number of copied studies.
    pub studies: usize,
    /// The faults of what could not be copied, in words.
    pub faults: Vec<String>,
}

/// The reason why a store cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// There is a store already where the copy should be.
    #[error("{} is a store already; name a new directory", .0.display())]
    Occupied(std::path::PathBuf),
    /// The copy cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The store cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The copy cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl StoreReader {
    /// Copies the studies, the records and the blobs that they refer to into a new store in
    /// `destination`. Records are opaque to the store, so `references` names the blobs that a
    /// record refers to. What is damaged is left out and said.
    ///
    /// The studies are named last and at once, so a copy that was cut short shows none, and to copy
    /// to the same place again completes it.
    ///
    /// # Errors
    /// [`ExportError`] if there is a store with studies in `destination`, or if reading or writing
    /// fails as a whole. What was copied by then is a store without studies.
    pub fn export(
        &self,
        destination: &Path,
        mut references: impl FnMut(&JobKey, &[u8]) -> Vec<Digest>,
    ) -> Result<Export, ExportError> {
        let occupied = || ExportError::Occupied(destination.to_owned());
        if is_there(destination)? && !Store::read(destination)?.study_names()?.is_empty() {
            return Err(occupied());
        }
        let copy = Store::open(destination)?;
        if !copy.study_names().is_empty() {
            return Err(occupied());
        }
        let (mut done, mut studies) = (Export::default(), BTreeMap::new());
        // A run that adds a study meanwhile adds its records later.
        for name in self.study_names()? {
            match self.study(&name) {
                Ok(Some(definition)) => drop(studies.insert(name, definition)),
                Ok(None) => {}
                Err(error) => done.faults.push(format!("study {name}: {error}")),
            }
        }
        let (mut group, mut bytes) = (Vec::new(), 0);
        for (key, record) in self.records()? {
            let record = match record {
                Ok(record) => record,
                Err(gone @ (ReadError::Gone(_) | ReadError::Unanswered { .. })) => {
                    return Err(gone.into());
                }
                Err(error) => {
                    done.faults.push(format!("record {key}: {error}"));
                    continue;
                }
            };
            for digest in references(&key, &record) {
                if copy.blobs().is_sound(&digest).is_ok_and(|is_sound| is_sound) {
                    continue;
                }
                match self.blobs().get(&digest) {
                    Ok(Some(content)) => {
                        copy.blobs().put(&content)?;
                        done.blobs += 1;
                    }
                    Ok(None) => done
                        .faults
                        .push(format!("file {digest} is missing, job {key} refers to it")),
                    Err(error) => done.faults.push(error.to_string()),
                }
            }
            bytes += record.len();
            done.records += 1;
            group.push((key, record));
            if bytes >= GROUP_BYTES {
                copy.commit(&std::mem::take(&mut group))?;
                bytes = 0;
            }
        }
        copy.commit(&group)?;
        copy.put_studies(&studies)?;
        done.studies = studies.len();
        Ok(done)
    }
}
