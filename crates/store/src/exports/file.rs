//! This file makes the index of one export, and reads its records and blobs.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::Path;
use std::sync::Arc;

use crate::access::{self, Wanted};
use crate::digest::Digest;
use crate::error::OpenError;
use crate::exports::shard::{part_of, require_possible};
use crate::exports::summary::{ExportHeader, ExportSummary};
use crate::frame::{
    BodySum, EXPORT_FORMAT, ExportFrame, FRAME_LIMIT, FrameKind, FrameStep, FrameWalk, MAGIC,
    PREAMBLE, TableEntry, content_of, digest_of, entries_of,
};
use crate::rules::MergeRules;
use crate::sorted::beginning;

/// The ending of the name of every export.
pub(crate) const EXTENSION: &str = "tribosweep";

/// The place of a frame of records in an export.
#[derive(Clone, Copy, Debug)]
struct RecordFrame {
    /// The place of its head \[bytes\].
    start: u64,
    /// The length of the whole frame \[bytes\].
    length: u64,
    /// The number of records in it.
    records: u32,
}

impl RecordFrame {
    /// Reads the table again, or says why it cannot be read.
    fn table(&self, file: &File) -> Result<(ExportFrame, Vec<TableEntry>), String> {
        let frame = FrameWalk::frame_at(file, self.start, self.length);
        let frame = frame.map_err(|error| error.to_string())?.ok_or_else(|| self.differs())?;
        let entries = entries_of(&frame.table).map_err(|reason| self.explained(&reason))?;
        match frame.kind == FrameKind::Records && entries.len() == self.records as usize {
            true => Ok((frame, entries)),
            false => Err(self.differs()),
        }
    }

    fn differs(&self) -> String {
        self.explained("differs from what was written")
    }

    fn explained(&self, reason: &str) -> String {
        format!("the frame at byte {} {reason}", self.start)
    }
}

/// The records of a frame as they were read.
pub(crate) struct FrameRecords {
    pub(crate) entries: Vec<TableEntry>,
    /// The records one after the other, or the reason why they cannot be read.
    content: Result<Vec<u8>, String>,
}

impl FrameRecords {
    /// Returns a record, or the reason why it cannot be read.
    pub(crate) fn record(&self, offset: u32, length: u32) -> Result<&[u8], String> {
        let content = self.content.as_ref().map_err(String::clone)?;
        let (start, length) = (offset as usize, length as usize);
        let record = content.get(start..start + length);
        record.ok_or_else(|| "it goes on after its frame".to_owned())
    }

    /// Says what is wrong with the frame, if anything is.
    pub(super) fn fault(self) -> Option<String> {
        self.content.err()
    }
}

/// The index of one export.
#[derive(Debug)]
pub(crate) struct ExportFile {
    pub(crate) summary: ExportSummary,
    /// The frames of records in the order in which they stand there.
    frames: Vec<RecordFrame>,
    pub(crate) blobs: BTreeMap<Digest, BlobPlace>,
    pub(crate) studies: BTreeMap<String, Digest>,
    file: Option<Arc<File>>,
    identity: FileIdentity,
}

/// The place of a blob in an export.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlobPlace {
    start: u64,
    length: u64,
}

impl BlobPlace {
    pub(crate) fn length(&self) -> u64 {
        self.length
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

    /// Reads what is in an export and where its frames are. The first eight bytes of the keys are
    /// kept while that goes on, and nothing of each record afterwards. The file stays open if it is
    /// to be `kept_open`.
    pub(super) fn open(
        path: &Path,
        kept_open: bool,
        rules: Option<&MergeRules>,
    ) -> Result<Self, OpenError> {
        let failed = |source| OpenError::io("read", Wanted::Read, path, source);
        let (file, damage) = open_export(path)?;
        let file = Arc::new(file);
        let metadata = file.metadata().map_err(failed)?;
        let mut index = ExportFile::empty(path, damage.into_iter().collect());
        index.summary.changed = metadata.modified().ok();
        index.identity = FileIdentity::of(&file).map_err(failed)?;
        let mut beginnings = Vec::new();
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
            if let Err(reason) = index.add(&frame, &mut beginnings) {
                let start = frame.start;
                index.summary.damage.push(format!("the frame at byte {start} {reason}"));
            }
        }
        if !has_header && index.summary.damage.is_empty() {
            index.summary.damage.push("it has no header".to_owned());
        }
        index.file = Some(file);
        index.count_jobs(beginnings);
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
        if !kept_open {
            index.file = None;
        }
        Ok(index)
    }

    /// Counts the jobs that have a record, by the `beginnings` of the keys of all records. Those
    /// that occur several times are told apart by their whole keys.
    fn count_jobs(&mut self, mut beginnings: Vec<u64>) {
        beginnings.sort_unstable();
        let repeats = beginnings.chunk_by(|one, next| one == next).filter(|same| same.len() > 1);
        let repeated: Vec<u64> = repeats.map(|same| same[0]).collect();
        beginnings.dedup();
        self.summary.records = beginnings.len() - repeated.len();
        drop(beginnings);
        if repeated.is_empty() {
            return;
        }
        let (mut keys, mut faults) = (Vec::new(), Vec::new());
        for table in self.tables() {
            match table {
                Ok(entries) => {
                    let found = entries.iter().map(|entry| entry.key);
                    keys.extend(
                        found.filter(|key| repeated.binary_search(&beginning(&key.0)).is_ok()),
                    );
                }
                Err(reason) => faults.push(reason),
            }
        }
        keys.sort_unstable();
        keys.dedup();
        self.summary.records += keys.len();
        self.summary.damage.extend(faults);
    }

    fn add(&mut self, frame: &ExportFrame, beginnings: &mut Vec<u64>) -> Result<(), String> {
        let body = BlobPlace { start: frame.body_start(), length: frame.head.body_length };
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
                self.blobs.insert(digest, body);
            }
            FrameKind::Records => {
                let entries = entries_of(&frame.table)?;
                self.frames.push(RecordFrame {
                    start: frame.start,
                    length: frame.head.frame_length(),
                    records: entries.len() as u32,
                });
                beginnings.extend(entries.iter().map(|entry| beginning(&entry.key.0)));
            }
            FrameKind::Blob => {
                let (digest, _) = digest_of(&frame.table)?;
                self.blobs.insert(digest, body);
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

    /// Returns the file. One that is not kept open is opened again, and must be the same.
    fn opened(&self) -> io::Result<Arc<File>> {
        if let Some(file) = &self.file {
            return Ok(file.clone());
        }
        let file = access::open_to_read(self.path())?;
        if FileIdentity::of(&file)? != self.identity {
            let reason = "its run was started again while it was read; ask again";
            return Err(io::Error::new(io::ErrorKind::Interrupted, reason));
        }
        Ok(Arc::new(file))
    }

    /// Returns the number of records in each frame, in the order in which the frames stand there. A
    /// job may have several records, of which the last one counts.
    pub(crate) fn frames(&self) -> impl ExactSizeIterator<Item = usize> {
        self.frames.iter().map(|frame| frame.records as usize)
    }

    /// Reads the tables of all frames again, each with the reason if it cannot be read.
    pub(crate) fn tables(&self) -> impl Iterator<Item = Result<Vec<TableEntry>, String>> {
        let file = self.opened().map_err(|error| error.to_string());
        self.frames.iter().map(move |frame| {
            let (_, entries) = frame.table(file.as_ref().map_err(String::clone)?)?;
            Ok(entries)
        })
    }

    /// Returns the records of a frame.
    ///
    /// # Errors
    /// The reason in words why not even its table can be read.
    pub(crate) fn records(&self, frame: usize) -> Result<FrameRecords, String> {
        let place = self.frames.get(frame).ok_or("it is in no frame")?;
        let file = self.opened().map_err(|error| error.to_string())?;
        let (frame, entries) = place.table(&file)?;
        let read = || -> Result<Vec<u8>, String> {
            if frame.head.body_length > zstd::zstd_safe::compress_bound(FRAME_LIMIT) as u64 {
                return Err(place.differs());
            }
            let mut body = vec![0; frame.head.body_length as usize];
            file.read_exact_at(&mut body, frame.body_start()).map_err(|error| error.to_string())?;
            if BodySum::of(&body) != frame.head.body_sum {
                return Err(place.differs());
            }
            content_of(&entries, &body).map_err(|reason| place.explained(&reason))
        };
        let content = read();
        Ok(FrameRecords { entries, content })
    }

    /// Returns a reader of the compressed bytes of a blob. Their checksum is not verified.
    pub(super) fn blob(&self, place: &BlobPlace) -> io::Result<BodyReader> {
        Ok(BodyReader { file: self.opened()?, position: place.start, left: place.length })
    }
}

/// The compressed bytes of a blob in an export.
pub(super) struct BodyReader {
    file: Arc<File>,
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
