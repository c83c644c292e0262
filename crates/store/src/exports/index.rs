//! This file makes the index of the records in several exports: 48 bytes for each.

use std::io;

use identity::JobKey;

use crate::error::ReadError;
use crate::exports::file::ExportFile;

/// The place of a record in a set of exports.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordPlace {
    pub(super) key: JobKey,
    /// The number of the file in the set.
    pub(super) file: u32,
    /// The number of the frame in the file.
    pub(super) frame: u32,
    /// The place of the record in its frame \[bytes\].
    pub(super) offset: u32,
    /// The length of the record \[bytes\].
    pub(super) length: u32,
}

/// The places of all records that count, in the order of their keys and then of the files.
#[derive(Debug)]
pub(super) struct RecordIndex(Vec<RecordPlace>);

impl RecordIndex {
    /// Reads the tables of all files.
    pub(super) fn of(files: &[ExportFile]) -> Result<Self, ReadError> {
        let mut places = Vec::with_capacity(files.iter().flat_map(ExportFile::frames).sum());
        for (file, number) in files.iter().zip(0..) {
            let start = places.len();
            for (table, frame) in file.tables().zip(0..) {
                let entries = table.map_err(|reason| ReadError::Io {
                    path: file.path().to_owned(),
                    source: io::Error::other(reason),
                })?;
                places.extend(entries.into_iter().map(|entry| RecordPlace {
                    key: entry.key,
                    file: number,
                    frame,
                    offset: entry.offset,
                    length: entry.length,
                }));
            }
            keep_last(&mut places, start);
        }
        places.sort_unstable_by_key(|place| (place.key, place.file));
        places.shrink_to_fit();
        Ok(RecordIndex(places))
    }

    /// Returns the keys of all records in ascending order.
    pub(super) fn keys(&self) -> Vec<JobKey> {
        let mut keys: Vec<JobKey> = self.0.iter().map(|place| place.key).collect();
        keys.dedup();
        keys
    }

    /// Returns the places of the records of a job, one for each file that has one.
    pub(super) fn places(&self, key: &JobKey) -> &[RecordPlace] {
        let start = self.0.partition_point(|place| place.key < *key);
        let count = self.0[start..].iter().take_while(|place| place.key == *key).count();
        &self.0[start..start + count]
    }

    pub(super) fn all(&self) -> &[RecordPlace] {
        &self.0
    }
}

/// Keeps the last record of each job among the `places` of one file, which begin at `start`.
fn keep_last(places: &mut Vec<RecordPlace>, start: usize) {
    let of_file = &mut places[start..];
    of_file.sort_by_key(|place| place.key);
    let mut kept = 0;
    for next in 0..of_file.len() {
        let is_last = of_file.get(next + 1).is_none_or(|later| later.key != of_file[next].key);
        if is_last {
            of_file[kept] = of_file[next];
            kept += 1;
        }
    }
    places.truncate(start + kept);
}
