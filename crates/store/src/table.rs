//! The table of a study: rows of figures by column, so that a query reads only the columns that it
//! filters by and shows.
//!
//! A table is made from records and never trusted over them. It is a file of its own in the folder
//! `tables` of the store, named by the digest of its head, and never changed. The list beside it
//! (`kept.rs`) says which file is the table of a study, and counts only as long as the database has
//! the marks that it had when the records were read. So a kill at any moment leaves the old list or
//! the new one, and files that neither names, which the next writer of a list removes.
//!
//! ```text
//! pieces   the cells of a column in a block of rows, in words of the caller; zstd, or as they are
//!          if that is not shorter
//! places   of each column, for each of its pieces: position u64, length u32, length of the cells
//!          u32, the first 16 bytes of BLAKE3
//! pages    of 128 entries in the order of the keys: a job's key, its row u64
//! head     bincode: words of the caller, the number of rows, the digests of places and pages
//! ```
//!
//! Everything is reached from the head by digests, so no damage passes for a row.

use std::fs::{self, File, Permissions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::{FileExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use bincode::config::standard;
use identity::JobKey;
use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use crate::access::{inherit_owner, open_to_read};
use crate::compression::{compress, decompress};
use crate::digest::Digest;
use crate::durable::{self, UNFINISHED_PREFIX};
use crate::error::WriteError;
use crate::kept::{self, AllWords, KeptWords, TABLES};
use crate::sorted::{KEY, RowSorter, beginning};
use crate::traces::Traces;

/// The folder of tables in the directory of a store.
const FOLDER: &str = "tables";

/// The largest head that is read \[bytes\].
const HEAD_LIMIT: u64 = 64 << 20;

/// The most bytes that the cells of a piece take.
const PIECE_LIMIT: usize = 16 << 20;

/// The length of the place of a piece \[bytes\].
const PLACE: usize = 32;

/// The length of a digest of a piece or a page \[bytes\].
const SUM: usize = 16;

/// The length of an entry of a page \[bytes\].
const ENTRY: usize = KEY + 8;

/// The number of entries of a page.
const ENTRIES: usize = 128;

/// The number of bytes after which the writer of a table looks for room again. A full disk would
/// be the end of a run that writes to it.
const ROOM: u64 = 16 << 20;

/// The words of the list about a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct TablePlace {
    /// The digest of all that the table depends on beside the records.
    meaning: [u8; 32],
    /// The digest of the head, by which the file is named.
    head: [u8; 32],
    /// The position of the head, which ends the file.
    position: u64,
}

#[derive(Serialize, Deserialize)]
struct TableHead {
    caption: Vec<u8>,
    rows: u64,
    columns: Vec<ColumnPlaces>,
    /// The position of the first page.
    pages_start: u64,
    pages: Vec<KeyPage>,
}

#[derive(Serialize, Deserialize)]
struct ColumnPlaces {
    position: u64,
    digest: [u8; 32],
}

#[derive(Serialize, Deserialize)]
struct KeyPage {
    /// The first eight bytes of the first key.
    first: u64,
    sum: [u8; SUM],
}

fn sum_of(bytes: &[u8]) -> [u8; SUM] {
    let mut sum = [0; SUM];
    sum.copy_from_slice(&blake3::hash(bytes).as_bytes()[..SUM]);
    sum
}

fn damaged(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("the table of the study {reason}"))
}

/// A table of a study, opened for reading.
pub struct KeptTable {
    file: File,
    length: u64,
    head: TableHead,
    /// The places of the pieces of each column, once they were read.
    places: Vec<OnceLock<Vec<[u8; PLACE]>>>,
}

impl KeptTable {
    /// The number of rows in a block; the last one may have fewer.
    pub const BLOCK: usize = 1024;

    /// Opens the table that the list of a store names for a study, if it means the same.
    pub(crate) fn of(directory: &Path, words: &KeptWords, meaning: &Digest) -> Option<KeptTable> {
        let (place, _): (TablePlace, usize) =
            bincode::serde::decode_from_slice(&words.words, standard()).ok()?;
        if place.meaning != meaning.0 {
            return None;
        }
        let file = open_to_read(&path_of(directory, &Digest(place.head))).ok()?;
        Self::read(file, &place).ok()
    }

    fn read(file: File, place: &TablePlace) -> io::Result<KeptTable> {
        let length = file.metadata()?.len();
        let head_length = length.checked_sub(place.position).filter(|rest| *rest <= HEAD_LIMIT);
        let head_length = head_length.ok_or_else(|| damaged("has no head"))?;
        let mut bytes = vec![0; head_length as usize];
        file.read_exact_at(&mut bytes, place.position)?;
        if Digest::of(&bytes).0 != place.head {
            return Err(damaged("has a head that differs from what was written"));
        }
        let decoded = bincode::serde::decode_from_slice(&bytes, standard());
        let (head, _): (TableHead, usize) =
            decoded.map_err(|_| damaged("has a head that cannot be read"))?;
        let table = KeptTable {
            places: head.columns.iter().map(|_| OnceLock::new()).collect(),
            file,
            length,
            head,
        };
        // A number of rows that is not followed by their places would take any memory.
        let places = table.head.rows.div_ceil(Self::BLOCK as u64).checked_mul(PLACE as u64);
        let is_within = |position: u64| {
            places.and_then(|places| position.checked_add(places)).is_some_and(|end| end <= length)
        };
        if table.head.columns.is_empty()
            || !table.head.columns.iter().all(|column| is_within(column.position))
        {
            return Err(damaged("has fewer rows than its head says"));
        }
        Ok(table)
    }

    /// Returns the words with which the table was written.
    pub fn caption(&self) -> &[u8] {
        &self.head.caption
    }

    /// Returns the number of rows.
    pub fn row_count(&self) -> usize {
        self.head.rows as usize
    }

    /// Returns the number of columns.
    pub fn column_count(&self) -> usize {
        self.head.columns.len()
    }

    /// Returns the cells of a column in a block of rows, as they were written.
    ///
    /// # Errors
    /// They are damaged, or cannot be read.
    pub fn piece(&self, column: usize, block: usize) -> io::Result<Vec<u8>> {
        let places = self.places(column)?;
        let place = places.get(block).ok_or_else(|| damaged("has no such block"))?;
        let (bytes, length) = self.stored_piece(place)?;
        if bytes.len() == length {
            return Ok(bytes);
        }
        let cells = decompress(&bytes, length)?;
        if cells.len() == length { Ok(cells) } else { Err(damaged("has a piece cut short")) }
    }

    /// Reads all cells of a column, and fails if some of them are damaged.
    ///
    /// # Errors
    /// They are damaged, or cannot be read.
    pub fn verify_column(&self, column: usize) -> io::Result<()> {
        self.places(column)?.iter().try_for_each(|place| self.stored_piece(place).map(drop))
    }

    /// Reads a piece as it is stored, and returns the length of its cells as well.
    fn stored_piece(&self, place: &[u8; PLACE]) -> io::Result<(Vec<u8>, usize)> {
        let number = |start: usize| {
            place[start..].first_chunk().map_or(u32::MAX, |bytes| u32::from_le_bytes(*bytes))
        };
        let position = place.first_chunk().map_or(u64::MAX, |bytes| u64::from_le_bytes(*bytes));
        let (stored, length) = (number(8) as usize, number(12) as usize);
        if stored > length || length > PIECE_LIMIT {
            return Err(damaged("claims a larger piece than any has"));
        }
        let bytes = self.bytes(position, stored)?;
        match sum_of(&bytes) == place[SUM..] {
            true => Ok((bytes, length)),
            false => Err(damaged("has a piece that differs from what was written")),
        }
    }

    /// Returns the places of the pieces of a column.
    fn places(&self, column: usize) -> io::Result<&[[u8; PLACE]]> {
        let there = (self.places.get(column), self.head.columns.get(column));
        let (Some(places), Some(listed)) = there else { return Err(damaged("has no such column")) };
        if let Some(places) = places.get() {
            return Ok(places);
        }
        let blocks = self.row_count().div_ceil(Self::BLOCK);
        let bytes = self.bytes(listed.position, blocks * PLACE)?;
        if Digest::of(&bytes).0 != listed.digest {
            return Err(damaged("has places that differ from what was written"));
        }
        Ok(places.get_or_init(|| bytes.as_chunks().0.to_vec()))
    }

    /// Returns the rows of the job with a key, in ascending order.
    ///
    /// # Errors
    /// The pages of keys are damaged, or cannot be read.
    pub fn rows_of(&self, key: &JobKey) -> io::Result<Vec<usize>> {
        let sought = beginning(&key.0);
        let pages = &self.head.pages;
        // Entries of a key may go on over several pages, and begin in one before.
        let first = pages.partition_point(|page| page.first < sought).saturating_sub(1);
        let mut rows = Vec::new();
        for (number, page) in pages.iter().enumerate().skip(first) {
            if page.first > sought {
                break;
            }
            let start = number as u64 * (ENTRIES * ENTRY) as u64;
            let left = self.head.rows.saturating_sub((number * ENTRIES) as u64);
            let entries = left.min(ENTRIES as u64) as usize;
            let position = self.head.pages_start.checked_add(start);
            let bytes = self.bytes(position.unwrap_or(u64::MAX), entries * ENTRY)?;
            if sum_of(&bytes) != page.sum {
                return Err(damaged("has a page of keys that differs from what was written"));
            }
            for entry in bytes.as_chunks::<ENTRY>().0 {
                let row = beginning(&entry[KEY..]);
                if entry[..KEY] == key.0 && row < self.head.rows {
                    rows.push(row as usize);
                }
            }
        }
        rows.sort_unstable();
        Ok(rows)
    }

    fn bytes(&self, position: u64, length: usize) -> io::Result<Vec<u8>> {
        let end = position.checked_add(length as u64);
        if end.is_none_or(|end| end > self.length) {
            return Err(damaged("ends before what it refers to"));
        }
        let mut bytes = vec![0; length];
        self.file.read_exact_at(&mut bytes, position)?;
        Ok(bytes)
    }
}

/// A table that is being written. Unless it is [finished](TableBuilder::finish), nothing stays.
pub struct TableBuilder {
    store: PathBuf,
    /// The marks that the database had while the records were read.
    marks: Traces,
    file: BufWriter<NamedTempFile>,
    position: u64,
    /// The position up to which there was room when it was last looked for.
    room: u64,
    /// The places of the pieces of each column.
    places: Vec<Vec<[u8; PLACE]>>,
    keys: RowSorter<{ KEY + 8 }>,
    rows: u64,
}

impl TableBuilder {
    /// Begins a table with so many columns in the store at a path, whose records are read while
    /// the database has some marks.
    pub(crate) fn new(store: &Path, columns: usize, marks: Traces) -> io::Result<Self> {
        let folder = store.join(FOLDER);
        if !durable::is_present(&folder) {
            durable::create_directory(&folder)?;
        }
        if columns == 0 || !durable::is_real_directory(&folder) {
            return Err(io::Error::other("there is no place for a table"));
        }
        let file = tempfile::Builder::new()
            .prefix(UNFINISHED_PREFIX)
            .permissions(Permissions::from_mode(0o666))
            .tempfile_in(&folder)?;
        Ok(TableBuilder {
            store: store.to_owned(),
            marks,
            file: BufWriter::new(file),
            position: 0,
            room: 0,
            places: vec![Vec::new(); columns],
            keys: RowSorter::new(&folder),
            rows: 0,
        })
    }

    /// Adds a block of rows: the keys of their jobs, and the cells of each column. All blocks but
    /// the last have [`KeptTable::BLOCK`] rows.
    ///
    /// # Errors
    /// There is no room, a piece is too large, or the bytes cannot be written.
    pub fn push(&mut self, keys: &[JobKey], pieces: &[Vec<u8>]) -> io::Result<()> {
        let is_full = self.rows.is_multiple_of(KeptTable::BLOCK as u64);
        if !is_full || keys.len() > KeptTable::BLOCK || pieces.len() != self.places.len() {
            return Err(io::Error::other("the blocks of a table have so many rows and columns"));
        }
        for (column, cells) in pieces.iter().enumerate() {
            if cells.len() > PIECE_LIMIT {
                return Err(io::Error::other("a piece of the table is too large"));
            }
            // The fastest level: numbers of 53 random bits hardly shrink at any.
            let short = compress(cells, 1)?;
            let stored: &[u8] = if short.len() < cells.len() { &short } else { cells };
            let mut place = [0; PLACE];
            place[..8].copy_from_slice(&self.position.to_le_bytes());
            place[8..12].copy_from_slice(&(stored.len() as u32).to_le_bytes());
            place[12..16].copy_from_slice(&(cells.len() as u32).to_le_bytes());
            place[16..].copy_from_slice(&sum_of(stored));
            self.places[column].push(place);
            self.write(stored)?;
        }
        for key in keys {
            let mut row = [0; KEY + 8];
            row[..KEY].copy_from_slice(&key.0);
            row[KEY..].copy_from_slice(&self.rows.to_be_bytes());
            self.keys.push(row)?;
            self.rows += 1;
        }
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let end = self.position + bytes.len() as u64;
        if end > self.room {
            let needed = bytes.len() as u64 + ROOM;
            WriteError::require_space(&self.store, needed).map_err(io::Error::other)?;
            self.room = end + ROOM;
        }
        self.position = end;
        self.file.write_all(bytes)
    }

    /// Ends the table as that of a study, with words of the caller and the digest of all that it
    /// depends on beside the records. It `is_final` if it holds whatever records come beside those
    /// that there are. If the database has changed since its records were read, nothing is kept.
    ///
    /// # Errors
    /// The bytes cannot be written.
    pub fn finish(
        mut self,
        study: &str,
        meaning: &Digest,
        caption: Vec<u8>,
        is_final: bool,
    ) -> io::Result<()> {
        let (head, position) = self.end(caption)?;
        let TableBuilder { store, marks, file, .. } = self;
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        inherit_owner(file.as_file(), file.path())?;
        let path = path_of(&store, &head);
        let place = TablePlace { meaning: meaning.0, head: head.0, position };
        let words = bincode::serde::encode_to_vec(place, standard()).map_err(io::Error::other)?;
        if !Traces::of(&store).is_ok_and(|now| now.is_same(&marks)) {
            return Ok(());
        }
        // It need not be durable: after a power failure its digest tells what became of it.
        file.persist(&path).map_err(|failed| failed.error)?;
        let mut list = kept::read(&store, TABLES);
        list.insert(study.to_owned(), KeptWords { words, is_final });
        kept::write(&store, TABLES, &marks, &list)?;
        remove_others(&store, &list)
    }

    /// Writes what follows the pieces, and returns the digest and the position of the head.
    fn end(&mut self, caption: Vec<u8>) -> io::Result<(Digest, u64)> {
        let mut columns = Vec::new();
        for places in std::mem::take(&mut self.places) {
            let bytes = places.as_flattened();
            columns.push(ColumnPlaces { position: self.position, digest: Digest::of(bytes).0 });
            self.write(bytes)?;
        }
        let empty = RowSorter::new(&self.store.join(FOLDER));
        let mut sorted = std::mem::replace(&mut self.keys, empty).sorted()?;
        let (pages_start, mut pages) = (self.position, Vec::new());
        let (mut page, mut rows) = (Vec::new(), Vec::new());
        loop {
            let goes_on = sorted.next_job(&mut rows)?;
            for row in &rows {
                page.extend_from_slice(row);
                if page.len() == ENTRIES * ENTRY {
                    pages.push(KeyPage { first: beginning(&page), sum: sum_of(&page) });
                    self.write(&std::mem::take(&mut page))?;
                }
            }
            if !goes_on {
                break;
            }
        }
        if !page.is_empty() {
            pages.push(KeyPage { first: beginning(&page), sum: sum_of(&page) });
            self.write(&page)?;
        }
        let head = TableHead { caption, rows: self.rows, columns, pages_start, pages };
        let bytes = bincode::serde::encode_to_vec(head, standard()).map_err(io::Error::other)?;
        let position = self.position;
        self.write(&bytes)?;
        Ok((Digest::of(&bytes), position))
    }
}

/// Returns the path of the table with a head in the store in `directory`.
fn path_of(directory: &Path, head: &Digest) -> PathBuf {
    directory.join(FOLDER).join(head.to_string())
}

/// Removes the tables that a list does not name from the store in `directory`.
fn remove_others(directory: &Path, list: &AllWords) -> io::Result<()> {
    let named = |words: &KeptWords| -> Option<Digest> {
        let place = bincode::serde::decode_from_slice::<TablePlace, _>(&words.words, standard());
        Some(Digest(place.ok()?.0.head))
    };
    let named: Vec<Digest> = list.values().filter_map(named).collect();
    for entry in fs::read_dir(directory.join(FOLDER))? {
        let entry = entry?;
        let digest = entry.file_name().to_str().and_then(|name| name.parse::<Digest>().ok());
        if digest.is_some_and(|digest| !named.contains(&digest)) {
            // Another process may be quicker.
            let _ = fs::remove_file(entry.path());
        }
    }
    Ok(())
}

/// The tables of a store that is open for writing. When this is dropped, after the list was
/// written, those that it does not name are removed, and what killed writers have left.
pub(crate) struct TableFolder {
    pub(crate) store: PathBuf,
}

impl TableFolder {
    fn tidy(&self) -> io::Result<()> {
        let folder = self.store.join(FOLDER);
        if durable::is_real_directory(&folder) {
            durable::clear_unfinished(&folder)?;
            remove_others(&self.store, &kept::read(&self.store, TABLES))?;
        }
        Ok(())
    }
}

impl Drop for TableFolder {
    fn drop(&mut self) {
        // What is left takes room and is in nobody's way.
        let _ = self.tidy();
    }
}
