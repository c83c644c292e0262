//! This file copies the records of a database into a file from which they are read with little
//! memory.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use identity::JobKey;

use crate::database::{Database, Fault};
use crate::error::{Answer, ReadError};
use crate::paged::{PagedRows, RowPager};
use crate::record;
use crate::sorted::KEY;

/// The length of a row: the key of a job, and the place and the length of its record.
const ROW: usize = KEY + 12;

/// The records of a database as they were copied.
pub(crate) struct FlatRecords {
    rows: PagedRows<ROW>,
    /// The sealed records, one after the other. The file has no name any more.
    sealed: File,
    /// The directory in which the copy was made.
    directory: PathBuf,
}

impl FlatRecords {
    /// Copies the records of the database in `directory`, which is written to, into a file without
    /// a name in `scratch`.
    pub(crate) fn of(directory: &Path, scratch: &Path) -> Result<Self, Fault> {
        let database = open(directory)?;
        let mut sealed = BufWriter::new(tempfile::tempfile_in(scratch).map_err(Fault::Io)?);
        let (mut pager, mut end, mut count) = (RowPager::new(scratch), 0, 0);
        let mut outcome: Result<(), Fault> = Ok(());
        let copied = database.visit_while(|key, value| {
            outcome = row(key, end, value).and_then(|row| {
                pager.push(row).map_err(Fault::Io)?;
                sealed.write_all(value).map_err(Fault::Io)
            });
            end += value.len() as u64;
            count += 1;
            outcome.is_ok()
        });
        outcome?;
        copied.map_err(|fault| match fault.is_damage() {
            true => Fault::Damaged(format!(
                "the database of records cannot be read: {fault} ({count} records were found)"
            )),
            false => fault,
        })?;
        drop(database);
        let sealed = sealed.into_inner().map_err(|error| Fault::Io(error.into_error()))?;
        let rows = pager.finished().map_err(Fault::Io)?;
        Ok(FlatRecords { rows, sealed, directory: scratch.to_owned() })
    }

    /// Returns the number of records.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Returns the keys of all records in ascending order.
    pub(crate) fn keys(&self) -> Result<Vec<JobKey>, ReadError> {
        let mut keys = Vec::with_capacity(self.len());
        self.rows.visit(|row| keys.push(key_of(row))).map_err(|error| self.unreadable(error))?;
        Ok(keys)
    }

    pub(crate) fn contains(&self, key: &JobKey) -> Result<bool, ReadError> {
        let rows = self.rows.of_job(key).map_err(|error| self.unreadable(error))?;
        Ok(!rows.is_empty())
    }

    /// Returns the verified record of a job, or `None` if it has none.
    pub(crate) fn get(&self, key: &JobKey) -> Answer {
        let rows = self.rows.of_job(key).map_err(|error| self.unreadable(error))?;
        let Some(row) = rows.first() else { return Ok(None) };
        let (start, length) = place_of(row);
        let mut sealed = vec![0; length];
        self.sealed.read_exact_at(&mut sealed, start).map_err(|error| self.unreadable(error))?;
        Ok(Some(record::unseal(key, &sealed).map_err(|reason| reason.of_job(key))?.to_vec()))
    }

    /// Returns true if every record is sound, be it for another version of this crate.
    pub(crate) fn is_sound(&self) -> bool {
        let is_sound =
            |key: &JobKey| matches!(self.get(key), Ok(_) | Err(ReadError::Version { .. }));
        self.keys().is_ok_and(|keys| keys.iter().all(is_sound))
    }

    fn unreadable(&self, source: io::Error) -> ReadError {
        ReadError::Io { path: self.directory.clone(), source }
    }
}

fn open(directory: &Path) -> Result<Database, Fault> {
    Database::open(directory).map_err(Fault::of_opening)
}

/// Returns the row of a record that begins at `start`.
fn row(key: &[u8], start: u64, sealed: &[u8]) -> Result<[u8; ROW], Fault> {
    let mut row = [0; ROW];
    if key.len() != KEY {
        let reason = "the database holds entries whose keys are not of 32 bytes";
        return Err(Fault::Damaged(reason.to_owned()));
    }
    row[..KEY].copy_from_slice(key);
    row[KEY..KEY + 8].copy_from_slice(&start.to_be_bytes());
    row[KEY + 8..].copy_from_slice(&(sealed.len() as u32).to_be_bytes());
    Ok(row)
}

fn key_of(row: &[u8; ROW]) -> JobKey {
    let mut key = [0; KEY];
    key.copy_from_slice(&row[..KEY]);
    JobKey(key)
}

/// Returns the place and the length of a record \[bytes\].
fn place_of(row: &[u8; ROW]) -> (u64, usize) {
    let (mut start, mut length) = ([0; 8], [0; 4]);
    start.copy_from_slice(&row[KEY..KEY + 8]);
    length.copy_from_slice(&row[KEY + 8..]);
    (u64::from_be_bytes(start), u32::from_be_bytes(length) as usize)
}
