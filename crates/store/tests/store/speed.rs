//! The figures are printed and not asserted: `cargo test --release -p tribosweep-store -- --ignored
//! --nocapture figures`.

use std::time::Instant;

use store::Store;

use super::{key, records};

fn resident() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .unwrap_or_default()
        .split_whitespace()
        .skip(1)
        .collect()
}

#[test]
#[ignore = "prints figures"]
fn figures() {
    for (count, group) in [(10_000, 100), (10_000, 500), (10_000, 2000), (100_000, 1000)] {
        let directory = tempfile::tempdir().unwrap();
        let jobs: Vec<_> = (0..count).map(|i| (key(i), vec![i as u8; 400])).collect();
        let store = Store::open(directory.path()).unwrap();
        let start = Instant::now();
        jobs.chunks(group).for_each(|group| store.commit(group).unwrap());
        println!(
            "{count} records of 400 B committed in groups of {group}: {:.0?}",
            start.elapsed()
        );
        let start = Instant::now();
        drop(store);
        println!("  closed: {:.0?}", start.elapsed());
        let start = Instant::now();
        let store = Store::open(directory.path()).unwrap();
        println!("  opened: {:.0?}", start.elapsed());
        assert!(jobs.iter().all(|(key, _)| store.contains(key)));
        println!("  opened, contains() of every key: {:.0?}", start.elapsed());
        let start = Instant::now();
        assert_eq!(store.records().filter(|(_, record)| record.is_ok()).count() as u64, count);
        println!("  every record read: {:.0?}", start.elapsed());
        let start = Instant::now();
        let reader = Store::read(directory.path()).unwrap();
        assert_eq!(
            reader.records().unwrap().filter(|(_, record)| record.is_ok()).count() as u64,
            count
        );
        println!(
            "  every record read through the socket: {:.0?}; memory at most {}",
            start.elapsed(),
            resident()
        );
    }
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    let start = Instant::now();
    (0..200).for_each(|i| store.commit(&records(i..i + 1)).unwrap());
    println!("200 records committed one by one: {:.0?}", start.elapsed());
}
