//! This file removes records and blobs from a store, whose database then takes less space.
//!
//! sled keeps the space that it once had. So the records that stay are written into a new
//! database, which takes the place of the old one in one step: a kill at any moment leaves either
//! of them, and the next opening clears away the other, as after a salvage.

use std::collections::BTreeSet;
use std::path::Path;
use std::{fs, io};

use identity::JobKey;
use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;

use crate::access::Wanted;
use crate::blob::BlobFile;
use crate::core::{Core, SALVAGED};
use crate::database::{Database, Fault, RECORDS, own_files};
use crate::digest::Digest;
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::store::Store;

/// The size of the records that are copied together \[bytes\].
const GROUP_BYTES: usize = 8 << 20;

/// The parts of a store that are to be removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Garbage {
    /// The jobs whose records are removed.
    pub records: BTreeSet<JobKey>,
    /// The blobs that are removed. Nothing that stays may refer to them.
    pub blobs: BTreeSet<Digest>,
}

/// The result of [`Store::collect`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Collection {
    /// The number of removed records.
    pub records: usize,
    /// The number of removed blobs.
    pub blobs: usize,
    /// The number of removed half-written files, which killed processes had left.
    pub unfinished: usize,
    /// The space of the removed files \[bytes\].
    pub file_bytes: u64,
    /// The size of the database before \[bytes\].
    pub database_before: u64,
    /// The size of the database afterwards \[bytes\].
    pub database_after: u64,
}

/// The reason why a store cannot be collected.
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// The records or the blobs cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// There is no room for the new database, or something cannot be removed.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The new database cannot be written or take its place.
    #[error(transparent)]
    Open(#[from] OpenError),
}

impl Store {
    /// Removes records and blobs, and the leftovers of killed writers. The database is written anew
    /// if records are removed, so that it shrinks. A kill at any moment leaves everything that is
    /// not garbage. Definitions of studies stay in any case. Like [`compact`](Store::compact) it
    /// may be called only while nobody writes blobs whose digests are yet to appear in a record.
    ///
    /// # Errors
    /// [`CollectError`]. Some of the garbage may then be gone.
    pub fn collect(self, garbage: &Garbage) -> Result<Collection, CollectError> {
        let blobs = self.blobs().clone();
        let studies: BTreeSet<Digest> = self.core().manifest().studies.values().copied().collect();
        let directory = self.core().directory.clone();
        let size = |directory: &Path| database_bytes(&directory.join(RECORDS));
        let mut done = Collection { database_before: size(&directory), ..Collection::default() };
        let present = garbage.records.iter().filter(|key| self.contains(key)).count();
        let _lock = if present > 0 {
            write_without(self.core(), &garbage.records)?;
            let lock = self.into_lock();
            replace(&directory).map_err(|source| {
                OpenError::io("replace the database of", Wanted::Write, &directory, source)
            })?;
            done.records = present;
            lock
        } else {
            self.into_lock()
        };
        // The records that referred to them are gone.
        for found in blobs.files()? {
            let (path, bytes) = match found {
                BlobFile::Blob { digest, path, bytes }
                    if garbage.blobs.contains(&digest) && !studies.contains(&digest) =>
                {
                    done.blobs += 1;
                    (path, bytes)
                }
                BlobFile::Unfinished { path, bytes } => {
                    done.unfinished += 1;
                    (path, bytes)
                }
                BlobFile::Blob { .. } | BlobFile::Stray(_) => continue,
            };
            match durable::remove(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(WriteError::io("remove the blob", &path, error).into());
                }
                _ => done.file_bytes += bytes,
            }
        }
        done.database_after = size(&directory);
        Ok(done)
    }
}

/// Returns the space that the database in `directory` takes \[bytes\].
fn database_bytes(directory: &Path) -> u64 {
    let names = own_files(directory).unwrap_or_default();
    let bytes = |name: &String| fs::metadata(directory.join(name)).map_or(0, |file| file.len());
    names.iter().map(bytes).sum()
}

/// Writes the records of the store beside its database, without those of some jobs, and promises no
/// more than these.
fn write_without(core: &Core, garbage: &BTreeSet<JobKey>) -> Result<(), CollectError> {
    let beside = core.directory.join(SALVAGED);
    let io = |action| {
        let beside = beside.clone();
        move |source| OpenError::io(action, Wanted::Write, &beside, source)
    };
    let failed = |fault| match fault {
        Fault::Io(source) => io("write the database")(source),
        Fault::Damaged(what) => OpenError::Damaged { directory: core.directory.clone(), what },
    };
    let mut manifest = core.manifest();
    let from = &core.records.database;
    let is_garbage = |key: &[u8]| key.try_into().is_ok_and(|key| garbage.contains(&JobKey(key)));
    let mut bytes = 0;
    from.visit(|key, sealed| {
        bytes += if is_garbage(key) { 0 } else { (key.len() + sealed.len()) as u64 };
    })
    .map_err(ReadError::from)?;
    WriteError::require_space(&core.directory, bytes)?;
    durable::clear_away(&beside).map_err(io("remove"))?;
    durable::create_directory(&beside).map_err(io("create"))?;
    let to = Database::open(&beside).map_err(failed)?;
    let mut group: Vec<(JobKey, Vec<u8>)> = Vec::new();
    let mut grouped = 0;
    let keys = core.records.keys();
    for (number, key) in keys.iter().enumerate() {
        // Damaged records are copied as they are, and stay known to be damaged.
        if !garbage.contains(key)
            && let Some(sealed) = from.get(key).map_err(ReadError::from)?
        {
            grouped += sealed.len();
            group.push((*key, sealed));
        }
        if grouped >= GROUP_BYTES || number + 1 == keys.len() {
            to.insert(group.iter().map(|(key, sealed)| (key, sealed.clone()))).map_err(failed)?;
            group.clear();
            grouped = 0;
        }
    }
    to.sync().map_err(failed)?;
    to.sync_files().map_err(io("make durable"))?;
    drop(to);
    // The promise is lowered before the records are gone. What is still there on closing counts.
    let left = core.records.reindex(|index| index.retain(|key| !garbage.contains(key)));
    core.promise(&mut manifest, left)?;
    Ok(())
}

/// Puts the database that was written beside that of the store into its place, and removes the old
/// one. Both are closed.
fn replace(directory: &Path) -> io::Result<()> {
    let (records, beside) = (directory.join(RECORDS), directory.join(SALVAGED));
    match renameat_with(CWD, &beside, CWD, &records, RenameFlags::EXCHANGE) {
        Ok(()) => {
            durable::sync_directory(directory)?;
            durable::clear_away(&beside)
        }
        // Some file systems cannot exchange two directories. A kill between the two steps is met
        // by the next opening, as that of a salvage is.
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => {
            let aside = durable::put_aside(&records)?;
            fs::rename(&beside, &records)?;
            durable::sync_directory(directory)?;
            aside.map_or(Ok(()), |aside| durable::clear_away(&aside))
        }
        Err(error) => Err(error.into()),
    }
}
