//! This file reads several exports as one store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::{fs, io};

use identity::JobKey;

use crate::access::Wanted;
use crate::digest::Digest;
use crate::error::{Answer, OpenError, ReadError};
use crate::exports::file::{EXTENSION, ExportFile, FrameRecords, is_export};
use crate::exports::index::{RecordIndex, RecordPlace};
use crate::rules::{Candidate, MergeRules, RecordChoice};

/// The number of exports that stay open while they are read. Others are opened again for every
/// frame, because a process may have few files open and a study many shards.
const OPEN_FILES: usize = 128;

/// A blob as it is compressed in some file.
pub(crate) struct CompressedBlob {
    pub(crate) path: PathBuf,
    pub(crate) length: u64,
    pub(crate) bytes: io::Result<Box<dyn io::Read>>,
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
    /// The places of the records, which are found when a record is first asked for. A merge asks
    /// for none.
    index: OnceLock<RecordIndex>,
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
        let (mut files, mut first) = (Vec::new(), None);
        for (number, file) in paths.iter().enumerate() {
            match ExportFile::open(file, number < OPEN_FILES, rules) {
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
        Ok(Some(Arc::new(ExportSet {
            path: path.to_owned(),
            files,
            index: OnceLock::new(),
            rules: rules.copied(),
        })))
    }

    fn index(&self) -> Result<&RecordIndex, ReadError> {
        if let Some(index) = self.index.get() {
            return Ok(index);
        }
        let index = RecordIndex::of(&self.files).map_err(|error| self.unreadable(error))?;
        Ok(self.index.get_or_init(|| index))
    }

    /// Returns the error of an index that cannot be made or read.
    fn unreadable(&self, source: io::Error) -> ReadError {
        ReadError::Io { path: self.path.clone(), source }
    }

    /// Returns the places of the records of a job.
    fn places(&self, key: &JobKey) -> Result<Vec<RecordPlace>, ReadError> {
        self.index()?.places(key).map_err(|error| self.unreadable(error))
    }

    /// Returns the keys of all records in ascending order.
    pub(crate) fn keys(&self) -> Result<Vec<JobKey>, ReadError> {
        self.index()?.keys().map_err(|error| self.unreadable(error))
    }

    /// Returns for each job whether it has a record.
    pub(crate) fn contains(&self, keys: &[JobKey]) -> Result<Vec<bool>, ReadError> {
        keys.iter().map(|key| Ok(!self.places(key)?.is_empty())).collect()
    }

    /// Reads the frames of which every record was replaced by a later one, which nobody else reads,
    /// and returns what is wrong with them in words.
    pub(crate) fn faults_of_replaced(&self) -> Result<Vec<String>, ReadError> {
        let mut read: Vec<Vec<bool>> =
            self.files.iter().map(|file| vec![false; file.frames().len()]).collect();
        self.index()?
            .visit(|place| read[place.file as usize][place.frame as usize] = true)
            .map_err(|error| self.unreadable(error))?;
        let mut faults = Vec::new();
        for (file, read) in self.files.iter().zip(read) {
            for (frame, _) in read.iter().enumerate().filter(|(_, is_read)| !**is_read) {
                if let Some(reason) = file.records(frame).map_or_else(Some, FrameRecords::fault) {
                    faults.push(format!("{}: {reason}", file.path().display()));
                }
            }
        }
        Ok(faults)
    }

    /// Returns one answer for each of the first of `keys`, as many as have `limit` bytes together
    /// and at least one. A frame is read once.
    pub(crate) fn first(&self, keys: &[JobKey], limit: usize) -> Result<Vec<Answer>, ReadError> {
        let (mut bytes, mut count) = (0, 0);
        let mut wanted: Vec<(usize, RecordPlace)> = Vec::new();
        for key in keys {
            let places = self.places(key)?;
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
            let records = export.records(group[0].1.frame as usize);
            for (number, place) in group {
                let record = records
                    .as_ref()
                    .map_err(String::clone)
                    .and_then(|records| Ok(records.record(place.offset, place.length)?.to_vec()));
                let record = record.map_err(|reason| ReadError::InExport {
                    key: place.key,
                    path: export.path().to_owned(),
                    reason,
                });
                found[*number].push(FoundRecord { file: place.file, record });
            }
        }
        Ok(keys.iter().zip(found).map(|(key, records)| self.chosen(key, records)).collect())
    }

    /// Chooses among the records of one job that are sound.
    fn chosen(&self, key: &JobKey, records: Vec<FoundRecord>) -> Answer {
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

    /// Returns true if a file has the blob.
    pub(crate) fn has_blob(&self, digest: &Digest) -> bool {
        self.files.iter().any(|file| file.blobs.contains_key(digest))
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
