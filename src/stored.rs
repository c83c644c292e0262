//! The contents of a store: studies by name, and records.

use std::ffi::OsStr;
use std::path::Path;

use answers::{RecordMap, Records, RecordsError};
use anyhow::{Context, Result, bail};
use contact::model::Fields;
use identity::JobKey;
use store::{Blobs, ReadError, RecordOrigin, Store, StoreReader};
use study::record_format::{decode_fields, job_text};
use study::{Record, Study};

use crate::{output, proposal};

/// A store as the place that keeps records.
#[derive(Clone, Copy)]
pub(crate) enum StoreSource<'a> {
    /// The store that this process writes.
    Store(&'a Store),
    /// A store that this process reads.
    Reader(&'a StoreReader),
}

/// A record as a store gives it.
type FetchedRecord = (JobKey, Result<Vec<u8>, ReadError>);

impl StoreSource<'_> {
    /// Returns the records of those of `keys` that have one.
    fn fetch(self, keys: &[JobKey]) -> Vec<FetchedRecord> {
        match self {
            StoreSource::Store(store) => keys
                .iter()
                .filter_map(|key| store.get(key).transpose().map(|record| (*key, record)))
                .collect(),
            StoreSource::Reader(reader) => reader.select(keys.to_vec()).collect(),
        }
    }

    /// Returns every record.
    fn all(&self) -> Result<Box<dyn Iterator<Item = FetchedRecord> + '_>, ReadError> {
        Ok(match self {
            StoreSource::Store(store) => Box::new(store.records()),
            StoreSource::Reader(reader) => Box::new(reader.records()?),
        })
    }

    fn blobs(&self) -> &Blobs {
        match self {
            StoreSource::Store(store) => store.blobs(),
            StoreSource::Reader(reader) => reader.blobs(),
        }
    }
}

impl Records for StoreSource<'_> {
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError> {
        let decoded = |(key, bytes): FetchedRecord| -> Result<(JobKey, Record)> {
            let bytes = bytes.with_context(|| {
                let command = proposal::command(self.blobs().store(), ["store", "verify"]);
                format!("run `{command}` to see the whole damage")
            })?;
            let record =
                Record::decode(&bytes).with_context(|| format!("the record of job {key}"))?;
            Ok((key, record))
        };
        Ok(self.fetch(keys).into_iter().map(decoded).collect::<Result<_>>()?)
    }

    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
        let wanted = |(key, bytes): FetchedRecord| {
            let bytes = bytes.ok().filter(|bytes| job_text(bytes).is_some_and(is_wanted))?;
            Some((key, Record::decode(&bytes).ok()?))
        };
        Ok(self.all()?.filter_map(wanted).collect())
    }

    fn fields(&self, record: &Record) -> Result<Fields, RecordsError> {
        Ok(fields(self.blobs(), record)?)
    }
}

/// Reads the fields of a record.
pub(crate) fn fields(blobs: &Blobs, record: &Record) -> Result<Fields> {
    let kept = record.fields.as_ref().with_context(|| {
        format!("job {} left no fields: it is {}", record.key(), record.standing())
    })?;
    let blob = blobs.kept(kept)?.with_context(|| {
        let command = proposal::command(blobs.store(), ["store", "verify"]);
        format!("the file with its fields is missing; `{command}` says what else is")
    })?;
    Ok(decode_fields(&blob)?)
}

/// Reads the study with a name from a store; if there is none, the error names those that are
/// there.
pub(crate) fn stored_study(reader: &StoreReader, name: &str) -> Result<Study> {
    let damaged = || {
        format!(
            "the definition of the study `{name}` is damaged; to run its file again writes it \
             anew"
        )
    };
    if let Some(definition) = reader.study(name).with_context(damaged)? {
        return Study::from_definition(&definition)
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
    bail!("there is no study `{name}` in the store; it has {}", list(&names))
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none so far".to_owned() } else { names.join(", ") }
}

/// Says that numbers come from a running process, if one is still adding to the store.
pub(crate) fn tell_origin(reader: &StoreReader) {
    if let origin @ RecordOrigin::Process { .. } = reader.origin() {
        output::say(&origin.to_string());
    }
}
