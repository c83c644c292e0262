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

/// The name of the list of tables in the directory of a store.
pub(crate) const TABLES: &str = "tables/list";

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
pub(crate) type AllWords = BTreeMap<String, KeptWords>;

/// Returns the words in a file that hold for the store in `directory` as it is now; none if any
/// process has changed it since they were written, or may be changing it.
pub(crate) fn read(directory: &Path, file: &str) -> AllWords {
    let Ok(bytes) = read_within(&directory.join(file), LIMIT) else { return AllWords::new() };
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

/// Writes words to a file of the store in `directory`, with the marks that the database had when
/// they were right.
pub(crate) fn write(
    directory: &Path,
    file: &str,
    marks: &Traces,
    words: &AllWords,
) -> io::Result<()> {
    let body =
        bincode::serde::encode_to_vec((marks, words), standard()).map_err(io::Error::other)?;
    let bytes = [MAGIC, &Digest::of(&body).0, &body].concat();
    durable::write(&directory.join(file), &bytes)
}

/// The words of a store that is open for writing. When this is dropped, after the database was
/// closed, they are written.
pub(crate) struct OpenWords {
    directory: PathBuf,
    words: Mutex<AllWords>,
    /// The words about tables.
    tables: Mutex<AllWords>,
    /// The store was opened, so that its records are as they were.
    is_open: AtomicBool,
}

impl OpenWords {
    /// Takes the words that hold, before the database is opened, and their files away.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub(crate) fn take(directory: &Path) -> io::Result<OpenWords> {
        let words = OpenWords {
            directory: directory.to_owned(),
            words: Mutex::new(read(directory, FILE)),
            tables: Mutex::new(read(directory, TABLES)),
            is_open: AtomicBool::new(false),
        };
        remove(directory)?;
        Ok(words)
    }

    /// Notes that the store was opened and has all its records. What was known of one that cannot
    /// be opened is forgotten.
    pub(crate) fn opened(&self) {
        self.is_open.store(true, Ordering::Relaxed);
    }

    /// Returns the words of both files, those about tables last.
    fn both(&self) -> [MutexGuard<'_, AllWords>; 2] {
        [&self.words, &self.tables].map(lock)
    }

    /// Keeps words about a study, unless there are too many.
    pub(crate) fn set(&self, study: &str, words: KeptWords) {
        let mut all = lock(&self.words);
        match words.words.len() <= MOST_WORDS {
            true => drop(all.insert(study.to_owned(), words)),
            false => drop(all.remove(study)),
        }
    }

    /// Forgets what records that come may make wrong.
    pub(crate) fn records_come(&self) {
        self.both().iter_mut().for_each(|all| all.retain(|_, words| words.is_final));
    }

    /// Forgets everything, since records change or go.
    pub(crate) fn forget(&self) {
        self.both().iter_mut().for_each(|all| all.clear());
    }

    fn write(&self) -> io::Result<()> {
        let [words, tables] = self.both();
        if !self.is_open.load(Ordering::Relaxed) || words.is_empty() && tables.is_empty() {
            return Ok(());
        }
        wait_for_end(&self.directory);
        let Ok(marks) = Traces::of(&self.directory) else { return Ok(()) };
        for (file, words) in [(FILE, words), (TABLES, tables)] {
            if !words.is_empty() {
                write(&self.directory, file, &marks, &words)?;
            }
        }
        Ok(())
    }
}

impl Drop for OpenWords {
    fn drop(&mut self) {
        // What is not written is learnt again.
        let _ = self.write();
    }
}

fn lock(all: &Mutex<AllWords>) -> MutexGuard<'_, AllWords> {
    all.lock().unwrap_or_else(PoisonError::into_inner)
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
/// holds none and stays, and so does a file in the place of their folder.
pub(crate) fn remove(directory: &Path) -> io::Result<()> {
    use io::ErrorKind::{IsADirectory, NotADirectory, NotFound};
    for file in [FILE, TABLES] {
        match fs::remove_file(directory.join(file)) {
            Err(error) if !matches!(error.kind(), NotFound | IsADirectory | NotADirectory) => {
                return Err(error);
            }
            _ => {}
        }
    }
    Ok(())
}
