//! Blobs are large values in files that are named by their content.
//!
//! A blob is a zstd frame in `blobs/ab/cdef….zst`, where `abcdef…` is the BLAKE3 digest of the
//! uncompressed content. Such names make writing idempotent and reading verifiable. No lock is
//! needed: any process may write blobs at any time.

mod files;
mod verified;

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use identity::KeptFields;

use crate::access;
use crate::compression;
use crate::digest::Digest;
use crate::durable;
use crate::error::{ReadError, WriteError};
use crate::exports::{CompressedBlob, ExportSet};
use crate::frame::{BodySum, Checksum};

pub(crate) use self::files::BlobFile;
pub use self::files::StoredBlob;
use self::files::{files_in, path_in};
use self::verified::{BlobSink, PIECE, verified};

/// The compression level, which is zstd's own default: fields shrink by the same few per cent at
/// every level that is worth its time.
const LEVEL: i32 = 3;

/// The largest compressed size of fields that a record keeps itself \[bytes\], about that of 32 ×
/// 32 elements. A file takes two fsyncs, each a quarter of a millisecond on an idle disk and ten
/// times that on a busy one, which is as long as such a job takes to solve.
const INLINE_LIMIT: usize = 16 << 10;

/// The largest content that may be kept in a record \[bytes\]. Larger content is not tried, and no
/// record is believed to keep more: fields do not shrink to less than an eighth.
const INLINE_CONTENT_LIMIT: usize = 8 * INLINE_LIMIT;

/// The largest content of a blob \[bytes\]. This is as much as the crate `study` decodes: six
/// doubles for each element of the largest grid, and room to spare. A file of a megabyte may claim
/// to be tens of gigabytes, and a reader must not find that out by running out of memory.
const CONTENT_LIMIT: u64 = 2 << 30;

/// The blobs of one store. They need no open store and no lock.
#[derive(Clone, Debug)]
pub struct Blobs {
    directory: PathBuf,
    /// The exports that hold the blobs, where no directory does.
    exports: Option<Arc<ExportSet>>,
}

/// The size of a compressed blob that was read whole and is sound, and its checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CompressedSize {
    /// The number of the copy among those that there are.
    copy: usize,
    pub(crate) length: u64,
    pub(crate) sum: Checksum,
}

impl Blobs {
    /// Returns the blobs of the store in the directory `store`.
    pub(crate) fn of(store: &Path) -> Self {
        Blobs { directory: store.join("blobs"), exports: None }
    }

    /// Returns the blobs in exports.
    pub(crate) fn in_exports(exports: Arc<ExportSet>) -> Self {
        Blobs { directory: exports.path.join("blobs"), exports: Some(exports) }
    }

    /// Returns the directory of all blobs.
    pub(crate) fn directory(&self) -> &Path {
        &self.directory
    }

    /// Returns the directory of the store, or the path of the exports.
    pub fn store(&self) -> &Path {
        if let Some(exports) = &self.exports {
            return &exports.path;
        }
        self.directory.parent().unwrap_or(&self.directory)
    }

    /// Returns the path of a blob in a store, where it need not exist.
    pub fn path(&self, digest: &Digest) -> PathBuf {
        path_in(&self.directory, digest)
    }

    /// Stores `content` durably and returns its name. The content may have at most 2 GiB. Storing
    /// it again changes nothing, except that a sound copy replaces a damaged one.
    ///
    /// # Errors
    /// [`WriteError::DiskFull`] if there is too little space, [`WriteError::Io`] if the content is
    /// too large or the operating system refuses.
    pub fn put(&self, content: &[u8]) -> Result<Digest, WriteError> {
        self.require_directory()?;
        if content.len() as u64 > CONTENT_LIMIT {
            let reason = format!(
                "it would have {} bytes, and a blob may have {CONTENT_LIMIT}",
                content.len()
            );
            return Err(WriteError::io(
                "write a blob in",
                &self.directory,
                io::Error::new(io::ErrorKind::FileTooLarge, reason),
            ));
        }
        let digest = Digest::of(content);
        let path = self.path(&digest);
        if let Ok(true) = self.is_sound(&digest) {
            return Ok(digest);
        }
        let failed = |source| WriteError::io("write the blob", &path, source);
        let compressed = compress(content).map_err(failed)?;
        self.prepare(&path, compressed.len() as u64)?;
        durable::write(&path, &compressed).map_err(failed)?;
        Ok(digest)
    }

    /// Creates the directory for the file of a blob and makes sure of the space for it.
    fn prepare(&self, path: &Path, length: u64) -> Result<(), WriteError> {
        let shelf = path.parent().unwrap_or(&self.directory);
        durable::create_directory(&self.directory)
            .and_then(|()| durable::create_directory(shelf))
            .map_err(|source| WriteError::io("write the blob", path, source))?;
        WriteError::require_space(&self.directory, length)
    }

    fn require_directory(&self) -> Result<(), WriteError> {
        if self.exports.is_none() {
            return Ok(());
        }
        let source = io::Error::new(io::ErrorKind::ReadOnlyFilesystem, "exports are only read");
        Err(WriteError::io("write a blob in", self.store(), source))
    }

    /// Stores a blob of `source`, as it is compressed there, unless a sound one is here already.
    /// Returns true if it was stored.
    ///
    /// # Errors
    /// The outer error is one of writing. The inner one says why the source does not give the blob.
    pub(crate) fn adopt(
        &self,
        digest: &Digest,
        source: &Blobs,
    ) -> Result<Result<bool, ReadError>, WriteError> {
        self.require_directory()?;
        if self.is_sound(digest).is_ok_and(|is_sound| is_sound) {
            return Ok(Ok(false));
        }
        let size = match source.compressed_size(digest) {
            Ok(Some(size)) => size,
            Ok(None) => return Ok(Err(source.missing(digest))),
            Err(error) => return Ok(Err(error)),
        };
        let path = self.path(digest);
        self.prepare(&path, size.length)?;
        let mut fault = None;
        let written = durable::write_with(&path, |file| {
            source.copy_compressed(digest, &size, file)?.map_err(|unread| {
                fault = Some(unread);
                io::Error::other("there is nothing to write")
            })
        });
        match (fault, written) {
            (Some(fault), _) => Ok(Err(fault)),
            (None, Err(source)) => Err(WriteError::io("write the blob", &path, source)),
            (None, Ok(())) => Ok(Ok(true)),
        }
    }

    /// Returns the error of a blob that is not there.
    pub(crate) fn missing(&self, digest: &Digest) -> ReadError {
        let path = match &self.exports {
            Some(exports) => exports.path.clone(),
            None => self.path(digest),
        };
        ReadError::Blob { digest: *digest, path, reason: "it is missing".to_owned() }
    }

    /// Reads a blob whole and returns its size in the file; `None` if there is no such blob.
    pub(crate) fn compressed_size(
        &self,
        digest: &Digest,
    ) -> Result<Option<CompressedSize>, ReadError> {
        self.read(digest, CONTENT_LIMIT, &mut io::sink())
    }

    /// Copies the compressed bytes of a blob whose size was found before.
    ///
    /// # Errors
    /// The outer error is one of writing. The inner one says why the blob cannot be read any more.
    pub(crate) fn copy_compressed(
        &self,
        digest: &Digest,
        size: &CompressedSize,
        target: &mut dyn Write,
    ) -> io::Result<Result<(), ReadError>> {
        let copies = match self.compressed(digest) {
            Ok(copies) => copies,
            Err(fault) => return Ok(Err(fault)),
        };
        let Some(copy) = copies.into_iter().nth(size.copy) else {
            return Ok(Err(self.missing(digest)));
        };
        let path = copy.path;
        let mut bytes = match copy.bytes {
            Ok(bytes) => bytes.take(size.length),
            Err(source) => return Ok(Err(ReadError::Io { path, source })),
        };
        let (mut sum, mut count, mut piece) = (BodySum::new(), 0, vec![0; PIECE]);
        loop {
            let read = match bytes.read(&mut piece) {
                Ok(read) => read,
                Err(source) => return Ok(Err(ReadError::Io { path, source })),
            };
            if read == 0 {
                break;
            }
            count += read as u64;
            sum.add(&piece[..read]);
            target.write_all(&piece[..read])?;
        }
        match (count, sum.get()) == (size.length, size.sum) {
            true => Ok(Ok(())),
            false => {
                let reason = "it changed while it was copied".to_owned();
                Ok(Err(ReadError::Blob { digest: *digest, path, reason }))
            }
        }
    }

    /// Returns the compressed bytes of a blob wherever they are.
    fn compressed(&self, digest: &Digest) -> Result<Vec<CompressedBlob>, ReadError> {
        if let Some(exports) = &self.exports {
            return Ok(exports.compressed(digest).collect());
        }
        let path = self.path(digest);
        let (length, bytes) = match access::open_to_read(&path) {
            Ok(file) => match file.metadata() {
                Ok(metadata) => (metadata.len(), Ok(Box::new(file) as Box<dyn Read>)),
                Err(error) => (0, Err(error)),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => (0, Err(error)),
        };
        Ok(vec![CompressedBlob { path, length, bytes }])
    }

    /// Keeps the fields of a record: small ones are compressed for the record itself, others are
    /// stored as a blob.
    ///
    /// # Errors
    /// [`WriteError::DiskFull`] if there is too little space, [`WriteError::Io`] if the operating
    /// system refuses.
    pub fn keep(&self, content: &[u8]) -> Result<KeptFields, WriteError> {
        if content.len() <= INLINE_CONTENT_LIMIT {
            let compressed = compress(content).map_err(|source| {
                WriteError::io("compress a field for", &self.directory, source)
            })?;
            if compressed.len() <= INLINE_LIMIT {
                return Ok(KeptFields::Inside(compressed));
            }
        }
        Ok(KeptFields::Blob(self.put(content)?.0))
    }

    /// Returns the content that [`keep`](Blobs::keep) kept, or `None` if its blob does not exist.
    ///
    /// # Errors
    /// [`ReadError::Inside`] if the bytes in the record are corrupt, otherwise those of
    /// [`get`](Blobs::get).
    pub fn kept(&self, kept: &KeptFields) -> Result<Option<Vec<u8>>, ReadError> {
        match kept {
            KeptFields::Blob(digest) => self.get(&Digest(*digest)),
            KeptFields::Inside(compressed) => inside(compressed).map(Some),
        }
    }

    /// Returns the name that the content of kept fields has as a blob, wherever it is kept.
    ///
    /// # Errors
    /// [`ReadError::Inside`] if the bytes in the record are corrupt.
    pub fn kept_digest(kept: &KeptFields) -> Result<Digest, ReadError> {
        match kept {
            KeptFields::Blob(digest) => Ok(Digest(*digest)),
            KeptFields::Inside(compressed) => Ok(Digest::of(&inside(compressed)?)),
        }
    }

    /// Returns the content of a blob, verified against its name, or `None` if there is no such
    /// blob.
    ///
    /// # Errors
    /// [`ReadError::Blob`] if the file holds anything else or more than 2 GiB, [`ReadError::Io`] if
    /// it cannot be read.
    pub fn get(&self, digest: &Digest) -> Result<Option<Vec<u8>>, ReadError> {
        self.get_within(digest, CONTENT_LIMIT)
    }

    /// Returns the content of a blob like [`get`](Blobs::get) if it has at most `limit` bytes.
    ///
    /// # Errors
    /// Those of [`get`](Blobs::get); a longer blob counts as corrupt.
    pub fn get_within(&self, digest: &Digest, limit: u64) -> Result<Option<Vec<u8>>, ReadError> {
        let mut content = Vec::new();
        Ok(self.read(digest, limit, &mut content)?.map(|_| content))
    }

    /// Returns true if the blob is there and holds what its name says. It is read in pieces and not
    /// kept.
    ///
    /// # Errors
    /// Those of [`get`](Blobs::get).
    pub fn is_sound(&self, digest: &Digest) -> Result<bool, ReadError> {
        Ok(self.read(digest, CONTENT_LIMIT, &mut io::sink())?.is_some())
    }

    /// Returns true if what [`keep`](Blobs::keep) kept is there and can be read.
    ///
    /// # Errors
    /// Those of [`kept`](Blobs::kept).
    pub fn is_kept(&self, kept: &KeptFields) -> Result<bool, ReadError> {
        match kept {
            KeptFields::Blob(digest) => self.is_sound(&Digest(*digest)),
            KeptFields::Inside(_) => self.kept(kept).map(|content| content.is_some()),
        }
    }

    /// Reads a blob of at most `limit` bytes into `content`, verifies it and returns its size in
    /// the file. Returns `None` if there is no such blob. Of several copies the first sound one
    /// counts.
    fn read(
        &self,
        digest: &Digest,
        limit: u64,
        content: &mut dyn BlobSink,
    ) -> Result<Option<CompressedSize>, ReadError> {
        let failed = |path: PathBuf, error: io::Error| {
            if access::is_damage(&error) || error.kind() == io::ErrorKind::Other {
                ReadError::Blob { digest: *digest, path, reason: error.to_string() }
            } else {
                ReadError::Io { path, source: error }
            }
        };
        let mut fault = None;
        let copies = self.compressed(digest)?.into_iter().enumerate();
        for (copy, CompressedBlob { path, length, bytes }) in copies {
            let sound = bytes.and_then(|bytes| verified(bytes, length, digest, limit, content));
            match sound {
                Ok(sum) => return Ok(Some(CompressedSize { copy, length, sum })),
                Err(error) => fault = fault.or(Some(failed(path, error))),
            }
            content.start_again();
        }
        fault.map_or(Ok(None), Err)
    }

    /// Returns the definition of the study `name`, which the manifest says is the blob `digest`.
    pub(crate) fn definition(&self, name: &str, digest: &Digest) -> Result<Vec<u8>, ReadError> {
        self.get(digest)?
            .ok_or_else(|| ReadError::StudyMissing { name: name.to_owned(), digest: *digest })
    }

    /// Returns true if there is a file for the blob. Its content is not read.
    pub fn contains(&self, digest: &Digest) -> bool {
        match &self.exports {
            Some(exports) => exports.has_blob(digest),
            None => self.path(digest).is_file(),
        }
    }

    /// Lists the blobs in the order of their names. Their content is not read.
    ///
    /// # Errors
    /// [`ReadError::Io`] if they cannot be listed.
    pub fn stored(&self) -> Result<Vec<StoredBlob>, ReadError> {
        Ok(self.files()?.iter().filter_map(BlobFile::stored).collect())
    }

    /// Lists every file under `blobs/` in the order of the names, or every blob in exports.
    pub(crate) fn files(&self) -> Result<Vec<BlobFile>, ReadError> {
        let Some(exports) = &self.exports else { return files_in(&self.directory) };
        let mut listed = BTreeMap::new();
        for file in &exports.files {
            for (digest, place) in &file.blobs {
                let (path, bytes) = (file.path().to_owned(), place.length());
                let blob = BlobFile::Blob { digest: *digest, path, bytes };
                listed.entry(*digest).or_insert(blob);
            }
        }
        Ok(listed.into_values().collect())
    }
}

/// Returns the content of fields that a record keeps itself.
fn inside(compressed: &[u8]) -> Result<Vec<u8>, ReadError> {
    compression::decompress(compressed, INLINE_CONTENT_LIMIT)
        .map_err(|error| ReadError::Inside { reason: error.to_string() })
}

/// Compresses `content` in one call, for which zstd reserves less memory than for a stream.
fn compress(content: &[u8]) -> io::Result<Vec<u8>> {
    compression::compress(content, LEVEL)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn blobs() -> (tempfile::TempDir, Blobs) {
        let directory = tempfile::tempdir().unwrap();
        let blobs = Blobs::of(directory.path());
        (directory, blobs)
    }

    #[test]
    fn a_blob_is_written_once_under_the_name_of_its_content() {
        let (_directory, blobs) = blobs();
        let content: Vec<u8> = (0..100_000u32).flat_map(|i| (i / 7).to_le_bytes()).collect();
        assert_eq!(blobs.get(&Digest::of(&content)).unwrap(), None);
        let digest = blobs.put(&content).unwrap();
        assert_eq!(digest, Digest::of(&content));
        let written = fs::metadata(blobs.path(&digest)).unwrap();
        assert!(written.len() < content.len() as u64 / 2);
        assert_eq!(blobs.put(&content).unwrap(), digest);
        assert_eq!(
            fs::metadata(blobs.path(&digest)).unwrap().modified().unwrap(),
            written.modified().unwrap()
        );
        assert_eq!(blobs.get(&digest).unwrap().unwrap(), content);
        assert_eq!(blobs.files().unwrap().len(), 1);
    }

    #[test]
    fn what_is_small_is_kept_by_its_record() {
        let (_directory, blobs) = blobs();
        // These numbers hardly shrink.
        let content = |len: u32| -> Vec<u8> {
            (0..len).flat_map(|i| i.wrapping_mul(2_654_435_769).to_le_bytes()).collect()
        };
        for (content, is_inside) in [
            (Vec::new(), true),
            (content(1000), true),
            (vec![7; 7 * INLINE_LIMIT], true),
            (content(5000), false),
        ] {
            let kept = blobs.keep(&content).unwrap();
            assert_eq!(matches!(kept, KeptFields::Inside(_)), is_inside, "{} bytes", content.len());
            assert_eq!(blobs.kept(&kept).unwrap().as_ref(), Some(&content));
        }
        assert_eq!(blobs.files().unwrap().len(), 1);
        assert_eq!(blobs.kept(&KeptFields::Blob([7; 32])).unwrap(), None);
        let garbage = blobs.kept(&KeptFields::Inside(vec![7; 20])).unwrap_err();
        assert!(
            garbage.to_string().starts_with("the fields in a record are corrupt: "),
            "{garbage}"
        );
    }

    #[test]
    fn a_damaged_blob_is_refused_and_healed_by_writing_it_again() {
        let (_directory, blobs) = blobs();
        let content = b"pressure, traction, gap".repeat(100);
        let digest = blobs.put(&content).unwrap();
        let sound = fs::read(blobs.path(&digest)).unwrap();
        let other = fs::read(blobs.path(&blobs.put(b"another field").unwrap())).unwrap();
        for damaged in [&b""[..], &sound[..sound.len() / 2], b"garbage", &other] {
            fs::write(blobs.path(&digest), damaged).unwrap();
            let error = blobs.get(&digest).unwrap_err();
            assert!(matches!(&error, ReadError::Blob { digest: d, .. } if *d == digest), "{error}");
            assert_eq!(blobs.put(&content).unwrap(), digest);
            assert_eq!(blobs.get(&digest).unwrap().unwrap(), content);
        }
    }

    #[test]
    fn a_blob_is_read_up_to_a_limit_however_small_its_file() {
        let (_directory, blobs) = blobs();
        let content = vec![0; 1 << 20];
        let digest = blobs.put(&content).unwrap();
        assert!(fs::metadata(blobs.path(&digest)).unwrap().len() < 200);
        assert_eq!(blobs.get_within(&digest, 1 << 20).unwrap().as_ref(), Some(&content));
        let error = blobs.get_within(&digest, (1 << 20) - 1).unwrap_err();
        assert!(
            matches!(&error, ReadError::Blob { reason, .. } if reason.contains("more than 1048575 bytes")),
            "{error}"
        );
        // Consecutive frames are one content.
        let frame = fs::read(blobs.path(&digest)).unwrap();
        fs::write(blobs.path(&digest), frame.repeat(3)).unwrap();
        let error = blobs.get_within(&digest, 2 << 20).unwrap_err();
        assert!(
            matches!(&error, ReadError::Blob { reason, .. } if reason.contains("more than 2097152 bytes")),
            "{error}"
        );

        // The file is sparse: neither the disk nor the memory holds its bytes.
        fs::File::create(blobs.path(&digest)).unwrap().set_len(2 * CONTENT_LIMIT).unwrap();
        let error = blobs.get(&digest).unwrap_err();
        assert!(
            matches!(&error, ReadError::Blob { reason, .. } if reason.contains("longer than that of any blob")),
            "{error}"
        );
        assert_eq!(blobs.put(&content).unwrap(), digest);
        assert_eq!(blobs.get(&digest).unwrap().unwrap(), content);
    }

    #[test]
    fn a_source_that_changes_while_it_is_copied_is_the_one_to_blame() {
        let (_directory, source) = blobs();
        let digest = source.put(&[7; 50_000]).unwrap();
        let size = source.compressed_size(&digest).unwrap().unwrap();
        let mut copy = Vec::new();
        source.copy_compressed(&digest, &size, &mut copy).unwrap().unwrap();
        assert_eq!(copy, fs::read(source.path(&digest)).unwrap());
        fs::write(source.path(&digest), &copy[..copy.len() - 1]).unwrap();
        let fault = source.copy_compressed(&digest, &size, &mut Vec::new()).unwrap().unwrap_err();
        assert!(fault.to_string().contains("changed while it was copied"), "{fault}");
        fs::remove_file(source.path(&digest)).unwrap();
        let fault = source.copy_compressed(&digest, &size, &mut Vec::new()).unwrap().unwrap_err();
        assert!(fault.to_string().contains("it is missing"), "{fault}");
        fs::create_dir(source.path(&digest)).unwrap();
        let fault = source.copy_compressed(&digest, &size, &mut Vec::new()).unwrap().unwrap_err();
        assert!(matches!(&fault, ReadError::Io { .. }), "{fault}");
    }

    #[test]
    fn a_blob_that_could_not_be_read_is_not_written() {
        let (_directory, blobs) = blobs();
        // The pages are never touched.
        let error = blobs.put(&vec![0; CONTENT_LIMIT as usize + 1]).unwrap_err();
        assert!(error.to_string().contains("a blob may have 2147483648"), "{error}");
        assert!(blobs.files().unwrap().is_empty());
    }
}
