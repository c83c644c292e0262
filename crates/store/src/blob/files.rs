//! This file knows where blobs lie in the directory of a store.

use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use crate::digest::Digest;
use crate::durable;
use crate::error::ReadError;

/// A file under `blobs/`.
pub(crate) enum BlobFile {
    Blob {
        digest: Digest,
        path: PathBuf,
        bytes: u64,
    },
    /// A file that a killed writer has left or that is being written now.
    Unfinished {
        path: PathBuf,
        bytes: u64,
    },
    /// A file that does not belong to the store.
    Stray(PathBuf),
}

/// The file of a blob in a store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredBlob {
    /// The name of the blob.
    pub digest: Digest,
    /// The size of the file \[bytes\].
    pub bytes: u64,
    /// The time of the last change, if it is known.
    pub changed: Option<SystemTime>,
}

impl BlobFile {
    /// Returns the file as one of a blob, if it is one.
    pub(super) fn stored(&self) -> Option<StoredBlob> {
        let BlobFile::Blob { digest, path, bytes } = self else { return None };
        let changed = fs::metadata(path).and_then(|file| file.modified()).ok();
        Some(StoredBlob { digest: *digest, bytes: *bytes, changed })
    }
}

/// Returns the path of a blob in the directory of all blobs.
pub(super) fn path_in(directory: &Path, digest: &Digest) -> PathBuf {
    let name = digest.to_string();
    directory.join(&name[..2]).join(format!("{}.zst", &name[2..]))
}

/// Lists every file below the directory of all blobs in the order of the names.
pub(super) fn files_in(directory: &Path) -> Result<Vec<BlobFile>, ReadError> {
    let mut found = Vec::new();
    for shelf in entries(directory)? {
        if !shelf.is_dir() {
            found.push(BlobFile::Stray(shelf));
            continue;
        }
        for path in entries(&shelf)? {
            let bytes = fs::metadata(&path).map(|file| file.len()).unwrap_or(0);
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let prefix = shelf.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let digest =
                name.strip_suffix(".zst").and_then(|rest| format!("{prefix}{rest}").parse().ok());
            found.push(match digest {
                Some(digest) if path_in(directory, &digest) == path => {
                    BlobFile::Blob { digest, path, bytes }
                }
                _ if name.starts_with(durable::UNFINISHED_PREFIX) => {
                    BlobFile::Unfinished { path, bytes }
                }
                _ => BlobFile::Stray(path),
            });
        }
    }
    Ok(found)
}

/// Lists the paths in `directory` in sorted order. A missing directory has none.
fn entries(directory: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let failed = |source| ReadError::Io { path: directory.to_owned(), source };
    let listing = match fs::read_dir(directory) {
        Ok(listing) => listing,
        // What stands in its place is put aside when the next blob is written.
        Err(error)
            if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) =>
        {
            return Ok(Vec::new());
        }
        Err(source) => return Err(failed(source)),
    };
    let mut paths = listing
        .map(|entry| entry.map(|e| e.path()))
        .collect::<io::Result<Vec<_>>>()
        .map_err(failed)?;
    paths.sort();
    Ok(paths)
}
