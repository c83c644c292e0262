//! This file says why an export cannot be written.

use std::io;
use std::path::{Path, PathBuf};

use identity::{JobKey, STORED_LIMIT};

use crate::access::Wanted;
use crate::error::{OpenError, ReadError};
use crate::exports::EXTENSION;

/// The reason why an export cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The name of an export has an ending of its own.
    #[error(
        "an export is one file, whose name ends in .{EXTENSION}, and {} does not; `tribosweep store \
         merge STORE --into DIRECTORY` copies a store whole",
        .path.display()
    )]
    Name {
        /// The path that was named.
        path: PathBuf,
    },
    /// The file is the export of something else.
    #[error("{} holds {found}, and {wanted} was to be written there; name another file", .path.display())]
    OtherShard {
        /// The path of the file.
        path: PathBuf,
        /// The content of the file in words.
        found: String,
        /// The content that was to be written, in words.
        wanted: String,
    },
    /// There is another definition of the study in the file.
    #[error(
        "{} holds another study called {name:?}; name another file, or rename one of the studies",
        .path.display()
    )]
    StudyDiffers {
        /// The path of the file.
        path: PathBuf,
        /// The name of the study.
        name: String,
    },
    /// The words about a file are too long, or they cannot be.
    #[error("{} cannot be written: {reason}", .path.display())]
    Impossible {
        /// The path of the file.
        path: PathBuf,
        /// The reason in words.
        reason: String,
    },
    /// A record is larger than [`STORED_LIMIT`].
    #[error("the record of job {key} has {bytes} bytes, and a record may have {STORED_LIMIT}")]
    TooLarge {
        /// The job of the record.
        key: JobKey,
        /// The size of the record \[bytes\].
        bytes: usize,
    },
    /// Another process goes on with the file, and this one writes to one without a name.
    #[error(
        "another process has gone on with {}; what it does not find there it computes again",
        .path.display()
    )]
    TakenOver {
        /// The path of the file.
        path: PathBuf,
    },
    /// Another process has put a file there since this one read it.
    #[error(
        "another process has written {} meanwhile, and nothing was merged into it; merge again",
        .path.display()
    )]
    Changed {
        /// The path of the file.
        path: PathBuf,
    },
    /// The disk is full. What was flushed before is there.
    #[error(
        "there is no room for {}: {source}; make room and run the same again, nothing that was done \
         is lost",
        .path.display()
    )]
    Full {
        /// The path of the file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// There is something else in the place of the file.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A blob cannot be read.
    #[error(transparent)]
    Blob(#[from] ReadError),
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

impl ExportError {
    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        match source.kind() {
            io::ErrorKind::StorageFull
            | io::ErrorKind::QuotaExceeded
            | io::ErrorKind::FileTooLarge => ExportError::Full { path, source },
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                ExportError::Open(OpenError::io(action, Wanted::Write, &path, source))
            }
            _ => ExportError::Io { action, path, source },
        }
    }
}
