//! Results of earlier versions of the physics in place of those that are missing, to be compared
//! with later ones. The key of a job names the version, so that nothing else ever finds them.

use std::cell::OnceCell;
use std::collections::HashMap;

use answers::{RecordMap, Records, RecordsError};
use contact::model::Fields;
use identity::JobKey;
use study::job::PHYSICS_VERSION;
use study::{Record, RunAccount};

use crate::stored::StoreSource;

/// A store whose earlier results stand in for those that it lacks.
pub(crate) struct EarlierResults<'a> {
    source: StoreSource<'a>,
    /// The latest of the earlier results of each job, by the key that the job has today. They are
    /// read when something is missing.
    earlier: OnceCell<RecordMap>,
}

impl<'a> EarlierResults<'a> {
    /// Returns a store with its earlier results.
    pub(crate) fn of(source: StoreSource<'a>) -> Self {
        Self { source, earlier: OnceCell::new() }
    }

    fn earlier(&self) -> Result<&RecordMap, RecordsError> {
        if let Some(earlier) = self.earlier.get() {
            return Ok(earlier);
        }
        let mut earlier: RecordMap = HashMap::new();
        for record in self.source.all_sound()? {
            let key = JobKey::of(PHYSICS_VERSION, &record.job);
            let is_later = |known: &Record| known.physics < record.physics;
            if record.physics < PHYSICS_VERSION && earlier.get(&key).is_none_or(is_later) {
                earlier.insert(key, record);
            }
        }
        Ok(self.earlier.get_or_init(|| earlier))
    }
}

impl Records for EarlierResults<'_> {
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError> {
        let mut found = self.source.select(keys)?;
        for key in keys {
            if !found.contains_key(key)
                && let Some(record) = self.earlier()?.get(key)
            {
                found.insert(*key, record.clone());
            }
        }
        Ok(found)
    }

    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
        self.source.matching(is_wanted)
    }

    fn fields(&self, record: &Record) -> Result<Fields, RecordsError> {
        self.source.fields(record)
    }

    fn account(&self, run: &[u8; 32]) -> Option<RunAccount> {
        self.source.account(run)
    }
}
