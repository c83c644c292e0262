//! This file sorts rows that need not fit into memory. Every row begins with the key of a job.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

/// The size of the rows that are sorted in memory \[bytes\]. Of more rows, each run of this size is
/// sorted and written to a file.
pub(crate) const RUN_BYTES: usize = 8 << 20;

/// The size of what is read of all runs together at once \[bytes\].
const READ_BYTES: usize = 4 << 20;

/// The smallest and the largest size of what is read of one run at once \[bytes\].
const PIECES: [usize; 2] = [4 << 10, 64 << 10];

/// The length of the key at the beginning of a row \[bytes\].
pub(crate) const KEY: usize = 32;

/// Rows of `N` bytes that are gathered to be read in ascending order. The file that they go to has
/// no name, so that a kill leaves nothing behind.
pub(crate) struct RowSorter<const N: usize> {
    directory: PathBuf,
    rows: Vec<[u8; N]>,
    file: Option<File>,
    /// The end of each run in the file \[bytes\].
    ends: Vec<u64>,
    /// The largest number of rows in a run.
    limit: usize,
}

impl<const N: usize> RowSorter<N> {
    /// Returns an empty sorter, whose file would be in `directory`.
    pub(crate) fn new(directory: &Path) -> Self {
        let (directory, limit) = (directory.to_owned(), RUN_BYTES / N);
        RowSorter { directory, rows: Vec::new(), file: None, ends: Vec::new(), limit }
    }

    /// Adds a row.
    pub(crate) fn push(&mut self, row: [u8; N]) -> io::Result<()> {
        if self.rows.len() >= self.limit {
            self.write_run()?;
        }
        self.rows.push(row);
        Ok(())
    }

    fn write_run(&mut self) -> io::Result<()> {
        self.rows.sort_unstable();
        let file = match &mut self.file {
            Some(file) => file,
            absent => absent.insert(tempfile::tempfile_in(&self.directory)?),
        };
        let (start, bytes) = (self.ends.last().copied().unwrap_or(0), self.rows.as_flattened());
        file.write_all_at(bytes, start)?;
        self.ends.push(start + bytes.len() as u64);
        self.rows.clear();
        Ok(())
    }

    /// Returns the rows in ascending order.
    pub(crate) fn sorted(mut self) -> io::Result<SortedRows<N>> {
        self.rows.sort_unstable();
        let mut position = 0;
        let mut runs: Vec<RowRun<N>> = Vec::new();
        for end in self.ends {
            runs.push(RowRun { rows: Vec::new(), next: 0, position, end });
            position = end;
        }
        runs.push(RowRun { rows: self.rows, next: 0, position, end: position });
        let [least, most] = PIECES;
        let piece = ((READ_BYTES / runs.len()).clamp(least, most) / N).max(1);
        let mut sorted = SortedRows { file: self.file, runs, heads: BinaryHeap::new(), piece };
        (0..sorted.runs.len()).try_for_each(|run| sorted.advance(run))?;
        Ok(sorted)
    }
}

/// Rows in ascending order.
pub(crate) struct SortedRows<const N: usize> {
    file: Option<File>,
    runs: Vec<RowRun<N>>,
    /// The first row of each run that was not taken yet, with the number of the run.
    heads: BinaryHeap<Reverse<([u8; N], usize)>>,
    /// The number of rows that are read of a run at once.
    piece: usize,
}

/// A run of sorted rows, of which some are in memory and the rest is in the file.
struct RowRun<const N: usize> {
    rows: Vec<[u8; N]>,
    /// The number of the next one of these rows.
    next: usize,
    /// The place of what was not read yet \[bytes\].
    position: u64,
    end: u64,
}

impl<const N: usize> SortedRows<N> {
    /// Puts all rows of the next job into `rows`, and returns false if there is no more.
    pub(crate) fn next_job(&mut self, rows: &mut Vec<[u8; N]>) -> io::Result<bool> {
        rows.clear();
        while let Some(Reverse((row, run))) = self.heads.peek().copied() {
            if rows.first().is_some_and(|first| first[..KEY] != row[..KEY]) {
                break;
            }
            rows.push(row);
            self.heads.pop();
            self.advance(run)?;
        }
        Ok(!rows.is_empty())
    }

    /// Lets the next row of a run wait among the others.
    fn advance(&mut self, number: usize) -> io::Result<()> {
        let run = &mut self.runs[number];
        if run.next == run.rows.len()
            && let Some(file) = &self.file
        {
            let left = usize::try_from((run.end - run.position) / N as u64).unwrap_or(usize::MAX);
            run.next = 0;
            run.rows.resize(left.min(self.piece), [0; N]);
            let bytes = run.rows.as_flattened_mut();
            file.read_exact_at(bytes, run.position)?;
            run.position += bytes.len() as u64;
        }
        if let Some(row) = run.rows.get(run.next) {
            run.next += 1;
            self.heads.push(Reverse((*row, number)));
        }
        Ok(())
    }
}

/// Returns the first eight bytes of a key or of a row.
pub(crate) fn beginning(bytes: &[u8]) -> u64 {
    bytes.first_chunk().map_or(0, |first| u64::from_be_bytes(*first))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const N: usize = KEY + 2;

    fn row(key: u8, rest: u16) -> [u8; N] {
        let mut row = [key; N];
        row[KEY..].copy_from_slice(&rest.to_be_bytes());
        row
    }

    fn jobs(mut sorted: SortedRows<N>) -> Vec<Vec<[u8; N]>> {
        let (mut jobs, mut rows) = (Vec::new(), Vec::new());
        while sorted.next_job(&mut rows).unwrap() {
            jobs.push(rows.clone());
        }
        assert!(!sorted.next_job(&mut rows).unwrap());
        jobs
    }

    proptest! {
        #[test]
        fn rows_come_in_order_and_those_of_a_job_together(
            rows in proptest::collection::vec((0..20u8, any::<u16>()), 0..300), limit in 1..40usize,
        ) {
            let directory = tempfile::tempdir().unwrap();
            let mut rows: Vec<[u8; N]> = rows.into_iter().map(|(key, rest)| row(key, rest)).collect();
            let mut sorter = RowSorter { limit, ..RowSorter::new(directory.path()) };
            rows.iter().try_for_each(|row| sorter.push(*row)).unwrap();
            prop_assert_eq!(sorter.file.is_some(), rows.len() > limit);
            // Little is read at once, so that every run is read in several pieces.
            let mut sorted = sorter.sorted().unwrap();
            sorted.piece = 3;
            let found = jobs(sorted);
            rows.sort_unstable();
            let expected: Vec<Vec<[u8; N]>> =
                rows.chunk_by(|one, next| one[0] == next[0]).map(<[_]>::to_vec).collect();
            prop_assert_eq!(found, expected);
            prop_assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
        }
    }
}
