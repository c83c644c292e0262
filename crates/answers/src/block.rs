//! The results of a study whose points are read a block at a time.

use identity::JobKey;
use rayon::prelude::*;
use report::Cell;
use study::columns::Row;
use study::{Column, Record, Study, StudyPoint};

use crate::accounts::Accounts;
use crate::error::AnswerError;
use crate::records::{RecordMap, Records};
use crate::rows::row;
use crate::tabled::{ROWS_OF_A_BLOCK, RowKeeper};

/// The number of points whose results are read at a time where they are read in blocks: those of
/// 4096 take some 20 MiB.
pub(crate) const POINTS_AT_ONCE: usize = 1024;

/// Some points of a study with their records.
pub(crate) struct ResultBlock<'b> {
    pub(crate) points: &'b [StudyPoint],
    pub(crate) records: &'b RecordMap,
    pub(crate) accounts: &'b Accounts,
}

impl ResultBlock<'_> {
    /// Iterates over the points that have a record.
    pub(crate) fn computed(&self) -> impl Iterator<Item = (&StudyPoint, &Record)> {
        self.points.iter().filter_map(|point| Some((point, self.records.get(&point.key)?)))
    }

    /// Makes the rows of the points with some columns.
    pub(crate) fn rows(&self, columns: &[Column]) -> Vec<Vec<Cell>> {
        let rows = self.points.par_iter().map(|point| {
            let record = self.records.get(&point.key);
            let account = record.and_then(|record| self.accounts.of(record));
            row(columns, &Row { point, record, compared: None, account })
        });
        rows.collect()
    }

    /// Gives the rows of the points with some columns to a keeper, unless it keeps none.
    pub(crate) fn keep(&self, columns: &[Column], keeper: &dyn RowKeeper) {
        for points in self.points.chunks(ROWS_OF_A_BLOCK) {
            if keeper.is_keeping() {
                let keys: Vec<JobKey> = points.iter().map(|point| point.key).collect();
                let (records, accounts) = (self.records, self.accounts);
                keeper.keep(&keys, &ResultBlock { points, records, accounts }.rows(columns));
            }
        }
    }
}

/// Visits the points of a study with their records, so many at a time, until the visitor returns
/// false. Returns the accounts of the runs that computed what was visited.
///
/// # Errors
/// A record cannot be read, or the visitor fails.
pub(crate) fn visit<E: From<AnswerError>>(
    study: &Study,
    source: &dyn Records,
    at_once: usize,
    visitor: &mut dyn FnMut(ResultBlock<'_>) -> Result<bool, E>,
) -> Result<Accounts, E> {
    let mut accounts = Accounts::default();
    for points in study.point_blocks(at_once) {
        let records = records_of(&points, source)?;
        accounts.read(records.values(), source);
        if !visitor(ResultBlock { points: &points, records: &records, accounts: &accounts })? {
            break;
        }
    }
    Ok(accounts)
}

/// Reads the records of some points.
pub(crate) fn records_of(
    points: &[StudyPoint],
    source: &dyn Records,
) -> Result<RecordMap, AnswerError> {
    let mut keys: Vec<JobKey> = points.iter().map(|point| point.key).collect();
    keys.sort_unstable();
    keys.dedup();
    source.select(&keys).map_err(AnswerError::Records)
}
