//! The accounts of the runs that computed some records.

use std::collections::HashMap;

use study::{Record, RunAccount};

use crate::records::Records;

/// The accounts of runs, by their digests. Each is read once, however many records share it.
#[derive(Clone, Debug, Default)]
pub struct Accounts {
    known: HashMap<[u8; 32], Option<RunAccount>>,
}

/// A run of which there are records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputingRun<'a> {
    /// The digest of its account; `None` for records that name no run.
    pub digest: Option<[u8; 32]>,
    /// The account, if it can be read.
    pub account: Option<&'a RunAccount>,
    /// The number of records.
    pub records: usize,
}

impl Accounts {
    /// Reads the accounts of the runs of some records that are not known yet.
    pub fn read<'r>(
        &mut self,
        records: impl IntoIterator<Item = &'r Record>,
        source: &dyn Records,
    ) {
        let runs = records.into_iter().filter_map(|record| record.provenance.run.as_ref());
        self.read_of(runs, |run| source.account(run));
    }

    /// Reads the accounts of some runs that are not known yet.
    pub fn read_of<'r>(
        &mut self,
        runs: impl IntoIterator<Item = &'r [u8; 32]>,
        account: impl Fn(&[u8; 32]) -> Option<RunAccount>,
    ) {
        for digest in runs {
            if !self.known.contains_key(digest) {
                self.known.insert(*digest, account(digest));
            }
        }
    }

    /// Returns the account of the run that computed a record, if it is known.
    pub fn of(&self, record: &Record) -> Option<&RunAccount> {
        self.known.get(record.provenance.run.as_ref()?)?.as_ref()
    }

    /// Lists the runs whose accounts were read, the lost ones included, in the order of their
    /// digests.
    pub fn listed(&self) -> Vec<(&[u8; 32], Option<&RunAccount>)> {
        let mut listed: Vec<_> =
            self.known.iter().map(|(digest, account)| (digest, account.as_ref())).collect();
        listed.sort_unstable_by_key(|(digest, _)| *digest);
        listed
    }

    /// Lists the runs of some records: the known ones from the earliest to the latest, then those
    /// whose account is lost, then the records that name no run.
    pub fn runs<'r>(&self, records: impl IntoIterator<Item = &'r Record>) -> Vec<ComputingRun<'_>> {
        let mut counts: HashMap<Option<[u8; 32]>, usize> = HashMap::new();
        for record in records {
            *counts.entry(record.provenance.run).or_default() += 1;
        }
        self.counted(counts)
    }

    /// Lists runs like [`runs`](Accounts::runs), each given with the number of its records.
    pub fn counted(
        &self,
        counts: impl IntoIterator<Item = (Option<[u8; 32]>, usize)>,
    ) -> Vec<ComputingRun<'_>> {
        let run = |(digest, records): (Option<[u8; 32]>, usize)| {
            let account = digest.and_then(|digest| self.known.get(&digest)?.as_ref());
            ComputingRun { digest, account, records }
        };
        let mut runs: Vec<ComputingRun<'_>> = counts.into_iter().map(run).collect();
        let order = |run: &ComputingRun<'_>| {
            let started = run.account.map_or(u64::MAX, |account| account.started);
            (started, run.digest.is_none(), run.digest)
        };
        runs.sort_by_key(order);
        runs
    }
}
