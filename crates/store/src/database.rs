//! This is the only file that names sled, and it puts a fence around it.
//!
//! sled 0.34 reports some damage by a panic, and after a failed write nothing that it says is
//! reliable. So every call goes through [`fenced`], and the first failed write ends all writing
//! until the store is opened again.

use std::any::Any;
use std::cell::Cell;
use std::fs::File;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Once, OnceLock, PoisonError};
use std::time::{Duration, Instant};
use std::{fs, io, thread};

use identity::JobKey;

use crate::access;
use crate::durable;

/// The size of sled's cache \[bytes\]. Records are small and read once, and sled's default of 1 GiB
/// would be the largest part of a coordinator.
const CACHE_BYTES: u64 = 8 << 20;

/// The longest time for which an opening waits until sled has released its own lock, which a
/// background thread does some time after closing.
const CLOSING: Duration = Duration::from_secs(10);

/// The number of threads that sled starts for its writes. It waits for ever if it gets none.
const THREADS: usize = 7;

/// A failure inside sled.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The operating system refused.
    Io(io::Error),
    /// The database found its file inconsistent, or it panicked.
    Damaged(String),
}

impl Fault {
    /// Returns the fault with the words that it befell the opening, if it is damage.
    pub(crate) fn of_opening(self) -> Self {
        match self.is_damage() {
            true => Fault::Damaged(format!("the database of records cannot be opened: {self}")),
            false => self,
        }
    }

    /// Returns true if the fault is about the bytes on the disk. Every other fault may be gone at
    /// the next attempt.
    pub(crate) fn is_damage(&self) -> bool {
        match self {
            Fault::Damaged(_) => true,
            // sled has its own words for a lock.
            Fault::Io(error) if error.kind() == io::ErrorKind::Other => !is_locked(error),
            Fault::Io(error) => access::is_damage(error),
        }
    }
}

/// Returns true if sled says that its own lock is held.
fn is_locked(error: &io::Error) -> bool {
    error.to_string().contains("could not acquire lock")
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::Io(error) => error.fmt(f),
            Fault::Damaged(what) => what.fmt(f),
        }
    }
}

impl From<sled::Error> for Fault {
    fn from(error: sled::Error) -> Self {
        match error {
            sled::Error::Io(error) => Fault::Io(error),
            sled::Error::Corruption { .. } => {
                Fault::Damaged("the database reports corruption".to_owned())
            }
            other => Fault::Damaged(other.to_string()),
        }
    }
}

thread_local! {
    static FENCED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `call` and turns a panic into a [`Fault`]. Nothing is printed: the error tells the user
/// what it means.
fn fenced<T>(call: impl FnOnce() -> Result<T, sled::Error>) -> Result<T, Fault> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            let of_sled = thread::current().name().is_some_and(|name| name.starts_with("sled-io-"));
            if !FENCED.get() && !of_sled {
                previous(panic);
            }
        }));
    });
    let outer = FENCED.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(call));
    FENCED.set(outer);
    match outcome {
        Ok(result) => result.map_err(Fault::from),
        Err(payload) => {
            Err(Fault::Damaged(format!("the database gave up: {}", message(payload.as_ref()))))
        }
    }
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| payload.downcast_ref::<&str>().copied());
    text.unwrap_or("no reason given")
}

/// Lists the names of sled's files in `directory`: its configuration, its snapshots and its log, in
/// this order. The log is the last because it goes on where a snapshot ends.
pub(crate) fn own_files(directory: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        // A snapshot that was never finished has another ending.
        let digits = name.strip_prefix("snap.").unwrap_or_default();
        let is_snapshot = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        if is_snapshot || name == "conf" || name == LOG {
            names.push(name);
        }
    }
    names.sort_by_key(|name| (name == LOG, name.clone()));
    Ok(names)
}

/// Removes the database in `directory` and the directory, which stays if it holds anything else.
/// Something else in its place is removed too.
pub(crate) fn remove(directory: &Path) -> io::Result<()> {
    if !durable::is_real_directory(directory) {
        return durable::clear_away(directory);
    }
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        // A snapshot that was never finished begins like others.
        if name.starts_with("snap.") || ["conf", LOG, LARGE].contains(&&*name) {
            durable::clear_away(&directory.join(&name))?;
        }
    }
    fs::remove_dir(directory)
}

/// Gives what sled has made in `directory` as root to the owner of the directory.
fn hand_over(directory: &Path) -> io::Result<()> {
    for name in own_files(directory)?.iter().map(String::as_str).chain([LARGE]) {
        access::hand_over(&directory.join(name))?;
    }
    Ok(())
}

/// Starts as many threads at once as sled will, to find out whether the system allows it. They end
/// before sled starts its own, which it keeps for the rest of the process.
fn require_threads() -> io::Result<()> {
    static ALLOWED: OnceLock<()> = OnceLock::new();
    if ALLOWED.get().is_some() {
        return Ok(());
    }
    // Every thread waits until this one lets go of the lock.
    let gate = Arc::new(Mutex::new(()));
    let closed = gate.lock().unwrap_or_else(PoisonError::into_inner);
    let started: Vec<_> = (0..THREADS)
        .map(|_| {
            let gate = gate.clone();
            thread::Builder::new().spawn(move || drop(gate.lock()))
        })
        .collect();
    drop(closed);
    let mut refused = None;
    for thread in started {
        match thread {
            Ok(thread) => drop(thread.join()),
            Err(error) => refused = Some(error),
        }
    }
    match refused {
        None => {
            let _ = ALLOWED.set(()); // Another thread may have found out the same.
            Ok(())
        }
        Some(error) => Err(io::Error::new(
            io::ErrorKind::ResourceBusy,
            format!(
                "the database needs {THREADS} threads, and the system refuses them (see `ulimit \
                 -u`): {error}"
            ),
        )),
    }
}

/// Refuses links and whatever else is of another kind than sled makes it: sled follows links and
/// writes to what it opens.
fn require_own_kinds(directory: &Path) -> Result<(), Fault> {
    let mut names = own_files(directory).map_err(Fault::Io)?;
    names.push(LARGE.to_owned());
    for name in names {
        let kind = match fs::symlink_metadata(directory.join(&name)) {
            Ok(found) => found.file_type(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(Fault::Io(error)),
        };
        if kind.is_symlink() {
            let reason = format!(
                "{name} is a symbolic link, which is not followed; put what it leads to there, or \
                 let `tribosweep store salvage` do without it"
            );
            return Err(Fault::Io(io::Error::new(io::ErrorKind::InvalidInput, reason)));
        }
        let is_as_made = if name == LARGE { kind.is_dir() } else { kind.is_file() };
        if !is_as_made {
            return Err(Fault::Damaged(format!("its {name} is of another kind")));
        }
    }
    Ok(())
}

/// Removes the snapshots that a killed process was writing. sled would take them for finished ones,
/// and they only repeat the log.
fn remove_unfinished_snapshots(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name();
        let text = name.to_string_lossy();
        if text.starts_with("snap.") && text.ends_with(".generating") {
            fs::remove_file(directory.join(&name))?;
        }
    }
    Ok(())
}

/// The directory of the database within the store.
pub(crate) const RECORDS: &str = "records";

/// The name of sled's log.
pub(crate) const LOG: &str = "db";

/// The name of the directory in which sled keeps what is too large for its log.
pub(crate) const LARGE: &str = "blobs";

/// Asks some more times for what was just read or written. sled looks for nodes to put away only
/// after 64 requests to one of 256 groups of them, so that otherwise 16 384 nodes of up to 16
/// records stay in memory, whatever the size of its cache.
fn put_away(sled: &sled::Db, key: &[u8], times: usize) -> sled::Result<()> {
    (0..times).try_for_each(|_| sled.contains_key(key).map(drop))
}

/// Visits entries until the visitor returns false.
fn visit_each(
    sled: &sled::Db,
    entries: impl Iterator<Item = sled::Result<(sled::IVec, sled::IVec)>>,
    mut entry: impl FnMut(&[u8], &[u8]) -> bool,
) -> sled::Result<()> {
    for item in entries {
        let (key, value) = item?;
        if !entry(&key, &value) {
            break;
        }
        put_away(sled, &key, 1)?;
    }
    Ok(())
}

pub(crate) struct Database {
    /// The handle of sled, which is `None` only during the drop.
    sled: Option<sled::Db>,
    /// The log of sled, opened once more for an fsync that sled does not offer.
    log: File,
    directory: PathBuf,
    /// The message of the first failed write.
    broken: OnceLock<String>,
}

impl Database {
    /// Opens the database in `directory` and creates it if it is absent.
    pub(crate) fn open(directory: &Path) -> Result<Self, Fault> {
        require_threads().map_err(Fault::Io)?;
        remove_unfinished_snapshots(directory).map_err(Fault::Io)?;
        require_own_kinds(directory)?;
        // There is no background flusher: every commit flushes, and closing waits for ever for a
        // flusher that panicked. The garbage that it would collect was measured: 100 000 records of
        // 1 KiB take the same 190 MB with and without it.
        let config =
            sled::Config::new().path(directory).cache_capacity(CACHE_BYTES).flush_every_ms(None);
        let start = Instant::now();
        let sled = loop {
            match fenced(|| config.open()) {
                Err(Fault::Io(error)) if is_locked(&error) => {
                    if start.elapsed() > CLOSING {
                        return Err(Fault::Io(error));
                    }
                    thread::sleep(Duration::from_millis(5));
                }
                other => break other?,
            }
        };
        let log =
            File::options().read(true).write(true).open(directory.join(LOG)).map_err(Fault::Io)?;
        hand_over(directory).map_err(Fault::Io)?;
        Ok(Database {
            sled: Some(sled),
            log,
            directory: directory.to_owned(),
            broken: OnceLock::new(),
        })
    }

    fn fenced<T>(
        &self,
        call: impl FnOnce(&sled::Db) -> Result<T, sled::Error>,
    ) -> Result<T, Fault> {
        match &self.sled {
            Some(sled) => fenced(|| call(sled)),
            None => Err(Fault::Damaged("the database is closed".to_owned())),
        }
    }

    /// Returns the reason why nothing can be written any more, if there is one.
    pub(crate) fn broken(&self) -> Option<&str> {
        self.broken.get().map(String::as_str)
    }

    fn writing<T>(&self, result: Result<T, Fault>) -> Result<T, Fault> {
        if let Err(fault) = &result {
            let _ = self.broken.set(fault.to_string()); // The first cause stands.
        }
        result
    }

    /// Visits every entry in the order of the keys and stops at the first fault.
    pub(crate) fn visit(&self, mut entry: impl FnMut(&[u8], &[u8])) -> Result<(), Fault> {
        self.visit_while(|key, value| {
            entry(key, value);
            true
        })
    }

    /// Visits the entries in the order of the keys until the visitor returns false, or up to the
    /// first fault.
    pub(crate) fn visit_while(&self, entry: impl FnMut(&[u8], &[u8]) -> bool) -> Result<(), Fault> {
        self.fenced(|sled| visit_each(sled, sled.iter(), entry))
    }

    /// Visits the entries from the last key to the first like [`visit_while`](Self::visit_while).
    pub(crate) fn visit_backwards(
        &self,
        entry: impl FnMut(&[u8], &[u8]) -> bool,
    ) -> Result<(), Fault> {
        self.fenced(|sled| visit_each(sled, sled.iter().rev(), entry))
    }

    pub(crate) fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, Fault> {
        self.fenced(|sled| {
            let value = sled.get(key.0)?.map(|value| value.to_vec());
            put_away(sled, &key.0, 3)?;
            Ok(value)
        })
    }

    pub(crate) fn insert(
        &self,
        entries: impl Iterator<Item = (JobKey, Vec<u8>)>,
    ) -> Result<(), Fault> {
        self.writing(self.fenced(|sled| {
            for (key, value) in entries {
                sled.insert(key.0, value)?;
                put_away(sled, &key.0, 3)?;
            }
            Ok(())
        }))
    }

    pub(crate) fn remove<'a>(&self, keys: impl Iterator<Item = &'a JobKey>) -> Result<(), Fault> {
        self.writing(self.fenced(|sled| {
            for key in keys {
                sled.remove(key.0)?;
            }
            Ok(())
        }))
    }

    /// Returns as soon as everything written so far would survive a power failure.
    pub(crate) fn sync(&self) -> Result<(), Fault> {
        // sled writes with sync_file_range, which waits for the pages but leaves out the disk's
        // cache and the length of the file.
        self.writing(self.fenced(|sled| sled.flush().map(drop)))?;
        self.writing(self.log.sync_all().map_err(Fault::Io))
    }

    /// Makes the files themselves durable after the database was created or sled has rotated its
    /// snapshot.
    pub(crate) fn sync_files(&self) -> io::Result<()> {
        File::open(self.directory.join("conf"))?.sync_all()?;
        crate::durable::sync_directory(&self.directory)
    }
}

impl Drop for Database {
    fn drop(&mut self) {
        let sled = self.sled.take();
        // Everything acknowledged is durable already, so nothing that sled still writes or reports
        // matters.
        let _ = fenced(|| {
            drop(sled);
            Ok(())
        });
        let _ = hand_over(&self.directory); // The next opening does it where this one could not.
    }
}
