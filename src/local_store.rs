//! The store of a shard on the disk of its machine, which is there only while the shard runs.

use std::fs::{self, DirBuilder};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

/// A directory for temporary files that belongs to a shard.
pub(crate) struct LocalStore {
    path: PathBuf,
}

impl LocalStore {
    /// Opens the directory of a shard, or that which a killed run of it has left.
    pub(crate) fn open(label: &str) -> Result<Self> {
        let user = rustix::process::geteuid().as_raw();
        let path = std::env::temp_dir().join(format!("tribosweep-{user}-{label}"));
        let failed = || format!("cannot make the directory {}", path.display());
        match DirBuilder::new().mode(0o700).create(&path) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
                Err(error).with_context(failed)
            }
            _ => {
                // Everybody may make directories here, and links to other places.
                let found = fs::symlink_metadata(&path).with_context(failed)?;
                if !found.is_dir() || found.uid() != user {
                    bail!(
                        "{} is not a directory of this user; remove it, or name a directory on a \
                         local disk: --store DIR",
                        path.display()
                    );
                }
                Ok(Self { path })
            }
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the directory.
    pub(crate) fn remove(self) -> Result<()> {
        fs::remove_dir_all(&self.path)
            .with_context(|| format!("cannot remove {}", self.path.display()))
    }
}
