//! The marks of the files of a database, by which a change is noticed without reading them.

use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::access::{self, Wanted};
use crate::database::{self, LARGE, RECORDS};
use crate::error::OpenError;

/// The age from which on a file is known to have changed if it changes again: the clock of a file
/// system moves in steps of a few milliseconds.
pub(crate) const SETTLED: Duration = Duration::from_millis(20);

/// The marks that changes leave on the files of a database.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Traces {
    pub(crate) files: Vec<Trace>,
    /// True if every change of a file from now on will show in these marks.
    pub(crate) tell_changes: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Trace {
    /// The path of the file below the directory of the database.
    pub(crate) name: PathBuf,
    inode: u64,
    bytes: u64,
    /// The time of the last change, since 1970-01-01 UTC.
    changed: Duration,
}

impl Traces {
    /// Returns the marks of the database of the store in `directory`.
    pub(crate) fn of(directory: &Path) -> Result<Self, OpenError> {
        let path = directory.join(RECORDS);
        let refused = |source| OpenError::io("read", Wanted::Read, &path, source);
        let mut files = Vec::new();
        let names = match database::own_files(&path) {
            Ok(names) => names.into_iter().map(PathBuf::from).collect(),
            // The manifest is older than the database.
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) if access::is_damage(&error) => Vec::new(),
            Err(error) => return Err(refused(error)),
        };
        let mut large = match fs::read_dir(path.join(LARGE)) {
            Ok(entries) => entries
                .map(|entry| entry.map(|entry| Path::new(LARGE).join(entry.file_name())))
                .collect::<io::Result<Vec<_>>>()
                .map_err(refused)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) if access::is_damage(&error) => Vec::new(),
            Err(error) => return Err(refused(error)),
        };
        large.sort();
        let mut newest = Duration::ZERO;
        for name in names.into_iter().chain(large) {
            // A file that has disappeared is missing from the next list too.
            let Ok(found) = fs::metadata(path.join(&name)) else { continue };
            let seconds = found.mtime().max(0).cast_unsigned();
            let nanoseconds = u32::try_from(found.mtime_nsec()).unwrap_or(0);
            let changed = Duration::new(seconds, nanoseconds);
            newest = newest.max(changed);
            files.push(Trace { name, inode: found.ino(), bytes: found.len(), changed });
        }
        // A time in the future differs from that of any change now.
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let tell_changes = now.abs_diff(newest) > SETTLED;
        Ok(Traces { files, tell_changes })
    }

    /// Returns the traces as soon as they would tell of changes, or those of a store that is being
    /// written to.
    pub(crate) fn settled(directory: &Path) -> Result<Self, OpenError> {
        let traces = Self::of(directory)?;
        if traces.tell_changes {
            return Ok(traces);
        }
        thread::sleep(SETTLED + SETTLED / 2);
        Self::of(directory)
    }

    /// Returns whether nothing has changed between two looks at the files.
    pub(crate) fn is_same(&self, other: &Traces) -> bool {
        self.files == other.files
    }

    /// Returns the size of all files together \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        self.files.iter().fold(0, |sum, file| sum.saturating_add(file.bytes))
    }
}
