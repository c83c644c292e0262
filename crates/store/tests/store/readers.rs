//! Several processes use one store.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use identity::{JobKey, STORED_LIMIT};
use store::{CopyReason, OpenError, ReadError, RecordOrigin, Store};

use super::child::{Player, command};
use super::{key, record, records};

#[test]
fn the_second_writer_is_told_who_has_it() {
    let directory = tempfile::tempdir().unwrap();
    let mut holder = Player::start(command("hold", directory.path(), 0));
    assert_eq!(holder.line().as_deref(), Some("open"));
    match Store::open(directory.path()) {
        Err(OpenError::Held { pid, command, .. }) => {
            assert_eq!(pid, holder.process.id());
            assert!(command.contains("plays_its_part"), "{command}");
        }
        other => panic!("{:?}", other.err()),
    }
    holder.kill();
    assert!(Store::open(directory.path()).is_ok(), "a killed holder holds nothing");
}

#[test]
fn of_many_at_once_one_gets_it_and_the_others_say_who() {
    for _ in 0..4 {
        let directory = tempfile::tempdir().unwrap();
        let store = directory.path().join("new");
        let mut players: Vec<_> =
            (0..5).map(|_| Player::start(command("race", &store, 0))).collect();
        let said: Vec<_> = players.iter_mut().map(|player| player.line().unwrap()).collect();
        let winner = said.iter().position(|line| line == "open").expect("one of them gets it");
        let held = format!("held by {}", players[winner].process.id());
        let losers = said.iter().filter(|line| **line == held).count();
        assert_eq!(losers, 4, "{said:?}");
        players.into_iter().for_each(Player::dismiss);
    }
}

#[test]
fn this_process_cannot_open_it_twice_but_can_read_it() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    assert!(
        matches!(Store::open(directory.path()), Err(OpenError::Held { pid, .. }) if pid == std::process::id())
    );
    store.commit(&records(0..700)).unwrap();
    store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
    let digest = store.blobs().put(b"pressure").unwrap();

    let reader = Store::read(directory.path()).unwrap();
    assert!(
        matches!(reader.origin(), RecordOrigin::Process { pid, .. } if pid == std::process::id())
    );
    assert!(reader.origin().to_string().starts_with("served by the running process"));
    let check = |reader: &store::StoreReader, count: u64| {
        assert_eq!(reader.keys().unwrap(), store_keys(count));
        let found: Vec<_> =
            reader.records().unwrap().map(|(key, record)| (key, record.unwrap())).collect();
        let mut expected = records(0..count);
        expected.sort();
        assert_eq!(found, expected);
        assert_eq!(reader.get(&key(3)).unwrap(), Some(record(3)));
        assert_eq!(reader.get(&key(count)).unwrap(), None);
        assert_eq!(reader.contains(&[key(0), key(count)]).unwrap(), [true, false]);
        assert_eq!(
            reader.select(vec![key(5), key(count), key(4)]).map(|(key, _)| key).collect::<Vec<_>>(),
            [key(5), key(4)]
        );
        assert_eq!(reader.study("sweep").unwrap().unwrap(), b"mu = [0.1, 0.3]");
        assert_eq!(reader.study("another").unwrap(), None);
        assert_eq!(reader.study_names().unwrap().len(), 1);
        assert_eq!(reader.blobs().get(&digest).unwrap().unwrap(), b"pressure");
    };
    check(&reader, 700);
    store.commit(&records(700..10_000)).unwrap();
    check(&reader, 10_000); // The same reader sees the new records.

    drop(store);
    check(&reader, 10_000); // It goes on from disk.
    assert_eq!(reader.origin().to_string(), "read from disk");
    let reader = Store::read(directory.path()).unwrap();
    assert_eq!(reader.origin(), RecordOrigin::Disk);
    check(&reader, 10_000);
}

#[test]
fn a_reader_knows_whether_the_store_has_changed_since() {
    let directory = tempfile::tempdir().unwrap();
    Store::open(directory.path()).unwrap().commit(&records(0..3)).unwrap();
    let reader = Store::read(directory.path()).unwrap();
    assert!(reader.is_current());
    let store = Store::open(directory.path()).unwrap();
    store.commit(&records(3..5)).unwrap();
    assert!(!reader.is_current(), "it is being written");
    let served = Store::read(directory.path()).unwrap();
    assert!(served.is_current());
    drop(store);
    assert!(!reader.is_current(), "it was written");
    assert_eq!(served.keys().unwrap().len(), 5);
    assert_eq!(reader.keys().unwrap().len(), 3);
    let reader = Store::read(directory.path()).unwrap();
    assert!(reader.is_current());
    assert_eq!(reader.keys().unwrap().len(), 5);
}

/// Whatever it was asked when the process ended, the answer is the same.
#[test]
fn a_holder_that_goes_away_in_mid_answer_is_no_error() {
    const COUNT: u64 = 3000;
    let directory = tempfile::tempdir().unwrap();
    Store::open(directory.path()).unwrap().commit(&records(0..COUNT)).unwrap();
    for already in [0, 1, 300, 2999] {
        let store = Store::open(directory.path()).unwrap();
        let reader = Store::read(directory.path()).unwrap();
        let mut found = reader.records().unwrap();
        let mut sound = 0;
        for (_, record) in found.by_ref().take(already) {
            record.unwrap();
            sound += 1;
        }
        drop(store);
        for (_, record) in found {
            record.unwrap();
            sound += 1;
        }
        assert_eq!(sound, COUNT);
        assert_eq!(reader.contains(&[key(0), key(COUNT)]).unwrap(), [true, false]);
    }
}

#[test]
fn a_store_that_is_gone_when_its_holder_ends_is_an_error() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    store.commit(&records(0..700)).unwrap();
    let reader = Store::read(directory.path()).unwrap();
    drop(store);
    std::fs::remove_dir_all(directory.path().join("records")).unwrap();
    assert!(matches!(reader.keys(), Err(ReadError::Gone(_))));
    assert!(matches!(reader.get(&key(0)), Err(ReadError::Gone(_))));
    let all: Vec<_> = reader.select(vec![key(0), key(1), key(2)]).collect();
    assert!(matches!(&all[..], [(_, Err(ReadError::Gone(_)))]), "{all:?}");
    assert!(matches!(reader.verify(|_, _| Vec::new()), Err(ReadError::Gone(_))));
}

/// Together they are many times what a frame holds, and more than the reader asks for at once.
#[test]
fn large_records_are_served_in_parts() {
    const COUNT: u64 = 40;
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    for i in 0..COUNT {
        store.commit(&[(key(i), vec![i as u8; STORED_LIMIT])]).unwrap();
    }
    store.commit(&records(COUNT..COUNT + 300)).unwrap();
    let check = |reader: &store::StoreReader| {
        let mut keys = store_keys(COUNT + 300);
        keys.insert(20, key(u64::MAX)); // This key has no record.
        let mut found = reader.select(keys);
        for i in store_keys(COUNT + 300) {
            let (key, record) = found.next().unwrap();
            assert_eq!((key, record.unwrap()), (i, reader.get(&i).unwrap().unwrap()));
        }
        assert!(found.next().is_none());
        for i in 0..COUNT {
            assert!(reader.get(&key(i)).unwrap() == Some(vec![i as u8; STORED_LIMIT]));
        }
    };
    let reader = Store::read(directory.path()).unwrap();
    assert!(matches!(reader.origin(), RecordOrigin::Process { .. }));
    check(&reader);
    drop((reader, store));
    let reader = Store::read(directory.path()).unwrap();
    assert_eq!(reader.origin(), RecordOrigin::Disk);
    check(&reader);
}

fn store_keys(count: u64) -> Vec<JobKey> {
    let mut keys: Vec<_> = (0..count).map(key).collect();
    keys.sort();
    keys
}

#[test]
fn a_reader_is_served_while_another_process_writes() {
    let directory = tempfile::tempdir().unwrap();
    let mut writer = Player::start(command("write", directory.path(), 0));
    for _ in 0..5 {
        writer.line().unwrap();
    }
    let reader = Store::read(directory.path()).unwrap();
    assert!(
        matches!(reader.origin(), RecordOrigin::Process { pid, .. } if pid == writer.process.id())
    );
    let before = reader.keys().unwrap().len();
    for _ in 0..20 {
        writer.line().unwrap();
        for (_, record) in reader.records().unwrap() {
            record.unwrap();
        }
    }
    assert!(reader.keys().unwrap().len() > before);
    let served = reader.keys().unwrap().len();
    writer.kill();
    assert!(reader.keys().unwrap().len() + 100 > served);
    assert_eq!(reader.origin(), RecordOrigin::Disk);
    assert_eq!(Store::read(directory.path()).unwrap().origin(), RecordOrigin::Disk);
}

#[test]
fn a_reader_stops_no_writer() {
    let directory = tempfile::tempdir().unwrap();
    Store::open(directory.path()).unwrap().commit(&records(0..10)).unwrap();
    let mut reader = Player::start(command("read", directory.path(), 0));
    assert_eq!(reader.line().as_deref(), Some("10 records, read from disk"));
    let store = Store::open(directory.path()).unwrap();
    store.commit(&records(10..20)).unwrap();
    assert_eq!(store.len(), 20);
    reader.dismiss();
}

#[test]
fn reading_changes_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    store.commit(&records(0..300)).unwrap();
    store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
    drop(store);
    std::fs::remove_file(directory.path().join("lock")).unwrap();
    let before = listing(directory.path());
    let reader = Store::read(directory.path()).unwrap();
    assert_eq!(reader.keys().unwrap(), store_keys(300));
    assert!(reader.verify(|_, _| Vec::new()).unwrap().is_sound());
    drop(reader);
    assert_eq!(listing(directory.path()), before);
}

/// Returns every file below a directory with its content and the time of its last change.
fn listing(directory: &Path) -> Vec<(PathBuf, Vec<u8>, SystemTime)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(directory).unwrap().map(Result::unwrap) {
        let changed = entry.metadata().unwrap().modified().unwrap();
        if entry.path().is_dir() {
            files.push((entry.path(), Vec::new(), changed));
            files.extend(listing(&entry.path()));
        } else {
            files.push((entry.path(), std::fs::read(entry.path()).unwrap(), changed));
        }
    }
    files.sort();
    files
}

/// A process that is stopped answers nobody, and one in another container cannot be asked.
#[test]
fn a_store_is_read_from_disk_while_its_holder_does_not_answer() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    store.commit(&records(0..500)).unwrap();
    drop(store);
    let mut writer = Player::start(command("write", directory.path(), 1_000_000));
    for _ in 0..5 {
        writer.line().unwrap();
    }
    // The words lead nowhere, as they do in another name space of the network.
    let lock = directory.path().join("lock");
    let words = std::fs::read_to_string(&lock).unwrap();
    std::fs::write(&lock, words.replace("tribosweep-store-", "tribosweep-elsewhere-")).unwrap();
    let start = Instant::now();
    let reader = Store::read(directory.path()).unwrap();
    assert!(start.elapsed() < Duration::from_secs(6), "{:?}", start.elapsed());
    let pid = writer.process.id();
    assert!(
        matches!(reader.origin(), RecordOrigin::Copy(CopyReason::Unreachable { pid: p, .. }) if p == pid),
        "{:?}",
        reader.origin()
    );
    assert!(reader.origin().to_string().contains("may be missing"), "{}", reader.origin());
    assert!((0..500).all(|i| reader.get(&key(i)).unwrap() == Some(record(i))));
    assert!(reader.verify(|_, _| Vec::new()).unwrap().is_sound());
    let error = Store::open(directory.path()).err().unwrap();
    assert!(matches!(error, OpenError::Held { pid: p, .. } if p == pid), "{error}");
    // A writer that comes second does not repeat words that nobody stands behind.
    std::fs::write(&lock, words.replace("tribosweep-store-", "x").replace("plays", "played"))
        .unwrap();
    let error = Store::open(directory.path()).err().unwrap();
    assert!(matches!(error, OpenError::HeldByUnknown { .. }), "{error}");
    writer.kill();
}

/// The copy is taken while a process writes without a pause, and lacks nothing that was promised.
#[test]
fn a_copy_of_a_busy_store_has_all_that_was_promised() {
    let rounds: u32 = std::env::var("TRIBOSWEEP_STORE_COPIES")
        .map_or(1, |count| count.parse().expect("a number of copies"));
    let directory = tempfile::tempdir().unwrap();
    let mut writer = Player::start(command("write", directory.path(), 0));
    writer.line().unwrap();
    std::fs::write(directory.path().join("lock"), "").unwrap();
    let pid = rustix::process::Pid::from_child(&writer.process);
    let committed = std::sync::Mutex::new(vec![(Instant::now(), 0)]);
    let groups = || committed.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while let Some(line) = writer.line() {
                if let Some(group) = line.strip_prefix("committed ") {
                    groups().push((Instant::now(), group.parse::<u64>().unwrap()));
                }
            }
        });
        let outcome = std::panic::catch_unwind(|| {
            for round in 0..rounds {
                std::thread::sleep(Duration::from_millis(1200));
                // The manifest promises a group half a second after it was committed at the latest.
                let promised = Instant::now() - Duration::from_secs(1);
                let reader = Store::read(directory.path()).unwrap();
                assert!(!matches!(reader.origin(), RecordOrigin::Process { .. }));
                let found: BTreeSet<_> = reader.keys().unwrap().into_iter().collect();
                assert!(reader.verify(|_, _| Vec::new()).unwrap().is_sound());
                let old: Vec<u64> = groups()
                    .iter()
                    .filter(|(time, group)| *time < promised && group % 3 != 1)
                    .map(|(_, group)| *group)
                    .collect();
                assert!(!old.is_empty(), "the writer has only begun");
                for group in &old {
                    let start = 100 * group;
                    let missing = (start..start + super::child::size(*group))
                        .filter(|i| !found.contains(&key(*i)))
                        .count();
                    assert_eq!(missing, 0, "round {round}: group {group} of {}", old.len());
                }
            }
        });
        rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
        outcome.unwrap();
    });
}

#[test]
fn reading_creates_nothing() {
    let directory = tempfile::tempdir().unwrap();
    assert!(matches!(Store::read(directory.path()), Err(OpenError::Missing { .. })));
    assert!(matches!(
        Store::read(&directory.path().join("nowhere")),
        Err(OpenError::Missing { .. })
    ));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
}
