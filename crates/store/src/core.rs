//! This file holds the open store without the server that shares it with other processes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use identity::{JobKey, STORED_LIMIT};

use crate::blob::Blobs;
use crate::database::{Database, Fault};
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::lock::{Acquired, Holder, Lock};
use crate::manifest::{self, Manifest, Unreadable};
use crate::record::{self, Unsealable};
use crate::volume;

/// The longest time for which an opening waits until a reader, or a process that is starting, has
/// released the store.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

/// The time by which the promise of the manifest may lag behind the records during a run. A promise
/// that is too low is harmless, and raising it costs twice as much as making a group of records
/// durable (measured: 8 ms and 4 ms).
const LAG: Duration = Duration::from_millis(500);

/// The directory of the sled database within the store.
pub(crate) const RECORDS: &str = "records";

/// Takes the lock. It waits for a reader to finish but not for another writer.
pub(crate) fn lock_for_writing(
    directory: &Path,
    address: Option<String>,
) -> Result<Lock, OpenError> {
    let io =
        |source| OpenError::Io { action: "lock the store", path: directory.to_owned(), source };
    let start = Instant::now();
    loop {
        match Lock::acquire(directory).map_err(io)? {
            Acquired::Lock(mut lock) => {
                lock.sign(&Holder::this_process(address)).map_err(io)?;
                return Ok(lock);
            }
            // An unsigned lock was taken this moment, and a lock without an address is held by a
            // reader.
            Acquired::Held(holder)
                if holder.as_ref().is_some_and(|h| h.address.is_some())
                    || start.elapsed() > PATIENCE =>
            {
                return Err(held_error(directory, holder));
            }
            Acquired::Held(_) => thread::sleep(Duration::from_millis(5)),
        }
    }
}

pub(crate) fn held_error(directory: &Path, holder: Option<Holder>) -> OpenError {
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
    pub(crate) database: Database,
    /// The keys of all records, so that counting them and looking one up cost nothing. A key is
    /// here once its record is durable.
    index: RwLock<BTreeSet<JobKey>>,
    /// The manifest as it is on the disk. It is locked during every change of the store, so changes
    /// happen one at a time.
    manifest: Mutex<Manifest>,
    /// The time at which a commit last raised the promise of the manifest.
    raised: Mutex<Option<Instant>>,
    // The lock is dropped last.
    _lock: Lock,
}

impl Core {
    /// Opens the store in an existing directory whose lock is held.
    pub(crate) fn open(directory: &Path, lock: Lock) -> Result<Core, OpenError> {
        let io =
            |action| move |source| OpenError::Io { action, path: directory.to_owned(), source };
        let damaged = |what: String| OpenError::Damaged { directory: directory.to_owned(), what };
        if let Some(kind) =
            volume::network_file_system(directory).map_err(io("examine the file system of"))?
        {
            return Err(OpenError::NetworkFileSystem { directory: directory.to_owned(), kind });
        }
        durable::clear_unfinished(directory).map_err(io("clear"))?;
        let manifest = read_or_create_manifest(directory)?;
        let records = directory.join(RECORDS);
        if manifest.records > 0 && !records.join("db").is_file() {
            return Err(damaged(format!(
                "it promises {} records and has no database",
                manifest.records
            )));
        }
        // sled enlarges and rewrites its files when it opens them.
        WriteError::require_space(directory, 0)?;
        durable::create_directory(&records).map_err(io("create the database in"))?;
        let failed = |fault| match fault {
            Fault::Io(source) => {
                OpenError::Io { action: "open the database of", path: directory.to_owned(), source }
            }
            Fault::Damaged(what) => {
                damaged(format!("the database of records cannot be opened: {what}"))
            }
        };
        let database = Database::open(&records).map_err(failed)?;
        let index = read_index(&database).map_err(damaged)?;
        let found = index.len() as u64;
        if found < manifest.records {
            let promised = manifest.records;
            return Err(damaged(format!(
                "it promises {promised} records and only {found} can be found"
            )));
        }
        let core = Core {
            directory: directory.to_owned(),
            blobs: Blobs::of(directory),
            database,
            index: RwLock::new(index),
            manifest: Mutex::new(manifest),
            raised: Mutex::new(None),
            _lock: lock,
        };
        core.database.sync().map_err(failed)?;
        core.database.sync_files().map_err(io("make durable the database of"))?;
        let mut manifest = core.manifest();
        if found > manifest.records {
            // A kill came between a commit and its manifest. The records are durable now and are
            // promised from here on.
            core.promise(&mut manifest, found)?;
        }
        drop(manifest);
        Ok(core)
    }

    pub(crate) fn index(&self) -> std::sync::RwLockReadGuard<'_, BTreeSet<JobKey>> {
        self.index.read().unwrap_or_else(PoisonError::into_inner)
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

    fn promise(&self, manifest: &mut Manifest, records: u64) -> Result<(), WriteError> {
        let next = Manifest::new(records, manifest.studies.clone());
        self.replace(manifest, next)
    }

    pub(crate) fn contains(&self, key: &JobKey) -> bool {
        self.index().contains(key)
    }

    pub(crate) fn keys(&self) -> Vec<JobKey> {
        self.index().iter().copied().collect()
    }

    pub(crate) fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        if !self.contains(key) {
            return Ok(None);
        }
        let Some(sealed) = self.database.get(key)? else {
            if !self.contains(key) {
                return Ok(None); // The record was removed this moment.
            }
            return Err(ReadError::Corrupt {
                key: *key,
                reason: "the database has lost it".to_owned(),
            });
        };
        match record::unseal(key, &sealed) {
            Ok(payload) => Ok(Some(payload.to_vec())),
            Err(Unsealable::Version(found)) => Err(ReadError::Version { key: *key, found }),
            Err(Unsealable::Corrupt(reason)) => {
                Err(ReadError::Corrupt { key: *key, reason: reason.to_owned() })
            }
        }
    }

    pub(crate) fn records(&self) -> impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)> {
        self.keys().into_iter().filter_map(|key| Some((key, self.get(&key).transpose()?)))
    }

    fn writable(&self, bytes: u64) -> Result<(), WriteError> {
        if let Some(earlier) = self.database.broken() {
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
        self.writable(records.iter().map(|(_, record)| record.as_ref().len() as u64).sum())?;
        self.database.insert(
            records.iter().map(|(key, record)| (key, record::seal(key, record.as_ref()))),
        )?;
        self.database.sync()?;
        let found = {
            let mut index = self.index.write().unwrap_or_else(PoisonError::into_inner);
            index.extend(records.iter().map(|(key, _)| *key));
            index.len() as u64
        };
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        if found <= manifest.records || raised.is_some_and(|last| last.elapsed() < LAG) {
            return Ok(());
        }
        self.promise(&mut manifest, found)?;
        *raised = Some(Instant::now());
        Ok(())
    }

    pub(crate) fn remove(&self, keys: &[JobKey]) -> Result<usize, WriteError> {
        let mut manifest = self.manifest();
        let present: BTreeSet<JobKey> =
            keys.iter().copied().filter(|key| self.contains(key)).collect();
        if present.is_empty() {
            return Ok(0);
        }
        self.writable(0)?;
        // The promise is lowered first, so that a kill between the two does not look like a loss.
        let left = (self.index().len() - present.len()) as u64;
        self.promise(&mut manifest, left)?;
        self.index
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .retain(|key| !present.contains(key));
        self.database.remove(present.iter())?;
        self.database.sync()?;
        Ok(present.len())
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        let found = self.index().len() as u64;
        let mut manifest = self.manifest();
        if found > manifest.records {
            // A failure does no harm, because the next opening counts again.
            let _ = self.promise(&mut manifest, found);
        }
    }
}

fn read_or_create_manifest(directory: &Path) -> Result<Manifest, OpenError> {
    let damaged = |what: String| OpenError::Damaged { directory: directory.to_owned(), what };
    let io = |action| {
        move |source| OpenError::Io { action, path: directory.join(manifest::FILE), source }
    };
    match Manifest::read(directory) {
        Ok(manifest) => Ok(manifest),
        Err(Unreadable::Format(found)) => {
            Err(OpenError::Format { directory: directory.to_owned(), found })
        }
        Err(Unreadable::Damaged(what)) => {
            Err(damaged(format!("its manifest.json cannot be read: {what}")))
        }
        Err(Unreadable::Io(source)) => Err(io("read")(source)),
        Err(Unreadable::Absent) if directory.join(RECORDS).exists() => {
            Err(damaged("its manifest.json is missing".to_owned()))
        }
        Err(Unreadable::Absent) if !is_vacant(directory).map_err(io("look for"))? => {
            Err(OpenError::NotAStore { directory: directory.to_owned() })
        }
        Err(Unreadable::Absent) => {
            // The manifest is written before the database, so a database without a manifest means
            // that the manifest was lost.
            let manifest = Manifest::new(0, BTreeMap::new());
            manifest.write(directory).map_err(io("write"))?;
            Ok(manifest)
        }
    }
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

/// Reads the keys in the database, or returns what is wrong with it.
fn read_index(database: &Database) -> Result<BTreeSet<JobKey>, String> {
    let mut index = BTreeSet::new();
    let mut foreign = 0;
    let visited = database.visit(|key, _| match key.try_into() {
        Ok(key) => drop(index.insert(JobKey(key))),
        Err(_) => foreign += 1,
    });
    match visited {
        Err(fault) => Err(format!(
            "the database of records cannot be read: {fault} ({} records were found)",
            index.len()
        )),
        Ok(()) if foreign > 0 => {
            Err(format!("the database holds {foreign} entries whose keys are not of 32 bytes"))
        }
        Ok(()) => Ok(index),
    }
}
