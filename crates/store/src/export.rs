//! This file writes exports: it starts one, or goes on with what is sound of an earlier one.
//!
//! Writing takes no locks and maps no memory, and nothing is written but at the end of the file, so
//! an export may lie on a parallel file system.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{FileExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use identity::{JobKey, STORED_LIMIT};
use tempfile::NamedTempFile;

use crate::access::{self, Wanted, inherit_owner};
use crate::blob::Blobs;
use crate::digest::Digest;
use crate::durable;
use crate::error::{OpenError, ReadError};
use crate::exports::{
    EXTENSION, ExportHeader, ExportSet, ShardState, open_export, part_table, require_possible,
};
use crate::frame::{
    BodySum, Checksum, EXPORT_FORMAT, ExportFrame, FRAME_LIMIT, FRAME_TARGET, FrameHead, FrameKind,
    FrameStep, FrameWalk, HEAD, MAGIC, PREAMBLE, RECORDS_PER_FRAME, TABLE_ENTRY, TABLE_LIMIT,
    TableEntry, add_entry, content_of, digest_of, entries_of,
};

/// The compression level, which is zstd's own default.
const LEVEL: i32 = 3;

/// The longest note \[bytes\].
const NOTE_LIMIT: usize = TABLE_LIMIT / 4;

/// The size of the pieces in which bodies are copied \[bytes\].
const PIECE: usize = 128 << 10;

/// The reason why an export cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The name of an export has an ending of its own.
    #[error(
        "an export is one file, whose name ends in .{EXTENSION}, and {} does not; `tribosweep store \
         merge STORE --into DIRECTORY` copies a store whole",
        .path.display()
    )]
    Name {
        /// The path that was named.
        path: PathBuf,
    },
    /// The file is the export of something else.
    #[error("{} holds {found}, and {wanted} was to be written there; name another file", .path.display())]
    OtherShard {
        /// The path of the file.
        path: PathBuf,
        /// The content of the file in words.
        found: String,
        /// The content that was to be written, in words.
        wanted: String,
    },
    /// There is another definition of the study in the file.
    #[error(
        "{} holds another study called {name:?}; name another file, or rename one of the studies",
        .path.display()
    )]
    StudyDiffers {
        /// The path of the file.
        path: PathBuf,
        /// The name of the study.
        name: String,
    },
    /// The words about a file are too long, or they cannot be.
    #[error("{} cannot be written: {reason}", .path.display())]
    Impossible {
        /// The path of the file.
        path: PathBuf,
        /// The reason in words.
        reason: String,
    },
    /// A record is larger than [`STORED_LIMIT`].
    #[error("the record of job {key} has {bytes} bytes, and a record may have {STORED_LIMIT}")]
    TooLarge {
        /// The job of the record.
        key: JobKey,
        /// The size of the record \[bytes\].
        bytes: usize,
    },
    /// Another process goes on with the file, and this one writes to one without a name.
    #[error(
        "another process has gone on with {}; what it does not find there it computes again",
        .path.display()
    )]
    TakenOver {
        /// The path of the file.
        path: PathBuf,
    },
    /// Another process has put a file there since this one read it.
    #[error(
        "another process has written {} meanwhile, and nothing was merged into it; merge again",
        .path.display()
    )]
    Changed {
        /// The path of the file.
        path: PathBuf,
    },
    /// The disk is full. What was flushed before is there.
    #[error(
        "there is no room for {}: {source}; make room and run the same again, nothing that was done \
         is lost",
        .path.display()
    )]
    Full {
        /// The path of the file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// There is something else in the place of the file.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A blob cannot be read.
    #[error(transparent)]
    Blob(#[from] ReadError),
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// The attempted action.
        action: &'static str,
        /// The path of the action.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

impl ExportError {
    fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        match source.kind() {
            io::ErrorKind::StorageFull
            | io::ErrorKind::QuotaExceeded
            | io::ErrorKind::FileTooLarge => ExportError::Full { path, source },
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                ExportError::Open(OpenError::io(action, Wanted::Write, &path, source))
            }
            _ => ExportError::Io { action, path, source },
        }
    }
}

/// An export that is being written. Records are gathered into frames, which are written when they
/// are large enough or by [`flush`](ExportWriter::flush).
pub struct ExportWriter {
    path: PathBuf,
    file: File,
    /// The name of the file as long as it has not taken its place.
    temporary: Option<tempfile::TempPath>,
    /// The end of the last whole frame \[bytes\].
    end: u64,
    /// The beginning of the digest of the last record of each job.
    records_of: HashMap<JobKey, Checksum>,
    blobs: HashSet<Digest>,
    studies: BTreeMap<String, Digest>,
    /// The table and the records of the frame that is being gathered.
    table: Vec<u8>,
    records: Vec<u8>,
    /// The last note that was given, unless it is in the file already.
    note: Option<Vec<u8>>,
    written_note: Option<Vec<u8>>,
    damage: Vec<String>,
}

/// Refuses a path whose name does not end like that of an export.
fn require_name(path: &Path) -> Result<(), ExportError> {
    match path.extension().is_some_and(|extension| extension == EXTENSION) {
        true => Ok(()),
        false => Err(ExportError::Name { path: path.to_owned() }),
    }
}

/// Returns the directory of a file.
fn directory_of(path: &Path) -> &Path {
    path.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the beginning of the name of a file that is to take the place of `path`.
fn unfinished_prefix(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!("{}{name}-", durable::UNFINISHED_PREFIX)
}

fn described(header: &ExportHeader) -> String {
    header
        .shard
        .as_ref()
        .map_or_else(|| "an export that is not of a shard".to_owned(), ToString::to_string)
}

impl ExportWriter {
    /// Starts the file, or goes on with it: what is sound of an existing file is copied into a new
    /// one that takes its place. So a writer that still lives elsewhere writes to a file without a
    /// name, and finds that out when it flushes. The earlier note is not copied. The directory is
    /// created if it is absent.
    ///
    /// # Errors
    /// [`ExportError::Name`] if the name does not end as it must, [`ExportError::OtherShard`] if
    /// the file is that of another shard, [`ExportError::Open`] if it is one of another format or
    /// no file, and others if the system refuses. A file that is no export is put aside, as
    /// [`damage`](ExportWriter::damage) says.
    pub fn open(path: &Path, header: &ExportHeader) -> Result<ExportWriter, ExportError> {
        let mut writer = Self::beside(path, header)?;
        if durable::is_present(path) {
            writer.take_over(path, header)?;
        }
        writer.settle()?;
        Ok(writer)
    }

    /// Starts a file that takes the place of `path` when it is [settled](ExportWriter::settle).
    pub(crate) fn beside(path: &Path, header: &ExportHeader) -> Result<ExportWriter, ExportError> {
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
        let mut writer = ExportWriter {
            path: path.to_owned(),
            file,
            temporary: Some(temporary),
            end: PREAMBLE,
            records_of: HashMap::new(),
            blobs: HashSet::new(),
            studies: BTreeMap::new(),
            table: Vec::new(),
            records: Vec::new(),
            note: None,
            written_note: None,
            damage: Vec::new(),
        };
        let preamble = [&MAGIC[..], &EXPORT_FORMAT.to_le_bytes()].concat();
        writer.file.write_all_at(&preamble, 0).map_err(failed)?;
        let words = serde_json::to_vec(header).map_err(|error| failed(error.into()))?;
        writer.add_frame(FrameKind::Header, &words, &[])?;
        Ok(writer)
    }

    /// Copies what is sound of an earlier export.
    fn take_over(&mut self, path: &Path, header: &ExportHeader) -> Result<(), ExportError> {
        let failed = |source| ExportError::io("go on with", path, source);
        let (earlier, damage) = match open_export(path) {
            // What is there is kept, and is in nobody's way.
            Err(OpenError::NotAnExport { reason, .. }) if durable::is_file(path) => {
                let aside = durable::put_aside(path).map_err(failed)?;
                let aside = aside.unwrap_or_default();
                let aside = aside.file_name().unwrap_or_default().to_string_lossy();
                self.damage.push(format!(
                    "what was there is no export ({reason}) and is put aside as {aside}"
                ));
                return Ok(());
            }
            opened => opened?,
        };
        self.damage.extend(damage);
        let length = earlier.metadata().map_err(failed)?.len();
        let mut walk = FrameWalk::new(&earlier, length);
        while let Some(step) = walk.next_step().map_err(failed)? {
            let frame = match step {
                FrameStep::Frame(frame) => frame,
                FrameStep::Damaged(reason) => {
                    self.damage.push(reason);
                    continue;
                }
                FrameStep::Unfinished(_) => continue,
            };
            match frame.kind {
                FrameKind::Header => {
                    let Ok(found) = serde_json::from_slice::<ExportHeader>(&frame.table) else {
                        continue;
                    };
                    if found.shard != header.shard {
                        return Err(ExportError::OtherShard {
                            path: path.to_owned(),
                            found: described(&found),
                            wanted: described(header),
                        });
                    }
                }
                // Whoever goes on says anew how far it is, so the shard counts as unfinished until
                // then.
                FrameKind::Note | FrameKind::End => {}
                FrameKind::Study | FrameKind::Records | FrameKind::Blob | FrameKind::Part => {
                    if let Err(reason) = self.copy_frame(&earlier, &frame)? {
                        let start = frame.start;
                        self.damage.push(format!("the frame at byte {start} {reason}"));
                    }
                }
            }
        }
        Ok(())
    }

    /// Copies a frame of an earlier export, or says what is wrong with it. Nothing of it stays
    /// then.
    fn copy_frame(
        &mut self,
        earlier: &File,
        frame: &ExportFrame,
    ) -> Result<Result<(), String>, ExportError> {
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
        if understood.is_err() {
            return Ok(understood);
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
        self.records_of.extend(records);
        self.blobs.extend(digest);
        if let (Some(name), Some(digest)) = (study, digest) {
            self.studies.insert(name, digest);
        }
        Ok(Ok(()))
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
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the damage of the earlier file that was left out, in words.
    pub fn damage(&self) -> &[String] {
        &self.damage
    }

    /// Returns true if the file has a record of the job.
    pub fn contains(&self, key: &JobKey) -> bool {
        self.records_of.contains_key(key)
    }

    /// Returns true if the last record of the job in the file has these very bytes.
    pub fn holds(&self, key: &JobKey, record: &[u8]) -> bool {
        self.records_of.get(key) == Some(&short_digest(record))
    }

    /// Returns true if the file has the blob.
    pub fn has_blob(&self, digest: &Digest) -> bool {
        self.blobs.contains(digest)
    }

    /// Returns the number of jobs that have a record in the file.
    pub fn len(&self) -> usize {
        self.records_of.len()
    }

    /// Returns true if the file has no record.
    pub fn is_empty(&self) -> bool {
        self.records_of.is_empty()
    }

    /// Adds the definition of a study. Nothing happens if it is there already.
    ///
    /// # Errors
    /// [`ExportError::StudyDiffers`] if there is another definition under the name, and others if
    /// the system refuses.
    pub fn put_study(&mut self, name: &str, definition: &[u8]) -> Result<(), ExportError> {
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

    /// Returns the definition of a study that the file has.
    ///
    /// # Errors
    /// [`ExportError::Open`] if the file cannot be read any more, [`ExportError::Blob`] if the
    /// definition is damaged.
    pub fn study(&self, name: &str) -> Result<Option<Vec<u8>>, ExportError> {
        let Some(digest) = self.studies.get(name) else { return Ok(None) };
        let Some(set) = ExportSet::open(&self.path, None)? else { return Ok(None) };
        Ok(Some(Blobs::in_exports(set).definition(name, digest)?))
    }

    /// Adds the record of a job, after the blobs of `source` that it refers to and that are not in
    /// the file yet. A later record of a job takes the place of an earlier one.
    ///
    /// # Errors
    /// [`ExportError::TooLarge`] if the record may not be kept, [`ExportError::Blob`] if a blob is
    /// missing or damaged, and others if the system refuses.
    pub fn append(
        &mut self,
        key: &JobKey,
        record: &[u8],
        source: &Blobs,
        references: impl IntoIterator<Item = Digest>,
    ) -> Result<(), ExportError> {
        for digest in references {
            self.put_blob(&digest, source)?;
        }
        self.put_record(key, record)
    }

    /// Adds a blob of `source` that goes along with records, and returns whether the file has it
    /// now: one that is missing or damaged there is left out.
    ///
    /// # Errors
    /// The system refuses.
    pub fn accompany(&mut self, digest: &Digest, source: &Blobs) -> Result<bool, ExportError> {
        match self.put_blob(digest, source) {
            Ok(_) => Ok(true),
            Err(ExportError::Blob(_)) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Adds a record without the blobs that it refers to.
    pub(crate) fn put_record(&mut self, key: &JobKey, record: &[u8]) -> Result<(), ExportError> {
        if record.len() > STORED_LIMIT {
            return Err(ExportError::TooLarge { key: *key, bytes: record.len() });
        }
        // What could not be written last time is tried before it grows.
        if self.is_large() {
            self.write_records()?;
        }
        add_entry(&mut self.table, key, record.len());
        self.records.extend_from_slice(record);
        self.records_of.insert(*key, short_digest(record));
        if self.is_large() { self.write_records() } else { Ok(()) }
    }

    /// Returns true if the frame that is being gathered is large enough.
    fn is_large(&self) -> bool {
        self.records.len() >= FRAME_TARGET || self.table.len() >= RECORDS_PER_FRAME * TABLE_ENTRY
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
    /// next [`flush`](ExportWriter::flush), which refuses one of more than a quarter of a MiB.
    pub fn note(&mut self, state: &[u8]) {
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

    /// Says that the file is whole, durably.
    ///
    /// # Errors
    /// Those of [`flush`](ExportWriter::flush).
    pub fn close(&mut self) -> Result<(), ExportError> {
        self.write_end()?;
        self.flush()
    }

    pub(crate) fn write_end(&mut self) -> Result<(), ExportError> {
        self.write_records()?;
        self.write_note()?;
        let table: Vec<u8> = [self.records_of.len(), self.studies.len(), self.blobs.len()]
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
    pub fn flush(&mut self) -> Result<(), ExportError> {
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
fn short_digest(record: &[u8]) -> Checksum {
    let mut short = Checksum::default();
    short.copy_from_slice(&Digest::of(record).0[..16]);
    short
}

/// Returns the jobs of a frame and the digests of their records, or says what is wrong with it.
fn records_in(entries: &[TableEntry], body: &[u8]) -> Result<Vec<(JobKey, Checksum)>, String> {
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
