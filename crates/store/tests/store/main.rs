//! These tests use the store as its users do: whole directories, several processes, several users,
//! kills, damage and a full disk.

mod child;
mod damage;
mod full;
mod kill;
mod model;
mod readers;
mod speed;
mod users;

use identity::JobKey;

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
