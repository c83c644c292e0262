//! This file opens the store for reading only, also while another process has it open.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::{fmt, fs};

use identity::JobKey;

use crate::access::{self, Wanted};
use crate::blob::Blobs;
use crate::connection::Connection;
use crate::database::RECORDS;
use crate::digest::Digest;
use crate::error::{Answer, OpenError, ReadError};
use crate::exports::{ExportSet, ExportSummary, ShardState, exports_at};
use crate::lock::{self, Holder};
use crate::manifest::{self, Manifest, StudyLabels, Unreadable};
use crate::mark::FileMark;
use crate::parts;
use crate::replica::Replica;
use crate::rules::MergeRules;
use crate::serve::first_records;
use crate::table::TableBuilder;
use crate::wire::{KEYS_PER_REQUEST, ReadRequest, ReadResponse};

/// The number of processes that may end one after the other while one question is asked.
const ENDINGS: usize = 5;

/// The size of the records that are read of exports at once \[bytes\].
const EXPORTS_AT_ONCE: usize = 32 << 20;

/// The origin of the records of a [`StoreReader`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordOrigin {
    /// The records come from the files as they were when the reader was opened.
    Disk,
    /// The records come from exports.
    Exports {
        /// The number of exports.
        count: usize,
    },
    /// The records come from a store, in whose directory lie exports that are not read.
    BesideExports {
        /// The origin of the records in the store.
        store: Box<RecordOrigin>,
        /// The number of exports.
        count: usize,
    },
    /// The records come from the files, and it cannot be ruled out that there are more.
    Copy(CopyReason),
    /// The records come from the process that has the store open.
    Process {
        /// The id of the process.
        pid: u32,
        /// The command line of the process.
        command: String,
    },
}

/// The reason why a reader took a copy although a process may be writing the store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CopyReason {
    /// A process has the store open and cannot be asked from here.
    Unreachable {
        /// The id of the process.
        pid: u32,
        /// The command line of the process.
        command: String,
    },
    /// The store belongs to another user, whose processes do not answer.
    Foreign {
        /// The name of that user.
        owner: String,
    },
    /// This user may not write to the store.
    ReadOnly,
}

impl fmt::Display for RecordOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self {
            RecordOrigin::Disk => return f.write_str("read from disk"),
            RecordOrigin::Exports { count } => {
                let noun = if *count == 1 { "export" } else { "exports" };
                return write!(f, "read from {count} {noun}");
            }
            RecordOrigin::BesideExports { store, count } => {
                let (noun, verb) = if *count == 1 { ("export", "is") } else { ("exports", "are") };
                return write!(
                    f,
                    "{store}; {count} {noun} in the same directory {verb} not read: name one of them, or \
                     bring them into the store with `tribosweep store merge`"
                );
            }
            RecordOrigin::Process { pid, command } => {
                return write!(f, "served by the running process {pid} ({command})");
            }
            RecordOrigin::Copy(reason) => reason,
        };
        f.write_str("read from a private copy of the records: ")?;
        match reason {
            CopyReason::Unreachable { pid, command } => write!(
                f,
                "process {pid} ({command}) is writing the store and does not answer here, so \
                 results of the last moments may be missing"
            ),
            CopyReason::Foreign { owner } => write!(
                f,
                "the store belongs to {owner}; if a run is adding to it, results of the last \
                 moments may be missing"
            ),
            CopyReason::ReadOnly => f.write_str("this user may not write to the store"),
        }
    }
}

enum Backing {
    Disk { replica: Box<Replica>, origin: RecordOrigin },
    Process(Connection),
    Exports(Arc<ExportSet>),
}

impl Backing {
    /// Asks the process that has the store open, or else copies the records.
    fn of(directory: &Path) -> Result<Self, OpenError> {
        let mut writer = None;
        if let Some(holder) = lock::last_holder(directory) {
            if holder.answers
                && let Ok(connection) = Connection::open(&holder)
            {
                return Ok(Backing::Process(connection));
            }
            // The words may be those of a dead process.
            writer = lock::is_held(directory).then_some(holder);
        }
        let replica = Box::new(Replica::take(directory)?);
        let origin = match writer {
            Some(Holder { pid, command, .. }) => {
                RecordOrigin::Copy(CopyReason::Unreachable { pid, command })
            }
            None => origin_of_idle(directory),
        };
        Ok(Backing::Disk { replica, origin })
    }
}

/// Returns the origin of what is read of a store that no process holds as far as this user knows.
fn origin_of_idle(directory: &Path) -> RecordOrigin {
    // A group may write to a store whose lock only its owner may look at.
    if let Some(owner) = lock::hidden_owner(directory) {
        return RecordOrigin::Copy(CopyReason::Foreign { owner });
    }
    if access::is_writable(directory) {
        return RecordOrigin::Disk;
    }
    RecordOrigin::Copy(match access::other_owner(directory) {
        Some(owner) => CopyReason::Foreign { owner },
        None => CopyReason::ReadOnly,
    })
}

/// A store that is only read. It shows durable records, and ever more of them while a run is
/// writing. When the process that answers ends, it goes on from disk.
pub struct StoreReader {
    directory: PathBuf,
    /// The number of exports in the directory of a store, which are not read.
    exports_beside: usize,
    /// The marks of the exports when they were opened.
    export_marks: Vec<FileMark>,
    blobs: Blobs,
    source: Mutex<Arc<Backing>>,
}

/// Returns true if there is a store in `directory`, whatever its state.
pub(crate) fn is_there(directory: &Path) -> Result<bool, OpenError> {
    for name in [manifest::FILE, RECORDS] {
        let path = directory.join(name);
        match fs::symlink_metadata(&path) {
            Ok(_) => return Ok(true),
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
                ) => {}
            Err(error) => return Err(OpenError::io("look for", Wanted::Read, &path, error)),
        }
    }
    Ok(false)
}

/// Returns the marks of the exports at a path.
fn export_marks(path: &Path) -> Vec<FileMark> {
    exports_at(path).ok().flatten().map_or_else(Vec::new, |paths| FileMark::of(&paths))
}

impl StoreReader {
    pub(crate) fn open(
        directory: &Path,
        rules: Option<&MergeRules>,
    ) -> Result<StoreReader, OpenError> {
        if !is_there(directory)? {
            let export_marks = export_marks(directory);
            if let Some(exports) = ExportSet::open(directory, rules)? {
                return Ok(StoreReader {
                    directory: directory.to_owned(),
                    exports_beside: 0,
                    export_marks,
                    blobs: Blobs::in_exports(exports.clone()),
                    source: Mutex::new(Arc::new(Backing::Exports(exports))),
                });
            }
            return Err(OpenError::Missing { directory: directory.to_owned() });
        }
        Ok(StoreReader {
            directory: directory.to_owned(),
            exports_beside: exports_at(directory)?.map_or(0, |paths| paths.len()),
            export_marks: Vec::new(),
            blobs: Blobs::of(directory),
            source: Mutex::new(Arc::new(Backing::of(directory)?)),
        })
    }

    fn source(&self) -> Arc<Backing> {
        self.source.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Answers `question` and, if the process that should answer has ended, asks anew where the
    /// records are now.
    fn answered<T>(
        &self,
        question: impl Fn(&Backing) -> Result<T, ReadError>,
    ) -> Result<T, ReadError> {
        let mut endings = 0;
        loop {
            let source = self.source();
            match question(&source) {
                Err(ReadError::Unanswered { .. }) if endings < ENDINGS => endings += 1,
                answer => return answer,
            }
            let mut current = self.source.lock().unwrap_or_else(PoisonError::into_inner);
            // Another thread may have asked already.
            if Arc::ptr_eq(&current, &source) {
                let anew = Backing::of(&self.directory);
                *current = Arc::new(anew.map_err(|error| ReadError::Gone(Box::new(error)))?);
            }
        }
    }

    /// Returns true if no record can have come since the reader was opened that it does not show. A
    /// process that has the store open answers with what there is; files are compared by their
    /// marks, which takes 0.2 ms. Studies and files of fields are always read anew.
    pub fn is_current(&self) -> bool {
        match &*self.source() {
            Backing::Process(_) => true,
            Backing::Disk { replica, .. } => replica.is_current(&self.directory),
            Backing::Exports(_) => {
                is_there(&self.directory).is_ok_and(|is_store| !is_store)
                    && export_marks(&self.directory) == self.export_marks
            }
        }
    }

    /// Returns the origin of the records.
    pub fn origin(&self) -> RecordOrigin {
        let origin = match &*self.source() {
            Backing::Disk { origin, .. } => origin.clone(),
            Backing::Exports(exports) => {
                let readable = exports.files.iter().filter(|file| file.summary.is_readable);
                RecordOrigin::Exports { count: readable.count() }
            }
            Backing::Process(connection) => RecordOrigin::Process {
                pid: connection.holder.pid,
                command: connection.holder.command.clone(),
            },
        };
        match self.exports_beside {
            0 => origin,
            count => RecordOrigin::BesideExports { store: Box::new(origin), count },
        }
    }

    /// Returns the keys of all records in ascending order.
    ///
    /// # Errors
    /// [`ReadError::Unanswered`] or [`ReadError::Gone`] if neither a process that has the store
    /// open answers nor the store can be read from disk.
    pub fn keys(&self) -> Result<Vec<JobKey>, ReadError> {
        self.answered(|source| match source {
            Backing::Disk { replica, .. } => replica.records.keys(),
            Backing::Exports(exports) => exports.keys(),
            Backing::Process(connection) => {
                let mut keys: Vec<JobKey> = Vec::new();
                loop {
                    let last = keys.last().copied();
                    match ask(connection, &ReadRequest::Keys(last.map(|key| key.0)))? {
                        ReadResponse::Keys(more) if more.is_empty() => return Ok(keys),
                        // Without this condition the exchange could go on for ever.
                        ReadResponse::Keys(more) if more.first().map(|key| JobKey(*key)) > last => {
                            keys.extend(more.into_iter().map(JobKey))
                        }
                        _ => return Err(nonsense(connection)),
                    }
                }
            }
        })
    }

    /// Returns for each job whether it has a record.
    ///
    /// # Errors
    /// Those of [`StoreReader::keys`].
    pub fn contains(&self, keys: &[JobKey]) -> Result<Vec<bool>, ReadError> {
        self.answered(|source| {
            let connection = match source {
                Backing::Disk { replica, .. } => {
                    return keys.iter().map(|key| replica.records.contains(key)).collect();
                }
                Backing::Exports(exports) => return exports.contains(keys),
                Backing::Process(connection) => connection,
            };
            let mut all = Vec::with_capacity(keys.len());
            for batch in keys.chunks(KEYS_PER_REQUEST) {
                let request = ReadRequest::Contains(batch.iter().map(|key| key.0).collect());
                match ask(connection, &request)? {
                    ReadResponse::Contains(some) if some.len() == batch.len() => all.extend(some),
                    _ => return Err(nonsense(connection)),
                }
            }
            Ok(all)
        })
    }

    /// Returns the verified record of a job, or `None` if it has none.
    ///
    /// # Errors
    /// Those of [`Store::get`](crate::Store::get) and of [`StoreReader::keys`].
    pub fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        self.first(std::slice::from_ref(key))?.pop().unwrap_or(Ok(None))
    }

    /// Iterates over all records and their keys in the order of the keys. A corrupt record does not
    /// hide the others.
    ///
    /// # Errors
    /// Those of [`StoreReader::keys`].
    pub fn records(
        &self,
    ) -> Result<impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)>, ReadError> {
        Ok(self.select(self.keys()?))
    }

    /// Iterates over the records of `keys` in the given order. Keys without a record are left out.
    /// The iterator ends with an error if no record can be had any more.
    pub fn select(
        &self,
        keys: Vec<JobKey>,
    ) -> impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)> {
        // The number of keys is small because the caller may stop early. In exports the records of
        // neighbouring keys are far apart, and each frame is read once for all that are asked for.
        const KEYS_AT_ONCE: usize = 256;
        const KEYS_OF_EXPORTS: usize = 65_536;
        let keys_at_once = match &*self.source() {
            Backing::Exports(_) => KEYS_OF_EXPORTS,
            Backing::Disk { .. } | Backing::Process(_) => KEYS_AT_ONCE,
        };
        let mut next = 0;
        let replies = std::iter::from_fn(move || {
            let batch = &keys[next..keys.len().min(next + keys_at_once)];
            let first = *batch.first()?;
            let records = match self.first(batch) {
                Ok(records) => records,
                Err(error) => {
                    next = keys.len();
                    return Some(vec![(first, Err(error))]);
                }
            };
            next += records.len();
            let found = batch
                .iter()
                .copied()
                .zip(records)
                .filter_map(|(key, record)| Some((key, record.transpose()?)));
            Some(found.collect::<Vec<_>>())
        });
        replies.flatten()
    }

    /// Returns one answer for each of the first of `keys`, as many as fit into a response. If there
    /// is a key, there is at least one answer.
    fn first(&self, keys: &[JobKey]) -> Result<Vec<Answer>, ReadError> {
        self.answered(|source| {
            let connection = match source {
                Backing::Disk { replica, .. } => {
                    return Ok(first_records(keys, |key| replica.records.get(key)));
                }
                Backing::Exports(exports) => return exports.first(keys, EXPORTS_AT_ONCE),
                Backing::Process(connection) => connection,
            };
            match ask(connection, &ReadRequest::Get(keys.iter().map(|key| key.0).collect()))? {
                ReadResponse::Get(records)
                    if records.len() <= keys.len() && records.is_empty() == keys.is_empty() =>
                {
                    let found = keys.iter().zip(records);
                    Ok(found.map(|(key, record)| record.into_result(key)).collect())
                }
                _ => Err(nonsense(connection)),
            }
        })
    }

    /// Begins a table of a study with so many columns, beside the records that this reader shows;
    /// `None` where none can be kept: the records come from a process or from exports, or the store
    /// was being changed, is somebody else's or has no room.
    pub fn table_builder(&self, columns: usize) -> Option<TableBuilder> {
        // Root may write anywhere.
        let is_own = || access::other_owner(&self.directory).is_none();
        match &*self.source() {
            Backing::Disk { replica, origin: RecordOrigin::Disk }
                if self.exports_beside == 0 && is_own() =>
            {
                TableBuilder::new(&self.directory, columns, replica.marks()?.clone()).ok()
            }
            _ => None,
        }
    }

    /// Returns the exports that are read, in the order of their names. A store has none.
    pub fn exports(&self) -> Vec<ExportSummary> {
        self.export_set().map_or_else(Vec::new, |exports| {
            exports.files.iter().map(|file| file.summary.clone()).collect()
        })
    }

    /// Lists the shards whose results are here, with their last notes. One that is in several files
    /// is listed for each.
    pub fn shards(&self) -> Vec<ShardState> {
        match self.export_set() {
            Some(set) => set.files.iter().flat_map(|file| file.summary.shards()).collect(),
            None => parts::read(&self.directory),
        }
    }

    /// Returns the exports that are read, if it is exports.
    pub(crate) fn export_set(&self) -> Option<Arc<ExportSet>> {
        match &*self.source() {
            Backing::Exports(exports) => Some(exports.clone()),
            Backing::Disk { .. } | Backing::Process(_) => None,
        }
    }

    /// Returns the path that was opened.
    pub(crate) fn path(&self) -> &Path {
        &self.directory
    }

    /// Returns the blobs, which are plain files or parts of exports.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Returns the definition of a study, or `None` if there is no study of that name.
    ///
    /// # Errors
    /// [`ReadError::Manifest`], [`ReadError::StudyMissing`], [`ReadError::Blob`] or
    /// [`ReadError::Io`] if the definition cannot be read, [`ReadError::StudiesDiffer`] if exports
    /// disagree.
    pub fn study(&self, name: &str) -> Result<Option<Vec<u8>>, ReadError> {
        let digest = self.studies()?.get(name).copied();
        digest.map(|digest| self.blobs.definition(name, &digest)).transpose()
    }

    /// Returns the names of all studies in alphabetical order.
    ///
    /// # Errors
    /// [`ReadError::Manifest`] or [`ReadError::Io`] if the manifest cannot be read,
    /// [`ReadError::StudiesDiffer`] if exports disagree.
    pub fn study_names(&self) -> Result<Vec<String>, ReadError> {
        Ok(self.studies()?.into_keys().collect())
    }

    /// Returns the labels of every study that has some. Exports keep none.
    ///
    /// # Errors
    /// [`ReadError::Manifest`] or [`ReadError::Io`] if the manifest cannot be read.
    pub fn labels(&self) -> Result<BTreeMap<String, StudyLabels>, ReadError> {
        match self.export_set() {
            Some(_) => Ok(BTreeMap::new()),
            None => Ok(self.manifest()?.labels),
        }
    }

    /// Returns the names of all studies with the blobs that hold their definitions.
    ///
    /// # Errors
    /// Those of [`StoreReader::study_names`].
    pub fn studies(&self) -> Result<BTreeMap<String, Digest>, ReadError> {
        match self.export_set() {
            Some(exports) => exports.studies(|digest| self.blobs.get(digest).ok().flatten()),
            None => Ok(self.manifest()?.studies),
        }
    }

    fn manifest(&self) -> Result<Manifest, ReadError> {
        let path = self.directory.join(manifest::FILE);
        Manifest::read(&self.directory).map_err(|unreadable| match unreadable {
            Unreadable::Io(source) => ReadError::Io { path, source },
            Unreadable::Absent => ReadError::Manifest { path, reason: "it is missing".to_owned() },
            Unreadable::Format(found) => {
                ReadError::Manifest { path, reason: format!("its format is {found}") }
            }
            Unreadable::Damaged(reason) => ReadError::Manifest { path, reason },
        })
    }
}

fn ask(connection: &Connection, request: &ReadRequest) -> Result<ReadResponse, ReadError> {
    connection
        .ask(request)
        .map_err(|source| ReadError::Unanswered { pid: connection.holder.pid, source })
}

fn nonsense(connection: &Connection) -> ReadError {
    let source = io::Error::new(io::ErrorKind::InvalidData, "it did not answer the question");
    ReadError::Unanswered { pid: connection.holder.pid, source }
}
