//! Stores and exports are merged: in any order, any number of times, in part, and killed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use identity::JobKey;
use proptest::prelude::*;
use store::{
    Digest, ExportError, ExportHeader, ExportWriter, MergeError, MergeReport, MergeRules,
    MergeSelection, RecordRank, References, ShardName, Store, StoreReader, merge_into_export,
};

use super::child::{Player, command};
use super::{RULES, field, key, ranked};

/// The records of a source, by the numbers of their jobs.
type Content = BTreeMap<u64, Vec<u8>>;

fn shard(index: u32, count: u32) -> Option<ShardName> {
    Some(ShardName { study: "sweep".to_owned(), index, count })
}

/// Writes an export, with the blobs that its records refer to and a definition from some path.
fn write(path: &Path, shard: Option<ShardName>, from: &str, content: &Content) {
    let machine = tempfile::tempdir().unwrap();
    let source = Store::open(machine.path()).unwrap();
    let header = ExportHeader { program: "0.1.0".to_owned(), shard };
    let mut writer = ExportWriter::open(path, &header).unwrap();
    writer.put_study("sweep", format!("{from}|mu = 1").as_bytes()).unwrap();
    for (i, bytes) in content {
        let references = (RULES.examine)(&key(*i), bytes).unwrap().references;
        if references != References::default() {
            source.blobs().put(&field(bytes[9])).unwrap();
        }
        for digest in &references.companions {
            assert!(writer.accompany(digest, source.blobs()).unwrap());
        }
        writer.append(&key(*i), bytes, source.blobs(), references.needed).unwrap();
    }
    writer.note(format!("note of {from}").as_bytes());
    writer.close().unwrap();
}

/// Everything in a store: records, studies and blobs.
#[derive(Debug, PartialEq)]
struct Whole {
    records: Vec<(JobKey, Vec<u8>)>,
    studies: Vec<(String, Vec<u8>)>,
    blobs: usize,
}

fn whole(path: &Path) -> Whole {
    let reader = Store::read_by(path, &RULES).unwrap();
    let references = |job: &JobKey, bytes: &[u8]| (RULES.examine)(job, bytes).unwrap().references;
    let found = reader.verify(references).unwrap();
    assert!(found.is_sound(), "{found:?}");
    let names = reader.study_names().unwrap().into_iter();
    Whole {
        records: reader.records().unwrap().map(|(key, bytes)| (key, bytes.unwrap())).collect(),
        studies: names.map(|name| (name.clone(), reader.study(&name).unwrap().unwrap())).collect(),
        blobs: found.blobs - found.unreferenced_blobs,
    }
}

/// Many records share the blob that goes along with them. It travels with them, is brought back
/// from any source, and nothing is given up without it.
#[test]
fn what_only_goes_along_with_records_travels_and_may_be_lost() {
    let directory = tempfile::tempdir().unwrap();
    let place = |name: &str| directory.path().join(name);
    let content: Content = (0..5).map(|i| (i, ranked(RecordRank::Finished, i, 150))).collect();
    write(&place("all.tribosweep"), None, "here", &content);
    let digest = Digest::of(&field(150));
    let report = merge(&[place("all.tribosweep")], &place("store")).unwrap();
    assert_eq!((report.added, report.blobs, report.lost_companions), (5, 1, Vec::new()));
    assert_eq!(whole(&place("store")).blobs, 2, "a definition and what goes along");

    let lose = |store: &str, damage: Option<&[u8]>| {
        let path = Store::read(&place(store)).unwrap().blobs().path(&digest);
        match damage {
            Some(bytes) => fs::write(path, bytes).unwrap(),
            None => fs::remove_file(path).unwrap(),
        }
    };
    let references = |job: &JobKey, bytes: &[u8]| (RULES.examine)(job, bytes).unwrap().references;
    for damage in [None, Some(&b"rubbish"[..])] {
        lose("store", damage);
        let found = Store::read(&place("store")).unwrap().verify(references).unwrap();
        assert!(found.is_sound() && found.unreferenced_blobs == 0, "{found:?}");
        let [lost] = &found.lost_companions[..] else { panic!("{found:?}") };
        assert_eq!((lost.digest, lost.records), (digest, 5));
        // A source without it says so once, and gives its records.
        let target = place(if damage.is_some() { "damaged" } else { "lost.tribosweep" });
        let report = merge(&[place("store")], &target).unwrap();
        assert_eq!((report.added, report.blobs), (5, 0));
        assert_eq!((report.faults.len(), report.incomplete.len()), (0, 0));
        let [lost] = &report.lost_companions[..] else { panic!("{report:?}") };
        assert_eq!((lost.digest, lost.records), (digest, 5));
        assert_eq!(Store::read(&target).unwrap().keys().unwrap().len(), 5);
        // Another source brings it back, although it has no record that is new.
        let report = merge(&[place("all.tribosweep")], &place("store")).unwrap();
        assert_eq!((report.added, report.blobs, report.lost_companions.len()), (0, 1, 0));
        assert_eq!(whole(&place("store")).blobs, 2, "a definition and what goes along");
    }
    lose("store", None);
    let needed = |job: &JobKey, bytes: &[u8]| references(job, bytes).needed;
    assert_eq!(Store::salvage(&place("store"), needed).unwrap().kept, 5);
}

fn readers(paths: &[PathBuf]) -> Vec<StoreReader> {
    paths.iter().map(|path| Store::read_by(path, &RULES).unwrap()).collect()
}

fn merge(sources: &[PathBuf], target: &Path) -> Result<MergeReport, MergeError> {
    let readers = readers(sources);
    let readers: Vec<&StoreReader> = readers.iter().collect();
    if target.extension().is_some() {
        merge_into_export(target, "0.1.0", &readers, &RULES, &MergeSelection::default())
    } else {
        Store::open(target).unwrap().import(&readers, &RULES)
    }
}

/// Returns records of some of twelve jobs. Machines agree on results and on nothing else.
fn contents() -> impl Strategy<Value = Vec<Content>> {
    let record = (0..12u64, 0..3u8, 0..4u8).prop_map(|(job, rank, machine)| {
        let rank =
            [RecordRank::Foreign, RecordRank::Unfinished, RecordRank::Finished][rank as usize];
        (job, ranked(rank, job, if machine == 3 { 200 } else { machine }))
    });
    let content = proptest::collection::vec(record, 0..12)
        .prop_map(|records| records.into_iter().collect::<Content>());
    proptest::collection::vec(content, 1..5)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    /// Any order, any repetition, any way of grouping the merges and any kind of target give the
    /// same records.
    #[test]
    fn the_order_of_merges_leaves_no_trace(
        contents in contents(), order in proptest::collection::vec((any::<prop::sample::Index>(), 1..4usize), 0..6),
    ) {
        let directory = tempfile::tempdir().unwrap();
        let exports = directory.path().join("exports");
        let paths: Vec<PathBuf> =
            (0..contents.len()).map(|i| exports.join(format!("{i}.tribosweep"))).collect();
        for (path, (content, i)) in paths.iter().zip(contents.iter().zip(1..)) {
            write(path, shard(i, 16), &format!("machine {i}"), content);
        }
        let at_once = directory.path().join("store");
        let report = merge(&paths, &at_once).unwrap();
        prop_assert!(report.conflicts.is_empty() && report.faults.is_empty(), "{:?}", report);
        let expected = whole(&at_once);
        let jobs: BTreeSet<u64> = contents.iter().flat_map(|content| content.keys().copied()).collect();
        prop_assert_eq!(expected.records.len(), jobs.len());
        prop_assert_eq!(report.added, jobs.len());
        let given: usize = contents.iter().map(BTreeMap::len).sum();
        prop_assert_eq!(report.already_there, given - jobs.len());
        prop_assert_eq!(report.shards.len(), contents.len());
        // The directory of the exports is read as the merged store is.
        prop_assert_eq!(&whole(&exports).records, &expected.records);
        prop_assert_eq!(&whole(&exports).studies, &expected.studies);

        // Some are merged first, some several times, then all in the opposite order.
        for target in [directory.path().join("steps"), directory.path().join("steps.tribosweep")] {
            for (place, count) in &order {
                let start = place.index(paths.len());
                merge(&paths[start..paths.len().min(start + count)], &target).unwrap();
            }
            let backwards: Vec<PathBuf> = paths.iter().rev().cloned().collect();
            let report = merge(&backwards, &target).unwrap();
            prop_assert_eq!(report.shards.len(), contents.len());
            prop_assert_eq!(&whole(&target), &expected);
            let again = merge(&paths, &target).unwrap();
            prop_assert_eq!((again.added, again.replaced, again.blobs), (0, 0, 0));
            prop_assert_eq!(again.already_there, given);
            prop_assert_eq!(&whole(&target), &expected);
        }
        // What was merged may be merged again, in either form.
        let third = directory.path().join("third");
        merge(&[at_once, directory.path().join("steps.tribosweep")], &third).unwrap();
        prop_assert_eq!(&whole(&third), &expected);
    }
}

#[test]
fn different_results_of_one_job_are_a_conflict_and_change_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let finished = |result, machine| ranked(RecordRank::Finished, result, machine);
    let content = |result, machine| {
        Content::from([(1, finished(result, machine)), (2, finished(2, machine))])
    };
    write(&path("a.tribosweep"), shard(1, 2), "a", &content(10, 1));
    write(&path("b.tribosweep"), shard(2, 2), "b", &content(20, 2));
    write(
        &path("c.tribosweep"),
        shard(2, 2),
        "c",
        &Content::from([(1, ranked(RecordRank::Unfinished, 1, 3))]),
    );
    let names = ["a.tribosweep", "b.tribosweep", "c.tribosweep"];
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        for target in ["store", "merged.tribosweep"] {
            let sources: Vec<PathBuf> = order.iter().map(|i| path(names[*i])).collect();
            let report = merge(&sources, &path(target)).unwrap();
            let [conflict] = &report.conflicts[..] else { panic!("{report:?}") };
            assert_eq!(conflict.key, key(1));
            let both = BTreeSet::from([conflict.first.clone(), conflict.second.clone()]);
            assert_eq!(both, BTreeSet::from([path(names[0]), path(names[1])]));
            let merged = whole(&path(target));
            assert_eq!(merged.records.len(), 1, "everything else is merged");
            assert_eq!((report.added, report.already_there), (1, 1));
            if target == "store" {
                fs::remove_dir_all(path(target)).unwrap();
            } else {
                fs::remove_file(path(target)).unwrap();
            }
        }
    }
    // The target is a source like any other, and keeps what it has.
    for target in ["store", "merged.tribosweep"] {
        merge(&[path(names[0])], &path(target)).unwrap();
        let report = merge(&[path(names[1])], &path(target)).unwrap();
        assert_eq!(report.conflicts.len(), 1);
        assert!(report.conflicts[0].first == path(target), "{report:?}");
        let reader = Store::read_by(&path(target), &RULES).unwrap();
        assert_eq!(reader.get(&key(1)).unwrap().unwrap(), finished(10, 1));
        // A finished result takes the place of none.
        let report = merge(&[path(names[2])], &path(target)).unwrap();
        assert_eq!((report.conflicts.len(), report.already_there), (0, 1));
    }
    let late = path("late.tribosweep");
    merge(&[path(names[2])], &late).unwrap();
    let report = merge(&[path(names[0])], &late).unwrap();
    assert_eq!((report.replaced, report.added), (1, 1));
    // A single file is read by the rule of the merge as well.
    assert_eq!(whole(&late).records.len(), 2);
}

#[test]
fn what_does_not_belong_together_is_refused_before_anything_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let content = Content::from([(1, ranked(RecordRank::Finished, 1, 1))]);
    write(&path("a.tribosweep"), shard(1, 2), "a", &content);
    write(&path("b.tribosweep"), shard(3, 16), "b", &content);
    let target = path("store");
    let refused = merge(&[path("a.tribosweep"), path("b.tribosweep")], &target).unwrap_err();
    assert!(matches!(&refused, MergeError::ShardCounts { .. }), "{refused}");
    let words = refused.to_string();
    assert!(
        words.contains("a.tribosweep is shard 1/2") && words.contains("is shard 3/16"),
        "{words}"
    );
    assert!(whole(&target).records.is_empty() && whole(&target).studies.is_empty());

    let other = Store::open(&path("other")).unwrap();
    other.put_study("sweep", b"x|mu = 2").unwrap();
    drop(other);
    for order in [["other", "a.tribosweep"], ["a.tribosweep", "other"]] {
        let refused = merge(&order.map(path), &path("new")).unwrap_err();
        assert!(matches!(&refused, MergeError::StudiesDiffer { .. }), "{refused}");
        assert!(order.iter().all(|name| refused.to_string().contains(name)), "{refused}");
    }
    assert!(whole(&path("new")).studies.is_empty());
    let refused = merge(&[path("other")], &path("a.tribosweep")).unwrap_err();
    assert!(
        matches!(&refused, MergeError::Export(ExportError::OtherShard { .. })),
        "a merge does not write over the export of a shard: {refused}"
    );
    fs::write(path("letter.tribosweep"), "dear reader, this is no export").unwrap();
    assert!(merge(&[path("other")], &path("letter.tribosweep")).is_err());
    assert!(fs::read(path("letter.tribosweep")).unwrap().starts_with(b"dear"));
}

#[test]
fn a_study_may_be_divided_anew() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    for (name, index, count) in [("a", 1, 2), ("b", 3, 16), ("c", 2, 2)] {
        let job = u64::from(index + count);
        let content = Content::from([(job, ranked(RecordRank::Finished, job, 1))]);
        write(&path(&format!("{name}.tribosweep")), shard(index, count), "a", &content);
    }
    let [a, b, c] = ["a.tribosweep", "b.tribosweep", "c.tribosweep"].map(path);
    for target in [path("store"), path("merged.tribosweep")] {
        merge(std::slice::from_ref(&a), &target).unwrap();
        // The target remembers of how many shards the study was, and new ones count.
        let report = merge(std::slice::from_ref(&b), &target).unwrap();
        assert_eq!((report.added, report.shards.len()), (1, 1));
        assert_eq!(report.forgotten, [shard(1, 2).unwrap()]);
        let known = || Store::read(&target).unwrap().shards();
        assert_eq!(
            known().iter().map(|state| &state.shard).collect::<Vec<_>>(),
            [&shard(3, 16).unwrap()]
        );
        assert_eq!(whole(&target).records.len(), 2, "the results stay");
        // Sources that contradict each other are refused all the same.
        let refused = merge(&[a.clone(), b.clone(), c.clone()], &target).unwrap_err();
        assert!(matches!(&refused, MergeError::ShardCounts { .. }), "{refused}");
        // What a merged export names counts as much as what another one does, and what a store
        // remembers counts less.
        let both = merge(&[target.clone(), c.clone()], &path("other"));
        match target.is_dir() {
            true => assert_eq!(both.unwrap().forgotten, [shard(3, 16).unwrap()]),
            false => assert!(matches!(both, Err(MergeError::ShardCounts { .. }))),
        }
    }
}

#[test]
fn a_run_takes_results_of_any_shard() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let store = Store::open(&path("store")).unwrap();
    let mut sources = Vec::new();
    for (name, index, count) in [("a", 1, 2), ("b", 3, 16)] {
        let job = u64::from(index + count);
        let content = Content::from([(job, ranked(RecordRank::Finished, job, 1))]);
        sources.push(path(&format!("{name}.tribosweep")));
        write(&sources[sources.len() - 1], shard(index, count), name, &content);
    }
    let readers = readers(&sources);
    for reader in &readers {
        let report = store.import_results(&[reader], &RULES).unwrap();
        assert_eq!((report.added, report.shards.len()), (1, 0));
    }
    let both: Vec<&StoreReader> = readers.iter().collect();
    assert_eq!(store.import_results(&both, &RULES).unwrap().already_there, 2);
    drop(store);
    assert!(!path("store/shards.json").exists());
    assert_eq!((whole(&path("store")).records.len(), whole(&path("store")).studies.len()), (2, 1));
}

#[test]
fn what_is_damaged_is_left_out_and_said_and_another_source_heals_it() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let content: Content = (0..4)
        .map(|i| (i, ranked(RecordRank::Finished, i, if i == 3 { 200 } else { 1 })))
        .collect();
    write(&path("a.tribosweep"), shard(1, 2), "a", &content);
    let bytes = fs::read(path("a.tribosweep")).unwrap();
    fs::write(path("b.tribosweep"), &bytes).unwrap();
    let expected = {
        merge(&[path("b.tribosweep")], &path("expected")).unwrap();
        whole(&path("expected"))
    };
    let mut lost = BTreeSet::new();
    for offset in (100..bytes.len()).step_by(61) {
        let mut flipped = bytes.clone();
        flipped[offset] ^= 1;
        fs::write(path("a.tribosweep"), &flipped).unwrap();
        let target = path("store");
        let report = merge(&[path("a.tribosweep")], &target).unwrap();
        let reader = Store::read(&target).unwrap();
        lost.insert(expected.records.len() - reader.keys().unwrap().len());
        drop(reader);
        let has_said = !report.faults.is_empty()
            || !report.incomplete.is_empty()
            || !readers(&[path("a.tribosweep")])[0].exports()[0].damage.is_empty();
        assert!(has_said, "{offset}: {report:?}");
        let report = merge(&[path("a.tribosweep"), path("b.tribosweep")], &target).unwrap();
        assert!(report.conflicts.is_empty());
        assert_eq!(whole(&target), expected, "{offset}");
        fs::remove_dir_all(&target).unwrap();
    }
    assert!(lost.contains(&0) && lost.contains(&4), "{lost:?}");
}

/// The note of a shard that is finished ends with an exclamation mark.
#[test]
fn a_shard_of_which_something_was_lost_is_not_finished() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let finished = |result, machine| ranked(RecordRank::Finished, result, machine);
    let first = Content::from([(1, finished(1, 1)), (3, finished(3, 200))]);
    let second = Content::from([(2, finished(2, 1))]);
    let [a, b, good] = ["a.tribosweep", "b.tribosweep", "good.tribosweep"].map(path);
    write(&a, shard(1, 2), "finished!", &first);
    write(&b, shard(2, 2), "finished!", &second);
    fs::copy(&a, &good).unwrap();
    let bytes = fs::read(&a).unwrap();
    let find =
        |needle: &[u8]| bytes.windows(needle.len()).rposition(|window| window == needle).unwrap();
    let is_finished = |report: &MergeReport, index: usize| {
        report.shards[index].note.as_ref().is_some_and(|note| note.ends_with(b"!"))
    };
    for target in [path("store"), path("merged.tribosweep")] {
        // The record of a job, then the blob of another.
        for offset in [find(&key(3).0) + 60, find(&Digest::of(&field(200)).0) + 60] {
            let mut flipped = bytes.clone();
            flipped[offset] ^= 1;
            fs::write(&a, &flipped).unwrap();
            for round in 0..2 {
                let report = merge(&[a.clone(), b.clone()], &target).unwrap();
                let said = report.faults.len() + report.incomplete.len();
                assert!(said > 0, "{offset} in round {round}: {report:?}");
                assert_eq!([0, 1].map(|i| is_finished(&report, i)), [false, true], "{report:?}");
                let known = Store::read_by(&target, &RULES).unwrap().shards();
                assert_eq!(known, report.shards);
            }
            // What is there in the end was not lost, wherever it came from.
            let report = merge(&[a.clone(), good.clone()], &target).unwrap();
            assert_eq!([0, 1].map(|i| is_finished(&report, i)), [true, true], "{report:?}");
            let report = merge(std::slice::from_ref(&a), &target).unwrap();
            assert_eq!([0, 1].map(|i| is_finished(&report, i)), [true, true], "{report:?}");
            match target.is_dir() {
                true => fs::remove_dir_all(&target).unwrap(),
                false => fs::remove_file(&target).unwrap(),
            }
        }
        // Neither of two results that differ is taken.
        fs::remove_file(&a).unwrap();
        write(&a, shard(1, 2), "finished!", &Content::from([(2, finished(9, 1))]));
        let report = merge(&[a.clone(), b.clone()], &target).unwrap();
        assert_eq!((report.conflicts.len(), report.added), (1, 0));
        assert_eq!([0, 1].map(|i| is_finished(&report, i)), [false, false], "{report:?}");
    }
}

std::thread_local! {
    /// The merge of another process that comes in between: its source and its target.
    static MEANWHILE: std::cell::Cell<Option<[PathBuf; 2]>> = const { std::cell::Cell::new(None) };
}

fn merge_meanwhile() {
    if let Some([source, target]) = MEANWHILE.take() {
        merge(&[source], &target).unwrap();
    }
}

#[test]
fn of_two_merges_into_one_export_at_once_none_is_lost() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let target = path("merged.tribosweep");
    for (name, i) in [("a", 1), ("b", 2), ("c", 3)] {
        let content = Content::from([(i, ranked(RecordRank::Finished, i, 1))]);
        write(&path(&format!("{name}.tribosweep")), shard(i as u32, 3), name, &content);
    }
    let [a, b, c] = ["a.tribosweep", "b.tribosweep", "c.tribosweep"].map(path);
    // The target is asked for its shards when it is read, and a record when it is merged.
    let while_reading = MergeRules {
        unfinished: |note| {
            merge_meanwhile();
            note.to_vec()
        },
        ..RULES
    };
    let while_merging = MergeRules {
        examine: |key, bytes| {
            merge_meanwhile();
            (RULES.examine)(key, bytes)
        },
        ..RULES
    };
    for rules in [while_reading, while_merging] {
        merge(std::slice::from_ref(&a), &target).unwrap();
        // What is damaged there makes its shards doubtful.
        let mut bytes = fs::read(&target).unwrap();
        bytes.extend(b"more");
        fs::write(&target, bytes).unwrap();
        let source = Store::read_by(&c, &RULES).unwrap();
        MEANWHILE.set(Some([b.clone(), target.clone()]));
        let all = MergeSelection::default();
        let refused = merge_into_export(&target, "0.1.0", &[&source], &rules, &all).unwrap_err();
        assert!(MEANWHILE.take().is_none(), "the other merge took place");
        assert!(refused.to_string().ends_with("nothing was merged into it; merge again"));
        assert_eq!(whole(&target).records.len(), 2);
        fs::write(&target, [&fs::read(&target).unwrap()[..], b"more"].concat()).unwrap();
        let report = merge(std::slice::from_ref(&c), &target).unwrap();
        assert_eq!(report.added, 1);
        let [fault] = &report.faults[..] else { panic!("{report:?}") };
        assert!(fault.contains("merged.tribosweep: the last 4 bytes are no frame"), "{fault}");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 4, "nothing is left over");
        fs::remove_file(&target).unwrap();
    }
}

#[test]
fn a_part_of_a_store_is_exported() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let store = Store::open(&path("store")).unwrap();
    store.put_study("one", b"x|1").unwrap();
    store.put_study("other", b"x|2").unwrap();
    let blob = store.blobs().put(&field(200)).unwrap();
    let records: Vec<_> =
        (0..700).map(|i| (key(i), ranked(RecordRank::Finished, i, 200))).collect();
    store.commit(&records).unwrap();
    let reader = Store::read(&path("store")).unwrap();
    let selection = MergeSelection {
        studies: Some(BTreeSet::from(["one".to_owned()])),
        keys: Some((0..100).map(key).collect()),
    };
    let target = path("one.tribosweep");
    let report = merge_into_export(&target, "0.1.0", &[&reader], &RULES, &selection).unwrap();
    assert_eq!((report.added, report.studies, report.blobs), (100, 1, 1));
    let export = Store::read(&target).unwrap();
    assert_eq!(export.study_names().unwrap(), ["one"]);
    assert!(export.blobs().contains(&blob) && export.exports()[0].is_closed);
    // The whole of a store that is being written goes into the same file.
    let all = MergeSelection::default();
    let report = merge_into_export(&target, "0.1.0", &[&reader], &RULES, &all).unwrap();
    assert_eq!((report.added, report.already_there, report.studies), (600, 100, 1));
    assert_eq!(whole(&target), whole(&path("store")));
    // A part leaves the rest of the file alone.
    merge_into_export(&target, "0.1.0", &[&reader], &RULES, &selection).unwrap();
    assert_eq!(whole(&target), whole(&path("store")));
}

#[test]
fn the_last_record_of_a_job_in_a_file_is_merged() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let finished = |result, machine| ranked(RecordRank::Finished, result, machine);
    let blobs = Store::open(&path("machine")).unwrap();
    let write = |name: &str, records: &[(u64, Vec<u8>)]| {
        let header = ExportHeader { program: "0.1.0".to_owned(), shard: None };
        let mut writer = ExportWriter::open(&path(name), &header).unwrap();
        for (job, bytes) in records {
            writer.append(&key(*job), bytes, blobs.blobs(), []).unwrap();
            writer.flush().unwrap();
        }
        writer.close().unwrap();
    };
    // A result that was corrected differs from the first one, which no longer counts anywhere.
    let twice =
        [(1, finished(10, 1)), (2, finished(2, 1)), (1, finished(1, 1)), (1, finished(1, 2))];
    write("a.tribosweep", &twice);
    write("b.tribosweep", &[(1, finished(1, 3)), (3, finished(3, 1))]);
    for names in [
        &["a.tribosweep"][..],
        &["a.tribosweep", "b.tribosweep"],
        &["b.tribosweep", "a.tribosweep"],
    ] {
        for target in ["store", "merged.tribosweep"] {
            let sources: Vec<PathBuf> = names.iter().map(|name| path(name)).collect();
            let report = merge(&sources, &path(target)).unwrap();
            assert!(report.conflicts.is_empty() && report.faults.is_empty(), "{report:?}");
            assert_eq!((report.added, report.already_there), (names.len() + 1, names.len() - 1));
            let merged = whole(&path(target)).records;
            assert_eq!(merged.len(), names.len() + 1);
            let found = merged.iter().find(|(job, _)| *job == key(1)).unwrap();
            assert_eq!(found.1[..9], finished(1, 1)[..9]);
            assert!(names.len() > 1 || found.1 == finished(1, 2));
            let summaries = Store::read(&path("a.tribosweep")).unwrap().exports();
            assert!(summaries[0].records == 2 && summaries[0].damage.is_empty(), "{summaries:?}");
            match target {
                "store" => fs::remove_dir_all(path(target)).unwrap(),
                _ => fs::remove_file(path(target)).unwrap(),
            }
        }
    }
}

#[test]
fn a_shard_that_is_run_again_while_it_is_merged_is_said_to_be_unfinished() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let export = |i: u32| path("exports").join(format!("{i:03}.tribosweep"));
    // Only some of the files stay open between the opening and the merge.
    const SHARDS: u32 = 135;
    for i in 1..=SHARDS {
        let content = Content::from([(i.into(), ranked(RecordRank::Finished, i.into(), 1))]);
        write(&export(i), shard(i, SHARDS), "finished!", &content);
    }
    for target in [path("store"), path("merged.tribosweep")] {
        let reader = Store::read_by(&path("exports"), &RULES).unwrap();
        write(&export(SHARDS), shard(SHARDS, SHARDS), "finished!", &Content::new());
        let report = match target.extension() {
            None => Store::open(&target).unwrap().import(&[&reader], &RULES).unwrap(),
            Some(_) => {
                let all = MergeSelection::default();
                merge_into_export(&target, "0.1.0", &[&reader], &RULES, &all).unwrap()
            }
        };
        let count = SHARDS as usize;
        assert_eq!(
            (report.added, report.already_there, report.shards.len()),
            (count - 1, 0, count)
        );
        let [fault] = &report.faults[..] else { panic!("{:?}", report.faults) };
        assert!(fault.contains("135.tribosweep") && fault.contains("started again"), "{fault}");
        let is_finished = |number: usize| {
            report.shards[number].note.as_ref().is_some_and(|note| note.ends_with(b"!"))
        };
        assert!((0..count - 1).all(is_finished) && !is_finished(count - 1));
        // The next merge takes what there is.
        let report = merge(&[path("exports")], &target).unwrap();
        assert_eq!((report.added, report.faults.len()), (1, 0), "{report:?}");
    }
}

#[test]
fn a_merge_that_was_killed_is_completed_by_the_next() {
    let directory = tempfile::tempdir().unwrap();
    let exports = directory.path().join("exports");
    let mut expected: Vec<(JobKey, Vec<u8>)> = Vec::new();
    for i in 0..8 {
        let content: Content =
            (0..400).map(|job| (job, ranked(RecordRank::Finished, 400 * i + job, 1))).collect();
        let content: Content =
            content.into_iter().map(|(job, bytes)| (400 * i + job, bytes)).collect();
        expected.extend(content.iter().map(|(job, bytes)| (key(*job), bytes.clone())));
        write(&exports.join(format!("{i}.tribosweep")), shard(i as u32 + 1, 8), "a", &content);
    }
    expected.sort();
    let mut unfinished = 0;
    for round in 0..12 {
        let mut merging = Player::start(command("merge", directory.path(), 0));
        assert_eq!(merging.line().as_deref(), Some("begins"));
        std::thread::sleep(Duration::from_millis(round * 3));
        merging.kill();
        let reader = Store::read_by(&directory.path().join("merged"), &RULES).unwrap();
        let found: Vec<_> =
            reader.records().unwrap().map(|(job, bytes)| (job, bytes.unwrap())).collect();
        unfinished += usize::from(found.len() < expected.len());
        assert!(found.iter().all(|record| expected.binary_search(record).is_ok()));
        // A study is shown when all of its records are there.
        assert!(reader.study_names().unwrap().is_empty() || found.len() == expected.len());
    }
    assert!(unfinished > 0, "every merge was finished before it was killed");
    let merging = Player::start(command("merge", directory.path(), 0));
    assert_eq!(merging.transcript().len(), 2);
    let merged = whole(&directory.path().join("merged"));
    assert_eq!((&merged.records, merged.studies.len()), (&expected, 1));
    let merging = Player::start(command("merge", directory.path(), 0));
    assert_eq!(merging.transcript()[1], "added 0, already there 3200");

    // An export takes its place when it is whole.
    let target = directory.path().join("all.tribosweep");
    let mut left = 0;
    for round in 0..12 {
        let mut merging = Player::start(command("merge into export", directory.path(), 0));
        assert_eq!(merging.line().as_deref(), Some("begins"));
        std::thread::sleep(Duration::from_millis(round * 2));
        merging.kill();
        left += usize::from(fs::read_dir(directory.path()).unwrap().count() > 3);
        assert!(!target.exists() || whole(&target).records == merged.records);
    }
    assert!(left > 0, "every merge was finished before it was killed");
    Player::start(command("merge into export", directory.path(), 0)).transcript();
    assert_eq!(whole(&target), merged);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 3, "leftovers are removed");
}
