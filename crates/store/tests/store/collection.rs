//! A collection removes what nothing refers to, and the database shrinks; kills leave the rest as
//! it was.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Instant;

use identity::JobKey;
use store::{Collection, Digest, Garbage, Store, StudyLabels};

use super::child::{Player, command};
use super::{field, key, record, records};

/// The number of records of the store that collections are killed in.
const COUNT: u64 = 400;

/// Every fifth record stays; blobs 1 to 9 are garbage, and 101 to 109 stay.
pub(crate) fn garbage() -> Garbage {
    Garbage {
        records: (0..COUNT).filter(|i| i % 5 != 0).map(key).collect(),
        blobs: (1..10).map(|machine| Digest::of(&field(machine))).collect(),
        loose_blobs: BTreeSet::new(),
    }
}

fn make(directory: &Path) {
    let store = Store::open(directory).unwrap();
    for start in (0..COUNT).step_by(100) {
        store.commit(&records(start..start + 100)).unwrap();
    }
    for machine in (1..10).chain(101..110) {
        store.blobs().put(&field(machine)).unwrap();
    }
    store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
    let tags = BTreeSet::from(["draft".to_owned()]);
    store.set_labels("sweep", StudyLabels { tags, note: None }).unwrap();
}

/// Holds what stays against what was written.
fn require_kept(directory: &Path) {
    let store = Store::open(directory).unwrap();
    for i in (0..COUNT).step_by(5) {
        assert_eq!(store.get(&key(i)).unwrap(), Some(record(i)), "record {i}");
    }
    for machine in 101..110 {
        assert!(store.blobs().is_sound(&Digest::of(&field(machine))).unwrap(), "blob {machine}");
    }
    assert_eq!(store.study("sweep").unwrap().unwrap(), b"mu = [0.1, 0.3]");
    assert!(store.labels("sweep").tags.contains("draft"));
    // What is garbage is whole as long as it is there.
    assert!(store.records().all(|(_, record)| record.is_ok()));
}

#[test]
fn a_collection_removes_garbage_alone_and_the_database_shrinks() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    // The definition of a study stays although it is called garbage.
    let mut garbage = garbage();
    garbage.blobs.insert(Digest::of(b"mu = [0.1, 0.3]"));
    let shelf = directory.path().join("blobs/ab");
    fs::create_dir_all(&shelf).unwrap();
    fs::write(shelf.join(".unfinished-1"), "half").unwrap();
    let done = Store::open(directory.path()).unwrap().collect(&garbage).unwrap();
    let Collection { database_before, database_after, .. } = done;
    assert_eq!((done.records, done.blobs, done.unfinished), (320, 9, 1));
    assert!(database_after < database_before, "{done:?}");
    require_kept(directory.path());
    assert_eq!(Store::open(directory.path()).unwrap().len(), 80);
    let left: Vec<_> =
        fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap()).collect();
    let names: BTreeSet<_> =
        left.iter().map(|entry| entry.file_name().into_string().unwrap()).collect();
    assert_eq!(names, ["blobs", "lock", "manifest.json", "records"].map(str::to_owned).into());
    // A second one has nothing to do, and the store is written to as before.
    let store = Store::open(directory.path()).unwrap();
    let again = store.collect(&garbage).unwrap();
    assert_eq!((again.records, again.blobs), (0, 0));
    let store = Store::open(directory.path()).unwrap();
    store.commit(&records(0..10)).unwrap();
    assert_eq!(store.len(), 88);
}

/// One that reads meanwhile sees every record that stays.
#[test]
fn a_reader_goes_on_while_a_store_is_collected() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let store = Store::open(directory.path()).unwrap();
    let reader = Store::read(directory.path()).unwrap();
    assert_eq!(reader.keys().unwrap().len(), COUNT as usize);
    store.collect(&garbage()).unwrap();
    let keys: Vec<JobKey> = (0..COUNT).step_by(5).map(key).collect();
    let found: Vec<_> =
        reader.select(keys.clone()).map(|(key, found)| (key, found.unwrap())).collect();
    assert_eq!(found.iter().map(|(key, _)| *key).collect::<Vec<_>>(), keys);
    assert_eq!(reader.keys().unwrap().len(), keys.len());
}

#[test]
fn a_killed_collection_loses_nothing_that_stays() {
    let begin = || {
        let directory = tempfile::tempdir().unwrap();
        make(directory.path());
        let mut collector = Player::start(command("collect", directory.path(), 0));
        assert_eq!(collector.line().as_deref(), Some("begins"));
        (directory, collector)
    };
    // The time of a whole one says when there is something to kill.
    let (_directory, mut collector) = begin();
    let start = Instant::now();
    assert_eq!(collector.line().as_deref(), Some("removed 320"));
    let mut whole = start.elapsed();
    let (mut met, mut done) = (0, 0);
    for round in 0..16 {
        let (directory, mut collector) = begin();
        std::thread::sleep(whole * round / 8);
        collector.kill();
        if collector.line().is_some() {
            done += 1;
            // The first one was slower.
            whole = whole * 3 / 4;
        } else {
            met += 1;
        }
        require_kept(directory.path());
        // The next collection finishes.
        Store::open(directory.path()).unwrap().collect(&garbage()).unwrap();
        require_kept(directory.path());
        assert_eq!(Store::open(directory.path()).unwrap().len(), 80);
        assert!(!directory.path().join("records.salvaged").exists());
    }
    assert!(met >= 5, "only {met} collections were killed, {done} had ended");
}

#[test]
fn a_study_is_removed_with_its_labels_and_its_results_stay() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let store = Store::open(directory.path()).unwrap();
    store.put_study("other", b"nothing").unwrap();
    assert_eq!(store.remove_studies(&["gone".to_owned()].into()).unwrap(), 0);
    assert_eq!(store.remove_studies(&["sweep".to_owned(), "gone".to_owned()].into()).unwrap(), 1);
    assert_eq!(store.study_names(), ["other"]);
    assert_eq!(store.len(), COUNT as usize);
    drop(store);
    let reader = Store::read(directory.path()).unwrap();
    assert!(reader.labels().unwrap().is_empty());
    assert!(reader.blobs().contains(&Digest::of(b"mu = [0.1, 0.3]")));
}
