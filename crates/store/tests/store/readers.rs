//! Several processes use one store.

use std::time::{Duration, Instant};

use identity::STORED_LIMIT;
use store::{OpenError, ReadError, RecordOrigin, Store};

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
fn of_many_at_once_one_gets_it() {
    let directory = tempfile::tempdir().unwrap();
    let mut players: Vec<_> =
        (0..4).map(|_| Player::start(command("race", directory.path(), 0))).collect();
    let mut said: Vec<_> = players.iter_mut().map(|player| player.line().unwrap()).collect();
    said.sort();
    assert_eq!(said, ["held", "held", "held", "open"]);
    players.into_iter().for_each(Player::dismiss);
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
    assert!(matches!(reader.keys(), Err(ReadError::Unanswered { .. })));
    assert!(matches!(reader.get(&key(0)), Err(ReadError::Unanswered { .. })));
    assert!(reader.select(vec![key(0)]).all(|(_, record)| record.is_err()));
    let reader = Store::read(directory.path()).unwrap();
    assert_eq!(reader.origin().to_string(), "read from disk");
    check(&reader, 10_000);
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

fn store_keys(count: u64) -> Vec<identity::JobKey> {
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
    writer.kill();
    assert!(matches!(reader.keys(), Err(ReadError::Unanswered { .. })));
    assert_eq!(Store::read(directory.path()).unwrap().origin(), RecordOrigin::Disk);
}

#[test]
fn a_writer_waits_for_a_reader() {
    let directory = tempfile::tempdir().unwrap();
    Store::open(directory.path()).unwrap().commit(&records(0..10)).unwrap();
    let mut reader = Player::start(command("read", directory.path(), 0));
    assert_eq!(reader.line().as_deref(), Some("read from disk"));
    let start = Instant::now();
    let leaving = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(200));
        reader.dismiss();
    });
    assert_eq!(Store::open(directory.path()).unwrap().len(), 10);
    assert!(start.elapsed() >= Duration::from_millis(200));
    leaving.join().unwrap();
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
