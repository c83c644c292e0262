//! This file removes records and blobs from a store, whose database then takes less space.
//!
//! sled keeps the space that it once had. So the records that stay are written into a new
//! database, which takes the place of the old one in one step: a kill at any moment leaves either
//! of them, and the next opening clears away the other, as after a salvage.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{fs, io};

use identity::JobKey;
use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;

use crate::access::Wanted;
use crate::blob::{BlobFile, Blobs};
use crate::core::{Core, REPLACED, SALVAGED};
use crate::database::{self, Database, Fault, RECORDS, own_files};
use crate::digest::Digest;
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::grouped::GroupWriter;
use crate::store::Store;

/// The parts of a store that are to be removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Garbage {
    /// The jobs whose records are removed.
    pub records: BTreeSet<JobKey>,
    /// The blobs that are removed. Nothing that stays may refer to them.
    pub blobs: BTreeSet<Digest>,
    /// The blobs that are removed and to which no record refers, neither one that is removed. They
    /// make room for what else is done.
    pub loose_blobs: BTreeSet<Digest>,
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
    /// There was no room for a new database if this is true. The old one keeps its size, and later
    /// records use the space of the removed ones.
    pub is_in_place: bool,
    /// The old database could not be removed if this is true. The next opening tries again.
    pub is_old_left: bool,
}

/// The reason why a store cannot be collected.
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// The records or the blobs cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// There is no room to remove records, or something cannot be removed.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The new database cannot be written or take its place.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The database is elsewhere, and would not be replaced there.
    #[error(
        "{} is a symbolic link, so the database to which it leads cannot be replaced by a smaller \
         one, and nothing was removed; put that directory in its place",
        path.display()
    )]
    Linked {
        /// The link.
        path: PathBuf,
    },
}

impl Store {
    /// Removes records and blobs, and the leftovers of killed writers. The database is written anew
    /// if records are removed and there is room for it, so that it shrinks. A kill at any moment
    /// leaves everything that is not garbage. Definitions of studies stay in any case. Like
    /// [`compact`](Store::compact) it may be called only while nobody writes blobs whose digests
    /// are yet to appear in a record.
    ///
    /// # Errors
    /// [`CollectError`]. Some of the garbage may then be gone.
    pub fn collect(self, garbage: &Garbage) -> Result<Collection, CollectError> {
        // A fresh copy is written to the log once.
        self.collect_with(garbage, |bytes, directory| {
            WriteError::require_space(directory, bytes.div_ceil(2))
        })
    }

    /// Collects like [`collect`](Store::collect). `require_room` says whether there is room for a
    /// number of bytes of records in a directory.
    fn collect_with(
        self,
        garbage: &Garbage,
        require_room: impl Fn(u64, &Path) -> Result<(), WriteError>,
    ) -> Result<Collection, CollectError> {
        let blobs = self.blobs().clone();
        let studies: BTreeSet<Digest> = self.core().manifest().studies.values().copied().collect();
        let directory = self.core().directory.clone();
        let size = |directory: &Path| database_bytes(&directory.join(RECORDS));
        let mut done = Collection { database_before: size(&directory), ..Collection::default() };
        let present = garbage.records.iter().filter(|key| self.contains(key)).count();
        let records = directory.join(RECORDS);
        if present > 0 && !durable::is_real_directory(&records) {
            return Err(CollectError::Linked { path: records });
        }
        let without_studies = |blobs: &BTreeSet<Digest>| blobs - &studies;
        done.remove_files(&blobs, &without_studies(&garbage.loose_blobs))?;
        let is_copied = present > 0
            && match write_without(self.core(), &garbage.records, require_room) {
                Err(CollectError::Write(
                    WriteError::DiskFull { .. } | WriteError::FileLimit { .. },
                )) => {
                    let keys: Vec<JobKey> = garbage.records.iter().copied().collect();
                    self.remove(&keys)?;
                    done.is_in_place = true;
                    false
                }
                written => written.map(|()| true)?,
            };
        done.records = present;
        let _lock = self.into_lock();
        if is_copied {
            done.is_old_left = replace(&directory).map_err(|source| {
                OpenError::io("replace the database of", Wanted::Write, &directory, source)
            })?;
        }
        // The records that referred to them are gone.
        done.remove_files(&blobs, &without_studies(&garbage.blobs))?;
        done.database_after = size(&directory);
        Ok(done)
    }
}

impl Collection {
    /// Removes some blobs, and unfinished files, and counts them.
    fn remove_files(
        &mut self,
        blobs: &Blobs,
        garbage: &BTreeSet<Digest>,
    ) -> Result<(), CollectError> {
        for found in blobs.files()? {
            let (path, bytes) = match found {
                BlobFile::Blob { digest, path, bytes } if garbage.contains(&digest) => {
                    self.blobs += 1;
                    (path, bytes)
                }
                BlobFile::Unfinished { path, bytes } => {
                    self.unfinished += 1;
                    (path, bytes)
                }
                BlobFile::Blob { .. } | BlobFile::Stray(_) => continue,
            };
            match durable::remove(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(WriteError::io("remove the blob", &path, error).into());
                }
                _ => self.file_bytes += bytes,
            }
        }
        Ok(())
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
fn write_without(
    core: &Core,
    garbage: &BTreeSet<JobKey>,
    require_room: impl Fn(u64, &Path) -> Result<(), WriteError>,
) -> Result<(), CollectError> {
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
    require_room(bytes, &core.directory)?;
    for left in [&beside, &core.directory.join(REPLACED)] {
        database::remove(left).map_err(io("remove"))?;
    }
    durable::create_directory(&beside).map_err(io("create"))?;
    let to = Database::open(&beside).map_err(failed)?;
    let mut writer = GroupWriter::new(&to);
    for key in core.records.keys() {
        // Damaged records are copied as they are, and stay known to be damaged.
        if !garbage.contains(&key)
            && let Some(sealed) = from.get(&key).map_err(ReadError::from)?
        {
            writer.push(key, sealed).map_err(failed)?;
        }
    }
    writer.finish().map_err(failed)?;
    drop(to);
    // The promise is lowered before the records are gone. What is still there on closing counts.
    let left = core.records.reindex(|index| index.retain(|key| !garbage.contains(key)));
    core.promise(&mut manifest, left)?;
    Ok(())
}

/// Puts the database that was written beside that of the store into its place, and removes the old
/// one. Both are closed. Returns whether the old one could not be removed.
fn replace(directory: &Path) -> io::Result<bool> {
    let (records, beside) = (directory.join(RECORDS), directory.join(SALVAGED));
    let old = directory.join(REPLACED);
    match renameat_with(CWD, &beside, CWD, &records, RenameFlags::EXCHANGE) {
        Ok(()) => fs::rename(&beside, &old)?,
        // Some file systems cannot exchange two directories.
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP | Errno::PERM | Errno::NOTTY) => {
            replace_in_steps(directory)?
        }
        Err(error) => return Err(error.into()),
    }
    durable::sync_directory(directory)?;
    Ok(database::remove(&old).is_err())
}

/// Puts the old database aside and the new one into its place. A kill between the two steps is met
/// by the next opening, as that of a salvage is.
fn replace_in_steps(directory: &Path) -> io::Result<()> {
    let records = directory.join(RECORDS);
    fs::rename(&records, directory.join(REPLACED))?;
    fs::rename(directory.join(SALVAGED), &records)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn store(directory: &Path) -> (Store, Garbage) {
        let store = Store::open(directory).unwrap();
        let records: Vec<_> = (0..50u8).map(|i| (JobKey([i; 32]), vec![i; 2000])).collect();
        store.commit(&records).unwrap();
        let garbage = records.iter().skip(1).map(|(key, _)| *key).collect();
        (store, Garbage { records: garbage, ..Garbage::default() })
    }

    #[test]
    fn records_are_removed_in_place_where_no_copy_has_room() {
        let directory = tempfile::tempdir().unwrap();
        let (store, garbage) = store(directory.path());
        let full = |needed, path: &Path| {
            Err(WriteError::DiskFull { path: path.to_owned(), free: 0, needed })
        };
        let done = store.collect_with(&garbage, full).unwrap();
        assert_eq!((done.records, done.is_in_place, done.is_old_left), (49, true, false));
        let store = Store::open(directory.path()).unwrap();
        assert_eq!(store.keys(), [JobKey([0; 32])]);
        assert_eq!(store.get(&JobKey([0; 32])).unwrap(), Some(vec![0; 2000]));
    }

    #[test]
    fn a_database_is_replaced_in_steps_and_the_next_opening_removes_the_old_one() {
        for has_moved in [false, true] {
            let directory = tempfile::tempdir().unwrap();
            let (store, garbage) = store(directory.path());
            write_without(store.core(), &garbage.records, |_, _| Ok(())).unwrap();
            drop(store);
            if has_moved {
                replace_in_steps(directory.path()).unwrap();
            } else {
                // The process is killed between the two.
                let old = directory.path().join(REPLACED);
                fs::rename(directory.path().join(RECORDS), old).unwrap();
            }
            assert_eq!(Store::open(directory.path()).unwrap().len(), 1);
            for name in [REPLACED, SALVAGED] {
                assert!(!directory.path().join(name).exists(), "{name}");
            }
        }
    }

    #[test]
    fn what_cannot_be_cleared_away_does_not_lock_the_store() {
        let directory = tempfile::tempdir().unwrap();
        drop(store(directory.path()));
        for name in [REPLACED, SALVAGED] {
            let left = directory.path().join(name);
            fs::create_dir(&left).unwrap();
            fs::write(left.join("conf"), "old").unwrap();
            fs::write(left.join("foreign"), "somebody's").unwrap();
        }
        assert_eq!(Store::open(directory.path()).unwrap().len(), 50);
        for name in [REPLACED, SALVAGED] {
            let left = directory.path().join(name);
            assert!(left.join("foreign").exists() && !left.join("conf").exists());
        }
    }

    #[test]
    fn a_linked_database_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let (store, garbage) = store(directory.path());
        drop(store);
        let records = directory.path().join(RECORDS);
        fs::rename(&records, elsewhere.path().join(RECORDS)).unwrap();
        std::os::unix::fs::symlink(elsewhere.path().join(RECORDS), &records).unwrap();
        let refused = Store::open(directory.path()).unwrap().collect(&garbage).unwrap_err();
        assert!(matches!(refused, CollectError::Linked { .. }), "{refused}");
        assert!(fs::symlink_metadata(&records).unwrap().is_symlink());
        assert_eq!(Store::open(directory.path()).unwrap().len(), 50);
    }
}
