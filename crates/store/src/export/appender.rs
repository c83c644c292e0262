//! This file appends frames to an export, and lets it take its place when it is whole.

use std::collections::{BTreeMap, HashSet};
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{FileExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use identity::{JobKey, STORED_LIMIT};
use tempfile::NamedTempFile;

use crate::access::{self, inherit_owner};
use crate::blob::Blobs;
use crate::digest::Digest;
use crate::durable;
use crate::export::error::ExportError;
use crate::exports::{EXTENSION, ExportHeader, ShardState, part_table, require_possible};
use crate::frame::{
    BodySum, Checksum, EXPORT_FORMAT, ExportFrame, FRAME_LIMIT, FRAME_TARGET, FrameHead, FrameKind,
    HEAD, MAGIC, PREAMBLE, RECORDS_PER_FRAME, TABLE_ENTRY, TABLE_LIMIT, TableEntry, add_entry,
    content_of, digest_of, entries_of,
};

/// The compression level, which is zstd's own default.
const LEVEL: i32 = 3;

/// The longest note \[bytes\].
const NOTE_LIMIT: usize = TABLE_LIMIT / 4;

/// The size of the pieces in which bodies are copied \[bytes\].
const PIECE: usize = 128 << 10;

/// A file to which frames are appended. Records are gathered into frames, which are written when
/// they are large enough or by [`flush`](ExportAppender::flush). It remembers the blobs and the
/// studies that are in the file, and nothing of the records.
pub(crate) struct ExportAppender {
    path: PathBuf,
    file: File,
    /// The name of the file as long as it has not taken its place.
    temporary: Option<tempfile::TempPath>,
    /// The end of the last whole frame \[bytes\].
    end: u64,
    blobs: HashSet<Digest>,
    studies: BTreeMap<String, Digest>,
    /// The number of records that were added.
    added: usize,
    /// The table and the records of the frame that is being gathered.
    table: Vec<u8>,
    records: Vec<u8>,
    /// The last note that was given, unless it is in the file already.
    note: Option<Vec<u8>>,
    written_note: Option<Vec<u8>>,
}

/// Refuses a path whose name does not end like that of an export.
fn require_name(path: &Path) -> Result<(), ExportError> {
    match path.extension().is_some_and(|extension| extension == EXTENSION) {
        true => Ok(()),
        false => Err(ExportError::Name { path: path.to_owned() }),
    }
}

/// Returns the directory of a file.
pub(crate) fn directory_of(path: &Path) -> &Path {
    path.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the beginning of the name of a file that is to take the place of `path`.
fn unfinished_prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!("{}{name}-", durable::UNFINISHED_PREFIX)
}

/// The jobs of a frame with the beginnings of the digests of their records.
pub(super) type SummedRecords = Vec<(JobKey, Checksum)>;

impl ExportAppender {
    /// Starts a file that takes the place of `path` when it is [settled](ExportAppender::settle).
    pub(crate) fn beside(
        path: &Path,
        header: &ExportHeader,
    ) -> Result<ExportAppender, ExportError> {
        require_name(path)?;
        let impossible = |reason| ExportError::Impossible { path: path.to_owned(), reason };
        header.shard.as_ref().map_or(Ok(()), require_possible).map_err(impossible)?;
        let directory = directory_of(path);
        let failed = |source| ExportError::io("write", path, source);
        if !directory.exists() {
            access::create_directories(directory)
                .map_err(|source| ExportError::io("create the directory", directory, source))?;
        }
        let file = tempfile::Builder::new()
            .prefix(&unfinished_prefix(path))
            // The umask is subtracted, as for any file; the default is 0600.
            .permissions(Permissions::from_mode(0o666))
            .tempfile_in(directory)
            .map_err(failed)?;
        inherit_owner(file.as_file(), path).map_err(failed)?;
        let (file, temporary) = NamedTempFile::into_parts(file);
        let mut writer = ExportAppender {
            path: path.to_owned(),
            file,
            temporary: Some(temporary),
            end: PREAMBLE,
            blobs: HashSet::new(),
            studies: BTreeMap::new(),
            added: 0,
            table: Vec::new(),
            records: Vec::new(),
            note: None,
            written_note: None,
        };
        let preamble = [&MAGIC[..], &EXPORT_FORMAT.to_le_bytes()].concat();
        writer.file.write_all_at(&preamble, 0).map_err(failed)?;
        let words = serde_json::to_vec(header).map_err(|error| failed(error.into()))?;
        writer.add_frame(FrameKind::Header, &words, &[])?;
        Ok(writer)
    }

    /// Copies a frame of an earlier export and returns the records in it, or says what is wrong
    /// with it. Nothing of it stays then.
    pub(super) fn copy_frame(
        &mut self,
        earlier: &File,
        frame: &ExportFrame,
    ) -> Result<Result<SummedRecords, String>, ExportError> {
        let (mut entries, mut digest, mut study) = (Vec::new(), None, None);
        let understood = match frame.kind {
            FrameKind::Records => entries_of(&frame.table).map(|found| entries = found),
            FrameKind::Study => digest_of(&frame.table).map(|(found, name)| {
                digest = Some(found);
                study = Some(String::from_utf8_lossy(name).into_owned());
            }),
            FrameKind::Blob => digest_of(&frame.table).map(|(found, _)| digest = Some(found)),
            _ => Ok(()),
        };
        if let Err(reason) = understood {
            return Ok(Err(reason));
        }
        let written = |source| ExportError::io("write", &self.path, source);
        let head = frame.head;
        let mut position = self.end;
        let mut put = |bytes: &[u8]| {
            let outcome = self.file.write_all_at(bytes, position);
            position += bytes.len() as u64;
            outcome
        };
        put(&head.to_bytes()).and_then(|()| put(&frame.table)).map_err(written)?;
        let (mut sum, mut piece) = (BodySum::new(), vec![0; PIECE]);
        let (mut from, mut left) = (frame.body_start(), head.body_length);
        let is_records = frame.kind == FrameKind::Records
            && head.body_length <= zstd::zstd_safe::compress_bound(FRAME_LIMIT) as u64;
        let mut body = Vec::new();
        while left > 0 {
            let count = PIECE.min(usize::try_from(left).unwrap_or(PIECE));
            match earlier.read_exact_at(&mut piece[..count], from) {
                // The checksum tells that something is missing.
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => break,
                read => read.map_err(|source| ExportError::io("read", &self.path, source))?,
            }
            sum.add(&piece[..count]);
            put(&piece[..count]).map_err(written)?;
            if is_records {
                body.extend_from_slice(&piece[..count]);
            }
            from += count as u64;
            left -= count as u64;
        }
        let records = match sum.get() == head.body_sum {
            true => records_in(&entries, &body),
            false => Err("differs from what was written".to_owned()),
        };
        let records = match records {
            Ok(records) => records,
            Err(reason) => {
                // The next frame is written over it.
                self.file.set_len(self.end).map_err(written)?;
                return Ok(Err(reason));
            }
        };
        self.end = position;
        self.blobs.extend(digest);
        if let (Some(name), Some(digest)) = (study, digest) {
            self.studies.insert(name, digest);
        }
        Ok(Ok(records))
    }

    /// Lets the file take its place, durably. Leftovers of writers that were killed before that are
    /// removed; a writer that is just going on with the same file fails then.
    pub(crate) fn settle(&mut self) -> Result<(), ExportError> {
        self.write_records()?;
        let failed = |source| ExportError::io("write", &self.path, source);
        self.file.sync_all().map_err(failed)?;
        let Some(temporary) = self.temporary.take() else { return Ok(()) };
        if let Err(refused) = temporary.persist(&self.path) {
            if refused.error.kind() == io::ErrorKind::NotFound {
                return Err(ExportError::TakenOver { path: self.path.clone() });
            }
            return Err(failed(refused.error));
        }
        let directory = directory_of(&self.path);
        let prefix = unfinished_prefix(&self.path);
        for entry in fs::read_dir(directory).map_err(failed)?.filter_map(Result::ok) {
            // What follows is random and has no dot, so other names are not taken for ours.
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.strip_prefix(&prefix).is_some_and(|rest| !rest.contains('.')) {
                // Whoever else removes it at this moment does the same.
                let _ = fs::remove_file(entry.path());
            }
        }
        durable::sync_directory(directory).map_err(failed)
    }

    /// Returns the path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the number of records that were added, whether they are of one job or of several.
    pub(crate) fn added(&self) -> usize {
        self.added
    }

    /// Returns true if the file has the blob.
    pub(crate) fn has_blob(&self, digest: &Digest) -> bool {
        self.blobs.contains(digest)
    }

    /// Returns the digest of the definition of a study that the file has.
    pub(super) fn study(&self, name: &str) -> Option<&Digest> {
        self.studies.get(name)
    }

    /// Adds the definition of a study. Nothing happens if it is there already.
    ///
    /// # Errors
    /// [`ExportError::StudyDiffers`] if there is another definition under the name, and others if
    /// the system refuses.
    pub(crate) fn put_study(&mut self, name: &str, definition: &[u8]) -> Result<(), ExportError> {
        let digest = Digest::of(definition);
        match self.studies.get(name) {
            Some(found) if *found == digest => return Ok(()),
            Some(_) => {
                let (path, name) = (self.path.clone(), name.to_owned());
                return Err(ExportError::StudyDiffers { path, name });
            }
            None => {}
        }
        let table = [&digest.0[..], name.as_bytes()].concat();
        let body = zstd::bulk::compress(definition, LEVEL)
            .map_err(|source| ExportError::io("write", &self.path, source))?;
        self.add_frame(FrameKind::Study, &table, &body)?;
        self.studies.insert(name.to_owned(), digest);
        self.blobs.insert(digest);
        Ok(())
    }

    /// Adds a record without the blobs that it refers to.
    pub(crate) fn put_record(&mut self, key: &JobKey, record: &[u8]) -> Result<(), ExportError> {
        self.gather(key, record)?;
        self.write_large()
    }

    /// Adds a record to the frame that is being gathered. It stays there if that cannot be written.
    pub(super) fn gather(&mut self, key: &JobKey, record: &[u8]) -> Result<(), ExportError> {
        if record.len() > STORED_LIMIT {
            return Err(ExportError::TooLarge { key: *key, bytes: record.len() });
        }
        // What could not be written last time is tried before it grows.
        self.write_large()?;
        add_entry(&mut self.table, key, record.len());
        self.records.extend_from_slice(record);
        self.added += 1;
        Ok(())
    }

    /// Writes the frame that is being gathered if it is large enough.
    pub(super) fn write_large(&mut self) -> Result<(), ExportError> {
        let is_large = self.records.len() >= FRAME_TARGET
            || self.table.len() >= RECORDS_PER_FRAME * TABLE_ENTRY;
        if is_large { self.write_records() } else { Ok(()) }
    }

    /// Adds a blob of `source`, as it is compressed there, and returns true unless it is there
    /// already.
    pub(crate) fn put_blob(
        &mut self,
        digest: &Digest,
        source: &Blobs,
    ) -> Result<bool, ExportError> {
        if self.has_blob(digest) {
            return Ok(false);
        }
        let size = source.compressed_size(digest)?.ok_or_else(|| source.missing(digest))?;
        let head = FrameHead::new(FrameKind::Blob, &digest.0, size.length, size.sum);
        let mut target = AtPosition { file: &self.file, position: self.end };
        let outcome = target
            .write_all(&head.to_bytes())
            .and_then(|()| target.write_all(&digest.0))
            .and_then(|()| source.copy_compressed(digest, &size, &mut target));
        if let Ok(Err(fault)) = outcome {
            // The next frame is written over what there is of this one.
            let _ = self.file.set_len(self.end);
            return Err(ExportError::Blob(fault));
        }
        self.settled(outcome.map(drop), head.frame_length())?;
        self.blobs.insert(*digest);
        Ok(true)
    }

    /// Keeps a note about the state of whoever writes; the last one counts. It is written by the
    /// next [`flush`](ExportAppender::flush), which refuses one of more than a quarter of a MiB.
    pub(crate) fn note(&mut self, state: &[u8]) {
        let is_new = self.written_note.as_deref() != Some(state);
        self.note = is_new.then(|| state.to_owned());
    }

    fn write_note(&mut self) -> Result<(), ExportError> {
        if let Some(note) = self.note.take() {
            if note.len() > NOTE_LIMIT {
                let reason = format!("a note has {} bytes and may have {NOTE_LIMIT}", note.len());
                return Err(ExportError::Impossible { path: self.path.clone(), reason });
            }
            if let Err(error) = self.add_frame(FrameKind::Note, &note, &[]) {
                self.note = Some(note);
                return Err(error);
            }
            self.written_note = Some(note);
        }
        Ok(())
    }

    /// Says that the results of a shard are in the file, which is not that of the shard itself.
    pub(crate) fn put_part(&mut self, part: &ShardState) -> Result<(), ExportError> {
        let table =
            part_table(part).map_err(|source| ExportError::io("write", &self.path, source))?;
        self.add_frame(FrameKind::Part, &table, &[])
    }

    /// Says that the file is whole, with the number of `jobs` that have a record in it.
    pub(crate) fn write_end(&mut self, jobs: usize) -> Result<(), ExportError> {
        self.write_records()?;
        self.write_note()?;
        let table: Vec<u8> = [jobs, self.studies.len(), self.blobs.len()]
            .iter()
            .flat_map(|count| (*count as u64).to_le_bytes())
            .collect();
        self.add_frame(FrameKind::End, &table, &[])
    }

    /// Writes everything that was added. Once it has returned `Ok`, it survives a kill and a power
    /// failure.
    ///
    /// # Errors
    /// [`ExportError::Full`] if there is no room: the file then ends with the last frame that had
    /// room, and flushing may be tried again. [`ExportError::TakenOver`] if another process has
    /// gone on with the file.
    pub(crate) fn flush(&mut self) -> Result<(), ExportError> {
        self.write_records()?;
        self.write_note()?;
        let failed = |source| ExportError::io("write", &self.path, source);
        self.file.sync_data().map_err(failed)?;
        if self.temporary.is_some() {
            return Ok(());
        }
        let file = self.file.metadata().map_err(failed)?;
        match fs::symlink_metadata(&self.path) {
            Ok(found) if (found.dev(), found.ino()) == (file.dev(), file.ino()) => Ok(()),
            Ok(_) => Err(ExportError::TakenOver { path: self.path.clone() }),
            Err(error) => Err(ExportError::io("find", &self.path, error)),
        }
    }

    fn write_records(&mut self) -> Result<(), ExportError> {
        if self.table.is_empty() {
            return Ok(());
        }
        let body = zstd::bulk::compress(&self.records, LEVEL)
            .map_err(|source| ExportError::io("write", &self.path, source))?;
        let table = std::mem::take(&mut self.table);
        let outcome = self.add_frame(FrameKind::Records, &table, &body);
        match outcome {
            Ok(()) => self.records.clear(),
            Err(_) => self.table = table,
        }
        outcome
    }

    fn add_frame(&mut self, kind: FrameKind, table: &[u8], body: &[u8]) -> Result<(), ExportError> {
        if table.len() > TABLE_LIMIT {
            let reason = format!("a table of {} bytes is longer than any", table.len());
            return Err(ExportError::Impossible { path: self.path.clone(), reason });
        }
        let head = FrameHead::new(kind, table, body.len() as u64, BodySum::of(body));
        let frame = [&head.to_bytes()[..], table, body].concat();
        let outcome = self.file.write_all_at(&frame, self.end);
        self.settled(outcome, (HEAD + table.len() + body.len()) as u64)
    }

    /// Moves the end behind a frame that was written, or takes back the part that was.
    fn settled(&mut self, outcome: io::Result<()>, length: u64) -> Result<(), ExportError> {
        match outcome {
            Ok(()) => {
                self.end += length;
                Ok(())
            }
            Err(source) => {
                // A failure leaves the beginning of a frame, which no reader takes for one.
                let _ = self.file.set_len(self.end);
                Err(ExportError::io("write", &self.path, source))
            }
        }
    }
}

/// Returns the first bytes of the digest of a record. More would only take memory.
pub(super) fn short_digest(record: &[u8]) -> Checksum {
    let mut short = Checksum::default();
    short.copy_from_slice(&Digest::of(record).0[..16]);
    short
}

/// Returns the jobs of a frame and the digests of their records, or says what is wrong with it.
fn records_in(entries: &[TableEntry], body: &[u8]) -> Result<SummedRecords, String> {
    let content = content_of(entries, body)?;
    let record = |entry: &TableEntry| {
        let start = entry.offset as usize;
        (entry.key, short_digest(&content[start..start + entry.length as usize]))
    };
    Ok(entries.iter().map(record).collect())
}

/// A place in a file at which is written.
struct AtPosition<'f> {
    file: &'f File,
    position: u64,
}

impl Write for AtPosition<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write_at(bytes, self.position)?;
        self.position += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
