//! This file makes the index of the records in several exports: 48 bytes for each, which are
//! sorted. Those of more than 8 MiB stand in a file.

use std::io;
use std::path::Path;

use identity::JobKey;

use crate::exports::file::ExportFile;
use crate::paged::{PagedRows, RowPager};
use crate::scratch::{ScratchDirectory, ScratchError};
use crate::sorted::{KEY, RUN_BYTES, RowSorter};

/// The length of a row: the key of a job, and the place of its record.
const ROW: usize = KEY + 16;

/// The place of a record in a set of exports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

impl RecordPlace {
    /// Returns the place as a row. Rows are in the order of the keys, of the files, and of what
    /// stands in a file.
    fn to_row(self) -> [u8; ROW] {
        let mut row = [0; ROW];
        row[..KEY].copy_from_slice(&self.key.0);
        let numbers = [self.file, self.frame, self.offset, self.length].map(u32::to_be_bytes);
        row[KEY..].copy_from_slice(numbers.as_flattened());
        row
    }

    fn of_row(row: &[u8; ROW]) -> Self {
        let mut key = [0; KEY];
        key.copy_from_slice(&row[..KEY]);
        let (numbers, _) = row[KEY..].as_chunks::<4>();
        let number = |index: usize| u32::from_be_bytes(numbers[index]);
        let [file, frame, offset, length] = [0, 1, 2, 3].map(number);
        RecordPlace { key: JobKey(key), file, frame, offset, length }
    }
}

/// The places of all records that count, in the order of their keys and then of the files.
#[derive(Debug)]
pub(super) struct RecordIndex(PagedRows<ROW>);

impl RecordIndex {
    /// Reads the tables of all files.
    pub(super) fn of(files: &[ExportFile]) -> io::Result<Self> {
        let count: usize = files.iter().flat_map(ExportFile::frames).sum();
        if count * ROW <= RUN_BYTES {
            // Nothing is written.
            return Self::sorted(files, Path::new(""));
        }
        // The rows are in two files while they are sorted, which have no names.
        let scratch = ScratchDirectory::new((count * 2 * ROW) as u64).map_err(|error| {
            let ScratchError { bytes, tried } = error;
            let reason = format!(
                "the keys of {count} records are sorted in temporary files of {} MiB, for which \
                 there is no room: {tried}; let TMPDIR name a directory with room",
                bytes.div_ceil(1 << 20)
            );
            io::Error::new(io::ErrorKind::StorageFull, reason)
        })?;
        Self::sorted(files, scratch.path())
    }

    fn sorted(files: &[ExportFile], directory: &Path) -> io::Result<Self> {
        let mut sorter = RowSorter::new(directory);
        for (file, number) in files.iter().zip(0..) {
            for (table, frame) in file.tables().zip(0..) {
                let table = table.map_err(|reason| {
                    io::Error::other(format!("{}: {reason}", file.path().display()))
                });
                for entry in table? {
                    let place = RecordPlace {
                        key: entry.key,
                        file: number,
                        frame,
                        offset: entry.offset,
                        length: entry.length,
                    };
                    sorter.push(place.to_row())?;
                }
            }
        }
        let (mut sorted, mut rows) = (sorter.sorted()?, Vec::new());
        let mut pager = RowPager::new(directory);
        while sorted.next_job(&mut rows)? {
            // Of several records of a job in one file the last one counts.
            for of_file in rows.chunk_by(|one, next| one[..KEY + 4] == next[..KEY + 4]) {
                of_file.last().map_or(Ok(()), |last| pager.push(*last))?;
            }
        }
        Ok(RecordIndex(pager.finished()?))
    }

    /// Returns the keys of all records in ascending order.
    pub(super) fn keys(&self) -> io::Result<Vec<JobKey>> {
        let mut keys: Vec<JobKey> = Vec::with_capacity(self.0.len());
        self.visit(|place| {
            if keys.last() != Some(&place.key) {
                keys.push(place.key);
            }
        })?;
        Ok(keys)
    }

    /// Returns the places of the records of a job, one for each file that has one.
    pub(super) fn places(&self, key: &JobKey) -> io::Result<Vec<RecordPlace>> {
        Ok(self.0.of_job(key)?.iter().map(RecordPlace::of_row).collect())
    }

    /// Visits all places.
    pub(super) fn visit(&self, mut visitor: impl FnMut(RecordPlace)) -> io::Result<()> {
        self.0.visit(|row| visitor(RecordPlace::of_row(row)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_told_from_their_rows_and_sorted_by_them() {
        let place = |key: u8, file: u32, frame: u32, offset: u32| RecordPlace {
            key: JobKey([key; 32]),
            file,
            frame,
            offset,
            length: 70_000,
        };
        let places =
            [place(1, 7, 0, 0), place(2, 1, 256, 1), place(2, 256, 0, 3), place(2, 256, 1, 0)];
        let rows = places.map(RecordPlace::to_row);
        assert!(rows.is_sorted());
        assert_eq!(rows.map(|row| RecordPlace::of_row(&row)), places);
    }
}
