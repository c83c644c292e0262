//! This file remembers what a merge could not take.

use std::collections::{BTreeMap, BTreeSet};

use identity::JobKey;

use crate::digest::Digest;
use crate::merge::report::MergeReport;
use crate::merge::source::MergeSource;

/// The losses of a merge.
#[derive(Default)]
pub(super) struct MergeLosses {
    /// The number of records that were left out, by the number of their source.
    counts: BTreeMap<usize, usize>,
    /// The jobs of which something was lost in some source, with their blobs that were.
    pub(super) jobs: BTreeMap<JobKey, BTreeSet<Digest>>,
    /// The numbers of the sources that have lost records whose jobs nobody knows.
    pub(super) doubted: BTreeSet<usize>,
    /// Those of the jobs of which the merge has written a record all the same.
    pub(super) written: BTreeSet<JobKey>,
}

impl MergeLosses {
    /// Returns the number of records of a source that were left out.
    pub(super) fn count(&self, source: usize) -> usize {
        self.counts.get(&source).copied().unwrap_or(0)
    }

    /// Leaves out the record of a job, and says why.
    pub(super) fn leave_out(
        &mut self,
        key: &JobKey,
        number: usize,
        source: &MergeSource,
        reason: &str,
        report: &mut MergeReport,
    ) {
        self.jobs.entry(*key).or_default();
        self.say(1, number, source, reason, report);
    }

    /// Leaves out records whose jobs cannot be read, and says why.
    pub(super) fn leave_out_unknown(
        &mut self,
        count: usize,
        number: usize,
        source: &MergeSource,
        reason: &str,
        report: &mut MergeReport,
    ) {
        self.doubted.insert(number);
        self.say(count, number, source, reason, report);
    }

    fn say(
        &mut self,
        count: usize,
        number: usize,
        source: &MergeSource,
        reason: &str,
        report: &mut MergeReport,
    ) {
        *self.counts.entry(number).or_default() += count;
        let fault = format!("{}: {reason}", source.path.display());
        // Many frames may have one fault.
        if report.faults.last() != Some(&fault) {
            report.faults.push(fault);
        }
    }

    /// Notes that a record of a job is written.
    pub(super) fn write(&mut self, key: &JobKey) {
        if self.jobs.contains_key(key) {
            self.written.insert(*key);
        }
    }
}
