//! These tests use the store as its users do: whole directories, several processes, several users,
//! kills, damage and a full disk.

mod child;
mod collection;
mod damage;
mod exports;
mod full;
mod kept;
mod kill;
mod merge;
mod model;
mod readers;
mod speed;
mod tables;
mod users;

use identity::JobKey;
use store::{Digest, Examination, MergeRules, RecordRank, References};

/// Returns the key of the `i`-th made-up job.
fn key(i: u64) -> JobKey {
    JobKey(*blake3::hash(&i.to_le_bytes()).as_bytes())
}

/// Returns its record: 0 to 2000 bytes that tell it from every other.
fn record(i: u64) -> Vec<u8> {
    let seed = blake3::hash(&(!i).to_le_bytes());
    let mut bytes = vec![0; i as usize * 37 % 2000];
    blake3::Hasher::new_keyed(seed.as_bytes()).finalize_xof().fill(&mut bytes);
    bytes
}

fn records(range: std::ops::Range<u64>) -> Vec<(JobKey, Vec<u8>)> {
    range.map(|i| (key(i), record(i))).collect()
}

/// Returns a record of the `i`-th job as the rules of the tests read it: its rank, then what
/// machines must agree on, then who computed it.
fn ranked(rank: RecordRank, result: u64, machine: u8) -> Vec<u8> {
    let mut bytes = vec![rank as u8];
    bytes.extend(result.to_le_bytes());
    bytes.push(machine);
    bytes.extend(record(result));
    bytes
}

/// The rules for those records. A record whose machine is 200 or more refers to a blob, and one
/// whose machine is between 100 and 199 to a blob that only goes along with it.
const RULES: MergeRules = MergeRules {
    examine: |_, bytes| {
        let rank = match bytes.first() {
            Some(0) => RecordRank::Foreign,
            Some(1) => RecordRank::Unfinished,
            Some(2) => RecordRank::Finished,
            _ => return Err("it has no rank".to_owned()),
        };
        let machine = bytes.get(9).copied().unwrap_or(0);
        let blob = vec![Digest::of(&field(machine))];
        let references = match machine {
            200.. => References { needed: blob, ..References::default() },
            100.. => References { companions: blob, ..References::default() },
            _ => References::default(),
        };
        Ok(Examination { rank, references })
    },
    fingerprint: |bytes| Digest::of(&bytes[1..9]),
    definition: |bytes| Digest::of(bytes.split(|byte| *byte == b'|').next_back().unwrap_or(&[])),
    progress: |note| note.len() as u64,
    unfinished: |note| note.split(|byte| *byte == b'!').next().unwrap_or(&[]).to_vec(),
};

/// Returns the content of the blob of a machine.
fn field(machine: u8) -> Vec<u8> {
    (0..3000u32).flat_map(|i| (i * u32::from(machine)).to_le_bytes()).collect()
}
