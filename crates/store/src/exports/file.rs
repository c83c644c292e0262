//! This file makes the index of one export, and reads its records and blobs.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::Path;

use identity::JobKey;

use crate::access::{self, Wanted};
use crate::digest::Digest;
use crate::error::OpenError;
use crate::exports::shard::{part_of, require_possible};
use crate::exports::summary::{ExportHeader, ExportSummary};
use crate::frame::{
    BodySum, Checksum, EXPORT_FORMAT, ExportFrame, FRAME_LIMIT, FrameKind, FrameStep, FrameWalk,
    MAGIC, PREAMBLE, digest_of, entries_of,
};
use crate::rules::MergeRules;

/// The ending of the name of every export.
pub(crate) const EXTENSION: &str = "tribosweep";

/// The number of exports that stay open while they are read. Others are opened again for every
/// frame, because a process may have few files open and a study many shards.
const OPEN_FILES: usize = 128;

/// The place of a record in a set of exports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordPlace {
    pub(crate) key: JobKey,
    /// The number of the file in the set.
    pub(crate) file: u32,
    /// The number of the frame in the file.
    pub(crate) frame: u32,
    pub(super) offset: u32,
    pub(super) length: u32,
}

/// The place of a body in an export.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyPlace {
    start: u64,
    length: u64,
    sum: Checksum,
    /// The place of the frame, for words.
    frame: u64,
    /// The length of the records in it when it is decompressed \[bytes\].
    content: u32,
}

/// The index of one export.
#[derive(Debug)]
pub(crate) struct ExportFile {
    pub(crate) summary: ExportSummary,
    /// The bodies of records.
    pub(super) frames: Vec<BodyPlace>,
    pub(crate) blobs: BTreeMap<Digest, BlobPlace>,
    pub(crate) studies: BTreeMap<String, Digest>,
    file: Option<File>,
    identity: FileIdentity,
}

/// The place of a blob in an export.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlobPlace(BodyPlace);

impl BlobPlace {
    pub(crate) fn length(&self) -> u64 {
        self.0.length
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FileIdentity {
    device: u64,
    inode: u64,
}

impl FileIdentity {
    fn of(file: &File) -> io::Result<Self> {
        let found = file.metadata()?;
        Ok(FileIdentity { device: found.dev(), inode: found.ino() })
    }

    /// Returns the identity of what is at `path`, or `None` if nothing can be seen there.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        let found = fs::symlink_metadata(path).ok()?;
        Some(FileIdentity { device: found.dev(), inode: found.ino() })
    }
}

/// Returns true if the file begins like an export.
pub(crate) fn is_export(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    let read = access::open_to_read(path).and_then(|file| file.read_exact_at(&mut magic, 0));
    path.extension().is_some_and(|extension| extension == EXTENSION)
        || read.is_ok() && magic == *MAGIC
}

/// Opens an export and checks what stands before its first frame. If that is damaged and the frames
/// are there, the damage is returned in words.
pub(crate) fn open_export(path: &Path) -> Result<(File, Option<String>), OpenError> {
    let failed = |source| OpenError::io("read", Wanted::Read, path, source);
    let not_one =
        |reason: &str| OpenError::NotAnExport { path: path.to_owned(), reason: reason.to_owned() };
    let file = match access::open_to_read(path) {
        Err(error) if access::is_damage(&error) => return Err(not_one(&error.to_string())),
        opened => opened.map_err(failed)?,
    };
    if file.metadata().map_err(failed)?.len() < PREAMBLE {
        return Err(not_one("it is shorter than its first line"));
    }
    let mut preamble = [0; PREAMBLE as usize];
    file.read_exact_at(&mut preamble, 0).map_err(failed)?;
    let (magic, version) = preamble.split_at(MAGIC.len());
    let is_sound = magic == MAGIC && version == EXPORT_FORMAT.to_le_bytes();
    let is_named = path.extension().is_some_and(|extension| extension == EXTENSION);
    if !is_sound && is_named && FrameWalk::new(&file, 0).begins_with_frame() {
        return Ok((file, Some("its first line differs from what was written".to_owned())));
    }
    if magic != MAGIC {
        return Err(not_one("it begins with other words"));
    }
    let found = version.try_into().map_or(0, u16::from_le_bytes);
    if found != EXPORT_FORMAT {
        return Err(OpenError::ExportFormat { path: path.to_owned(), found });
    }
    Ok((file, None))
}

impl ExportFile {
    /// Returns the index of a file of which nothing has been read.
    fn empty(path: &Path, damage: Vec<String>) -> Self {
        ExportFile {
            summary: ExportSummary {
                path: path.to_owned(),
                header: ExportHeader::default(),
                records: 0,
                note: None,
                parts: Vec::new(),
                changed: None,
                is_closed: false,
                is_readable: true,
                unfinished: 0,
                damage,
            },
            frames: Vec::new(),
            blobs: BTreeMap::new(),
            studies: BTreeMap::new(),
            file: None,
            identity: FileIdentity { device: 0, inode: 0 },
        }
    }

    /// Returns the index of a file that cannot be read.
    pub(super) fn unreadable(path: &Path, error: &OpenError) -> Self {
        let reason = match error {
            OpenError::NotAnExport { reason, .. } => format!("it is not an export: {reason}"),
            OpenError::ExportFormat { found, .. } => {
                format!("it has format {found}, and this program reads format {EXPORT_FORMAT}")
            }
            OpenError::Refused { why, .. } => why.clone(),
            OpenError::Io { source, .. } => source.to_string(),
            other => other.to_string(),
        };
        let mut file = ExportFile::empty(path, vec![format!("nothing of it is read: {reason}")]);
        file.summary.is_readable = false;
        file
    }

    /// Reads the index of an export, which is the `number`-th of its set, and adds the places of
    /// its records.
    pub(crate) fn open(
        path: &Path,
        number: u32,
        places: &mut Vec<RecordPlace>,
        rules: Option<&MergeRules>,
    ) -> Result<Self, OpenError> {
        let failed = |source| OpenError::io("read", Wanted::Read, path, source);
        let (file, damage) = open_export(path)?;
        let metadata = file.metadata().map_err(failed)?;
        let mut index = ExportFile::empty(path, damage.into_iter().collect());
        index.summary.changed = metadata.modified().ok();
        index.identity = FileIdentity::of(&file).map_err(failed)?;
        let mut found = Vec::new();
        let mut walk = FrameWalk::new(&file, metadata.len());
        let (mut has_header, mut end) = (false, None);
        while let Some(step) = walk.next_step().map_err(failed)? {
            let frame = match step {
                FrameStep::Frame(frame) => frame,
                FrameStep::Damaged(reason) => {
                    index.summary.damage.push(reason);
                    index.summary.is_closed = false;
                    continue;
                }
                FrameStep::Unfinished(length) => {
                    index.summary.unfinished = length;
                    index.summary.is_closed = false;
                    continue;
                }
            };
            has_header |= frame.kind == FrameKind::Header;
            index.summary.is_closed = frame.kind == FrameKind::End;
            end = index.summary.is_closed.then(|| frame.table.clone());
            if let Err(reason) = index.add(&frame, number, &mut found) {
                let start = frame.start;
                index.summary.damage.push(format!("the frame at byte {start} {reason}"));
            }
        }
        if !has_header && index.summary.damage.is_empty() {
            index.summary.damage.push("it has no header".to_owned());
        }
        // The last record of a job counts.
        found.sort_by_key(|place| place.key);
        found.dedup_by(|later, earlier| {
            let is_same = later.key == earlier.key;
            if is_same {
                *earlier = *later;
            }
            is_same
        });
        index.summary.records = found.len();
        let counts = end.filter(|_| index.summary.is_closed).map(|end| index.require_counts(&end));
        let is_all_there = matches!(counts, Some(Ok(())));
        if index.summary.damage.is_empty()
            && let Some(Err(reason)) = counts
        {
            index.summary.damage.push(reason);
        }
        if let Some(rules) = rules {
            index.believe(is_all_there, rules);
        }
        places.append(&mut found);
        if (number as usize) < OPEN_FILES {
            index.file = Some(file);
        }
        Ok(index)
    }

    fn add(
        &mut self,
        frame: &ExportFrame,
        number: u32,
        places: &mut Vec<RecordPlace>,
    ) -> Result<(), String> {
        let mut body = BodyPlace {
            start: frame.body_start(),
            length: frame.head.body_length,
            sum: frame.head.body_sum,
            frame: frame.start,
            content: 0,
        };
        match frame.kind {
            FrameKind::Header => {
                let header: ExportHeader = serde_json::from_slice(&frame.table)
                    .map_err(|error| format!("has a header that cannot be read: {error}"))?;
                if let Some(shard) = &header.shard {
                    require_possible(shard)?;
                }
                self.summary.header = header;
            }
            FrameKind::Study => {
                let (digest, name) = digest_of(&frame.table)?;
                let name = std::str::from_utf8(name)
                    .map_err(|_| "has the name of a study that is no text".to_owned())?;
                self.studies.insert(name.to_owned(), digest);
                self.blobs.insert(digest, BlobPlace(body));
            }
            FrameKind::Records => {
                let entries = entries_of(&frame.table)?;
                body.content = entries.last().map_or(0, |last| last.offset + last.length);
                let frame = self.frames.len() as u32;
                self.frames.push(body);
                places.extend(entries.into_iter().map(|entry| RecordPlace {
                    key: entry.key,
                    file: number,
                    frame,
                    offset: entry.offset,
                    length: entry.length,
                }));
            }
            FrameKind::Blob => {
                let (digest, _) = digest_of(&frame.table)?;
                self.blobs.insert(digest, BlobPlace(body));
            }
            FrameKind::Note => self.summary.note = Some(frame.table.clone()),
            FrameKind::Part => self.summary.parts.push(part_of(&frame.table)?),
            FrameKind::End => {}
        }
        Ok(())
    }

    /// Takes for unfinished what the file says is finished, if results of it may be lost.
    fn believe(&mut self, is_all_there: bool, rules: &MergeRules) {
        let ExportSummary { note, parts, damage, .. } = &mut self.summary;
        let claimed = |note: &mut Vec<u8>| *note = (rules.unfinished)(note);
        if !is_all_there {
            note.iter_mut().for_each(claimed);
        }
        // A merged file is named when it is whole, with its parts after their records.
        if !is_all_there && !damage.is_empty() {
            parts.iter_mut().filter_map(|part| part.note.as_mut()).for_each(claimed);
        }
    }

    /// Holds the numbers in the last frame against what was found.
    fn require_counts(&self, end: &[u8]) -> Result<(), String> {
        let found = [self.summary.records, self.studies.len(), self.blobs.len()];
        let (counts, _) = end.as_chunks::<8>();
        let said: Vec<u64> = counts.iter().map(|count| u64::from_le_bytes(*count)).collect();
        if said.iter().copied().eq(found.iter().map(|count| *count as u64)) {
            return Ok(());
        }
        Err(format!(
            "{} records, {} studies and {} files can be found of the {said:?} that were written",
            found[0], found[1], found[2]
        ))
    }

    pub(crate) fn path(&self) -> &Path {
        &self.summary.path
    }

    /// Calls `read` with the file. One that is not kept open is opened again, and must be the same.
    fn with_file<T>(&self, read: impl FnOnce(&File) -> io::Result<T>) -> io::Result<T> {
        if let Some(file) = &self.file {
            return read(file);
        }
        let file = access::open_to_read(self.path())?;
        if FileIdentity::of(&file)? != self.identity {
            let reason = "its run was started again while it was read; ask again";
            return Err(io::Error::new(io::ErrorKind::Interrupted, reason));
        }
        read(&file)
    }

    /// Returns the records of a frame, one after the other.
    ///
    /// # Errors
    /// The reason in words why the frame cannot be read.
    pub(super) fn content(&self, frame: u32) -> Result<Vec<u8>, String> {
        let body = self.frames.get(frame as usize).ok_or("it is in no frame")?;
        let differs = || format!("the frame at byte {} differs from what was written", body.frame);
        if body.length > zstd::zstd_safe::compress_bound(FRAME_LIMIT) as u64 {
            return Err(differs());
        }
        let mut bytes = vec![0; body.length as usize];
        self.with_file(|file| file.read_exact_at(&mut bytes, body.start))
            .map_err(|error| error.to_string())?;
        if BodySum::of(&bytes) != body.sum {
            return Err(differs());
        }
        if body.content == 0 {
            return Ok(Vec::new());
        }
        let content = zstd::bulk::decompress(&bytes, body.content as usize)
            .map_err(|error| format!("the frame at byte {}: {error}", body.frame))?;
        if content.len() != body.content as usize {
            return Err(differs());
        }
        Ok(content)
    }

    /// Returns a reader of the compressed bytes of a blob. Their checksum is not verified.
    pub(super) fn blob(&self, place: &BlobPlace) -> io::Result<BodyReader> {
        let file = match &self.file {
            Some(file) => file.try_clone()?,
            None => self.with_file(File::try_clone)?,
        };
        Ok(BodyReader { file, position: place.0.start, left: place.0.length })
    }
}

/// The compressed bytes of a blob in an export.
pub(super) struct BodyReader {
    file: File,
    position: u64,
    left: u64,
}

impl io::Read for BodyReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let wanted = buffer.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        let count = self.file.read_at(&mut buffer[..wanted], self.position)?;
        if count == 0 && wanted > 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.position += count as u64;
        self.left -= count as u64;
        Ok(count)
    }
}
