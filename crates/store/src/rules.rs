//! This file says when two records of one job are the same result. Records are opaque to the store,
//! so whoever merges them brings the rules.

use identity::JobKey;

use crate::digest::Digest;

/// The rules by which records, definitions and notes of several sources become one.
#[derive(Clone, Copy, Debug)]
pub struct MergeRules {
    /// Reads a record of a job, or says what is wrong with it.
    pub examine: fn(&JobKey, &[u8]) -> Result<Examination, String>,
    /// Computes the digest of what two machines must agree on in a record.
    pub fingerprint: fn(&[u8]) -> Digest,
    /// Computes the digest of what two machines must agree on in the definition of a study.
    pub definition: fn(&[u8]) -> Digest,
    /// Returns how far a shard is by its note; a larger number is further.
    pub progress: fn(&[u8]) -> u64,
    /// Returns what is left of the note of a shard if the shard is not finished, whatever it says.
    pub unfinished: fn(&[u8]) -> Vec<u8>,
}

/// The findings about a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Examination {
    /// The rank of the record among those of its job.
    pub rank: RecordRank,
    /// The blobs that the record refers to.
    pub references: References,
}

/// The blobs that a record refers to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct References {
    /// The blobs without which the record is not whole.
    pub needed: Vec<Digest>,
    /// The blobs that go along with the record, which is whole without them. Many records may share
    /// one.
    pub companions: Vec<Digest>,
}

impl From<Vec<Digest>> for References {
    fn from(needed: Vec<Digest>) -> Self {
        References { needed, companions: Vec::new() }
    }
}

/// A blob that goes along with records and is damaged or not there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LostCompanion {
    /// The name of the blob.
    pub digest: Digest,
    /// The number of records that it goes along with.
    pub records: usize,
    /// The fault, in words.
    pub reason: String,
}

/// The rank of a record among those of its job. A higher one takes the place of a lower one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RecordRank {
    /// Another version of the program wrote it, and this one cannot read it.
    Foreign,
    /// The job was set aside without a result.
    Unfinished,
    /// The job has a result, which is the same on every machine.
    Finished,
}

/// The standing of a record in the choice between those of one job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Candidate {
    pub(crate) rank: RecordRank,
    /// The beginning of the digest of what machines must agree on.
    fingerprint: [u8; 16],
    /// The beginning of the digest of all bytes. It decides between equal results, so that the
    /// order in which they come does not.
    bytes: [u8; 16],
}

/// The choice between two records of one job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RecordChoice {
    First,
    Second,
    /// Both are results, and they differ.
    Conflict,
}

impl Candidate {
    /// The length of a candidate as bytes.
    pub(crate) const BYTES: usize = 33;

    /// Returns the candidate as bytes.
    pub(crate) fn to_bytes(self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        bytes[0] = match self.rank {
            RecordRank::Foreign => 1,
            RecordRank::Unfinished => 2,
            RecordRank::Finished => 3,
        };
        bytes[1..17].copy_from_slice(&self.fingerprint);
        bytes[17..].copy_from_slice(&self.bytes);
        bytes
    }

    /// Returns the candidate whose bytes these are, or `None` if they are of none, as zeros are.
    pub(crate) fn of_bytes(bytes: &[u8; Self::BYTES]) -> Option<Self> {
        let rank = match bytes[0] {
            1 => RecordRank::Foreign,
            2 => RecordRank::Unfinished,
            3 => RecordRank::Finished,
            _ => return None,
        };
        let [fingerprint, digest] = [1, 17].map(|start| {
            let mut half = [0; 16];
            half.copy_from_slice(&bytes[start..start + 16]);
            half
        });
        Some(Candidate { rank, fingerprint, bytes: digest })
    }

    pub(crate) fn of(rules: &MergeRules, rank: RecordRank, record: &[u8]) -> Self {
        let short = |digest: Digest| {
            let mut first = [0; 16];
            first.copy_from_slice(&digest.0[..16]);
            first
        };
        let fingerprint = match rank {
            RecordRank::Finished => short((rules.fingerprint)(record)),
            RecordRank::Foreign | RecordRank::Unfinished => [0; 16],
        };
        Candidate { rank, fingerprint, bytes: short(Digest::of(record)) }
    }

    /// Chooses between this record and another one of the same job.
    pub(crate) fn against(&self, other: &Candidate) -> RecordChoice {
        use std::cmp::Ordering::{Equal, Greater, Less};
        match self.rank.cmp(&other.rank) {
            Greater => RecordChoice::First,
            Less => RecordChoice::Second,
            Equal if self.fingerprint != other.fingerprint => RecordChoice::Conflict,
            Equal if self.bytes <= other.bytes => RecordChoice::First,
            Equal => RecordChoice::Second,
        }
    }
}
