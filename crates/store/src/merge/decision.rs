//! This file decides what a merge takes of each record of its sources.
//!
//! The keys of all records are sorted, which shows the jobs that several sources have, or a source
//! and the target. The records of these are read once, in the order in which they stand in the
//! sources, and what decides about each is sorted by the jobs in turn. So one byte is kept for each
//! record, and a few MiB for the sorting.

use std::collections::{BTreeMap, BTreeSet};

use identity::JobKey;

use crate::digest::Digest;
use crate::error::ReadError;
use crate::merge::losses::MergeLosses;
use crate::merge::report::{MergeError, MergeReport, RecordConflict};
use crate::merge::source::{MergeInput, VisitedRecords};
use crate::merge::target::MergeTarget;
use crate::rules::{Candidate, Examination, MergeRules, RecordChoice, RecordRank};
use crate::sorted::RowSorter;

/// The length of a row of a record: the key of its job and its place.
const RECORD_ROW: usize = 40;

/// The length of a row of a record that is to be chosen or not: what decides follows.
const CANDIDATE_ROW: usize = RECORD_ROW + Candidate::BYTES;

/// The fate of a record of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum RecordFate {
    /// It is not taken.
    Left,
    /// Somebody else has a record of the job, and nothing is decided yet.
    Shared,
    /// It is the first one of its job in the target.
    Added,
    /// It takes the place of one of lower rank.
    Replacing,
    /// It is taken, and the target has no more than before.
    Kept,
}

/// The fates of all records, which are numbered through all sources.
pub(super) struct MergeDecision {
    fates: Vec<RecordFate>,
    /// The number of the first record of each source.
    starts: Vec<usize>,
    /// The number of jobs of each source, without those in conflict.
    pub(super) given: Vec<usize>,
    /// The blobs that records of the target refer to and that are not there.
    pub(super) lost_blobs: BTreeSet<(Digest, JobKey)>,
    /// The blobs that go along with records of the target, with the number of these.
    pub(super) target_companions: BTreeMap<Digest, usize>,
}

impl MergeDecision {
    /// Returns the fates of the records of a source.
    pub(super) fn of_source(&self, source: usize) -> &[RecordFate] {
        let end = self.starts.get(source + 1).copied().unwrap_or(self.fates.len());
        &self.fates[self.starts[source]..end]
    }

    /// Returns the number of the source of a record.
    fn source_of(&self, record: usize) -> usize {
        self.starts.partition_point(|start| *start <= record).saturating_sub(1)
    }
}

/// The place of a record. The record of the target comes before those of the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RecordSite {
    Target,
    Source(usize),
}

impl RecordSite {
    fn to_bytes(self) -> [u8; 8] {
        match self {
            RecordSite::Target => 0,
            RecordSite::Source(number) => number as u64 + 1,
        }
        .to_be_bytes()
    }

    fn of_bytes(bytes: [u8; 8]) -> Self {
        match u64::from_be_bytes(bytes) {
            0 => RecordSite::Target,
            next => RecordSite::Source((next - 1) as usize),
        }
    }
}

/// Returns the row of a record.
fn record_row(key: &JobKey, site: RecordSite) -> [u8; RECORD_ROW] {
    let mut row = [0; RECORD_ROW];
    row[..32].copy_from_slice(&key.0);
    row[32..].copy_from_slice(&site.to_bytes());
    row
}

/// Returns the row of a record with what decides about it; one that is damaged has nothing.
fn candidate_row(
    key: &JobKey,
    site: RecordSite,
    candidate: Option<Candidate>,
) -> [u8; CANDIDATE_ROW] {
    let mut row = [0; CANDIDATE_ROW];
    row[..RECORD_ROW].copy_from_slice(&record_row(key, site));
    if let Some(candidate) = candidate {
        row[RECORD_ROW..].copy_from_slice(&candidate.to_bytes());
    }
    row
}

/// Returns what decides about a record.
fn candidate_of(row: &[u8; CANDIDATE_ROW]) -> Option<Candidate> {
    row.last_chunk().and_then(Candidate::of_bytes)
}

/// Returns the key and the place at the beginning of a row.
fn parts_of(row: &[u8]) -> (JobKey, RecordSite) {
    let (mut key, mut site) = ([0; 32], [0; 8]);
    key.copy_from_slice(&row[..32]);
    site.copy_from_slice(&row[32..RECORD_ROW]);
    (JobKey(key), RecordSite::of_bytes(site))
}

/// A job of which several sources, or a source and the target, have a record.
#[derive(Default)]
struct SharedJob {
    /// The best record and its place.
    best: Option<(Candidate, RecordSite)>,
    /// The place of a result that differs from the best.
    rival: Option<RecordSite>,
    /// The rank of the record in the target.
    before: Option<RecordRank>,
}

impl SharedJob {
    fn meet(&mut self, site: RecordSite, candidate: Candidate) {
        match self.best.map_or(RecordChoice::Second, |(best, _)| best.against(&candidate)) {
            RecordChoice::First => {}
            RecordChoice::Second => self.best = Some((candidate, site)),
            RecordChoice::Conflict => self.rival = self.rival.or(Some(site)),
        }
    }

    /// Returns the fate of the record that was chosen.
    fn fate(&self) -> RecordFate {
        match (self.before, self.best) {
            (None, _) => RecordFate::Added,
            (Some(before), Some((best, _))) if before < best.rank => RecordFate::Replacing,
            // An equal result, with another provenance.
            (Some(_), _) => RecordFate::Kept,
        }
    }
}

/// Decides what is taken of each record.
pub(super) fn decide(
    input: &mut MergeInput,
    target: &MergeTarget,
    report: &mut MergeReport,
    losses: &mut MergeLosses,
) -> Result<MergeDecision, MergeError> {
    let mut starts = Vec::new();
    let mut count = 0;
    for source in &mut input.sources {
        starts.push(count);
        count += source.list()?;
    }
    let given = vec![0; starts.len()];
    let fates = vec![RecordFate::Left; count];
    let decision = MergeDecision {
        fates,
        starts,
        given,
        lost_blobs: BTreeSet::new(),
        target_companions: BTreeMap::new(),
    };
    let candidates = RowSorter::new(target.directory());
    let input = &*input;
    let mut deciding = Deciding { input, target, report, losses, decision, candidates };
    deciding.compare_keys()?;
    deciding.examine_shared()?;
    deciding.choose()
}

/// A decision that is being made.
struct Deciding<'d, 'm> {
    input: &'d MergeInput<'m>,
    target: &'d MergeTarget<'d>,
    report: &'d mut MergeReport,
    losses: &'d mut MergeLosses,
    decision: MergeDecision,
    candidates: RowSorter<CANDIDATE_ROW>,
}

impl Deciding<'_, '_> {
    /// Finds the jobs that have one record, and those that have several.
    fn compare_keys(&mut self) -> Result<(), MergeError> {
        let (input, target) = (self.input, self.target);
        let unsorted = |error| target.unsorted(error);
        let mut keys = RowSorter::new(target.directory());
        for (number, source) in input.sources.iter().enumerate() {
            let first = self.decision.starts[number];
            let faults = source.each_key(|record, key| match input.is_selected(source, key) {
                true => keys.push(record_row(key, RecordSite::Source(first + record))),
                false => Ok(()),
            });
            for reason in faults.map_err(unsorted)? {
                self.losses.leave_out_unknown(0, number, source, &reason, self.report);
            }
        }
        let (mut sorted, mut rows) = (keys.sorted().map_err(unsorted)?, Vec::new());
        while sorted.next_job(&mut rows).map_err(unsorted)? {
            self.share(&rows)?;
        }
        Ok(())
    }

    /// Takes the record of a job that is alone, and puts off the decision on several.
    fn share(&mut self, rows: &[[u8; RECORD_ROW]]) -> Result<(), MergeError> {
        let (rules, decision) = (self.input.rules, &mut self.decision);
        let (key, _) = parts_of(&rows[0]);
        // The last record of a job in a file counts.
        let mut last: Vec<(usize, usize)> = Vec::new();
        for row in rows {
            let (_, RecordSite::Source(record)) = parts_of(row) else { continue };
            let source = decision.source_of(record);
            match last.last_mut() {
                Some((before, earlier)) if *before == source => *earlier = record,
                _ => last.push((source, record)),
            }
        }
        let is_kept = self.target.keeps(&key);
        let fate = if last.len() > 1 || is_kept { RecordFate::Shared } else { RecordFate::Added };
        for (source, record) in last {
            decision.given[source] += 1;
            decision.fates[record] = fate;
        }
        if is_kept
            && let MergeTarget::Store(store) = self.target
            // A record that is damaged counts as absent, and a sound one heals it.
            && let Ok(Some(record)) = store.get(&key)
            && let Ok(found) = (rules.examine)(&key, &record)
        {
            // Its file may have been lost meanwhile, and is taken from any source.
            for digest in found.references.companions {
                *decision.target_companions.entry(digest).or_default() += 1;
            }
            let blobs = found.references.needed.into_iter();
            let lost = blobs.filter(|digest| !store.blobs().contains(digest));
            decision.lost_blobs.extend(lost.map(|digest| (digest, key)));
            let candidate = Candidate::of(rules, found.rank, &record);
            let row = candidate_row(&key, RecordSite::Target, Some(candidate));
            self.candidates.push(row).map_err(|error| self.target.unsorted(error))?;
        }
        Ok(())
    }

    /// Reads the records of jobs that have several.
    fn examine_shared(&mut self) -> Result<(), MergeError> {
        let Deciding { input, target, report, losses, decision, candidates } = self;
        for (number, source) in input.sources.iter().enumerate() {
            let (first, fates) = (decision.starts[number], decision.of_source(number));
            let is_shared = |record: usize| fates[record] == RecordFate::Shared;
            source.visit(is_shared, |visited| {
                let (record, key, bytes) = match visited {
                    VisitedRecords::One { number, key, record } => (number, key, record),
                    VisitedRecords::Unreadable { count, reason } => {
                        losses.leave_out_unknown(count, number, source, &reason, report);
                        return Ok(());
                    }
                };
                let candidate = match examined(input.rules, &key, bytes) {
                    Ok((found, bytes)) => Some(Candidate::of(input.rules, found.rank, bytes)),
                    Err(reason) => {
                        losses.leave_out(&key, number, source, &reason, report);
                        None
                    }
                };
                let row = candidate_row(&key, RecordSite::Source(first + record), candidate);
                candidates.push(row).map_err(|error| target.unsorted(error))
            })?;
        }
        Ok(())
    }

    /// Chooses among the records of each job that has several.
    fn choose(self) -> Result<MergeDecision, MergeError> {
        let Deciding { input, target, report, losses, mut decision, candidates } = self;
        let unsorted = |error| target.unsorted(error);
        let (mut sorted, mut rows) = (candidates.sorted().map_err(unsorted)?, Vec::new());
        while sorted.next_job(&mut rows).map_err(unsorted)? {
            let mut job = SharedJob::default();
            for row in &rows {
                let (_, site) = parts_of(row);
                let Some(candidate) = candidate_of(row) else { continue };
                let is_before = match site {
                    RecordSite::Target => true,
                    RecordSite::Source(record) => {
                        input.sources[decision.source_of(record)].is_target
                    }
                };
                if is_before {
                    job.before = Some(candidate.rank);
                }
                job.meet(site, candidate);
            }
            for row in &rows {
                let (_, RecordSite::Source(record)) = parts_of(row) else { continue };
                let source = decision.source_of(record);
                let is_best = job.best.is_some_and(|(_, site)| site == RecordSite::Source(record));
                decision.given[source] -= usize::from(job.rival.is_some());
                decision.fates[record] = match job.rival {
                    // What the target had of a job in conflict stays.
                    Some(_) if input.sources[source].is_target && candidate_of(row).is_some() => {
                        RecordFate::Kept
                    }
                    None if is_best => job.fate(),
                    _ => RecordFate::Left,
                };
            }
            if let (Some(rival), Some((_, holder))) = (job.rival, job.best) {
                let path = |site| match site {
                    RecordSite::Target => target.path().to_owned(),
                    RecordSite::Source(record) => {
                        input.sources[decision.source_of(record)].path.clone()
                    }
                };
                let (key, _) = parts_of(&rows[0]);
                let (first, second) = (path(holder), path(rival));
                report.conflicts.push(RecordConflict { key, first, second });
                losses.jobs.entry(key).or_default();
            }
        }
        Ok(decision)
    }
}

/// Examines a record that was read, or says what is wrong with it.
pub(super) fn examined<'r>(
    rules: &MergeRules,
    key: &JobKey,
    record: Result<&'r [u8], ReadError>,
) -> Result<(Examination, &'r [u8]), String> {
    let record = record.map_err(|error| error.to_string())?;
    let found = (rules.examine)(key, record);
    found.map(|found| (found, record)).map_err(|reason| format!("record {key}: {reason}"))
}
