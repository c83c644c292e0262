//! This file holds the open store without the server that shares it with other processes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use identity::{JobKey, STORED_LIMIT};

use crate::access::Wanted;
use crate::blob::Blobs;
use crate::database::{self, Fault, LOG, RECORDS};
use crate::durable;
use crate::error::{OpenError, WriteError};
use crate::kept::OpenWords;
use crate::lock::{self, Acquired, Holder, Lock};
use crate::manifest::{self, Manifest, Unreadable};
use crate::record;
use crate::sealed::SealedRecords;
use crate::table::TableFolder;
use crate::volume;

/// The longest time for which an opening waits for a process that has taken the lock to say who it
/// is, and for one of an earlier version that only reads to end.
const PATIENCE: Duration = Duration::from_secs(3);

/// The time by which the promise of the manifest may lag behind the records during a run. A promise
/// that is too low is harmless, and raising it costs twice as much as making a group of records
/// durable (measured: 8 ms and 4 ms).
const LAG: Duration = Duration::from_millis(500);

/// The directory of the sound database while a salvage is writing it.
pub(crate) const SALVAGED: &str = "records.salvaged";

/// The directory of a database whose place another one has taken, until it is removed.
pub(crate) const REPLACED: &str = "records.replaced";

/// Takes the lock and signs it as `holder`. It does not wait for another writer.
pub(crate) fn lock_for_writing(directory: &Path, holder: &Holder) -> Result<Lock, OpenError> {
    let refused =
        |source| OpenError::io("lock", Wanted::Write, &directory.join(lock::FILE), source);
    let start = Instant::now();
    loop {
        match Lock::acquire(directory).map_err(refused)? {
            Acquired::Lock(mut lock) => {
                if let Err(error) = lock.sign(holder) {
                    WriteError::require_space(directory, 0)?;
                    return Err(refused(error));
                }
                return Ok(lock);
            }
            // An unsigned lock was taken this moment; one whose holder was killed is free the next.
            Acquired::Held(found)
                if found.as_ref().is_some_and(Holder::is_listed) || start.elapsed() > PATIENCE =>
            {
                return Err(held_error(directory, found));
            }
            Acquired::Held(_) => thread::sleep(Duration::from_millis(5)),
        }
    }
}

fn held_error(directory: &Path, holder: Option<Holder>) -> OpenError {
    let directory = directory.to_owned();
    match holder {
        Some(holder) => OpenError::Held {
            directory,
            pid: holder.pid,
            held_for: holder.held_for(),
            command: holder.command,
        },
        None => OpenError::HeldByUnknown { directory },
    }
}

/// The open store without the server that shares it with other processes.
pub(crate) struct Core {
    pub(crate) directory: PathBuf,
    pub(crate) blobs: Blobs,
    pub(crate) records: SealedRecords,
    /// The manifest as it is on the disk. It is locked during every change of the store, so changes
    /// happen one at a time.
    manifest: Mutex<Manifest>,
    /// The time at which a commit last raised the promise of the manifest.
    raised: Mutex<Option<Instant>>,
    // The words about studies are dropped, and so written, after the database was closed.
    pub(crate) kept: OpenWords,
    // The tables that no word names are removed after that.
    _tables: TableFolder,
    // The lock is dropped last, unless somebody goes on holding it.
    pub(crate) lock: Arc<Lock>,
}

impl Core {
    /// Opens the store in an existing directory whose lock is held.
    pub(crate) fn open(directory: &Path, lock: Lock) -> Result<Core, OpenError> {
        let io = |action| move |source| OpenError::io(action, Wanted::Write, directory, source);
        let damaged = |what: String| OpenError::Damaged { directory: directory.to_owned(), what };
        if let Some(kind) =
            volume::network_file_system(directory).map_err(io("examine the file system of"))?
        {
            return Err(OpenError::NetworkFileSystem { directory: directory.to_owned(), kind });
        }
        durable::clear_unfinished(directory).map_err(io("clear"))?;
        let manifest = match read_manifest(directory)? {
            Some(manifest) => manifest,
            None => create_manifest(directory)?,
        };
        let path = directory.join(RECORDS);
        finish_salvage(directory).map_err(io("clear away an unfinished salvage in"))?;
        require_log(directory, &manifest)?;
        let kept = OpenWords::take(directory).map_err(io("clear"))?;
        // sled enlarges and rewrites its files when it opens them.
        WriteError::require_space(directory, 0)?;
        let failed = |fault: Fault| match fault {
            Fault::Io(source) => OpenError::io("open the database", Wanted::Write, &path, source),
            Fault::Damaged(what) => damaged(what),
        };
        durable::create_directory(&path).map_err(io("create the database in"))?;
        let records = match SealedRecords::open(&path) {
            // Nothing was acknowledged yet: the first commit makes a promise before it returns.
            Err(fault) if manifest.records == 0 && fault.is_damage() => {
                durable::put_aside(&path).map_err(io("put aside the damaged database of"))?;
                durable::create_directory(&path).map_err(io("create the database in"))?;
                SealedRecords::open(&path)
            }
            opened => opened,
        }
        .map_err(failed)?;
        let found = records.index().len() as u64;
        require_promised(directory, &manifest, found)?;
        let core = Core {
            directory: directory.to_owned(),
            blobs: Blobs::of(directory),
            records,
            manifest: Mutex::new(manifest),
            raised: Mutex::new(None),
            kept,
            _tables: TableFolder { store: directory.to_owned() },
            lock: Arc::new(lock),
        };
        core.records.database.sync().map_err(failed)?;
        core.records.database.sync_files().map_err(io("make durable the database of"))?;
        let mut manifest = core.manifest();
        if found > manifest.records {
            // A kill came between a commit and its manifest. The records are durable now and are
            // promised from here on.
            core.promise(&mut manifest, found)?;
        }
        drop(manifest);
        core.kept.opened();
        Ok(core)
    }

    pub(crate) fn manifest(&self) -> MutexGuard<'_, Manifest> {
        self.manifest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn replace(
        &self,
        manifest: &mut Manifest,
        next: Manifest,
    ) -> Result<(), WriteError> {
        WriteError::require_space(&self.directory, 0)?;
        next.write(&self.directory).map_err(|source| {
            WriteError::io("write the manifest", &self.directory.join(manifest::FILE), source)
        })?;
        *manifest = next;
        Ok(())
    }

    pub(crate) fn promise(&self, manifest: &mut Manifest, records: u64) -> Result<(), WriteError> {
        let next = manifest.promising(records);
        self.replace(manifest, next)
    }

    fn writable(&self, bytes: u64) -> Result<(), WriteError> {
        if let Some(earlier) = self.records.database.broken() {
            return Err(WriteError::Database(earlier.to_owned()));
        }
        WriteError::require_space(&self.directory, bytes)
    }

    pub(crate) fn commit<Record: AsRef<[u8]>>(
        &self,
        records: &[(JobKey, Record)],
    ) -> Result<(), WriteError> {
        if let Some((key, record)) =
            records.iter().find(|(_, record)| record.as_ref().len() > STORED_LIMIT)
        {
            return Err(WriteError::TooLarge { key: *key, bytes: record.as_ref().len() });
        }
        if records.is_empty() {
            return Ok(());
        }
        let mut manifest = self.manifest();
        match records.iter().any(|(key, _)| self.records.contains(key)) {
            true => self.kept.forget(),
            false => self.kept.records_come(),
        }
        self.writable(records.iter().map(|(_, record)| record.as_ref().len() as u64).sum())?;
        self.records.database.insert(
            records.iter().map(|(key, record)| (*key, record::seal(key, record.as_ref()))),
        )?;
        self.records.database.sync()?;
        let found = self.records.reindex(|index| index.extend(records.iter().map(|(key, _)| *key)));
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        // A promise of nothing would let a database that is damaged pass for a new one.
        let is_late = || raised.is_none_or(|last| last.elapsed() >= LAG);
        if found <= manifest.records || manifest.records > 0 && !is_late() {
            return Ok(());
        }
        self.promise(&mut manifest, found)?;
        *raised = Some(Instant::now());
        Ok(())
    }

    pub(crate) fn remove(&self, keys: &[JobKey]) -> Result<usize, WriteError> {
        let mut manifest = self.manifest();
        let present: BTreeSet<JobKey> =
            keys.iter().copied().filter(|key| self.records.contains(key)).collect();
        if present.is_empty() {
            return Ok(0);
        }
        self.kept.forget();
        self.writable(0)?;
        // The promise is lowered first, so that a kill between the two does not look like a loss.
        let left = (self.records.index().len() - present.len()) as u64;
        self.promise(&mut manifest, left)?;
        self.records.reindex(|index| index.retain(|key| !present.contains(key)));
        self.records.database.remove(present.iter())?;
        self.records.database.sync()?;
        Ok(present.len())
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        let found = self.records.index().len() as u64;
        let mut manifest = self.manifest();
        if found > manifest.records {
            // A failure does no harm, because the next opening counts again.
            let _ = self.promise(&mut manifest, found);
        }
    }
}

/// Reads the manifest, or returns `None` if there is neither a manifest nor a database.
pub(crate) fn read_manifest(directory: &Path) -> Result<Option<Manifest>, OpenError> {
    let damaged = |what: String| OpenError::Damaged { directory: directory.to_owned(), what };
    match Manifest::read(directory) {
        Ok(manifest) => Ok(Some(manifest)),
        Err(Unreadable::Format(found)) => {
            Err(OpenError::Format { directory: directory.to_owned(), found })
        }
        Err(Unreadable::Damaged(what)) => {
            Err(damaged(format!("its manifest.json cannot be read: {what}")))
        }
        Err(Unreadable::Io(source)) => {
            Err(OpenError::io("read", Wanted::Read, &directory.join(manifest::FILE), source))
        }
        Err(Unreadable::Absent) if directory.join(RECORDS).exists() => {
            Err(damaged("its manifest.json is missing".to_owned()))
        }
        Err(Unreadable::Absent) => Ok(None),
    }
}

/// Creates the manifest of a store that is new. It is written before the database, so a database
/// without a manifest means that the manifest was lost.
fn create_manifest(directory: &Path) -> Result<Manifest, OpenError> {
    let path = directory.join(manifest::FILE);
    if !is_vacant(directory)
        .map_err(|source| OpenError::io("look into", Wanted::Read, directory, source))?
    {
        return Err(OpenError::NotAStore { directory: directory.to_owned() });
    }
    let manifest = Manifest::new(0, BTreeMap::new(), BTreeMap::new());
    manifest
        .write(directory)
        .map_err(|source| OpenError::io("write", Wanted::Write, &path, source))?;
    Ok(manifest)
}

/// Refuses a store whose database is gone although its manifest promises records.
pub(crate) fn require_log(directory: &Path, manifest: &Manifest) -> Result<(), OpenError> {
    if manifest.records == 0 || directory.join(RECORDS).join(LOG).is_file() {
        return Ok(());
    }
    Err(OpenError::Damaged {
        directory: directory.to_owned(),
        what: format!("it promises {} records and has no database", manifest.records),
    })
}

/// Refuses a store that holds fewer records than its manifest promises.
pub(crate) fn require_promised(
    directory: &Path,
    manifest: &Manifest,
    found: u64,
) -> Result<(), OpenError> {
    if found >= manifest.records {
        return Ok(());
    }
    let promised = manifest.records;
    Err(OpenError::Damaged {
        directory: directory.to_owned(),
        what: format!("it promises {promised} records and only {found} can be found"),
    })
}

/// Clears away what a killed salvage or collection has left. One that was killed at its last step
/// is finished: the new database takes the place from which the old one was put aside. What cannot
/// be removed stays until the next opening, for it is in nobody's way.
fn finish_salvage(directory: &Path) -> io::Result<()> {
    let (records, salvaged) = (directory.join(RECORDS), directory.join(SALVAGED));
    if durable::is_real_directory(&salvaged) {
        if records.exists() {
            let _ = database::remove(&salvaged);
        } else {
            fs::rename(&salvaged, &records)?;
            durable::sync_directory(directory)?;
        }
    }
    let _ = database::remove(&directory.join(REPLACED));
    Ok(())
}

/// Returns true if the directory holds nothing except the leftovers of a killed opening or of a
/// writer of blobs.
pub(crate) fn is_vacant(directory: &Path) -> io::Result<bool> {
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name();
        let name = name.to_string_lossy();
        // The leftover of the first manifest of a killed opening belongs to the store too.
        if name != "lock" && name != "blobs" && !name.starts_with(durable::UNFINISHED_PREFIX) {
            return Ok(false);
        }
    }
    Ok(true)
}
