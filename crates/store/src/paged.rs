//! This file keeps sorted rows of which only little is in memory. Every row begins with the key of
//! a job.
//!
//! Rows that take more than [`RUN_BYTES`] stand in a file in pages, and 8 bytes of each page are
//! kept: 0.1 bytes for a row of 48.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use identity::JobKey;

use crate::sorted::{KEY, RUN_BYTES, beginning};

/// The size of a page \[bytes\].
const PAGE_BYTES: usize = 4 << 10;

/// The rows as they are kept.
#[derive(Debug)]
enum KeptRows<const N: usize> {
    Memory(Vec<[u8; N]>),
    /// The file has no name, so that a kill leaves nothing behind.
    File(File),
}

/// Rows of `N` bytes in ascending order.
#[derive(Debug)]
pub(crate) struct PagedRows<const N: usize> {
    /// The beginning of the key of the first row of each page.
    pages: Vec<u64>,
    /// The number of rows.
    count: usize,
    rows: KeptRows<N>,
}

/// Rows of `N` bytes that come in ascending order and are to be kept.
pub(crate) struct RowPager<const N: usize> {
    directory: PathBuf,
    pages: Vec<u64>,
    count: usize,
    /// The rows that are not in the file.
    rows: Vec<[u8; N]>,
    file: Option<File>,
    /// The largest number of rows in memory.
    limit: usize,
}

impl<const N: usize> RowPager<N> {
    /// Returns an empty pager, whose file would be in `directory`.
    pub(crate) fn new(directory: &Path) -> Self {
        let (directory, limit) = (directory.to_owned(), RUN_BYTES / N);
        RowPager { directory, pages: Vec::new(), count: 0, rows: Vec::new(), file: None, limit }
    }

    /// Adds a row, which is not less than any before it.
    pub(crate) fn push(&mut self, row: [u8; N]) -> io::Result<()> {
        if self.rows.len() >= self.limit {
            self.write()?;
        }
        if self.count.is_multiple_of(PagedRows::<N>::ROWS) {
            self.pages.push(beginning(&row));
        }
        self.count += 1;
        self.rows.push(row);
        Ok(())
    }

    fn write(&mut self) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            absent => absent.insert(tempfile::tempfile_in(&self.directory)?),
        };
        let start = ((self.count - self.rows.len()) * N) as u64;
        file.write_all_at(self.rows.as_flattened(), start)?;
        self.rows.clear();
        Ok(())
    }

    /// Returns the rows.
    pub(crate) fn finished(mut self) -> io::Result<PagedRows<N>> {
        if self.file.is_some() {
            self.write()?;
        }
        self.rows.shrink_to_fit();
        let rows = match self.file {
            Some(file) => KeptRows::File(file),
            None => KeptRows::Memory(self.rows),
        };
        Ok(PagedRows { pages: self.pages, count: self.count, rows })
    }
}

impl<const N: usize> PagedRows<N> {
    /// The number of rows in a page.
    const ROWS: usize = if PAGE_BYTES > N { PAGE_BYTES / N } else { 1 };

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Returns the rows of a job.
    pub(crate) fn of_job(&self, key: &JobKey) -> io::Result<Vec<[u8; N]>> {
        let mut found = Vec::new();
        // Pages whose first keys begin alike may hold the job in any of them, and one before too.
        let sought = beginning(&key.0);
        let first = self.pages.partition_point(|page| *page < sought).saturating_sub(1);
        self.visit_from(first, |row| {
            if row[..KEY] == key.0 {
                found.push(*row);
            }
            row[..KEY] <= key.0[..]
        })?;
        Ok(found)
    }

    /// Visits all rows.
    pub(crate) fn visit(&self, mut visitor: impl FnMut(&[u8; N])) -> io::Result<()> {
        self.visit_from(0, |row| {
            visitor(row);
            true
        })
    }

    /// Visits the rows from a page on, until the visitor returns false.
    fn visit_from(
        &self,
        first: usize,
        mut visitor: impl FnMut(&[u8; N]) -> bool,
    ) -> io::Result<()> {
        let mut buffer: Vec<[u8; N]> = Vec::new();
        for page in first..self.pages.len() {
            let (start, end) = (page * Self::ROWS, self.count.min((page + 1) * Self::ROWS));
            let rows = match &self.rows {
                KeptRows::Memory(rows) => &rows[start..end],
                KeptRows::File(file) => {
                    buffer.resize(end - start, [0; N]);
                    file.read_exact_at(buffer.as_flattened_mut(), (start * N) as u64)?;
                    &buffer[..]
                }
            };
            if !rows.iter().all(&mut visitor) {
                return Ok(());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A page has 11 rows of this size.
    const N: usize = 360;

    fn row(key: u8, rest: u16) -> [u8; N] {
        let mut row = [7; N];
        // The first eight bytes of all keys are alike.
        row[KEY - 1] = key;
        row[KEY..KEY + 2].copy_from_slice(&rest.to_be_bytes());
        row
    }

    proptest! {
        #[test]
        fn rows_are_found_in_memory_and_in_a_file(
            mut rows in proptest::collection::vec((0..20u8, any::<u16>()), 0..100),
            limit in 1..120usize, distinct: bool,
        ) {
            let directory = tempfile::tempdir().unwrap();
            rows.sort_unstable();
            let rows: Vec<[u8; N]> = rows.into_iter().map(|(key, rest)| {
                let mut row = row(key, rest);
                row[0] = if distinct { key } else { 0 };
                row
            }).collect();
            let mut pager = RowPager { limit, ..RowPager::new(directory.path()) };
            rows.iter().try_for_each(|row| pager.push(*row)).unwrap();
            let paged = pager.finished().unwrap();
            prop_assert_eq!(matches!(paged.rows, KeptRows::File(_)), rows.len() > limit);
            prop_assert_eq!(paged.len(), rows.len());
            let mut all = Vec::new();
            paged.visit(|row| all.push(*row)).unwrap();
            prop_assert_eq!(&all, &rows);
            for number in 0..21u8 {
                let mut key = [0; KEY];
                key.copy_from_slice(&row(number, 0)[..KEY]);
                key[0] = if distinct { number } else { 0 };
                let expected: Vec<_> =
                    rows.iter().copied().filter(|row| row[..KEY] == key).collect();
                prop_assert_eq!(paged.of_job(&JobKey(key)).unwrap(), expected);
            }
            prop_assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
        }
    }
}
