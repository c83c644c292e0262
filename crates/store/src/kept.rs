//! Kept words: what was learnt of a study's records, so that it need not be learnt again.
//!
//! The words are never trusted over the records. They stand in one file beside the database, with
//! the marks of the database's files, and count only as long as these are the same. Whoever opens
//! the store for writing takes the file away first, and the end of the process, after the database
//! was closed, writes it anew with the words that still hold. So a kill at any moment leaves no
//! file, or one whose marks are not those of the database.
//!
//! ```text
//! bytes 0..18   "tribosweep kept 1\n"
//! bytes 18..50  BLAKE3 of the rest
//! bytes 50..    bincode: the marks, and the words of each study
//! ```

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use bincode::config::standard;
use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};

use crate::access::{open_to_read, read_within};
use crate::database::{LOG, RECORDS};
use crate::digest::Digest;
use crate::durable;
use crate::traces::Traces;

/// The name of the file in the directory of a store.
pub(crate) const FILE: &str = "kept";

const MAGIC: &[u8] = b"tribosweep kept 1\n";

/// The largest file that is read \[bytes\].
const LIMIT: u64 = 64 << 20;

/// The most words that are kept of one study \[bytes\].
const MOST_WORDS: usize = 1 << 20;

/// The longest time that the end of the database is waited for.
const CLOSING: Duration = Duration::from_secs(2);

/// The words about a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptWords {
    /// The words, which only their writer understands.
    pub words: Vec<u8>,
    /// The words hold whatever records come beside those that there are.
    pub is_final: bool,
}

/// The words about studies by their names.
type AllWords = BTreeMap<String, KeptWords>;

/// Returns the words that hold for the store in `directory` as it is now; none if any process has
/// changed it since they were written, or may be changing it.
pub(crate) fn read(directory: &Path) -> AllWords {
    let Ok(bytes) = read_within(&directory.join(FILE), LIMIT) else { return AllWords::new() };
    match (decode(&bytes), Traces::of(directory)) {
        (Some((marks, words)), Ok(now)) if now.is_same(&marks) => words,
        _ => AllWords::new(),
    }
}

fn decode(bytes: &[u8]) -> Option<(Traces, AllWords)> {
    let (sum, body) = bytes.strip_prefix(MAGIC)?.split_first_chunk::<32>()?;
    if Digest::of(body).0 != *sum {
        return None;
    }
    let (read, length) = bincode::serde::decode_from_slice(body, standard()).ok()?;
    (length == body.len()).then_some(read)
}

/// The words of a store that is open for writing. When this is dropped, after the database was
/// closed, they are written.
pub(crate) struct OpenWords {
    directory: PathBuf,
    words: Mutex<AllWords>,
    /// The store was opened, so that its records are as they were.
    is_open: AtomicBool,
}

impl OpenWords {
    /// Takes the words that hold, before the database is opened, and their file away.
    ///
    /// # Errors
    /// The file cannot be removed.
    pub(crate) fn take(directory: &Path) -> io::Result<OpenWords> {
        let words = Mutex::new(read(directory));
        remove(directory)?;
        Ok(OpenWords { directory: directory.to_owned(), words, is_open: AtomicBool::new(false) })
    }

    /// Notes that the store was opened and has all its records. What was known of one that cannot
    /// be opened is forgotten.
    pub(crate) fn opened(&self) {
        self.is_open.store(true, Ordering::Relaxed);
    }

    fn words(&self) -> MutexGuard<'_, AllWords> {
        self.words.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps words about a study, unless there are too many.
    pub(crate) fn set(&self, study: &str, words: KeptWords) {
        let mut all = self.words();
        match words.words.len() <= MOST_WORDS {
            true => drop(all.insert(study.to_owned(), words)),
            false => drop(all.remove(study)),
        }
    }

    /// Forgets what records that come may make wrong.
    pub(crate) fn records_come(&self) {
        self.words().retain(|_, words| words.is_final);
    }

    /// Forgets everything, since records change or go.
    pub(crate) fn forget(&self) {
        self.words().clear();
    }

    fn write(&self) -> io::Result<()> {
        let words = self.words();
        if words.is_empty() || !self.is_open.load(Ordering::Relaxed) {
            return Ok(());
        }
        wait_for_end(&self.directory);
        let Ok(marks) = Traces::of(&self.directory) else { return Ok(()) };
        let body = bincode::serde::encode_to_vec((&marks, &*words), standard())
            .map_err(io::Error::other)?;
        let bytes = [MAGIC, &Digest::of(&body).0, &body].concat();
        durable::write(&self.directory.join(FILE), &bytes)
    }
}

impl Drop for OpenWords {
    fn drop(&mut self) {
        // What is not written is learnt again.
        let _ = self.write();
    }
}

/// Waits until the database, which was closed, lets go of its files: a background thread does so.
fn wait_for_end(directory: &Path) {
    let start = Instant::now();
    let is_held = || -> io::Result<bool> {
        let log: File = open_to_read(&directory.join(RECORDS).join(LOG))?;
        match flock(&log, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(false),
            Err(rustix::io::Errno::WOULDBLOCK) => Ok(true),
            Err(error) => Err(error.into()),
        }
    };
    while start.elapsed() < CLOSING && is_held().unwrap_or(false) {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Removes the words from the store in `directory`, whose lock is held. A directory in their place
/// holds none and stays.
pub(crate) fn remove(directory: &Path) -> io::Result<()> {
    use io::ErrorKind::{IsADirectory, NotFound};
    match fs::remove_file(directory.join(FILE)) {
        Err(error) if !matches!(error.kind(), NotFound | IsADirectory) => Err(error),
        _ => Ok(()),
    }
}
