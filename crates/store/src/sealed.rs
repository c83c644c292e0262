//! This file reads the records of a database and verifies each against its seal.

use std::path::Path;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

use identity::JobKey;

use crate::database::{Database, Fault};
use crate::error::ReadError;
use crate::key_set::KeySet;
use crate::record;

/// The records of an open database.
pub(crate) struct SealedRecords {
    pub(crate) database: Database,
    /// The keys of all records, so that counting them and looking one up cost nothing. A key is
    /// here once its record is durable.
    index: RwLock<KeySet>,
}

impl SealedRecords {
    /// Opens the database in `directory` and creates it if it is absent.
    pub(crate) fn open(directory: &Path) -> Result<Self, Fault> {
        let database = Database::open(directory).map_err(Fault::of_opening)?;
        let index = read_index(&database).map_err(Fault::Damaged)?;
        Ok(SealedRecords { database, index: RwLock::new(index) })
    }

    pub(crate) fn index(&self) -> RwLockReadGuard<'_, KeySet> {
        self.index.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the index and returns the number of keys in it.
    pub(crate) fn reindex(&self, change: impl FnOnce(&mut KeySet)) -> u64 {
        let mut index = self.index.write().unwrap_or_else(PoisonError::into_inner);
        change(&mut index);
        index.len() as u64
    }

    pub(crate) fn contains(&self, key: &JobKey) -> bool {
        self.index().contains(key)
    }

    pub(crate) fn keys(&self) -> Vec<JobKey> {
        self.index().above(None).collect()
    }

    pub(crate) fn get(&self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        if !self.contains(key) {
            return Ok(None);
        }
        let Some(sealed) = self.database.get(key)? else {
            if !self.contains(key) {
                return Ok(None); // The record was removed this moment.
            }
            return Err(ReadError::Corrupt {
                key: *key,
                reason: "the database has lost it".to_owned(),
            });
        };
        let payload = record::unseal(key, &sealed).map_err(|reason| reason.of_job(key))?;
        Ok(Some(payload.to_vec()))
    }

    pub(crate) fn records(&self) -> impl Iterator<Item = (JobKey, Result<Vec<u8>, ReadError>)> {
        self.keys().into_iter().filter_map(|key| Some((key, self.get(&key).transpose()?)))
    }
}

/// Reads the keys in the database, or returns what is wrong with it.
fn read_index(database: &Database) -> Result<KeySet, String> {
    let mut keys = Vec::new();
    let mut foreign = 0;
    let visited = database.visit(|key, _| match key.try_into() {
        Ok(key) => keys.push(JobKey(key)),
        Err(_) => foreign += 1,
    });
    match visited {
        Err(fault) => Err(format!(
            "the database of records cannot be read: {fault} ({} records were found)",
            keys.len()
        )),
        Ok(()) if foreign > 0 => {
            Err(format!("the database holds {foreign} entries whose keys are not of 32 bytes"))
        }
        Ok(()) => Ok(KeySet::new(keys)),
    }
}
