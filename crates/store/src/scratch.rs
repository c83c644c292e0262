//! A directory for a private copy, which is removed however its process ends.

use std::fs::{self, File, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, OFlags, flock, statvfs};
use rustix::process::geteuid;
use tempfile::TempDir;

use crate::volume::RESERVE;

/// The beginning of the name of every such directory.
const PREFIX: &str = "tribosweep-read-";

/// The largest copy that is kept in shared memory if there is another place \[bytes\].
const MEMORY_LIMIT: u64 = 64 << 20;

/// The file system in memory.
const MEMORY: &str = "/dev/shm";

/// A directory that only this user may enter. It is locked while its process lives, and the next
/// process that needs such a directory removes those that nobody locks.
pub(crate) struct ScratchDirectory {
    directory: TempDir,
    _lock: File,
}

/// The reason why there is no room for a copy.
#[derive(Debug)]
pub(crate) struct ScratchError {
    /// The size of the copy \[bytes\].
    pub(crate) bytes: u64,
    /// The places that were tried, each with its reason.
    pub(crate) tried: String,
}

impl ScratchDirectory {
    /// Creates a directory where there is room for `bytes`.
    pub(crate) fn new(bytes: u64) -> Result<Self, ScratchError> {
        let mut tried = Vec::new();
        for place in places(bytes) {
            match Self::new_in(&place, bytes) {
                Ok(scratch) => return Ok(scratch),
                Err(error) => tried.push(format!("{} ({error})", place.display())),
            }
        }
        Err(ScratchError { bytes, tried: tried.join(", ") })
    }

    fn new_in(place: &Path, bytes: u64) -> io::Result<Self> {
        let free = free(place)?;
        // sled does not survive a full disk.
        if free < bytes.saturating_add(RESERVE) {
            return Err(io::Error::new(
                io::ErrorKind::StorageFull,
                format!("{} MiB are free", free >> 20),
            ));
        }
        remove_abandoned(place);
        loop {
            let directory = tempfile::Builder::new()
                .prefix(PREFIX)
                .permissions(Permissions::from_mode(0o700))
                .tempdir_in(place)?;
            // Another process may have taken it for an abandoned one before it was locked.
            match lock(directory.path())? {
                Some(lock) if directory.path().is_dir() => {
                    return Ok(ScratchDirectory { directory, _lock: lock });
                }
                _ => {}
            }
        }
    }

    pub(crate) fn path(&self) -> &Path {
        self.directory.path()
    }
}

/// Lists the places for a copy of `bytes`, the best first. A small one is in memory, where nothing
/// waits for a disk.
fn places(bytes: u64) -> Vec<PathBuf> {
    let memory = PathBuf::from(MEMORY);
    let is_small = bytes <= MEMORY_LIMIT && free(&memory).is_ok_and(|free| bytes <= free / 4);
    let mut places = Vec::new();
    for place in [
        is_small.then(|| memory.clone()),
        Some(std::env::temp_dir()),
        Some(memory),
        Some(PathBuf::from("/tmp")),
        Some(PathBuf::from("/var/tmp")),
        std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from),
    ]
    .into_iter()
    .flatten()
    {
        if !places.contains(&place) {
            places.push(place);
        }
    }
    places
}

/// Returns the space that is free for this user on the file system of `place` \[bytes\].
fn free(place: &Path) -> io::Result<u64> {
    let volume = statvfs(place)?;
    Ok(volume.f_bavail.saturating_mul(volume.f_frsize))
}

/// Locks a directory, or returns `None` if another process has locked it or it is gone.
fn lock(directory: &Path) -> io::Result<Option<File>> {
    let opened = File::options()
        .read(true)
        .custom_flags((OFlags::DIRECTORY | OFlags::NOFOLLOW).bits().cast_signed())
        .open(directory);
    let file = match opened {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(Some(file)),
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Removes the directories in `place` that killed processes of this user have left.
fn remove_abandoned(place: &Path) {
    let Ok(entries) = fs::read_dir(place) else { return };
    for entry in entries.filter_map(Result::ok) {
        let is_ours = entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes())
            && entry
                .metadata()
                .is_ok_and(|found| found.is_dir() && found.uid() == geteuid().as_raw());
        if is_ours && let Ok(Some(_lock)) = lock(&entry.path()) {
            // What cannot be removed is tried again by the next one.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_one_removes_what_a_killed_process_has_left() {
        let place = tempfile::tempdir().unwrap();
        let scratch = |name: &str| place.path().join(format!("{PREFIX}{name}"));
        fs::create_dir(scratch("dead")).unwrap();
        fs::write(scratch("dead").join("db"), "records").unwrap();
        fs::create_dir(scratch("alive")).unwrap();
        let alive = lock(&scratch("alive")).unwrap();
        fs::create_dir(place.path().join("letters")).unwrap();
        std::os::unix::fs::symlink(place.path().join("letters"), scratch("link")).unwrap();

        let new = ScratchDirectory::new_in(place.path(), 0).unwrap();
        assert!(!scratch("dead").exists() && scratch("alive").exists());
        assert!(place.path().join("letters").exists() && scratch("link").exists());
        let path = new.path().to_owned();
        assert!(path.is_dir() && fs::metadata(&path).unwrap().mode() & 0o077 == 0);
        drop((new, alive));
        assert!(!path.exists());
        assert!(ScratchDirectory::new_in(place.path(), u64::MAX).is_err());
    }
}
