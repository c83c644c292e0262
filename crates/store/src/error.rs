//! The errors of the store, one enum for each operation: opening, reading and writing.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use identity::{JobKey, STORED_LIMIT};

use crate::access::{self, Wanted};
use crate::database::{Fault, LOG, RECORDS};
use crate::digest::Digest;
use crate::frame::EXPORT_FORMAT;
use crate::manifest::FORMAT;
use crate::record::Unsealable;
use crate::volume::{self, Space};

/// The reason why a store cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Another process has the store open, or this process already does.
    #[error(
        "the store {} is in use by process {pid} ({command}), for {}",
        .directory.display(), words(*.held_for)
    )]
    Held {
        /// The directory of the store.
        directory: PathBuf,
        /// The process that has it open.
        pid: u32,
        /// The command line of that process.
        command: String,
        /// The time for which it has had the store open.
        held_for: Duration,
    },
    /// Another process has the store open and did not say who it is.
    #[error(
        "the store {} is in use by another process, which cannot be seen from here; it may run in \
         another container",
        .directory.display()
    )]
    HeldByUnknown {
        /// The directory of the store.
        directory: PathBuf,
    },
    /// The store changed whenever it was copied for reading.
    #[error(
        "the store {} is being written to without a pause, and no whole copy of its records could \
         be taken to read from: {last}; try again in a moment, or on the side of the process that \
         writes",
        .directory.display()
    )]
    Changing {
        /// The directory of the store.
        directory: PathBuf,
        /// The fault of the last copy in words.
        last: String,
    },
    /// Reading takes a private copy of the records, and there is no room for one.
    #[error(
        "the records of the store {} are read from a private copy of {} MiB, for which there is no \
         room: {tried}; let TMPDIR name a directory with room",
        .directory.display(), bytes.div_ceil(1 << 20)
    )]
    NoRoom {
        /// The directory of the store.
        directory: PathBuf,
        /// The size of the copy \[bytes\].
        bytes: u64,
        /// The places that were tried, each with its reason.
        tried: String,
    },
    /// There is no store to read.
    #[error("there is no store in {}", .directory.display())]
    Missing {
        /// The directory without a store.
        directory: PathBuf,
    },
    /// The directory holds other files.
    #[error(
        "{} is not a store: it has no manifest.json and is not empty; name an empty or a new \
         directory",
        .directory.display()
    )]
    NotAStore {
        /// The directory.
        directory: PathBuf,
    },
    /// Locks and durability do not hold on a network file system.
    #[error(
        "the store {} would be on {kind}, a network file system, where it could be lost; name \
         a directory on a local disk",
        .directory.display()
    )]
    NetworkFileSystem {
        /// The directory of the store.
        directory: PathBuf,
        /// The kind of file system.
        kind: &'static str,
    },
    /// A later version of this program wrote the store.
    #[error(
        "the store {} has format {found}, this program writes format {FORMAT}; use the version \
         that wrote it",
        .directory.display()
    )]
    Format {
        /// The directory of the store.
        directory: PathBuf,
        /// The format of the store.
        found: u64,
    },
    /// A file that is named like an export is none.
    #[error(
        "{} is not an export: {reason}; `tribosweep store export` and `run --export` write them",
        .path.display()
    )]
    NotAnExport {
        /// The path of the file.
        path: PathBuf,
        /// The reason in words.
        reason: String,
    },
    /// A later version of this program wrote the export.
    #[error(
        "the export {} has format {found}, this program reads format {EXPORT_FORMAT}; use the \
         version that wrote it",
        .path.display()
    )]
    ExportFormat {
        /// The path of the export.
        path: PathBuf,
        /// The format of the export.
        found: u16,
    },
    /// Exports are only read.
    #[error(
        "{} holds exports, which are only read; bring them into a store with `tribosweep store \
         merge`",
        .path.display()
    )]
    OnlyRead {
        /// The directory or the file.
        path: PathBuf,
    },
    /// The store does not hold what it promised. [`Store::salvage`](crate::Store::salvage) saves
    /// what can be read.
    #[error(
        "the store {} is damaged: {what}; put back a copy, or salvage it: what is lost will be \
         computed again",
        .directory.display()
    )]
    Damaged {
        /// The directory of the store.
        directory: PathBuf,
        /// The damage in words.
        what: String,
    },
    /// This user may not do that.
    #[error("cannot {action} {}: {why}", .path.display())]
    Refused {
        /// The attempted action.
        action: &'static str,
        /// The path of the action.
        path: PathBuf,
        /// The reason in words.
        why: String,
    },
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// The attempted action.
        action: &'static str,
        /// The path of the action.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The store was opened and then could not be written to.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// The reason why something cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The record differs from what was written. Its job is computed again once it is removed.
    #[error(
        "the record of job {key} is corrupt: {reason}; remove it and the job will be computed again"
    )]
    Corrupt {
        /// The job of the record.
        key: JobKey,
        /// The damage in words.
        reason: String,
    },
    /// The record in an export differs from what was written.
    #[error("the record of job {key} in {} is damaged: {reason}", .path.display())]
    InExport {
        /// The job of the record.
        key: JobKey,
        /// The export.
        path: PathBuf,
        /// The damage in words.
        reason: String,
    },
    /// Two exports have different results of one job.
    #[error(
        "{} and {} have different results of job {key}: one of the machines that computed it is \
         not to be trusted; compute it again and put aside the export that is wrong",
        .first.display(), .second.display()
    )]
    Conflict {
        /// The job.
        key: JobKey,
        /// An export with a result.
        first: PathBuf,
        /// An export with another result.
        second: PathBuf,
    },
    /// Two exports have studies of one name that differ.
    #[error(
        "{} and {} have different studies called {name:?}; keep them in directories of their own",
        .first.display(), .second.display()
    )]
    StudiesDiffer {
        /// The name of the studies.
        name: String,
        /// An export with the study.
        first: PathBuf,
        /// An export with the other study.
        second: PathBuf,
    },
    /// A later version of this program wrote the record.
    #[error("the record of job {key} has version {found}, which this program does not know")]
    Version {
        /// The job of the record.
        key: JobKey,
        /// The version of the record.
        found: u8,
    },
    /// The blob differs from what was written. Storing its content again heals it.
    #[error("the blob {digest} ({}) is corrupt: {reason}", .path.display())]
    Blob {
        /// The name of the blob.
        digest: Digest,
        /// The file of the blob.
        path: PathBuf,
        /// The damage in words.
        reason: String,
    },
    /// The fields that a record keeps itself differ from what was written.
    #[error("the fields in a record are corrupt: {reason}")]
    Inside {
        /// The damage in words.
        reason: String,
    },
    /// The definition of a study has disappeared.
    #[error("the definition of study {name:?} is missing: there is no blob {digest}")]
    StudyMissing {
        /// The name of the study.
        name: String,
        /// The blob that held its definition.
        digest: Digest,
    },
    /// The manifest cannot be read.
    #[error("the manifest {} cannot be read: {reason}", .path.display())]
    Manifest {
        /// The file of the manifest.
        path: PathBuf,
        /// The reason in words.
        reason: String,
    },
    /// The database failed.
    #[error("the database of records failed: {0}")]
    Database(String),
    /// The process that had the store open is gone, and the store cannot be opened anew.
    #[error("the process that had the store open stopped answering: {0}")]
    Gone(Box<OpenError>),
    /// The process that has the store open is gone, or its answers make no sense.
    #[error("process {pid}, which has the store open, stopped answering: {source}")]
    Unanswered {
        /// The process.
        pid: u32,
        /// The error of the unanswered request.
        source: io::Error,
    },
    /// The operating system refused.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// The path that was read.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// The record of a job, which may have none, or the fault of this record.
pub(crate) type Answer = Result<Option<Vec<u8>>, ReadError>;

/// The reason why something cannot be written. Everything acknowledged before stays.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// A record is larger than [`STORED_LIMIT`]. Nothing of the group was written.
    #[error(
        "the record of job {key} has {bytes} bytes, and a record may have {STORED_LIMIT}: put \
         fields into blobs and their digests into the record"
    )]
    TooLarge {
        /// The job of the record.
        key: JobKey,
        /// The size of the record \[bytes\].
        bytes: usize,
    },
    /// The disk is full, or so nearly full that writing is not risked. Nothing was written, and the
    /// write may be tried again.
    #[error(
        "the disk of {} is full: {} MiB are free and {} MiB are needed; make room and resume, \
         nothing that was done is lost",
        .path.display(), .free >> 20, needed.div_ceil(1 << 20)
    )]
    DiskFull {
        /// The path that was to be written.
        path: PathBuf,
        /// The free space \[bytes\].
        free: u64,
        /// The space that must be free before writing is risked \[bytes\].
        needed: u64,
    },
    /// The files of the store may not grow as they must. Nothing was written, and the write may be
    /// tried again.
    #[error(
        "a file in {} may have {} MiB and needs {} MiB: raise the limit with `ulimit -f` and resume, \
         nothing that was done is lost",
        .path.display(), .largest >> 20, needed.div_ceil(1 << 20)
    )]
    FileLimit {
        /// The path that was to be written.
        path: PathBuf,
        /// The largest size that a file may have \[bytes\].
        largest: u64,
        /// The size that must be allowed before writing is risked \[bytes\].
        needed: u64,
    },
    /// Writing failed half-way, now or earlier. The group was not acknowledged, and nothing more is
    /// written before the store is opened again.
    #[error(
        "writing to the database of records failed: {0}; nothing that was done is lost, open \
         the store again to go on"
    )]
    Database(String),
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// The attempted action.
        action: &'static str,
        /// The path of the action.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

impl OpenError {
    /// Returns the error of an action on `path` that the system has refused.
    pub(crate) fn io(action: &'static str, wanted: Wanted, path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        match access::refusal(&path, wanted, &source) {
            Some(why) => OpenError::Refused { action, path, why },
            None => OpenError::Io { action, path, source },
        }
    }
}

impl Unsealable {
    /// Returns the error about the record of a job that does not open.
    pub(crate) fn of_job(self, key: &JobKey) -> ReadError {
        match self {
            Unsealable::Version(found) => ReadError::Version { key: *key, found },
            Unsealable::Corrupt(reason) => {
                ReadError::Corrupt { key: *key, reason: reason.to_owned() }
            }
        }
    }
}

impl From<Fault> for ReadError {
    fn from(fault: Fault) -> Self {
        ReadError::Database(fault.to_string())
    }
}

impl From<Fault> for WriteError {
    fn from(fault: Fault) -> Self {
        WriteError::Database(fault.to_string())
    }
}

impl WriteError {
    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        WriteError::Io { action, path: path.to_owned(), source }
    }

    pub(crate) fn require_space(directory: &Path, bytes: u64) -> Result<(), WriteError> {
        match volume::space(directory, &directory.join(RECORDS).join(LOG), bytes) {
            Ok(Space::Enough) => Ok(()),
            Ok(Space::Short { free, needed }) => {
                Err(WriteError::DiskFull { path: directory.to_owned(), free, needed })
            }
            Ok(Space::Limited { largest, needed }) => {
                Err(WriteError::FileLimit { path: directory.to_owned(), largest, needed })
            }
            Err(source) => Err(WriteError::io("find the free space of", directory, source)),
        }
    }
}

/// Writes a duration for a person, as in "12 s", "3 min" or "5 h".
fn words(duration: Duration) -> String {
    match duration.as_secs() {
        s @ 0..120 => format!("{s} s"),
        s @ 120..7200 => format!("{} min", s / 60),
        s @ 7200..172_800 => format!("{} h", s / 3600),
        s => format!("{} days", s / 86_400),
    }
}
