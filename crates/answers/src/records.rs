//! The source of results.

use std::collections::HashMap;
use std::error::Error;

use contact::model::Fields;
use identity::JobKey;
use study::{Record, RunAccount};

/// Why results cannot be read, in the words of whoever keeps them.
pub type RecordsError = Box<dyn Error + Send + Sync>;

/// Records by the keys of their jobs.
pub type RecordMap = HashMap<JobKey, Record>;

/// A place that keeps the results of jobs.
pub trait Records {
    /// Returns the records of those of `keys` that have one.
    ///
    /// # Errors
    /// A record cannot be read.
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError>;

    /// Returns every record of this version of the physics for whose canonical job text `is_wanted`
    /// holds. Damaged records are left out.
    ///
    /// # Errors
    /// The records cannot be listed.
    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError>;

    /// Returns the fields that the job of a record has left.
    ///
    /// # Errors
    /// It has left none, or they cannot be read.
    fn fields(&self, record: &Record) -> Result<Fields, RecordsError>;

    /// Returns the account of a run, given its digest; `None` if it is lost, damaged or no account.
    fn account(&self, run: &[u8; 32]) -> Option<RunAccount>;
}
