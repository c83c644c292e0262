//! This file holds the places from which a merge takes records.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use identity::JobKey;

use crate::digest::Digest;
use crate::error::ReadError;
use crate::exports::{ExportFile, ExportSet, ShardState};
use crate::merge::report::{MergeError, MergeSelection};
use crate::parts;
use crate::reader::StoreReader;
use crate::rules::MergeRules;

/// The number of records of a store that are asked for at once.
const KEYS_AT_ONCE: usize = 65_536;

/// The sources of a merge, and what is taken of them.
pub(super) struct MergeInput<'m> {
    pub(super) sources: Vec<MergeSource<'m>>,
    pub(super) rules: &'m MergeRules,
    pub(super) selection: &'m MergeSelection,
}

impl<'m> MergeInput<'m> {
    /// Returns what `readers` read, after what an `earlier` file held at the place of the target.
    pub(super) fn new(
        readers: &[&'m StoreReader],
        rules: &'m MergeRules,
        selection: &'m MergeSelection,
        target: &Path,
        earlier: Option<&'m StoreReader>,
    ) -> Self {
        // What is named twice counts once, and nothing is merged into itself.
        let same = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let mut seen = BTreeSet::from([same(target)]);
        let earlier = earlier.into_iter().flat_map(MergeSource::all_of);
        let mut sources: Vec<_> =
            earlier.map(|source| MergeSource { is_target: true, ..source }).collect();
        let others = readers.iter().flat_map(|reader| MergeSource::all_of(reader));
        sources.extend(others.filter(|source| seen.insert(same(&source.path))));
        MergeInput { sources, rules, selection }
    }

    /// Returns true if the record of a job is taken from a source.
    pub(super) fn is_selected(&self, source: &MergeSource, key: &JobKey) -> bool {
        source.is_target || self.selection.keys.as_ref().is_none_or(|keys| keys.contains(key))
    }

    /// Returns the names of the studies that are taken from a source, if not all.
    pub(super) fn study_names(&self, source: &MergeSource) -> Option<&'m BTreeSet<String>> {
        self.selection.studies.as_ref().filter(|_| !source.is_target)
    }
}

/// A place from which records come: a store, or one of several exports.
pub(super) struct MergeSource<'s> {
    pub(super) reader: &'s StoreReader,
    records: SourceRecords,
    pub(super) path: PathBuf,
    /// True if this is what the target held before, of which everything stays.
    pub(super) is_target: bool,
}

/// The records of a source, which have numbers from 0 on.
enum SourceRecords {
    /// The records stand in the export of this number, in this order. A job may have several.
    Export { set: Arc<ExportSet>, number: usize },
    /// The records are those of these jobs in a store, since they were listed.
    Store { keys: Vec<JobKey> },
}

/// The records that a visit comes to.
pub(super) enum VisitedRecords<'r> {
    /// A record, or the reason why it cannot be read.
    One { number: usize, key: JobKey, record: Result<&'r [u8], ReadError> },
    /// Some records of which not even the jobs can be read any more.
    Unreadable { count: usize, reason: String },
}

impl MergeSource<'_> {
    /// Lists what is read by `reader`.
    fn all_of(reader: &StoreReader) -> Vec<MergeSource<'_>> {
        let source = |path, records| MergeSource { reader, records, path, is_target: false };
        let Some(set) = reader.export_set() else {
            let records = SourceRecords::Store { keys: Vec::new() };
            return vec![source(reader.path().to_owned(), records)];
        };
        let files = set.files.iter().enumerate();
        files
            .map(|(number, file)| {
                let records = SourceRecords::Export { set: set.clone(), number };
                source(file.path().to_owned(), records)
            })
            .collect()
    }

    fn export(&self) -> Option<&ExportFile> {
        match &self.records {
            SourceRecords::Export { set, number } => set.files.get(*number),
            SourceRecords::Store { .. } => None,
        }
    }

    /// Returns true if the records come from an export.
    pub(super) fn is_export(&self) -> bool {
        self.export().is_some()
    }

    /// Lists the records and returns their number. Of a store, a run may add to which meanwhile,
    /// what is there now counts, and its keys are kept.
    pub(super) fn list(&mut self) -> Result<usize, ReadError> {
        match &mut self.records {
            SourceRecords::Export { set, number } => Ok(set.files[*number].frames().sum()),
            SourceRecords::Store { keys } => {
                *keys = self.reader.keys()?;
                Ok(keys.len())
            }
        }
    }

    /// Visits the number and the key of every record that was listed. Returns the faults of what
    /// cannot be read any more, in words.
    pub(super) fn each_key<E>(
        &self,
        mut visit: impl FnMut(usize, &JobKey) -> Result<(), E>,
    ) -> Result<Vec<String>, E> {
        let mut faults = Vec::new();
        match &self.records {
            SourceRecords::Export { set, number } => {
                let (file, mut first) = (&set.files[*number], 0);
                for (table, count) in file.tables().zip(file.frames()) {
                    match table {
                        Ok(entries) => {
                            let mut numbered = entries.iter().zip(first..);
                            numbered.try_for_each(|(entry, number)| visit(number, &entry.key))?;
                        }
                        Err(reason) => faults.push(reason),
                    }
                    first += count;
                }
                faults.dedup();
            }
            SourceRecords::Store { keys } => {
                keys.iter().zip(0..).try_for_each(|(key, number)| visit(number, key))?;
            }
        }
        Ok(faults)
    }

    /// Returns the jobs among `keys`, which are in ascending order, that have a record here, be it
    /// a damaged one, and true if all keys could be read.
    pub(super) fn having(&self, keys: &[JobKey]) -> Result<(BTreeSet<JobKey>, bool), ReadError> {
        if !self.is_export() {
            let is_there = self.reader.contains(keys)?;
            let found = keys.iter().zip(is_there).filter(|(_, is_there)| *is_there);
            return Ok((found.map(|(key, _)| *key).collect(), true));
        }
        let mut found = BTreeSet::new();
        let faults = self.each_key(|_, key| -> Result<(), ReadError> {
            if keys.binary_search(key).is_ok() {
                found.insert(*key);
            }
            Ok(())
        })?;
        Ok((found, faults.is_empty()))
    }

    pub(super) fn studies(&self) -> Result<BTreeMap<String, Digest>, ReadError> {
        match self.export() {
            Some(file) => Ok(file.studies.clone()),
            None => self.reader.studies(),
        }
    }

    pub(super) fn shards(&self) -> Vec<ShardState> {
        match self.export() {
            Some(file) => file.summary.shards(),
            None => parts::read(&self.path),
        }
    }

    /// Visits the records whose numbers are `wanted`, in ascending order.
    pub(super) fn visit(
        &self,
        wanted: impl Fn(usize) -> bool,
        visit: impl FnMut(VisitedRecords) -> Result<(), MergeError>,
    ) -> Result<(), MergeError> {
        match &self.records {
            SourceRecords::Export { set, number } => {
                visit_export(&set.files[*number], wanted, visit)
            }
            SourceRecords::Store { keys } => visit_store(self.reader, keys, wanted, visit),
        }
    }
}

fn visit_export(
    file: &ExportFile,
    wanted: impl Fn(usize) -> bool,
    mut visit: impl FnMut(VisitedRecords) -> Result<(), MergeError>,
) -> Result<(), MergeError> {
    let mut first = 0;
    for (frame, count) in file.frames().enumerate() {
        let numbers = first..first + count;
        first = numbers.end;
        let count = numbers.clone().filter(|number| wanted(*number)).count();
        if count == 0 {
            continue;
        }
        let records = match file.records(frame) {
            Ok(records) => records,
            Err(reason) => {
                visit(VisitedRecords::Unreadable { count, reason })?;
                continue;
            }
        };
        for (entry, number) in records.entries.iter().zip(numbers) {
            if wanted(number) {
                let record = records.record(entry.offset, entry.length).map_err(|reason| {
                    let path = file.path().to_owned();
                    ReadError::InExport { key: entry.key, path, reason }
                });
                visit(VisitedRecords::One { number, key: entry.key, record })?;
            }
        }
    }
    Ok(())
}

fn visit_store(
    reader: &StoreReader,
    keys: &[JobKey],
    wanted: impl Fn(usize) -> bool,
    mut visit: impl FnMut(VisitedRecords) -> Result<(), MergeError>,
) -> Result<(), MergeError> {
    for (part, first) in keys.chunks(KEYS_AT_ONCE).zip((0..).step_by(KEYS_AT_ONCE)) {
        let numbered = part.iter().zip(first..).filter(|(_, number)| wanted(*number));
        for (key, record) in reader.select(numbered.map(|(key, _)| *key).collect()) {
            let record = match record {
                Err(gone @ (ReadError::Gone(_) | ReadError::Unanswered { .. })) => {
                    return Err(gone.into());
                }
                record => record,
            };
            let Ok(place) = part.binary_search(&key) else { continue };
            let number = first + place;
            match record {
                Ok(record) => visit(VisitedRecords::One { number, key, record: Ok(&record) })?,
                Err(error) => visit(VisitedRecords::One { number, key, record: Err(error) })?,
            }
        }
    }
    Ok(())
}
