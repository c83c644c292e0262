//! The store of a shard on the disk of its machine, which is there only while the shard runs.

use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rustix::fs::{FlockOperation, OFlags, flock};

use crate::output;

/// A directory for temporary files that belongs to a shard. It is locked, so that nobody else uses
/// it or what is left of it.
pub(crate) struct LocalStore {
    path: PathBuf,
    /// The directory itself, which holds the lock.
    _lock: File,
}

impl LocalStore {
    /// Opens the directory of a shard, or that which a killed run of it has left.
    pub(crate) fn open(label: &str) -> Result<Self> {
        let user = rustix::process::geteuid().as_raw();
        let path = std::env::temp_dir().join(format!("tribosweep-{user}-{label}"));
        let failed = || format!("cannot make the directory {}", path.display());
        loop {
            if let Err(error) = DirBuilder::new().mode(0o700).recursive(false).create(&path)
                && error.kind() != io::ErrorKind::AlreadyExists
            {
                return Err(error).with_context(failed);
            }
            // Everybody may make directories here, and links to other places.
            let strange = || {
                format!(
                    "{} is not a directory of this user; remove it, or name a directory on a local \
                     disk: --store DIR",
                    path.display()
                )
            };
            let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            let lock = match rustix::fs::open(&path, flags, rustix::fs::Mode::empty()) {
                Ok(lock) => File::from(lock),
                // Whoever used it has just removed it.
                Err(rustix::io::Errno::NOENT) => continue,
                Err(_) => bail!(strange()),
            };
            if lock.metadata().with_context(failed)?.uid() != user {
                bail!(strange());
            }
            if flock(&lock, FlockOperation::NonBlockingLockExclusive).is_err() {
                bail!(
                    "another process is running this shard in {}; wait for it, or name another \
                     directory: --store DIR",
                    path.display()
                );
            }
            // It may have been removed before it was locked.
            let ours = lock.metadata().with_context(failed)?;
            match fs::symlink_metadata(&path) {
                Ok(there) if (there.dev(), there.ino()) == (ours.dev(), ours.ino()) => {
                    return Ok(Self { path, _lock: lock });
                }
                _ => {}
            }
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the directory, of which nothing is needed any more.
    pub(crate) fn remove(self) {
        if let Err(error) = fs::remove_dir_all(&self.path) {
            output::say(&format!("warning: cannot remove {}: {error}", self.path.display()));
        }
    }
}
