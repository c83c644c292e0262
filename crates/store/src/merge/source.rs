//! This file holds a place from which a merge takes records.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use identity::JobKey;

use crate::digest::Digest;
use crate::error::ReadError;
use crate::exports::{ExportSet, ShardState};
use crate::merge::report::MergeError;
use crate::parts;
use crate::reader::StoreReader;

/// A place from which records come: a store, or one of several exports.
pub(super) struct MergeSource<'s> {
    pub(super) reader: &'s StoreReader,
    /// The exports and the number of the one among them, if it is one.
    pub(super) export: Option<(Arc<ExportSet>, u32)>,
    pub(super) path: PathBuf,
    /// True if this is what the target held before, of which everything stays.
    pub(super) is_target: bool,
}

impl MergeSource<'_> {
    /// Lists what is read by `reader`.
    pub(super) fn all_of(reader: &StoreReader) -> Vec<MergeSource<'_>> {
        let Some(set) = reader.export_set() else {
            let path = reader.path().to_owned();
            return vec![MergeSource { reader, export: None, path, is_target: false }];
        };
        let paths = set.files.iter().map(|file| file.path().to_owned());
        paths
            .zip(0..)
            .map(|(path, number)| {
                let export = Some((set.clone(), number));
                MergeSource { reader, export, path, is_target: false }
            })
            .collect()
    }

    pub(super) fn keys(&self) -> Result<Vec<JobKey>, ReadError> {
        match &self.export {
            Some((set, number)) => Ok(set.keys_of(*number).collect()),
            None => self.reader.keys(),
        }
    }

    /// Returns the jobs among `keys` that have a record here, be it a damaged one.
    pub(super) fn having(&self, keys: &[JobKey]) -> Result<Vec<JobKey>, ReadError> {
        let is_there = match &self.export {
            Some((set, number)) => {
                let is_in = |key| set.places(key).iter().any(|place| place.file == *number);
                keys.iter().map(is_in).collect()
            }
            None => self.reader.contains(keys)?,
        };
        let found = keys.iter().zip(is_there).filter(|(_, is_there)| *is_there);
        Ok(found.map(|(key, _)| *key).collect())
    }

    pub(super) fn studies(&self) -> Result<BTreeMap<String, Digest>, ReadError> {
        match &self.export {
            Some((set, number)) => Ok(set.files[*number as usize].studies.clone()),
            None => self.reader.studies(),
        }
    }

    pub(super) fn shards(&self) -> Vec<ShardState> {
        match &self.export {
            Some((set, number)) => set.files[*number as usize].summary.shards(),
            None => parts::read(&self.path),
        }
    }

    /// Visits the records that are `wanted`.
    pub(super) fn visit(
        &self,
        wanted: impl Fn(&JobKey) -> bool,
        mut visit: impl FnMut(&JobKey, Result<&[u8], ReadError>) -> Result<(), MergeError>,
    ) -> Result<(), MergeError> {
        if let Some((set, number)) = &self.export {
            return set.visit(*number, wanted, visit);
        }
        let keys = self.reader.keys()?.into_iter().filter(wanted).collect();
        for (key, record) in self.reader.select(keys) {
            match record {
                Err(gone @ (ReadError::Gone(_) | ReadError::Unanswered { .. })) => {
                    return Err(gone.into());
                }
                Ok(record) => visit(&key, Ok(&record))?,
                Err(error) => visit(&key, Err(error))?,
            }
        }
        Ok(())
    }
}
