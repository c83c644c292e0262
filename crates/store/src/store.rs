//! This file holds the store as one process has it open for writing.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use identity::JobKey;

use crate::access::{self, Wanted};
use crate::blob::Blobs;
use crate::core::{Core, is_vacant, lock_for_writing};
use crate::digest::Digest;
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::exports;
use crate::kept::{self, KeptWords};
use crate::lock::{self, Holder, Lock};
use crate::manifest::{Manifest, StudyLabels};
use crate::parts;
use crate::reader::{StoreReader, is_there};
use crate::rules::MergeRules;
use crate::salvage::{Salvage, salvage};
use crate::serve::{Listening, Server};
use crate::table::TableFolder;

/// A store that only this process has open, for reading and writing. Until it is dropped it answers
/// the readers of other processes from threads of its own. All methods may be called from any
/// thread.
pub struct Store {
    // The server is dropped first, because its threads use the core.
    _server: Server,
    core: Arc<Core>,
}

impl Store {
    /// Opens the store in `directory` and creates the store and the directory if they are absent.
    ///
    /// # Errors
    /// [`OpenError`]. In particular [`OpenError::Held`] if another process has the store open (a
    /// process that only reads is waited for), and [`OpenError::Damaged`] if the store holds less
    /// than its manifest promises.
    pub fn open(directory: &Path) -> Result<Store, OpenError> {
        let io = |action| move |source| OpenError::io(action, Wanted::Write, directory, source);
        if directory.is_file() && exports::are_there(directory)? {
            return Err(OpenError::OnlyRead { path: directory.to_owned() });
        }
        if !directory.exists() {
            access::create_directories(directory).map_err(io("create the directory"))?;
        }
        // The check comes before the lock, which would leave its file in somebody else's directory.
        // What another process has just made is there by the time of the second question.
        if !is_vacant(directory).map_err(io("look into"))? && !is_there(directory)? {
            if exports::are_there(directory)? {
                return Err(OpenError::OnlyRead { path: directory.to_owned() });
            }
            return Err(OpenError::NotAStore { directory: directory.to_owned() });
        }
        let listening = Listening::bind().map_err(io("open a socket for the readers of"))?;
        let holder = Holder::this_process(Some(listening.address.clone()), true);
        let lock = lock_for_writing(directory, &holder)?;
        let core = Arc::new(Core::open(directory, lock)?);
        let server = Server::start(listening, &core).map_err(io("answer the readers of"))?;
        Ok(Store { _server: server, core })
    }

    /// Opens the store in `directory` like [`open`](Store::open), but creates none.
    ///
    /// # Errors
    /// [`OpenError`]. In particular [`OpenError::Missing`] if there is no store.
    pub fn open_existing(directory: &Path) -> Result<Store, OpenError> {
        if !is_there(directory)? {
            if exports::are_there(directory)? {
                return Err(OpenError::OnlyRead { path: directory.to_owned() });
            }
            return Err(OpenError::Missing { directory: directory.to_owned() });
        }
        Self::open(directory)
    }

    /// Returns true if there is a store in `directory`, whatever its state.
    ///
    /// # Errors
    /// [`OpenError::Io`] if the system does not let this be found out.
    pub fn is_at(directory: &Path) -> Result<bool, OpenError> {
        is_there(directory)
    }

    /// Opens the store in `directory` for reading: through the process that has it open, or else
    /// from a private copy of its records. Reading changes nothing in the store and holds up
    /// nobody. An export, or a directory of exports, is read like a store; each is read up to its
    /// last whole frame, also while it grows.
    ///
    /// # Errors
    /// [`OpenError`]. In particular [`OpenError::Missing`] if there is no store.
    pub fn read(directory: &Path) -> Result<StoreReader, OpenError> {
        StoreReader::open(directory, None)
    }

    /// Opens a store or exports for reading like [`read`](Store::read). Where exports have several
    /// records of one job, the one counts that a [merge](Store::import) by these rules would keep.
    ///
    /// # Errors
    /// Those of [`read`](Store::read).
    pub fn read_by(directory: &Path, rules: &MergeRules) -> Result<StoreReader, OpenError> {
        StoreReader::open(directory, Some(rules))
    }

    /// Saves what can be read of a damaged store, which is sound afterwards. The lost jobs will be
    /// computed again. The damaged database is kept beside the new one. Records are opaque to the
    /// store, so `references` names the blobs that a record refers to; a record without them is
    /// lost too.
    ///
    /// # Errors
    /// [`OpenError`] if the store cannot be locked, read or written.
    pub fn salvage(
        directory: &Path,
        references: impl FnMut(&JobKey, &[u8]) -> Vec<Digest>,
    ) -> Result<Salvage, OpenError> {
        if !is_there(directory)? {
            return Err(OpenError::Missing { directory: directory.to_owned() });
        }
        let listening = Listening::bind().map_err(|source| {
            OpenError::io("open a socket for", Wanted::Write, directory, source)
        })?;
        // The socket shows that the process is alive. It answers nobody.
        let holder = Holder::this_process(Some(listening.address.clone()), false);
        let place = directory.join(lock::FILE);
        // Something that is no file is in the place of the lock, so nobody can hold it.
        if fs::symlink_metadata(&place).is_ok_and(|found| !found.is_file()) {
            durable::put_aside(&place)
                .map_err(|source| OpenError::io("put aside", Wanted::Write, &place, source))?;
        }
        let _lock = lock_for_writing(directory, &holder)?;
        salvage(directory, references)
    }

    /// Returns true if the job has a record.
    pub fn contains(&self, key: &JobKey) -> bool {
        self.core.records.contains(key)
    }

    /// Returns the verified record of a job, or `None` if it has none.
    ///
    /// # Errors
    /// [`ReadError::Corrupt`], [`ReadError::Version`] or [`ReadError::Database`] if the record
    /// cannot be read.
    pub fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        self.core.records.get(key)
    }

    /// Returns the number of records.
    pub fn len(&self) -> usize {
        self.core.records.index().len()
    }

    /// Returns true if there is no record.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the keys of all records in ascending order.
    pub fn keys(&self) -> Vec<JobKey> {
        self.core.records.keys()
    }

    /// Iterates over all records and their keys in the order of the keys. A corrupt record does not
    /// hide the others.
    pub fn records(&self) -> impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)> {
        self.core.records.records()
    }

    /// Writes records and replaces those of the same jobs. Once it has returned `Ok`, they survive
    /// a kill and a power failure. One call costs a few fsyncs, so records are best committed in
    /// groups.
    ///
    /// # Errors
    /// [`WriteError`] if the group was not acknowledged. Any part of the group may then be there
    /// after the next opening.
    pub fn commit<Record: AsRef<[u8]>>(
        &self,
        records: &[(JobKey, Record)],
    ) -> Result<(), WriteError> {
        self.core.commit(records)
    }

    /// Removes the records of these jobs durably and returns how many there were.
    ///
    /// # Errors
    /// [`WriteError`] if the removal was not acknowledged. Any part of the records may then be
    /// there after the next opening.
    pub fn remove(&self, keys: &[JobKey]) -> Result<usize, WriteError> {
        self.core.remove(keys)
    }

    /// Returns the blobs, which need no lock.
    pub fn blobs(&self) -> &Blobs {
        &self.core.blobs
    }

    /// Stores the definition of a study under its name and replaces an earlier one.
    ///
    /// # Errors
    /// [`WriteError`] if the blob or the manifest cannot be written.
    pub fn put_study(&self, name: &str, definition: &[u8]) -> Result<(), WriteError> {
        self.put_studies(&BTreeMap::from([(name.to_owned(), definition.to_owned())]))
    }

    /// Stores the definitions of studies under their names, all or none.
    pub(crate) fn put_studies(
        &self,
        definitions: &BTreeMap<String, Vec<u8>>,
    ) -> Result<(), WriteError> {
        let mut digests = BTreeMap::new();
        for (name, definition) in definitions {
            digests.insert(name.clone(), self.core.blobs.put(definition)?);
        }
        let mut manifest = self.core.manifest();
        let mut next = manifest.clone();
        next.studies.extend(digests);
        if next.studies == manifest.studies {
            return Ok(());
        }
        self.core.replace(&mut manifest, next)
    }

    /// Returns the definition of a study, or `None` if there is no study of that name.
    ///
    /// # Errors
    /// [`ReadError::StudyMissing`], [`ReadError::Blob`] or [`ReadError::Io`] if the definition
    /// cannot be read.
    pub fn study(&self, name: &str) -> Result<Option<Vec<u8>>, ReadError> {
        let digest = self.core.manifest().studies.get(name).copied();
        digest.map(|digest| self.core.blobs.definition(name, &digest)).transpose()
    }

    /// Returns the names of all studies in alphabetical order.
    pub fn study_names(&self) -> Vec<String> {
        self.core.manifest().studies.keys().cloned().collect()
    }

    /// Removes studies from the list, with their labels, and returns how many there were. Their
    /// definitions and the results of their jobs stay until they are [collected](Store::collect).
    ///
    /// # Errors
    /// [`WriteError`] if the manifest or the list of shards cannot be written.
    pub fn remove_studies(&self, names: &BTreeSet<String>) -> Result<usize, WriteError> {
        let mut manifest = self.core.manifest();
        let mut studies = manifest.studies.clone();
        studies.retain(|name, _| !names.contains(name));
        let removed = manifest.studies.len() - studies.len();
        if removed == 0 {
            return Ok(0);
        }
        // A kill between the two leaves the studies without their shards, and not the reverse.
        let mut shards = parts::read(&self.core.directory);
        shards.retain(|state| !names.contains(&state.shard.study));
        parts::write(&self.core.directory, &shards).map_err(|source| {
            WriteError::io("write", &self.core.directory.join(parts::FILE), source)
        })?;
        let next = Manifest::new(manifest.records, studies, manifest.labels.clone());
        self.core.replace(&mut manifest, next)?;
        Ok(removed)
    }

    /// Returns the labels of a study, which are none if there is no such study.
    pub fn labels(&self, name: &str) -> StudyLabels {
        self.core.manifest().labels.get(name).cloned().unwrap_or_default()
    }

    /// Replaces the labels of a study. Those of one that is not there are not kept.
    ///
    /// # Errors
    /// [`WriteError`] if the manifest cannot be written.
    pub fn set_labels(&self, name: &str, labels: StudyLabels) -> Result<(), WriteError> {
        let mut manifest = self.core.manifest();
        let mut all = manifest.labels.clone();
        all.insert(name.to_owned(), labels);
        let next = Manifest::new(manifest.records, manifest.studies.clone(), all);
        if next.labels == manifest.labels {
            return Ok(());
        }
        self.core.replace(&mut manifest, next)
    }

    /// Keeps words about a study. A [`Glance`](crate::Glance) at the store shows them until records
    /// come that may change what they say.
    pub fn keep_words(&self, study: &str, words: KeptWords) {
        self.core.kept.set(study, words);
    }

    /// Forgets the words and the tables that are kept of all studies.
    ///
    /// # Errors
    /// [`OpenError`] if the store cannot be locked or written.
    pub fn forget_words(directory: &Path) -> Result<(), OpenError> {
        let listening = Listening::bind().map_err(|source| {
            OpenError::io("open a socket for", Wanted::Write, directory, source)
        })?;
        let holder = Holder::this_process(Some(listening.address.clone()), false);
        let _lock = lock_for_writing(directory, &holder)?;
        let _tables = TableFolder { store: directory.to_owned() };
        kept::remove(directory)
            .map_err(|source| OpenError::io("write to", Wanted::Write, directory, source))
    }

    pub(crate) fn core(&self) -> &Core {
        &self.core
    }

    /// Closes the database and lets go of the readers, and returns the lock, which is still held.
    pub(crate) fn into_lock(self) -> Arc<Lock> {
        let Store { _server: server, core } = self;
        // Its threads use the core.
        drop(server);
        core.lock.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serve::first_records;
    use crate::wire::RESPONSE_LIMIT;

    #[test]
    fn a_reply_ends_where_it_would_grow_too_long() {
        let directory = tempfile::tempdir().unwrap();
        let store = Store::open(directory.path()).unwrap();
        let keys: Vec<JobKey> = (0..20).map(|i| JobKey([i; 32])).collect();
        for key in &keys[..19] {
            store.commit(&[(*key, vec![key.0[0]; RESPONSE_LIMIT / 8])]).unwrap();
        }
        let lengths = |keys: &[JobKey]| -> Vec<_> {
            first_records(keys, |key| store.get(key))
                .into_iter()
                .map(|record| record.unwrap().map(|record| record.len()))
                .collect()
        };
        assert_eq!(lengths(&keys), [Some(RESPONSE_LIMIT / 8); 8]);
        assert_eq!(
            lengths(&keys[17..]),
            [Some(RESPONSE_LIMIT / 8), Some(RESPONSE_LIMIT / 8), None]
        );
        assert_eq!(lengths(&[]), []);
    }
}
