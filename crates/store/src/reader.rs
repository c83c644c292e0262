//! This file opens the store for reading only, also while another process has it open.

use std::fmt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use identity::JobKey;

use crate::blob::Blobs;
use crate::connection::Connection;
use crate::core::{Core, PATIENCE, RECORDS, held_error};
use crate::error::{OpenError, ReadError};
use crate::lock::{Acquired, Holder, Lock};
use crate::manifest::{self, Manifest, Unreadable};
use crate::serve::first_records;
use crate::wire::{KEYS_PER_REQUEST, ReadRequest, ReadResponse};

/// The origin of the records of a [`StoreReader`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordOrigin {
    /// The records come from the files, which the reader has locked until it is dropped.
    Disk,
    /// The records come from the process that has the store open.
    Process {
        /// The id of the process.
        pid: u32,
        /// The command line of the process.
        command: String,
    },
}

impl fmt::Display for RecordOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RecordOrigin::Disk => f.write_str("read from disk"),
            RecordOrigin::Process { pid, command } => {
                write!(f, "served by the running process {pid} ({command})")
            }
        }
    }
}

enum Backing {
    Disk(Box<Core>),
    Process(Connection),
}

/// A store that is only read. It shows durable records, and ever more of them while a run is
/// writing.
pub struct StoreReader {
    directory: PathBuf,
    blobs: Blobs,
    source: Backing,
}

impl StoreReader {
    pub(crate) fn open(directory: &Path) -> Result<StoreReader, OpenError> {
        if !directory.join(manifest::FILE).is_file() && !directory.join(RECORDS).is_dir() {
            return Err(OpenError::Missing { directory: directory.to_owned() });
        }
        let io =
            |source| OpenError::Io { action: "lock the store", path: directory.to_owned(), source };
        let start = Instant::now();
        let source = loop {
            let holder = match Lock::acquire(directory).map_err(io)? {
                Acquired::Lock(mut lock) => {
                    lock.sign(&Holder::this_process(None)).map_err(io)?;
                    break Backing::Disk(Box::new(Core::open(directory, lock)?));
                }
                Acquired::Held(holder) => holder,
            };
            let patience = PATIENCE.saturating_sub(start.elapsed());
            let served =
                holder.as_ref().and_then(|holder| Some((holder, holder.address.as_ref()?)));
            match served.map(|(holder, address)| {
                (holder, Connection::open(holder, address, patience.max(Duration::from_millis(1))))
            }) {
                Some((_, Ok(connection))) => break Backing::Process(connection),
                // The process has ended since or has not yet begun; once the patience has ended, it
                // is stuck.
                Some((holder, Err(source))) if patience.is_zero() => {
                    let (pid, command) = (holder.pid, holder.command.clone());
                    return Err(OpenError::Unanswered {
                        directory: directory.to_owned(),
                        pid,
                        command,
                        source,
                    });
                }
                None if patience.is_zero() => return Err(held_error(directory, holder)),
                _ => thread::sleep(Duration::from_millis(5)),
            }
        };
        Ok(StoreReader { directory: directory.to_owned(), blobs: Blobs::of(directory), source })
    }

    /// Returns the origin of the records.
    pub fn origin(&self) -> RecordOrigin {
        match &self.source {
            Backing::Disk(_) => RecordOrigin::Disk,
            Backing::Process(connection) => RecordOrigin::Process {
                pid: connection.holder.pid,
                command: connection.holder.command.clone(),
            },
        }
    }

    /// Returns the keys of all records in ascending order.
    ///
    /// # Errors
    /// [`ReadError::Unanswered`] if the process that has the store open does not answer.
    pub fn keys(&self) -> Result<Vec<JobKey>, ReadError> {
        match &self.source {
            Backing::Disk(core) => Ok(core.keys()),
            Backing::Process(connection) => {
                let mut keys: Vec<JobKey> = Vec::new();
                loop {
                    let last = keys.last().copied();
                    match ask(connection, &ReadRequest::Keys(last.map(|key| key.0)))? {
                        ReadResponse::Keys(more) if more.is_empty() => return Ok(keys),
                        // Without this condition the exchange could go on for ever.
                        ReadResponse::Keys(more) if more.first().map(|key| JobKey(*key)) > last => {
                            keys.extend(more.into_iter().map(JobKey))
                        }
                        _ => return Err(nonsense(connection)),
                    }
                }
            }
        }
    }

    /// Returns for each job whether it has a record.
    ///
    /// # Errors
    /// [`ReadError::Unanswered`] if the process that has the store open does not answer.
    pub fn contains(&self, keys: &[JobKey]) -> Result<Vec<bool>, ReadError> {
        let connection = match &self.source {
            Backing::Disk(core) => return Ok(keys.iter().map(|key| core.contains(key)).collect()),
            Backing::Process(connection) => connection,
        };
        let mut all = Vec::with_capacity(keys.len());
        for batch in keys.chunks(KEYS_PER_REQUEST) {
            match ask(connection, &ReadRequest::Contains(batch.iter().map(|key| key.0).collect()))?
            {
                ReadResponse::Contains(some) if some.len() == batch.len() => all.extend(some),
                _ => return Err(nonsense(connection)),
            }
        }
        Ok(all)
    }

    /// Returns the verified record of a job, or `None` if it has none.
    ///
    /// # Errors
    /// Those of [`Store::get`](crate::Store::get), and [`ReadError::Unanswered`] if the process
    /// that has the store open does not answer.
    pub fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        match self.first(std::slice::from_ref(key)).pop() {
            Some(record) => record,
            None => Ok(None),
        }
    }

    /// Iterates over all records and their keys in the order of the keys. A corrupt record does not
    /// hide the others.
    ///
    /// # Errors
    /// Those of [`StoreReader::keys`].
    pub fn records(
        &self,
    ) -> Result<impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)>, ReadError> {
        Ok(self.select(self.keys()?))
    }

    /// Iterates over the records of `keys` in the given order. Keys without a record are left out.
    pub fn select(
        &self,
        keys: Vec<JobKey>,
    ) -> impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)> {
        // The number of keys is small because the caller may stop early.
        const KEYS_AT_ONCE: usize = 256;
        let mut next = 0;
        let replies = std::iter::from_fn(move || {
            let batch = &keys[next..keys.len().min(next + KEYS_AT_ONCE)];
            let records = self.first(batch);
            next += records.len();
            let found = batch
                .iter()
                .copied()
                .zip(records)
                .filter_map(|(key, record)| Some((key, record.transpose()?)));
            (!batch.is_empty()).then(|| found.collect::<Vec<_>>())
        });
        replies.flatten()
    }

    /// Returns one answer for each of the first of `keys`, as many as fit into a response. If there
    /// is a key, there is at least one answer.
    fn first(&self, keys: &[JobKey]) -> Vec<Result<Option<Vec<u8>>, ReadError>> {
        let connection = match &self.source {
            Backing::Disk(core) => return first_records(core, keys),
            Backing::Process(connection) => connection,
        };
        match ask(connection, &ReadRequest::Get(keys.iter().map(|key| key.0).collect())) {
            Ok(ReadResponse::Get(records))
                if records.len() <= keys.len() && records.is_empty() == keys.is_empty() =>
            {
                keys.iter().zip(records).map(|(key, record)| record.into_result(key)).collect()
            }
            Ok(_) => keys.iter().map(|_| Err(nonsense(connection))).collect(),
            Err(ReadError::Unanswered { pid, source }) => {
                let again = || std::io::Error::new(source.kind(), source.to_string());
                keys.iter().map(|_| Err(ReadError::Unanswered { pid, source: again() })).collect()
            }
            Err(other) => vec![Err(other)],
        }
    }

    /// Returns the blobs, which are plain files.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Returns the definition of a study, or `None` if there is no study of that name.
    ///
    /// # Errors
    /// [`ReadError::Manifest`], [`ReadError::StudyMissing`], [`ReadError::Blob`] or
    /// [`ReadError::Io`] if the definition cannot be read.
    pub fn study(&self, name: &str) -> Result<Option<Vec<u8>>, ReadError> {
        let digest = self.manifest()?.studies.get(name).copied();
        digest.map(|digest| self.blobs.definition(name, &digest)).transpose()
    }

    /// Returns the names of all studies in alphabetical order.
    ///
    /// # Errors
    /// [`ReadError::Manifest`] or [`ReadError::Io`] if the manifest cannot be read.
    pub fn study_names(&self) -> Result<Vec<String>, ReadError> {
        Ok(self.manifest()?.studies.into_keys().collect())
    }

    fn manifest(&self) -> Result<Manifest, ReadError> {
        let path = self.directory.join(manifest::FILE);
        Manifest::read(&self.directory).map_err(|unreadable| match unreadable {
            Unreadable::Io(source) => ReadError::Io { path, source },
            Unreadable::Absent => ReadError::Manifest { path, reason: "it is missing".to_owned() },
            Unreadable::Format(found) => {
                ReadError::Manifest { path, reason: format!("its format is {found}") }
            }
            Unreadable::Damaged(reason) => ReadError::Manifest { path, reason },
        })
    }
}

fn ask(connection: &Connection, request: &ReadRequest) -> Result<ReadResponse, ReadError> {
    connection
        .ask(request)
        .map_err(|source| ReadError::Unanswered { pid: connection.holder.pid, source })
}

fn nonsense(connection: &Connection) -> ReadError {
    let source =
        std::io::Error::new(std::io::ErrorKind::InvalidData, "it did not answer the question");
    ReadError::Unanswered { pid: connection.holder.pid, source }
}
