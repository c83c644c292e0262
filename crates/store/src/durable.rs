//! Files are written so that they exist entirely or not at all, also after a power failure.

use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use crate::access::{self, inherit_owner};

/// The prefix of a file that is still being written. Without its writer, such a file is a leftover
/// of a kill.
pub(crate) const UNFINISHED_PREFIX: &str = ".unfinished-";

/// Writes `bytes` to `path` durably: the file is written beside it, fsync'ed and renamed over it,
/// and the directory is fsync'ed. A directory in its place is put aside.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// Writes what `fill` puts into a file durably to `path`, like [`write`].
pub(crate) fn write_with(
    path: &Path,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let directory = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new()
        .prefix(UNFINISHED_PREFIX)
        // The umask is subtracted, as for any file; the default is 0600.
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(directory)?;
    fill(file.as_file_mut())?;
    inherit_owner(file.as_file(), path)?;
    file.as_file().sync_all()?;
    if is_real_directory(path) {
        put_aside(path)?;
    }
    file.persist(path).map_err(|failed| failed.error)?;
    sync_directory(directory)
}

/// Makes the names in `directory` durable, because the fsync of a file does not cover its name.
pub(crate) fn sync_directory(directory: &Path) -> io::Result<()> {
    File::open(directory)?.sync_all()
}

/// Creates `directory` durably if it is absent, and puts a file in its place aside. Its parent must
/// exist.
pub(crate) fn create_directory(directory: &Path) -> io::Result<()> {
    match fs::create_dir(directory) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            if directory.is_dir() {
                return Ok(());
            }
            put_aside(directory)?;
            fs::create_dir(directory)?;
        }
        outcome => outcome?,
    }
    inherit_owner(&access::open_directory(directory)?, directory)?;
    sync_directory(directory.parent().unwrap_or(Path::new(".")))
}

/// Returns true if `path` itself is a directory and no link to one.
pub(crate) fn is_real_directory(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_dir())
}

/// Returns true if `path` itself is a regular file and no link to one.
pub(crate) fn is_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
}

/// Returns true if there is anything at `path`, be it a link that leads nowhere.
pub(crate) fn is_present(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Removes whatever is at `path`, a directory with all that is in it. A link is not followed.
pub(crate) fn clear_away(path: &Path) -> io::Result<()> {
    if is_real_directory(path) {
        fs::remove_dir_all(path)
    } else if is_present(path) {
        fs::remove_file(path)
    } else {
        Ok(())
    }
}

/// Renames what is at `path`, so that the name is free, and returns its new name. An empty
/// directory is removed instead.
pub(crate) fn put_aside(path: &Path) -> io::Result<Option<PathBuf>> {
    if is_real_directory(path) && fs::remove_dir(path).is_ok() {
        return Ok(None);
    }
    let mut number = 1u32;
    loop {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".damaged-{number}"));
        let aside = PathBuf::from(name);
        if !is_present(&aside) {
            fs::rename(path, &aside)?;
            return Ok(Some(aside));
        }
        number += 1;
    }
}

/// Removes a file. A directory in its place is put aside.
pub(crate) fn remove(path: &Path) -> io::Result<()> {
    if is_real_directory(path) { put_aside(path).map(drop) } else { fs::remove_file(path) }
}

/// Removes the files that killed writers have left in `directory`. The caller must know that nobody
/// is writing there.
pub(crate) fn clear_unfinished(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        let is_unfinished = entry.file_name().to_string_lossy().starts_with(UNFINISHED_PREFIX);
        if is_unfinished && !entry.file_type()?.is_dir() {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}
