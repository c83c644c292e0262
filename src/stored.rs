//! The contents of a store: studies by name, and records.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use answers::{RecordMap, Records, RecordsError, effects};
use anyhow::{Context, Result, anyhow, bail};
use contact::model::Fields;
use contact::punch::Surfaces;
use identity::{JobKey, KeptFields};
use rayon::prelude::*;
use store::{Blobs, Digest, OpenError, ReadError, RecordOrigin, Store, StoreReader, StudyLabels};
use study::account::ACCOUNT_LIMIT;
use study::encoding::DecodeError;
use study::record_format::{decode_fields, job_text};
use study::{Job, MOST_POINTS, Record, RunAccount, Study};

use crate::merge_rules::RULES;
use crate::{output, proposal};

/// The likeness from which on a name is probably meant by another, by Jaro and Winkler.
const ALIKE: f64 = 0.85;

/// A store as the place that keeps records.
#[derive(Clone, Copy)]
pub(crate) enum StoreSource<'a> {
    /// The store that this process writes.
    Store(&'a WrittenStore<'a>),
    /// A store that this process reads.
    Reader(&'a StoreReader),
}

/// A store that this process writes. A record that is damaged, or whose file of fields is damaged
/// or gone, counts as absent, so a run computes its job again and so heals it.
pub(crate) struct WrittenStore<'a> {
    pub(crate) store: &'a Store,
    /// The jobs whose files have been read and were sound.
    sound: Mutex<HashSet<JobKey>>,
}

impl<'a> WrittenStore<'a> {
    /// Returns the store as one of which nothing has been examined yet.
    pub(crate) fn new(store: &'a Store) -> Self {
        Self { store, sound: Mutex::default() }
    }

    /// Returns the record of a job if it is there and whole.
    pub(crate) fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        match self.store.get(key) {
            Ok(Some(bytes)) => Ok(self.is_whole(key, &bytes)?.then_some(bytes)),
            Ok(None) | Err(ReadError::Corrupt { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Tells for each of `keys` in which state its record is.
    ///
    /// # Errors
    /// The system did not let a file be read, which says nothing about what stands in it.
    pub(crate) fn states(&self, keys: &[JobKey]) -> Result<Vec<RecordState>, ReadError> {
        let state = |key: &JobKey| match self.get(key) {
            Ok(None) if self.store.contains(key) => Ok(RecordState::Damaged),
            Ok(None) => Ok(RecordState::Absent),
            Ok(Some(_)) => Ok(RecordState::Present),
            Err(error @ ReadError::Io { .. }) => Err(error),
            Err(_) => Ok(RecordState::Present),
        };
        keys.par_iter().map(state).collect()
    }

    /// Returns true if a record can be decoded and its fields are there. A file of them is read
    /// whole, but only once (measured: 50 ms for 60 grids of 96 × 96 that took 3 s to compute, 100
    /// ms for 2000 of 16 × 16 that took 2.3 s).
    ///
    /// # Errors
    /// The system did not let the file of fields be read.
    fn is_whole(&self, key: &JobKey, bytes: &[u8]) -> Result<bool, ReadError> {
        if self.sound().contains(key) {
            return Ok(true);
        }
        let record = match Record::decode(bytes) {
            Ok(record) => record,
            // It is whole for the version of the program that wrote it.
            Err(error) => return Ok(matches!(error, DecodeError::Version { .. })),
        };
        let is_kept = match record.fields.as_ref().map(|kept| self.store.blobs().is_kept(kept)) {
            None => true,
            Some(Ok(is_kept)) => is_kept,
            Some(Err(error @ ReadError::Io { .. })) => return Err(error),
            Some(Err(_)) => false,
        };
        let is_whole = record.key() == *key && is_kept;
        if is_whole && matches!(record.fields, Some(KeptFields::Blob(_))) {
            self.sound().insert(*key);
        }
        Ok(is_whole)
    }

    fn sound(&self) -> MutexGuard<'_, HashSet<JobKey>> {
        self.sound.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The state of a job's record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RecordState {
    /// There is none.
    Absent,
    /// It is there and whole.
    Present,
    /// It or its file of fields is damaged or lost.
    Damaged,
}

/// A record as a store gives it.
type FetchedRecord = (JobKey, Result<Vec<u8>, ReadError>);

impl StoreSource<'_> {
    /// Returns the records of those of `keys` that have one.
    fn fetch(self, keys: &[JobKey]) -> Vec<FetchedRecord> {
        match self {
            StoreSource::Store(written) => keys
                .par_iter()
                .filter_map(|key| written.get(key).transpose().map(|record| (*key, record)))
                .collect(),
            StoreSource::Reader(reader) => reader.select(keys.to_vec()).collect(),
        }
    }

    /// Returns every record.
    fn all(&self) -> Result<Box<dyn Iterator<Item = FetchedRecord> + '_>, ReadError> {
        Ok(match self {
            StoreSource::Store(written) => Box::new(written.store.records()),
            StoreSource::Reader(reader) => Box::new(reader.records()?),
        })
    }

    /// Returns every record that can be read, whatever the version of its physics.
    pub(crate) fn all_sound(&self) -> Result<impl Iterator<Item = Record>, ReadError> {
        let sound = |(key, bytes): FetchedRecord| decoded(&key, &bytes.ok()?).ok();
        Ok(self.all()?.filter_map(sound))
    }

    /// Returns true if the record of a job that was read can be built upon.
    fn is_usable(&self, key: &JobKey, bytes: &[u8]) -> Result<bool, ReadError> {
        match self {
            StoreSource::Store(written) => written.is_whole(key, bytes),
            StoreSource::Reader(_) => Ok(true),
        }
    }

    fn blobs(&self) -> &Blobs {
        match self {
            StoreSource::Store(written) => written.store.blobs(),
            StoreSource::Reader(reader) => reader.blobs(),
        }
    }
}

impl Records for StoreSource<'_> {
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError> {
        let decoded = |(key, bytes): FetchedRecord| -> Result<(JobKey, Record)> {
            let bytes = bytes.with_context(|| {
                let command = proposal::command(self.blobs().store(), ["store", "verify"]);
                format!("run `{command}` to see the whole damage, and the study's file to heal it")
            })?;
            Ok((key, decoded(&key, &bytes)?))
        };
        Ok(self.fetch(keys).into_iter().map(decoded).collect::<Result<_>>()?)
    }

    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
        let wanted = |(key, bytes): FetchedRecord| {
            let bytes = bytes.ok().filter(|bytes| job_text(bytes).is_some_and(is_wanted))?;
            let record = decoded(&key, &bytes).ok()?;
            let usable = self.is_usable(&key, &bytes);
            usable.map(|is_usable| is_usable.then_some((key, record))).transpose()
        };
        Ok(self.all()?.filter_map(wanted).collect::<Result<_, ReadError>>()?)
    }

    fn fields(&self, record: &Record) -> Result<Fields, RecordsError> {
        Ok(fields(self.blobs(), record)?)
    }

    fn account(&self, run: &[u8; 32]) -> Option<RunAccount> {
        account(self.blobs(), run)
    }
}

/// Decodes the record of a job, and refuses that of another one.
fn decoded(key: &JobKey, bytes: &[u8]) -> Result<Record> {
    let record = Record::decode(bytes).with_context(|| format!("the record of job {key}"))?;
    if record.key() != *key {
        bail!("what is stored as the record of job {key} is that of job {}", record.key());
    }
    Ok(record)
}

/// Reads the record of a job that was just listed.
pub(crate) fn record(reader: &StoreReader, key: &JobKey) -> Result<Record> {
    let bytes = reader.get(key)?;
    decoded(key, &bytes.context("the record was removed while it was looked up")?)
}

/// Reads the fields of a record.
pub(crate) fn fields(blobs: &Blobs, record: &Record) -> Result<Fields> {
    let kept = record.fields.as_ref().with_context(|| {
        format!("job {} left no fields: it is {}", record.key(), record.standing())
    })?;
    let blob = blobs.kept(kept)?.with_context(|| {
        let command = proposal::command(blobs.store(), ["store", "verify"]);
        format!(
            "the file with its fields is missing; `{command}` says what else is, and to run the \
             study's file again computes it anew"
        )
    })?;
    Ok(decode_fields(&blob)?)
}

/// Reads the account of a run; `None` if it is lost, damaged or no account.
pub(crate) fn account(blobs: &Blobs, run: &[u8; 32]) -> Option<RunAccount> {
    let bytes = blobs.get_within(&Digest(*run), ACCOUNT_LIMIT).ok()??;
    RunAccount::parse(&bytes)
}

/// Reads the study with a name from a store; if there is none, the error names those that are
/// there.
pub(crate) fn stored_study(reader: &StoreReader, name: &str) -> Result<Study> {
    let study = stored_large_study(reader, name)?;
    if study.is_listed() { Ok(study) } else { Err(too_large(reader, &study)) }
}

/// Returns the error about a study that has too many points to read them all at a time.
pub(crate) fn too_large(reader: &StoreReader, study: &Study) -> anyhow::Error {
    let name = study.name();
    let part = format!("1/{}", study.len().div_ceil(MOST_POINTS));
    anyhow!(
        "the study `{name}` has {} points, and {MOST_POINTS} at most are read at a time; ask for \
         its parts: {}",
        study.len(),
        proposal::command(reader.blobs().store(), ["query", name, "--shard", &part])
    )
}

/// Returns a study of a store that holds the height map or the profiles which a job names; `None`
/// if it names none, and if no study holds them.
pub(crate) fn study_with_files(reader: &StoreReader, job: &Job) -> Result<Option<Study>> {
    if effects::missing_surface(job, &Surfaces::new()).is_none() {
        return Ok(None);
    }
    for name in reader.study_names()? {
        // A damaged study is no reason to find nothing.
        let Ok(study) = stored_study(reader, &name) else { continue };
        if effects::missing_surface(job, study.surfaces()).is_none() {
            return Ok(Some(study));
        }
    }
    Ok(None)
}

/// Reads the study with a name from a store; it may have more points than are read at a time.
pub(crate) fn stored_large_study(reader: &StoreReader, name: &str) -> Result<Study> {
    let damaged = || {
        format!(
            "the definition of the study `{name}` is damaged; to run its file again writes it \
             anew"
        )
    };
    if let Some(definition) = reader.study(name).with_context(damaged)? {
        return Study::from_large_definition(&definition)
            .with_context(|| format!("the stored study `{name}`"));
    }
    let names = reader.study_names()?;
    let file = Path::new(name);
    if file.is_file() {
        let run = [OsStr::new("run"), &wording::file_argument(file)];
        bail!(
            "`{name}` is a file; name a study in the store instead ({}), or start it with `{}`",
            list(&names),
            proposal::command(reader.blobs().store(), run)
        );
    }
    Err(no_such_study(name, &names))
}

/// Reads the labels of a study in a store.
pub(crate) fn study_labels(directory: &Path, name: &str) -> Result<StudyLabels> {
    let reader = read_store(directory)?;
    let names = reader.study_names()?;
    if !names.iter().any(|known| known == name) {
        return Err(no_such_study(name, &names));
    }
    Ok(reader.labels()?.remove(name).unwrap_or_default())
}

/// Changes the labels of a study in a store, and returns them.
pub(crate) fn change_labels(
    directory: &Path,
    name: &str,
    change: impl FnOnce(&mut StudyLabels) -> Result<()>,
) -> Result<StudyLabels> {
    let store = Store::open_existing(directory)?;
    let names = store.study_names();
    if !names.iter().any(|known| known == name) {
        return Err(no_such_study(name, &names));
    }
    let mut labels = store.labels(name);
    change(&mut labels)?;
    store.set_labels(name, labels.clone())?;
    Ok(labels)
}

/// Returns the error about a study that a store does not have, with the one that is spelled like it
/// or else with all that it has.
pub(crate) fn no_such_study(name: &str, names: &[String]) -> anyhow::Error {
    let likeness =
        |known: &String| strsim::jaro_winkler(&name.to_lowercase(), &known.to_lowercase());
    let nearest = names.iter().max_by(|one, other| likeness(one).total_cmp(&likeness(other)));
    match nearest.filter(|nearest| likeness(nearest) > ALIKE) {
        Some(nearest) => {
            anyhow!("there is no study `{name}` in the store; did you mean `{nearest}`?")
        }
        None => anyhow!("there is no study `{name}` in the store; it has {}", list(names)),
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none so far".to_owned() } else { names.join(", ") }
}

/// Opens a store for reading, or exports. It says so if the numbers come from a running process or
/// from exports, or if there may be more of them than this process can see.
pub(crate) fn read_store(directory: &Path) -> Result<StoreReader, OpenError> {
    let reader = open_to_read(directory)?;
    reader_notes(&reader).iter().for_each(|note| output::say(note));
    Ok(reader)
}

/// Opens a store for reading, or exports, without a word.
pub(crate) fn open_to_read(directory: &Path) -> Result<StoreReader, OpenError> {
    Store::read_by(directory, &RULES)
}

/// Returns what is to be said of the place from which records are read.
pub(crate) fn reader_notes(reader: &StoreReader) -> Vec<String> {
    let mut notes = Vec::new();
    match reader.origin() {
        RecordOrigin::Disk => {}
        origin => notes.push(origin.to_string()),
    }
    for export in reader.exports() {
        for reason in &export.damage {
            notes.push(format!("{} is damaged: {reason}", export.path.display()));
        }
    }
    notes
}

/// Returns the only key of a store that begins with some characters.
pub(crate) fn find_key(reader: &StoreReader, beginning: &str) -> Result<JobKey> {
    let prefix = beginning.to_ascii_lowercase();
    let matching: Vec<JobKey> =
        reader.keys()?.into_iter().filter(|key| key.to_string().starts_with(&prefix)).collect();
    match matching[..] {
        [key] => Ok(key),
        [] => bail!(
            "no result has a key that begins with `{beginning}`; `{} STUDY` lists keys",
            proposal::command(reader.blobs().store(), ["query", "--select", "key"])
        ),
        _ => bail!(
            "{} results have keys that begin with `{beginning}`; give more of it",
            matching.len()
        ),
    }
}
