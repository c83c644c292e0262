//! What can go wrong, one enum per operation: opening, reading, writing.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use identity::{JobKey, STORED_LIMIT};

use crate::database::Fault;
use crate::digest::Digest;
use crate::manifest::FORMAT;
use crate::volume::{self, Space};

/// Why a store cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Another process has it, or this process already does.
    #[error("the store {} is in use by process {pid} ({command}), for {}", .directory.display(), words(*.held_for))]
    Held {
        /// The store.
        directory: PathBuf,
        /// The process that has it.
        pid: u32,
        /// Its command line.
        command: String,
        /// For how long it has had it.
        held_for: Duration,
    },
    /// Another process has it and did not say who it is.
    #[error("the store {} is in use by another process", .directory.display())]
    HeldByUnknown {
        /// The store.
        directory: PathBuf,
    },
    /// Its holder should answer readers and does not.
    #[error("the store {} is in use by process {pid} ({command}), which does not answer: {source}", .directory.display())]
    Unanswered {
        /// The store.
        directory: PathBuf,
        /// The process that has it.
        pid: u32,
        /// Its command line.
        command: String,
        /// What happened to the question.
        source: io::Error,
    },
    /// There is nothing to read.
    #[error("there is no store in {}", .directory.display())]
    Missing {
        /// Where one was looked for.
        directory: PathBuf,
    },
    /// The directory holds other things.
    #[error("{} is not a store: it has no manifest.json and is not empty; name an empty or a new directory", .directory.display())]
    NotAStore {
        /// The directory.
        directory: PathBuf,
    },
    /// Locks and durability do not hold there.
    #[error("the store {} would be on {kind}, a network file system, where it could be lost; name a directory on a local disk", .directory.display())]
    NetworkFileSystem {
        /// The store.
        directory: PathBuf,
        /// The kind of file system.
        kind: &'static str,
    },
    /// Written by a later version of this program.
    #[error("the store {} has format {found}, this program writes format {FORMAT}; use the version that wrote it", .directory.display())]
    Format {
        /// The store.
        directory: PathBuf,
        /// The format that was found.
        found: u64,
    },
    /// It does not hold what it promised. [`Store::salvage`](crate::Store::salvage) saves what can
    /// be read.
    #[error("the store {} is damaged: {what}; put back a copy, or salvage it: what is lost will be computed again", .directory.display())]
    Damaged {
        /// The store.
        directory: PathBuf,
        /// What was found.
        what: String,
    },
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// On what.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// The store was opened, and then could not be written to.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Why something cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The record is not what was written. Remove it and its job is computed again.
    #[error(
        "the record of job {key} is corrupt: {reason}; remove it and the job will be computed again"
    )]
    Corrupt {
        /// The job.
        key: JobKey,
        /// What is wrong with it.
        reason: String,
    },
    /// The record was written by a later version of this program.
    #[error("the record of job {key} has version {found}, which this program does not know")]
    Version {
        /// The job.
        key: JobKey,
        /// The version that was found.
        found: u8,
    },
    /// The blob is not what was written. Storing its content again heals it.
    #[error("the blob {digest} ({}) is corrupt: {reason}", .path.display())]
    Blob {
        /// Its name.
        digest: Digest,
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// What a record keeps itself is not what was written.
    #[error("the fields in a record are corrupt: {reason}")]
    Inside {
        /// What is wrong with them.
        reason: String,
    },
    /// The definition of a study has disappeared.
    #[error("the definition of study {name:?} is missing: there is no blob {digest}")]
    StudyMissing {
        /// The study.
        name: String,
        /// The blob that held its definition.
        digest: Digest,
    },
    /// The manifest cannot be read.
    #[error("the manifest {} cannot be read: {reason}", .path.display())]
    Manifest {
        /// Its file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The database failed.
    #[error("the database of records failed: {0}")]
    Database(String),
    /// The process that was asked is gone, or answers nonsense.
    #[error("process {pid}, which has the store open, stopped answering: {source}")]
    Unanswered {
        /// The process.
        pid: u32,
        /// What happened to the question.
        source: io::Error,
    },
    /// The operating system refused.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// What was read.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
}

/// Why something cannot be written. What was acknowledged before stays.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// A record is larger than [`STORED_LIMIT`]. Nothing of the group was written.
    #[error(
        "the record of job {key} has {bytes} bytes, and a record may have {STORED_LIMIT}: put fields into blobs and their digests into the record"
    )]
    TooLarge {
        /// The job.
        key: JobKey,
        /// The size of its record.
        bytes: usize,
    },
    /// The disk is full, or so nearly that it is not risked. Nothing was written; it may be tried
    /// again.
    #[error("the disk of {} is full: {} MiB are free and {} MiB are needed; make room and resume, nothing that was done is lost", .path.display(), .free >> 20, needed.div_ceil(1 << 20))]
    DiskFull {
        /// What was to be written.
        path: PathBuf,
        /// What is free, in bytes.
        free: u64,
        /// What is needed before writing is risked, in bytes.
        needed: u64,
    },
    /// Writing failed half-way, now or earlier. The group was not acknowledged; nothing more is
    /// written before the store is opened again.
    #[error(
        "writing to the database of records failed: {0}; nothing that was done is lost, open the store again to go on"
    )]
    Database(String),
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// On what.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
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
        match volume::space(directory, bytes) {
            Ok(Space::Enough) => Ok(()),
            Ok(Space::Short { free, needed }) => {
                Err(WriteError::DiskFull { path: directory.to_owned(), free, needed })
            }
            Err(source) => Err(WriteError::io("find the free space of", directory, source)),
        }
    }
}

/// "12 s", "3 min", "5 h": what a person wants to know of a duration.
fn words(duration: Duration) -> String {
    match duration.as_secs() {
        s @ 0..120 => format!("{s} s"),
        s @ 120..7200 => format!("{} min", s / 60),
        s @ 7200..172_800 => format!("{} h", s / 3600),
        s => format!("{} days", s / 86_400),
    }
}
