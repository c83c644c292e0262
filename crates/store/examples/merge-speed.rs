//! Measures a merge: writes the exports of 16 shards, reads them as one store, merges them into a
//! store, merges them again, and merges them into one export. Each merge is a process of its own, whose peak memory is said.
//!
//! ```text
//! cargo run --release -p store --example merge-speed -- 1000000
//! cargo run --release -p store --example merge-speed -- 1000000 /scratch     # where the files go
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use identity::JobKey;
use store::{
    Digest, Examination, ExportHeader, ExportWriter, MergeRules, MergeSelection, RecordRank,
    ShardName, Store, StoreReader, merge_into_export,
};

const SHARDS: u32 = 16;

/// The size of a record \[bytes\], about that of a scene of one increment.
const RECORD: usize = 800;

/// The rules for records that are all finished and refer to no blob.
const RULES: MergeRules = MergeRules {
    examine: |_, _| Ok(Examination { rank: RecordRank::Finished, references: Vec::new() }),
    fingerprint: Digest::of,
    definition: Digest::of,
    progress: |_| 0,
};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["merge", exports, target] => merge(Path::new(exports), Path::new(target)),
        [records] => measure(records.parse()?, &std::env::temp_dir()),
        [records, place] => measure(records.parse()?, Path::new(place)),
        _ => Err("name the number of records, for example 100000".into()),
    }
}

fn measure(records: u64, place: &Path) -> Result<(), Box<dyn Error>> {
    let directory = tempfile::tempdir_in(place)?;
    let exports = directory.path().join("exports");
    let start = Instant::now();
    let bytes = write(&exports, records)?;
    say("written to 16 exports", records, start);
    println!("  {:.0} bytes of file a record", bytes as f64 / records as f64);
    let start = Instant::now();
    let reader = Store::read_by(&exports, &RULES)?;
    for (_, record) in reader.records()? {
        record?;
    }
    say("read in the order of the keys", records, start);
    drop(reader);
    for (what, target) in [
        ("merged into a store", "store"),
        ("merged into it again", "store"),
        ("merged into one export", "all.tribosweep"),
    ] {
        println!("{what}:");
        let merging = Command::new(std::env::current_exe()?)
            .arg("merge")
            .args([&exports, &directory.path().join(target)])
            .status()?;
        if !merging.success() {
            return Err("the merge failed".into());
        }
    }
    Ok(())
}

/// Writes the exports and returns their size \[bytes\].
fn write(exports: &Path, records: u64) -> Result<u64, Box<dyn Error>> {
    let mut bytes = 0;
    for index in 1..=SHARDS {
        let path = exports.join(format!("{index}.tribosweep"));
        let shard = Some(ShardName { study: "study".to_owned(), index, count: SHARDS });
        let mut writer =
            ExportWriter::open(&path, &ExportHeader { program: "0.1.0".to_owned(), shard })?;
        writer.put_study("study", b"a definition")?;
        let blobs = Store::read(&path)?.blobs().clone();
        for i in (u64::from(index) - 1..records).step_by(SHARDS as usize) {
            writer.append(&key(i), &record(i), &blobs, [])?;
        }
        writer.close()?;
        bytes += std::fs::metadata(&path)?.len();
    }
    Ok(bytes)
}

fn key(i: u64) -> JobKey {
    JobKey(Digest::of(&i.to_le_bytes()).0)
}

/// Returns a record of which every second word says something.
fn record(i: u64) -> Vec<u8> {
    let mut state = i ^ 0x9e37_79b9_7f4a_7c15;
    let mut bytes = Vec::with_capacity(RECORD);
    while bytes.len() < RECORD {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        bytes.extend((state ^ state >> 29).to_le_bytes());
        bytes.extend(b"increment"[..8].iter());
    }
    bytes
}

fn merge(exports: &Path, target: &Path) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let reader: StoreReader = Store::read_by(exports, &RULES)?;
    let records: usize = reader.exports().iter().map(|export| export.records).sum();
    println!("  {:.2} s to read the index", start.elapsed().as_secs_f64());
    let report = match target.extension() {
        Some(_) => {
            let all = MergeSelection::default();
            merge_into_export(&PathBuf::from(target), "0.1.0", &[&reader], &RULES, &all)?
        }
        None => Store::open(target)?.import(&[&reader], &RULES)?,
    };
    say(
        &format!("{} added, {} already there", report.added, report.already_there),
        records as u64,
        start,
    );
    let status = std::fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("unknown");
    println!("  peak memory {}", peak.trim());
    Ok(())
}

fn say(what: &str, records: u64, start: Instant) {
    let seconds = start.elapsed().as_secs_f64();
    println!("  {what}: {seconds:.1} s, {:.0} records/s", records as f64 / seconds);
}
