//! This file reads exports: one file, or a directory of them that counts as one store.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::SystemTime;

use identity::JobKey;
use serde::{Deserialize, Serialize};

use crate::access::{self, Wanted};
use crate::digest::Digest;
use crate::error::{OpenError, ReadError};
use crate::frame::{
    BodySum, Checksum, EXPORT_FORMAT, ExportFrame, FRAME_LIMIT, FrameKind, FrameStep, FrameWalk,
    MAGIC, PREAMBLE, digest_of, entries_of,
};
use crate::rules::{Candidate, MergeRules, RecordChoice};

/// The ending of the name of every export.
pub(crate) const EXTENSION: &str = "tribosweep";

/// The number of exports that stay open while they are read. Others are opened again for every
/// frame, because a process may have few files open and a study many shards.
const OPEN_FILES: usize = 128;

/// The largest number of shards that a study may be in. What is missing is listed one by one.
pub const SHARD_LIMIT: u32 = 1 << 16;

/// The first words of an export: whose it is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExportHeader {
    /// The version of the program that began it.
    pub program: String,
    /// The shard whose results it holds, if it is that of a shard.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardName>,
}

/// The name of a shard: a part of a study that one machine computes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ShardName {
    /// The name of the study.
    pub study: String,
    /// The number of the shard, counted from 1.
    pub index: u32,
    /// The number of shards that the study is in.
    pub count: u32,
}

impl std::fmt::Display for ShardName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "shard {}/{} of the study `{}`", self.index, self.count, self.study)
    }
}

/// A shard whose results are in a file, and how far it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardState {
    /// The shard.
    pub shard: ShardName,
    /// The last note that the shard left.
    pub note: Option<Vec<u8>>,
}

/// An export as a reader found it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportSummary {
    /// The path of the file.
    pub path: PathBuf,
    /// The header of the file; that of nobody if the header is damaged.
    pub header: ExportHeader,
    /// The number of jobs that have a record in the file.
    pub records: usize,
    /// The last note that the writer left. A reader that has [rules](MergeRules::unfinished) does
    /// not believe that a shard is finished whose file is not closed, or has lost something.
    pub note: Option<Vec<u8>>,
    /// The shards that were merged into the file, with their last notes.
    pub parts: Vec<ShardState>,
    /// The time of the last change.
    pub changed: Option<SystemTime>,
    /// True if the writer has said that nothing more will come.
    pub is_closed: bool,
    /// False if nothing of the file can be read, and the damage says why. A file that is named
    /// alone must be readable.
    pub is_readable: bool,
    /// The length of what stands at the end and is no whole frame yet \[bytes\].
    pub unfinished: u64,
    /// The damage in words.
    pub damage: Vec<String>,
}

impl ExportSummary {
    /// Lists the shards whose results are in the file, with their last notes.
    pub fn shards(&self) -> Vec<ShardState> {
        let shard = self.header.shard.clone();
        let state = shard.map(|shard| ShardState { shard, note: self.note.clone() });
        state.into_iter().chain(self.parts.iter().cloned()).collect()
    }
}

/// The place of a record in a set of exports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordPlace {
    pub(crate) key: JobKey,
    /// The number of the file in the set.
    pub(crate) file: u32,
    /// The number of the frame in the file.
    pub(crate) frame: u32,
    offset: u32,
    length: u32,
}

/// The place of a body in an export.
#[derive(Clone, Copy, Debug)]
struct BodyPlace {
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
    frames: Vec<BodyPlace>,
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
    fn unreadable(path: &Path, error: &OpenError) -> Self {
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
    fn content(&self, frame: u32) -> Result<Vec<u8>, String> {
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
    fn blob(&self, place: &BlobPlace) -> io::Result<BodyReader> {
        let file = match &self.file {
            Some(file) => file.try_clone()?,
            None => self.with_file(File::try_clone)?,
        };
        Ok(BodyReader { file, position: place.0.start, left: place.0.length })
    }
}

/// Refuses the name of a shard that cannot be.
pub(crate) fn require_possible(shard: &ShardName) -> Result<(), String> {
    let ShardName { index, count, .. } = shard;
    if *count > SHARD_LIMIT {
        return Err(format!("is of {count} shards, and a study may be in {SHARD_LIMIT}"));
    }
    match (1..=*count).contains(index) {
        true => Ok(()),
        false => Err(format!("is of shard {index} of {count}, which cannot be")),
    }
}

/// Returns the table of the frame that says that a shard was merged into a file.
pub(crate) fn part_table(part: &ShardState) -> io::Result<Vec<u8>> {
    let name = serde_json::to_vec(&part.shard)?;
    let mut table = (name.len() as u32).to_le_bytes().to_vec();
    table.extend_from_slice(&name);
    // A part without a note differs from one whose note is empty.
    if let Some(note) = &part.note {
        table.push(1);
        table.extend_from_slice(note);
    }
    Ok(table)
}

fn part_of(table: &[u8]) -> Result<ShardState, String> {
    let unreadable = || "names a part in words that cannot be read".to_owned();
    let (length, rest) = table.split_first_chunk::<4>().ok_or_else(unreadable)?;
    let (name, note) =
        rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(unreadable)?;
    let shard: ShardName = serde_json::from_slice(name).map_err(|_| unreadable())?;
    require_possible(&shard)?;
    Ok(ShardState { shard, note: note.split_first().map(|(_, note)| note.to_vec()) })
}

/// A blob as it is compressed in some file.
pub(crate) struct CompressedBlob {
    pub(crate) path: PathBuf,
    pub(crate) length: u64,
    pub(crate) bytes: io::Result<Box<dyn io::Read>>,
}

/// The compressed bytes of a blob in an export.
struct BodyReader {
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

/// A record of a job that several files may have.
struct FoundRecord {
    /// The number of the file in the set.
    file: u32,
    record: Result<Vec<u8>, ReadError>,
}

/// Several exports that count as one store.
#[derive(Debug)]
pub(crate) struct ExportSet {
    /// The directory or the file that was named.
    pub(crate) path: PathBuf,
    pub(crate) files: Vec<ExportFile>,
    /// The records of all files, in the order of their keys and then of the files.
    places: Vec<RecordPlace>,
    /// The numbers of those places in the order in which the records stand in the files, made when
    /// a file is first read from its beginning to its end.
    as_they_stand: OnceLock<Vec<u32>>,
    rules: Option<MergeRules>,
}

/// Returns the exports in a directory, or the file itself; `None` if there is none.
pub(crate) fn exports_at(path: &Path) -> Result<Option<Vec<PathBuf>>, OpenError> {
    if path.is_file() {
        return Ok(is_export(path).then(|| vec![path.to_owned()]));
    }
    let listing = match fs::read_dir(path) {
        Ok(listing) => listing,
        Err(error)
            if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) =>
        {
            return Ok(None);
        }
        Err(error) => return Err(OpenError::io("look into", Wanted::Read, path, error)),
    };
    let mut files = Vec::new();
    for entry in listing {
        let entry =
            entry.map_err(|error| OpenError::io("look into", Wanted::Read, path, error))?.path();
        let is_hidden =
            entry.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        // A store may have such a name too.
        if !is_hidden
            && !entry.is_dir()
            && entry.extension().is_some_and(|extension| extension == EXTENSION)
        {
            files.push(entry);
        }
    }
    files.sort();
    Ok((!files.is_empty()).then_some(files))
}

/// Returns true if `path` is an export or a directory of exports.
pub(crate) fn are_there(path: &Path) -> Result<bool, OpenError> {
    Ok(exports_at(path)?.is_some())
}

impl ExportSet {
    /// Reads the exports at `path`, which is a file or a directory of files; returns `None` if
    /// there is no export. A file that cannot be read hides no other. Without rules, equal jobs
    /// have equal results.
    pub(crate) fn open(
        path: &Path,
        rules: Option<&MergeRules>,
    ) -> Result<Option<Arc<ExportSet>>, OpenError> {
        let Some(paths) = exports_at(path)? else { return Ok(None) };
        let (mut files, mut places, mut first) = (Vec::new(), Vec::new(), None);
        for (number, file) in paths.iter().enumerate() {
            match ExportFile::open(file, number as u32, &mut places, rules) {
                Ok(file) => files.push(file),
                Err(error) => {
                    files.push(ExportFile::unreadable(file, &error));
                    first = first.or(Some(error));
                }
            }
        }
        if let Some(error) = first
            && files.iter().all(|file| !file.summary.is_readable)
        {
            return Err(error);
        }
        places.sort_unstable_by_key(|place| (place.key, place.file));
        places.shrink_to_fit();
        Ok(Some(Arc::new(ExportSet {
            path: path.to_owned(),
            files,
            places,
            as_they_stand: OnceLock::new(),
            rules: rules.copied(),
        })))
    }

    /// Returns the keys of all records in ascending order.
    pub(crate) fn keys(&self) -> Vec<JobKey> {
        let mut keys: Vec<JobKey> = self.places.iter().map(|place| place.key).collect();
        keys.dedup();
        keys
    }

    /// Returns the places of the records of a job, one for each file that has one.
    pub(crate) fn places(&self, key: &JobKey) -> &[RecordPlace] {
        let start = self.places.partition_point(|place| place.key < *key);
        let count = self.places[start..].iter().take_while(|place| place.key == *key).count();
        &self.places[start..start + count]
    }

    pub(crate) fn contains(&self, key: &JobKey) -> bool {
        !self.places(key).is_empty()
    }

    /// Returns the places of the records in one file, in the order in which they stand there.
    fn places_in(&self, file: u32) -> impl Iterator<Item = &RecordPlace> {
        let numbers = self.as_they_stand.get_or_init(|| {
            let mut numbers: Vec<u32> = (0..self.places.len() as u32).collect();
            numbers.sort_unstable_by_key(|number| {
                let RecordPlace { file, frame, offset, .. } = self.places[*number as usize];
                // An empty record stands at the same place as the next one.
                ((file, frame), (offset, *number))
            });
            numbers
        });
        let file_of = |number: &u32| self.places[*number as usize].file;
        let start = numbers.partition_point(|number| file_of(number) < file);
        let end = numbers.partition_point(|number| file_of(number) <= file);
        numbers[start..end].iter().map(|number| &self.places[*number as usize])
    }

    /// Returns the keys of the records in one file.
    pub(crate) fn keys_of(&self, file: u32) -> impl Iterator<Item = JobKey> {
        self.places_in(file).map(|place| place.key)
    }

    /// Visits those records of one file that are `wanted`, in the order in which they stand there.
    pub(crate) fn visit<E>(
        &self,
        file: u32,
        wanted: impl Fn(&JobKey) -> bool,
        mut visit: impl FnMut(&JobKey, Result<&[u8], ReadError>) -> Result<(), E>,
    ) -> Result<(), E> {
        let places: Vec<&RecordPlace> =
            self.places_in(file).filter(|place| wanted(&place.key)).collect();
        let Some(export) = self.files.get(file as usize) else { return Ok(()) };
        for group in places.chunk_by(|one, next| one.frame == next.frame) {
            let content = export.content(group[0].frame);
            for place in group {
                visit(&place.key, record_in(export, place, &content))?;
            }
        }
        Ok(())
    }

    /// Reads the frames of which every record was replaced by a later one, which nobody else reads,
    /// and returns what is wrong with them in words.
    pub(crate) fn faults_of_replaced(&self) -> Vec<String> {
        let mut read: Vec<Vec<bool>> =
            self.files.iter().map(|file| vec![false; file.frames.len()]).collect();
        for place in &self.places {
            read[place.file as usize][place.frame as usize] = true;
        }
        let mut faults = Vec::new();
        for (file, read) in self.files.iter().zip(read) {
            for (frame, _) in (0..).zip(read).filter(|(_, is_read)| !is_read) {
                if let Err(reason) = file.content(frame) {
                    faults.push(format!("{}: {reason}", file.path().display()));
                }
            }
        }
        faults
    }

    /// Returns one answer for each of the first of `keys`, as many as have `limit` bytes together
    /// and at least one. A frame is read once.
    pub(crate) fn first(
        &self,
        keys: &[JobKey],
        limit: usize,
    ) -> Vec<Result<Option<Vec<u8>>, ReadError>> {
        let (mut bytes, mut count) = (0, 0);
        let mut wanted: Vec<(usize, RecordPlace)> = Vec::new();
        for key in keys {
            let places = self.places(key);
            bytes += places.iter().map(|place| place.length as usize).sum::<usize>();
            wanted.extend(places.iter().map(|place| (count, *place)));
            count += 1;
            if bytes >= limit {
                break;
            }
        }
        wanted.sort_by_key(|(_, place)| (place.file, place.frame, place.offset));
        let mut found: Vec<Vec<FoundRecord>> = Vec::new();
        found.resize_with(count, Vec::new);
        for group in
            wanted.chunk_by(|(_, one), (_, next)| (one.file, one.frame) == (next.file, next.frame))
        {
            let export = &self.files[group[0].1.file as usize];
            let content = export.content(group[0].1.frame);
            for (number, place) in group {
                let record = record_in(export, place, &content).map(<[u8]>::to_vec);
                found[*number].push(FoundRecord { file: place.file, record });
            }
        }
        keys.iter().zip(found).map(|(key, records)| self.chosen(key, records)).collect()
    }

    /// Chooses among the records of one job that are sound.
    fn chosen(
        &self,
        key: &JobKey,
        records: Vec<FoundRecord>,
    ) -> Result<Option<Vec<u8>>, ReadError> {
        let (mut best, mut fault) = (None::<(u32, Option<Candidate>, Vec<u8>)>, None);
        let is_alone = records.len() == 1;
        for FoundRecord { file, record } in records {
            let record = match record {
                Ok(record) => record,
                Err(error) => {
                    fault = Some(error);
                    continue;
                }
            };
            let candidate = match &self.rules {
                Some(rules) if !is_alone => match (rules.examine)(key, &record) {
                    Ok(found) => Some(Candidate::of(rules, found.rank, &record)),
                    Err(reason) => {
                        let path = self.files[file as usize].path().to_owned();
                        fault = Some(ReadError::InExport { key: *key, path, reason });
                        continue;
                    }
                },
                _ => None,
            };
            let choice = match &best {
                None => RecordChoice::Second,
                Some((_, Some(one), _)) if candidate.is_some() => {
                    candidate.map_or(RecordChoice::First, |other| one.against(&other))
                }
                Some((_, _, one)) if *one <= record => RecordChoice::First,
                Some(_) => RecordChoice::Second,
            };
            match (choice, &best) {
                (RecordChoice::First, _) => {}
                (RecordChoice::Conflict, Some((first, _, _))) => {
                    let path = |file: u32| self.files[file as usize].path().to_owned();
                    let (first, second) = (path(*first), path(file));
                    return Err(ReadError::Conflict { key: *key, first, second });
                }
                (RecordChoice::Second | RecordChoice::Conflict, _) => {
                    best = Some((file, candidate, record));
                }
            }
        }
        match (best, fault) {
            (Some((_, _, record)), _) => Ok(Some(record)),
            (None, Some(error)) => Err(error),
            (None, None) => Ok(None),
        }
    }

    /// Returns the studies of all files, by their names, with the digests of their definitions,
    /// which `definition` reads.
    ///
    /// # Errors
    /// [`ReadError::StudiesDiffer`] if two files have studies of one name that differ.
    pub(crate) fn studies(
        &self,
        definition: impl Fn(&Digest) -> Option<Vec<u8>>,
    ) -> Result<BTreeMap<String, Digest>, ReadError> {
        let mut found: BTreeMap<&str, Vec<(Digest, &ExportFile)>> = BTreeMap::new();
        for file in &self.files {
            for (name, digest) in &file.studies {
                let known = found.entry(name).or_default();
                if known.iter().all(|(known, _)| known != digest) {
                    known.push((*digest, file));
                }
            }
        }
        let mut studies = BTreeMap::new();
        for (name, mut digests) in found {
            if digests.len() > 1 {
                // One that cannot be read says nothing, and is not chosen if another can be.
                let said: Vec<_> = digests.iter().map(|(digest, _)| definition(digest)).collect();
                if said.iter().any(Option::is_some) {
                    let mut said = said.iter();
                    digests.retain(|_| said.next().is_some_and(Option::is_some));
                }
                let mut said = said.iter().flatten().map(|bytes| match &self.rules {
                    Some(rules) => (rules.definition)(bytes),
                    None => Digest::of(bytes),
                });
                let first = said.next();
                if let Some(place) = said.position(|other| Some(other) != first) {
                    return Err(ReadError::StudiesDiffer {
                        name: name.to_owned(),
                        first: digests[0].1.path().to_owned(),
                        second: digests[place + 1].1.path().to_owned(),
                    });
                }
            }
            let chosen = digests.into_iter().map(|(digest, _)| digest).min();
            studies.extend(chosen.map(|digest| (name.to_owned(), digest)));
        }
        Ok(studies)
    }

    /// Returns the file that has a blob, and the place of the blob.
    pub(crate) fn blob(&self, digest: &Digest) -> Option<(&ExportFile, &BlobPlace)> {
        self.files.iter().find_map(|file| Some((file, file.blobs.get(digest)?)))
    }

    /// Returns the compressed bytes of a blob in each file that has it.
    pub(crate) fn compressed(&self, digest: &Digest) -> impl Iterator<Item = CompressedBlob> {
        self.files.iter().filter_map(|file| {
            let place = file.blobs.get(digest)?;
            let bytes = file.blob(place).map(|bytes| Box::new(bytes) as Box<dyn io::Read>);
            Some(CompressedBlob { path: file.path().to_owned(), length: place.length(), bytes })
        })
    }
}

fn record_in<'c>(
    export: &ExportFile,
    place: &RecordPlace,
    content: &'c Result<Vec<u8>, String>,
) -> Result<&'c [u8], ReadError> {
    let damaged = |reason: &str| ReadError::InExport {
        key: place.key,
        path: export.path().to_owned(),
        reason: reason.to_owned(),
    };
    let content = content.as_ref().map_err(|reason| damaged(reason))?;
    let (start, length) = (place.offset as usize, place.length as usize);
    content.get(start..start + length).ok_or_else(|| damaged("it goes on after its frame"))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use proptest::prelude::*;

    use super::*;
    use crate::blob::Blobs;
    use crate::frame::FrameHead;

    const KINDS: [FrameKind; 7] = [
        FrameKind::Header,
        FrameKind::Study,
        FrameKind::Records,
        FrameKind::Blob,
        FrameKind::Note,
        FrameKind::Part,
        FrameKind::End,
    ];

    fn export(frames: &[(FrameKind, Vec<u8>, Vec<u8>)]) -> tempfile::NamedTempFile {
        let mut file = tempfile::Builder::new().suffix(".tribosweep").tempfile().unwrap();
        file.write_all(MAGIC).unwrap();
        file.write_all(&EXPORT_FORMAT.to_le_bytes()).unwrap();
        for (kind, table, body) in frames {
            let head = FrameHead::new(*kind, table, body.len() as u64, BodySum::of(body));
            file.write_all(&[&head.to_bytes()[..], table, body].concat()).unwrap();
        }
        file
    }

    /// Reads everything that an export claims to have.
    fn read(file: &tempfile::NamedTempFile) -> ExportSummary {
        let set = ExportSet::open(file.path(), None).unwrap().unwrap();
        let _ = set.first(&set.keys(), 1 << 20);
        let _ = (set.faults_of_replaced(), set.studies(|_| None));
        let blobs = Blobs::in_exports(set.clone());
        for digest in set.files[0].blobs.keys() {
            assert!(blobs.get(digest).is_err());
        }
        set.files[0].summary.clone()
    }

    #[test]
    fn claims_in_sound_tables_are_not_believed() {
        let entry = |length: u32| [&[7; 32][..], &length.to_le_bytes()].concat();
        let bomb = zstd::bulk::compress(&vec![0; 64 << 20], 3).unwrap();
        let shard = br#"{"study":"s","index":3,"count":2}"#;
        let part = [&(shard.len() as u32).to_le_bytes()[..], shard].concat();
        for (kind, table, body) in [
            (FrameKind::Records, entry(u32::MAX), vec![]),
            (FrameKind::Records, entry(5).repeat(30_000), vec![]),
            (
                FrameKind::Header,
                br#"{"program":"x","shard":{"study":"s","index":0,"count":0}}"#.to_vec(),
                vec![],
            ),
            (
                FrameKind::Header,
                br#"{"program":"x","shard":{"study":"s","index":1,"count":4294967295}}"#.to_vec(),
                vec![],
            ),
            (FrameKind::Header, b"[]".to_vec(), vec![]),
            (FrameKind::Study, vec![7; 31], vec![]),
            (FrameKind::Study, vec![0xff; 40], vec![]),
            (FrameKind::Blob, vec![], vec![]),
            (FrameKind::Part, u32::MAX.to_le_bytes().to_vec(), vec![]),
            (FrameKind::Part, part, vec![]),
            (FrameKind::End, vec![9; 24], vec![]),
            (FrameKind::End, vec![9; 3], vec![]),
        ] {
            let frames =
                [(FrameKind::Header, b"{\"program\":\"x\"}".to_vec(), vec![]), (kind, table, body)];
            let summary = read(&export(&frames));
            assert_eq!(summary.damage.len(), 1, "{summary:?}");
        }
        // What a body decompresses to is bounded by its table.
        let set = export(&[(FrameKind::Records, entry(5), bomb.clone())]);
        let set = ExportSet::open(set.path(), None).unwrap().unwrap();
        let answer = set.first(&[JobKey([7; 32])], 1 << 20).remove(0).unwrap_err();
        assert!(answer.to_string().contains("is damaged"), "{answer}");
        let set = export(&[(FrameKind::Blob, vec![7; 32], bomb)]);
        let set = ExportSet::open(set.path(), None).unwrap().unwrap();
        assert!(Blobs::in_exports(set).get(&Digest([7; 32])).is_err());
    }

    proptest! {
        #[test]
        fn arbitrary_tables_never_panic(
            frames in proptest::collection::vec(
                (0..KINDS.len(), proptest::collection::vec(any::<u8>(), 0..120), proptest::collection::vec(any::<u8>(), 0..40)), 0..6),
        ) {
            let frames: Vec<_> =
                frames.into_iter().map(|(kind, table, body)| (KINDS[kind], table, body)).collect();
            read(&export(&frames));
        }
    }
}
