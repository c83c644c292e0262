//! Bodies that are too large for a message travel as files, through a directory on the volume that
//! keeps the results. They are checked by their hash and removed when they are read.

use std::fs::{DirBuilder, File};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::Path;

use crate::protocol::Body;

/// Writes a body to a new file. There is no sync: the file need not outlive the run, and the page
/// cache outlives both ends.
pub(crate) fn store(path: &Path, bytes: &[u8]) -> Result<Body, String> {
    let written = create(path).and_then(|mut file| {
        file.write_all(bytes).inspect_err(|_| {
            let _ = std::fs::remove_file(path);
        })
    });
    written.map_err(|error| {
        format!("cannot write {} bytes to {}: {error}", bytes.len(), path.display())
    })?;
    Ok(Body::File { hash: *blake3::hash(bytes).as_bytes(), length: bytes.len() as u64 })
}

/// Creates a file of this user alone, in the place of an older one: a message that finds no room in
/// shared memory is packed again. A link is not followed. If somebody has removed the directory, it
/// is made again.
fn create(path: &Path) -> std::io::Result<File> {
    let mut options = File::options();
    options.write(true).create_new(true).mode(0o600);
    let _ = std::fs::remove_file(path);
    match (options.open(path), path.parent()) {
        (Err(error), Some(directory)) if error.kind() == ErrorKind::NotFound => {
            match DirBuilder::new().mode(0o700).create(directory) {
                Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(error),
                _ => options.open(path),
            }
        }
        (opened, _) => opened,
    }
}

/// Returns the bytes of a body. `path` is the path of its file, if it has one.
pub(crate) fn load(path: &Path, body: Body) -> Result<Vec<u8>, String> {
    let (hash, length) = match body {
        Body::Inline(bytes) => return Ok(bytes),
        Body::File { hash, length } => (hash, length),
    };
    let bytes =
        std::fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let _ = std::fs::remove_file(path);
    if bytes.len() as u64 != length || blake3::hash(&bytes) != blake3::Hash::from_bytes(hash) {
        return Err(format!(
            "{} holds {} bytes that are not the {length} that were sent",
            path.display(),
            bytes.len()
        ));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_comes_back_once_and_only_unharmed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("body");
        let body = store(&path, b"traction").unwrap();
        assert_eq!(load(&path, body.clone()).unwrap(), b"traction");
        assert!(load(&path, body).unwrap_err().starts_with("cannot read"));
        let body = store(&path, b"traction").unwrap();
        std::fs::write(&path, b"fraction").unwrap();
        assert!(
            load(&path, body)
                .unwrap_err()
                .ends_with("holds 8 bytes that are not the 8 that were sent")
        );
        assert!(
            store(&dir.path().join("no/such/place"), b"x")
                .unwrap_err()
                .starts_with("cannot write 1 bytes")
        );
    }

    #[test]
    fn a_directory_that_somebody_removes_is_made_again() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("bodies/body");
        let body = store(&path, b"traction").unwrap();
        assert_eq!(load(&path, body).unwrap(), b"traction");
    }

    #[test]
    fn a_link_in_the_place_of_a_file_is_not_followed() {
        let dir = tempfile::tempdir().unwrap();
        let (target, link) = (dir.path().join("target"), dir.path().join("body"));
        std::fs::write(&target, b"precious").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let body = store(&link, b"traction").unwrap();
        assert_eq!(load(&link, body).unwrap(), b"traction");
        assert_eq!(std::fs::read(&target).unwrap(), b"precious");
    }
}
