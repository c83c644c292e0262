//! The store is compared with a map, with reopening in between, and its own reports are checked.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use proptest::prelude::*;

use identity::{JobKey, STORED_LIMIT};
use store::{Digest, ReadError, Store, WriteError};

use super::{key, record, records};

#[derive(Clone, Debug)]
enum Step {
    Commit(Vec<(u64, u64)>),
    Remove(Vec<u64>),
    Study(String, Vec<u8>),
    Reopen,
}

fn step() -> impl Strategy<Value = Step> {
    let job = 0..30u64;
    prop_oneof![
        4 => prop::collection::vec((job.clone(), 0..1000u64), 0..12).prop_map(Step::Commit),
        2 => prop::collection::vec(job, 0..8).prop_map(Step::Remove),
        1 => ("[a-z/ ]{0,3}", prop::collection::vec(any::<u8>(), 0..50)).prop_map(|(name, text)| Step::Study(name, text)),
        1 => Just(Step::Reopen),
    ]
}

fn promised(directory: &Path) -> u64 {
    let text = std::fs::read(directory.join("manifest.json")).unwrap();
    serde_json::from_slice::<serde_json::Value>(&text).unwrap()["records"].as_u64().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn it_is_a_map_that_lasts(steps in prop::collection::vec(step(), 1..25)) {
        let directory = tempfile::tempdir().unwrap();
        let mut store = Store::open(directory.path()).unwrap();
        let mut model: BTreeMap<JobKey, Vec<u8>> = BTreeMap::new();
        let mut studies: BTreeMap<String, Vec<u8>> = BTreeMap::new();
        for step in steps {
            match step {
                Step::Commit(jobs) => {
                    let group: Vec<_> = jobs.iter().map(|(job, value)| (key(*job), record(*value))).collect();
                    store.commit(&group).unwrap();
                    model.extend(group);
                }
                Step::Remove(jobs) => {
                    let keys: Vec<_> = jobs.iter().copied().map(key).collect();
                    let there = keys.iter().collect::<BTreeSet<_>>().into_iter().filter(|k| model.remove(k).is_some()).count();
                    prop_assert_eq!(store.remove(&keys).unwrap(), there);
                }
                Step::Study(name, text) => {
                    store.put_study(&name, &text).unwrap();
                    studies.insert(name, text);
                }
                Step::Reopen => {
                    drop(store);
                    prop_assert_eq!(promised(directory.path()), model.len() as u64);
                    store = Store::open(directory.path()).unwrap();
                }
            }
            prop_assert!(promised(directory.path()) <= model.len() as u64);
            prop_assert_eq!(store.len(), model.len());
            prop_assert_eq!(store.keys(), model.keys().copied().collect::<Vec<_>>());
            let found: BTreeMap<_, _> = store.records().map(|(key, record)| (key, record.unwrap())).collect();
            prop_assert_eq!(&found, &model);
            prop_assert_eq!(store.study_names(), studies.keys().cloned().collect::<Vec<_>>());
            for (name, definition) in &studies {
                let stored = store.study(name).unwrap();
                prop_assert_eq!(stored.as_ref(), Some(definition));
            }
        }
        for job in 0..30 {
            prop_assert_eq!(store.contains(&key(job)), model.contains_key(&key(job)));
            prop_assert_eq!(store.get(&key(job)).unwrap(), model.get(&key(job)).cloned());
        }
    }
}

#[test]
fn the_first_group_is_promised_at_once() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    assert_eq!(promised(directory.path()), 0);
    store.commit(&records(0..3)).unwrap();
    assert_eq!(promised(directory.path()), 3);
    store.remove(&[key(1)]).unwrap();
    assert_eq!(promised(directory.path()), 2);
}

/// A kill while the first manifest was being written leaves a store that was not there yet.
#[test]
fn a_store_that_was_killed_while_it_was_made_is_made_anew() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("lock"), "").unwrap();
    std::fs::write(directory.path().join(".unfinished-a1b2c3"), "{").unwrap();
    let store = Store::open(directory.path()).unwrap();
    store.commit(&[(key(1), vec![1])]).unwrap();
    assert!(!directory.path().join(".unfinished-a1b2c3").exists());
}

#[test]
fn a_record_too_large_stops_its_whole_group() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    let largest = vec![1; STORED_LIMIT];
    store.commit(&[(key(1), &largest)]).unwrap();
    assert_eq!(store.get(&key(1)).unwrap(), Some(largest));
    let error =
        store.commit(&[(key(2), vec![1]), (key(3), vec![1; STORED_LIMIT + 1])]).unwrap_err();
    assert!(
        matches!(error, WriteError::TooLarge { key: k, bytes } if k == key(3) && bytes == STORED_LIMIT + 1)
    );
    assert!(error.to_string().contains("blobs"), "{error}");
    assert_eq!(store.keys(), [key(1)]);
}

#[test]
fn verify_names_what_is_wrong_and_compact_keeps_what_is_needed() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    let field = |i: u8| vec![i; 5000];
    let (kept, orphan) =
        (store.blobs().put(&field(1)).unwrap(), store.blobs().put(&field(2)).unwrap());
    let absent = Digest::of(&field(3));
    store.commit(&[(key(1), kept.0), (key(2), absent.0)]).unwrap();
    store.put_study("sweep", b"a study").unwrap();
    let shelf = store.blobs().path(&kept).parent().unwrap().to_owned();
    std::fs::write(shelf.join(".unfinished-x"), b"half a fie").unwrap();
    std::fs::write(shelf.join("notes.txt"), b"mine").unwrap();
    let digests = |_: &JobKey, record: &[u8]| vec![Digest(record.try_into().unwrap())];

    let found = Store::read(directory.path()).unwrap().verify(digests).unwrap();
    assert_eq!((found.records, found.blobs, found.studies), (2, 3, 1));
    assert_eq!(found.missing_blobs, [(absent, key(2))]);
    assert_eq!(found.unreferenced_blobs, 1);
    assert_eq!(found.stray_files, [shelf.join("notes.txt")]);
    assert!(!found.is_sound());

    let size = std::fs::metadata(store.blobs().path(&orphan)).unwrap().len();
    let removed = store.compact(&BTreeSet::from([kept])).unwrap();
    assert_eq!((removed.blobs, removed.unfinished, removed.bytes), (1, 1, size + 10));
    assert!(store.blobs().contains(&kept) && !store.blobs().contains(&orphan));
    assert_eq!(store.study("sweep").unwrap().unwrap(), b"a study");
    assert_eq!(std::fs::read(shelf.join("notes.txt")).unwrap(), b"mine");

    assert_eq!(store.blobs().put(&field(3)).unwrap(), absent);
    assert!(Store::read(directory.path()).unwrap().verify(digests).unwrap().is_sound());
    std::fs::write(store.blobs().path(&kept), b"garbage").unwrap();
    std::fs::remove_file(store.blobs().path(&Digest::of(b"a study"))).unwrap();
    let found = Store::read(directory.path()).unwrap().verify(digests).unwrap();
    assert_eq!(found.corrupt_blobs.iter().map(|(digest, _)| *digest).collect::<Vec<_>>(), [kept]);
    assert_eq!(
        found.lost_studies.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["sweep"]
    );
    assert!(matches!(store.study("sweep"), Err(ReadError::StudyMissing { .. })));
}

#[test]
fn nothing_is_opened_where_there_is_something_else() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("thesis.tex"), b"").unwrap();
    let error = Store::open(directory.path()).err().unwrap().to_string();
    assert!(error.contains("is not a store"), "{error}");
    let file = directory.path().join("thesis.tex");
    assert!(Store::open(&file).err().unwrap().to_string().contains("thesis.tex"));
    assert!(Store::open(&directory.path().join("new/nested")).is_ok());
}

#[test]
fn records_outlive_many_threads_writing_at_once() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let store = &store;
            scope.spawn(move || {
                (0..10).for_each(|i| {
                    store
                        .commit(&records(thread * 100 + i * 10..thread * 100 + i * 10 + 10))
                        .unwrap()
                })
            });
        }
    });
    drop(store);
    assert_eq!(Store::open(directory.path()).unwrap().len(), 400);
}
