//! A table that is kept of a study has the rows of the records that there are, or is not shown.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use identity::JobKey;
use store::{Digest, Glance, KeptTable, Store, StoreReader};

use super::child::{Player, command};
use super::{key, record, records};

/// The rows of the tests' records: three columns, of which the second says their lengths.
fn block(reader: &StoreReader, keys: &[JobKey]) -> Vec<Vec<u8>> {
    let lengths = keys.iter().map(|key| reader.get(key).unwrap().unwrap().len() as u64);
    let keys: Vec<u8> = keys.iter().flat_map(|key| key.0).collect();
    vec![keys, lengths.flat_map(u64::to_le_bytes).collect(), Vec::new()]
}

fn meaning() -> Digest {
    Digest::of(b"lengths")
}

/// Makes a table of all records; false if none can be kept.
pub(crate) fn make_table(directory: &Path, is_final: bool) -> bool {
    let reader = Store::read(directory).unwrap();
    let keys = reader.keys().unwrap();
    let Some(mut builder) = reader.table_builder(3) else { return false };
    for keys in keys.chunks(KeptTable::BLOCK) {
        builder.push(keys, &block(&reader, keys)).unwrap();
    }
    builder.finish("sweep", &meaning(), b"a caption".to_vec(), is_final).unwrap();
    true
}

fn table(directory: &Path) -> Option<KeptTable> {
    Glance::at(directory)?.table("sweep", &meaning())
}

/// Returns whether a table is shown. Each cell that it has must be that of the records, and what it
/// does not give must be an error.
fn is_shown(directory: &Path) -> bool {
    let Some(table) = table(directory) else { return false };
    let reader = Store::read(directory).unwrap();
    let keys = reader.keys().unwrap();
    assert_eq!((table.row_count(), table.column_count()), (keys.len(), 3));
    assert_eq!(table.caption(), b"a caption");
    let mut is_whole = true;
    for (number, keys) in keys.chunks(KeptTable::BLOCK).enumerate() {
        for (column, expected) in block(&reader, keys).into_iter().enumerate() {
            match table.piece(column, number) {
                Ok(piece) => assert!(piece == expected, "column {column}"),
                Err(_) => {
                    is_whole = false;
                    assert!(table.verify_column(column).is_err(), "column {column}");
                }
            }
        }
    }
    for (row, key) in keys.iter().enumerate() {
        match table.rows_of(key) {
            Ok(rows) => assert_eq!(rows, [row]),
            Err(_) => is_whole = false,
        }
    }
    is_whole
}

/// Makes a store of so many records with a table of them.
fn make(directory: &Path, count: u64) {
    let store = Store::open(directory).unwrap();
    store.put_study("sweep", b"so many points").unwrap();
    store.commit(&records(0..count)).unwrap();
    drop(store);
    assert!(make_table(directory, true));
}

/// Returns the files in the folder of tables beside the list.
fn files(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory.join("tables")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    paths.filter(|path| !path.ends_with("list")).collect()
}

#[test]
fn a_table_has_the_rows_of_all_records() {
    for count in [0, 1, 1023, 1024, 1025, 2500] {
        let directory = tempfile::tempdir().unwrap();
        make(directory.path(), count);
        assert!(is_shown(directory.path()), "{count} records");
        let table = table(directory.path()).unwrap();
        assert!(table.rows_of(&key(1_000_000)).unwrap().is_empty());
        assert!(table.piece(3, 0).is_err() && table.piece(0, 3).is_err());
        let glance = Glance::at(directory.path()).unwrap();
        assert!(glance.table("sweep", &Digest::of(b"other")).is_none());
        assert!(glance.table("other", &meaning()).is_none());
    }
}

#[test]
fn points_that_share_a_job_have_its_row_each() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path(), 10);
    let reader = Store::read(directory.path()).unwrap();
    let mut builder = reader.table_builder(1).unwrap();
    let shared: Vec<JobKey> = (0..1024).map(|i| key(i % 2)).collect();
    for _ in 0..3 {
        builder.push(&shared, &[Vec::new()]).unwrap();
    }
    builder.finish("sweep", &meaning(), Vec::new(), true).unwrap();
    let rows = table(directory.path()).unwrap().rows_of(&key(1)).unwrap();
    assert_eq!(rows, (0..3 * 1024).filter(|row| row % 2 == 1).collect::<Vec<_>>());
}

#[test]
fn a_table_is_shown_as_long_as_it_holds() {
    /// A change of the store, and whether a table holds after it that is final, and one that is
    /// not.
    type Change = (&'static str, fn(&Store), [bool; 2]);
    let changes: [Change; 6] = [
        ("nothing", |_| {}, [true, true]),
        ("a study", |store| store.put_study("other", b"x").unwrap(), [true, true]),
        ("further records", |store| store.commit(&records(20..22)).unwrap(), [true, false]),
        ("another record", |store| store.commit(&[(key(3), record(4))]).unwrap(), [false, false]),
        ("a record fewer", |store| assert_eq!(store.remove(&[key(3)]).unwrap(), 1), [false, false]),
        ("no record fewer", |store| assert_eq!(store.remove(&[key(99)]).unwrap(), 0), [true, true]),
    ];
    for (name, change, expected) in changes {
        for (is_final, expected) in [true, false].into_iter().zip(expected) {
            let directory = tempfile::tempdir().unwrap();
            let path = directory.path();
            make(path, 10);
            assert!(make_table(path, is_final) && table(path).is_some());
            let store = Store::open(path).unwrap();
            assert!(table(path).is_none(), "a process may be changing it: {name}");
            assert!(!make_table(path, true), "its process answers: {name}");
            change(&store);
            drop(store);
            assert_eq!(table(path).is_some(), expected, "{name}, {is_final}");
            assert_eq!(files(path).len(), usize::from(expected), "{name}, {is_final}");
        }
    }
}

/// Whatever byte is another one, and wherever a file ends, no other cell is shown.
#[test]
fn a_damaged_table_shows_no_other_cell() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    make(path, 12);
    let files = [path.join("tables/list"), files(path).remove(0)];
    for file in files {
        let whole = fs::read(&file).unwrap();
        for place in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[place] ^= 1 << (place % 8);
            fs::write(&file, &flipped).unwrap();
            assert!(!is_shown(path), "byte {place} of {} in {}", whole.len(), file.display());
            fs::write(&file, &whole[..place]).unwrap();
            assert!(!is_shown(path), "cut to {place} of {} in {}", whole.len(), file.display());
        }
        fs::write(&file, [&whole[..], &[0]].concat()).unwrap();
        assert!(!is_shown(path), "a byte more");
        fs::write(&file, &whole).unwrap();
        assert!(is_shown(path));
    }
}

/// Words whose digests are right can still be those of somebody who wants this process to fail.
#[test]
fn a_table_that_claims_too_much_takes_no_memory() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    make(path, 12);
    let file = files(path).remove(0);
    let whole = fs::read(&file).unwrap();
    let list = fs::read(path.join("tables/list")).unwrap();
    let name = file.file_name().unwrap().to_str().unwrap();
    let digest: Digest = name.parse().unwrap();
    let head = (0..whole.len()).find(|start| Digest::of(&whole[*start..]) == digest).unwrap();
    let at = list.windows(32).position(|bytes| bytes == digest.0).unwrap();
    // The number of rows is a byte after the caption, and its longer forms have a byte in front.
    let rows = head + 1 + b"a caption".len();
    assert_eq!(whole[rows], 12);
    for claim in [vec![13], [&[253][..], &u64::MAX.to_le_bytes()].concat()] {
        let mut forged = whole.clone();
        forged.splice(rows..=rows, claim);
        let digest = Digest::of(&forged[head..]);
        fs::write(path.join("tables").join(digest.to_string()), &forged).unwrap();
        let mut words = list.clone();
        words[at..at + 32].copy_from_slice(&digest.0);
        let body = Digest::of(&words[50..]);
        words[18..50].copy_from_slice(&body.0);
        fs::write(path.join("tables/list"), &words).unwrap();
        match table(path) {
            None => {}
            Some(table) => {
                assert!(table.row_count() < 1000 && table.piece(0, 1).is_err());
                let _ = table.rows_of(&key(3));
            }
        }
    }
}

#[test]
fn other_things_in_the_place_of_tables_cost_no_result() {
    for is_file in [true, false] {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path();
        drop(Store::open(path).unwrap());
        let elsewhere = tempfile::tempdir().unwrap();
        match is_file {
            true => fs::write(path.join("tables"), "words").unwrap(),
            false => std::os::unix::fs::symlink(elsewhere.path(), path.join("tables")).unwrap(),
        }
        let store = Store::open(path).unwrap();
        store.commit(&records(0..3)).unwrap();
        drop(store);
        assert!(!make_table(path, true) && table(path).is_none());
        assert_eq!(Store::open(path).unwrap().len(), 3);
        assert_eq!(fs::read_dir(elsewhere.path()).unwrap().count(), 0, "no link is followed");
    }
}

#[test]
fn a_table_that_is_not_finished_leaves_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    make(path, 10);
    let reader = Store::read(path).unwrap();
    let mut builder = reader.table_builder(3).unwrap();
    let keys = reader.keys().unwrap();
    builder.push(&keys, &block(&reader, &keys)).unwrap();
    assert!(builder.push(&keys, &block(&reader, &keys)).is_err(), "the first was the last");
    drop(builder);
    // The database changes while another one is made.
    let mut builder = reader.table_builder(3).unwrap();
    builder.push(&keys, &block(&reader, &keys)).unwrap();
    Store::open(path).unwrap().commit(&records(10..11)).unwrap();
    builder.finish("sweep", &meaning(), b"a caption".to_vec(), false).unwrap();
    assert_eq!(files(path).len(), 1);
    assert_eq!(table(path).unwrap().row_count(), 10, "the first is final");
    // What a killed writer has left goes when the store is closed.
    fs::write(path.join("tables/.unfinished-abc"), "half").unwrap();
    drop(Store::open(path).unwrap());
    assert!(!path.join("tables/.unfinished-abc").exists());
    // Everything can be forgotten.
    Store::forget_words(path).unwrap();
    assert!(table(path).is_none() && files(path).is_empty());
}

/// Kills processes that make tables, and holds what is shown afterwards against the records.
fn kill(rounds: u64) -> u64 {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let (mut random, mut right) = (7u64, 0);
    for round in 0..rounds {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let mut player = Player::start(command("tabulate", path, 10_000 * round));
        for _ in 0..1 + (random >> 62) {
            player.line().expect("it goes on until it is killed");
        }
        std::thread::sleep(Duration::from_micros((random >> 40) % 20_000));
        player.kill();
        right += u64::from(is_shown(path));
        drop(Store::open(path).unwrap());
        assert!(files(path).len() <= 1, "round {round}");
    }
    right
}

#[test]
fn no_kill_leaves_a_table_that_is_wrong() {
    kill(20);
}

#[test]
#[ignore = "it takes minutes"]
fn no_kill_of_500_leaves_a_table_that_is_wrong() {
    let right = kill(500);
    println!("500 kills left a right table {right} times, and none in the other cases");
    assert!(right > 0);
}
