//! The marks that changes leave on files: whoever sees the same marks again need not read again.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// The marks of the last change of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FileMark {
    path: PathBuf,
    device: u64,
    inode: u64,
    bytes: u64,
    /// The time of the last change, in seconds and nanoseconds since 1970-01-01 UTC.
    changed: [i64; 2],
}

impl FileMark {
    /// Reads the marks of some files. One that cannot be seen has those of nothing.
    pub(crate) fn of(paths: &[PathBuf]) -> Vec<FileMark> {
        paths.iter().map(|path| Self::of_file(path)).collect()
    }

    fn of_file(path: &Path) -> FileMark {
        let path = path.to_owned();
        match fs::metadata(&path) {
            Ok(found) => FileMark {
                path,
                device: found.dev(),
                inode: found.ino(),
                bytes: found.len(),
                changed: [found.mtime(), found.mtime_nsec()],
            },
            Err(_) => FileMark { path, device: 0, inode: 0, bytes: 0, changed: [0; 2] },
        }
    }
}
