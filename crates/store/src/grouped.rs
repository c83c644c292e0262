//! This file writes sealed records into a database in groups, so that few are in memory together.

use identity::JobKey;

use crate::database::{Database, Fault};

/// The size of the records that are written together \[bytes\].
const GROUP_BYTES: usize = 8 << 20;

/// Sealed records on their way into a database.
pub(crate) struct GroupWriter<'d> {
    database: &'d Database,
    group: Vec<(JobKey, Vec<u8>)>,
    /// The size of the group \[bytes\].
    bytes: usize,
    records: usize,
}

impl<'d> GroupWriter<'d> {
    /// Returns a writer that has written nothing.
    pub(crate) fn new(database: &'d Database) -> Self {
        GroupWriter { database, group: Vec::new(), bytes: 0, records: 0 }
    }

    /// Adds a record, and writes its group if that is full.
    pub(crate) fn push(&mut self, key: JobKey, sealed: Vec<u8>) -> Result<(), Fault> {
        self.bytes += sealed.len();
        self.records += 1;
        self.group.push((key, sealed));
        if self.bytes >= GROUP_BYTES { self.write() } else { Ok(()) }
    }

    fn write(&mut self) -> Result<(), Fault> {
        self.bytes = 0;
        let group = std::mem::take(&mut self.group);
        self.database.insert(group.into_iter())
    }

    /// Writes the rest, makes everything durable and returns the number of records.
    pub(crate) fn finish(mut self) -> Result<usize, Fault> {
        self.write()?;
        self.database.sync()?;
        self.database.sync_files().map_err(Fault::Io)?;
        Ok(self.records)
    }
}
