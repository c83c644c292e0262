//! Bodies that are too large for a message travel as files in the run's root. They are checked by
//! their hash and removed when they are read.

use std::path::Path;

use crate::protocol::Body;

/// Writes a body to a file. There is no sync: the file need not outlive the run, and the page cache
/// outlives both ends.
pub(crate) fn store(path: &Path, bytes: &[u8]) -> Result<Body, String> {
    std::fs::write(path, bytes).map_err(|error| {
        let _ = std::fs::remove_file(path);
        format!("cannot write {} bytes to {}: {error}", bytes.len(), path.display())
    })?;
    Ok(Body::File { hash: *blake3::hash(bytes).as_bytes(), length: bytes.len() as u64 })
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
            store(&dir.path().join("no/such"), b"x")
                .unwrap_err()
                .starts_with("cannot write 1 bytes")
        );
    }
}
