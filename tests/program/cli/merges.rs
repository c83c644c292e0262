//! Exports of shards through the command: merged, read together, contradicting, missing, damaged.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};
use store::{Digest, ExportHeader, ExportWriter, ShardName, Store, StoreReader};
use study::{Ending, Record};

use crate::place::{Place, SMALL, without_hashes};

/// The small study with fields that are too large for a record.
fn with_files() -> String {
    SMALL.replace("mesh = 6", "mesh = 40")
}

fn path(place: &Place, index: u32) -> PathBuf {
    place.path(&format!("exports/small-{index}-of-4.tribosweep"))
}

/// Writes the export of a shard as a run of it does, with every fourth record of the store.
fn write_shard(place: &Place, reader: &StoreReader, index: u32, note: &Value) {
    let shard = Some(ShardName { study: "small".to_owned(), index, count: 4 });
    let header = ExportHeader { program: env!("CARGO_PKG_VERSION").to_owned(), shard };
    let mut writer = ExportWriter::open(&path(place, index), &header).unwrap();
    writer.put_study("small", &reader.study("small").unwrap().unwrap()).unwrap();
    for (number, (key, record)) in (0..).zip(reader.records().unwrap()) {
        if number % 4 == index - 1 {
            let record = record.unwrap();
            let Record { fields, provenance, .. } = Record::decode(&record).unwrap();
            let fields = fields.unwrap();
            let run = store::Digest(provenance.run.unwrap());
            assert!(writer.accompany(&run, reader.blobs()).unwrap());
            let digest = store::Blobs::kept_digest(&fields).unwrap();
            let kept = reader.blobs().contains(&digest).then_some(digest);
            writer.append(&key, &record, reader.blobs(), kept).unwrap();
        }
    }
    writer.note(note.to_string().as_bytes());
    writer.close().unwrap();
}

fn finished() -> Value {
    json!({"jobs": 2, "done": 2, "failed": 0, "left": 0, "finished": true, "file": "small.toml"})
}

/// Returns a directory in which the study has run, and its exports of four shards.
fn sharded() -> Place {
    let place = Place::with("small.toml", with_files());
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    let reader = Store::read(&place.path(".tribosweep")).unwrap();
    (1..=4).for_each(|index| write_shard(&place, &reader, index, &finished()));
    place
}

#[test]
fn a_directory_of_exports_is_read_like_the_merged_store() {
    let place = sharded();
    let merged = place.call("store merge exports --into merged");
    assert_eq!((merged.code, merged.err.as_str()), (0, ""), "{}", merged.out);
    assert_eq!(place.call("store merge exports --into merged.tribosweep").code, 0);
    fs::rename(place.path(".tribosweep"), place.path("run")).unwrap();
    let key = place.call("query small --select key --format csv --store run").out;
    let key = key.lines().nth(1).unwrap().to_owned();
    let lines = [
        "query small --format csv".to_owned(),
        "query small --json".to_owned(),
        "query small --sort=-mu --select mu,load,seconds".to_owned(),
        "query small --steps --format csv".to_owned(),
        "answer small".to_owned(),
        "plan small.toml".to_owned(),
        format!("show {key}"),
        format!("show {key} --field pressure"),
    ];
    for line in lines {
        let own = place.call(&format!("{line} --store run"));
        assert_eq!(own.code, 0, "{line}: {}", own.err);
        for store in ["merged", "merged.tribosweep", "exports"] {
            let other = place.call(&format!("{line} --store {store}"));
            assert_eq!((other.code, &other.out), (0, &own.out), "{line} --store {store}");
        }
    }
    // Exports say besides how far their shards are.
    let progress =
        |store: &str| place.json(&format!("status --json --store {store}"))[0]["progress"].clone();
    for store in ["merged", "merged.tribosweep", "exports"] {
        assert_eq!(progress(store), progress("run"), "{store}");
    }
    let said = place.call("query small --store exports").err;
    assert_eq!(said, "read from 4 exports\n");
    for store in ["run", "merged", "exports"] {
        let figure = format!("plot small --output {store}.svg --store {store}");
        assert_eq!(place.call(&figure).code, 0);
        let svg = fs::read(place.path(&format!("{store}.svg"))).unwrap();
        assert_eq!(svg, fs::read(place.path("run.svg")).unwrap(), "{store}");
    }
    let verified = place.json("store verify --json --store exports");
    assert_eq!(
        (&verified["sound"], &verified["records"], &verified["files"]),
        (&true.into(), &6.into(), &8.into())
    );
}

#[test]
fn a_merge_says_what_is_missing_and_how_to_compute_it() {
    let place = sharded();
    fs::rename(path(&place, 2), place.path("second.tribosweep")).unwrap();
    fs::remove_file(path(&place, 3)).unwrap();
    let unfinished = json!({"jobs": 2, "done": 1, "failed": 0, "left": 1, "file": "small.toml"});
    let reader = Store::read(&place.path(".tribosweep")).unwrap();
    write_shard(&place, &reader, 4, &unfinished);
    insta::assert_snapshot!(place.transcript(&[
        &["store", "merge", "exports", "--into", "merged"],
        &["store", "merge", "exports", "--into", "merged"],
        &["store", "merge", "second.tribosweep", "--into", "merged"],
        &["store", "merge", "exports", "second.tribosweep", "--into", "all.tribosweep"],
        &["store", "verify", "--store", "all.tribosweep"],
    ]));
    let merged = place.json("store merge all.tribosweep --into merged --json");
    let sharded = &merged["sharded"][0];
    assert_eq!((&sharded["present"], &sharded["shards"]), (&3.into(), &4.into()));
    assert_eq!(
        sharded["missing"],
        json!([{"shard": 3, "command": "tribosweep run small.toml --shard 3/4 --export ."}])
    );
    write_shard(&place, &reader, 3, &finished());
    write_shard(&place, &reader, 4, &finished());
    let whole = place.call("store merge exports --into merged");
    assert_eq!(whole.code, 0, "{}", whole.out);
    assert!(whole.out.ends_with("`small`: 4 of 4 shards, all finished\n"), "{}", whole.out);
    assert_eq!(place.json("store verify --json --store merged")["sound"], true);
    assert_eq!(place.json("run small.toml --json --store merged")["run"]["cached"], 6);
}

/// Another version of the program may cut a study elsewhere.
#[test]
fn shards_of_two_partitions_do_not_pass_for_a_whole() {
    let place = sharded();
    let reader = Store::read(&place.path(".tribosweep")).unwrap();
    for (index, partition) in [(1, "one"), (2, "one"), (3, "one"), (4, "other")] {
        let mut note = finished();
        note["partition"] = partition.into();
        write_shard(&place, &reader, index, &note);
    }
    let merged = place.call("store merge exports --into merged");
    assert_eq!(merged.code, 2, "{}", merged.out);
    assert!(merged.out.contains("unfinished 4: it was cut by another partition"), "{}", merged.out);
}

#[test]
fn two_machines_that_disagree_are_both_named() {
    let place = sharded();
    let reader = Store::read(&path(&place, 1)).unwrap();
    let (key, bytes) = reader.records().unwrap().next().unwrap();
    let mut record = Record::decode(&bytes.unwrap()).unwrap();
    let Ending::Finished(outcome) = &mut record.ending else { panic!() };
    outcome.steps[0].observables.load *= 1.0 + 1e-15;
    let mut writer = ExportWriter::open(
        &path(&place, 4),
        &ExportHeader {
            program: "0.0.1".to_owned(),
            shard: Some(ShardName { study: "small".to_owned(), index: 4, count: 4 }),
        },
    )
    .unwrap();
    writer.append(&key, &record.encode(), reader.blobs(), []).unwrap();
    writer.close().unwrap();
    let key = key.to_string();
    for order in [[1, 2, 3, 4], [4, 3, 2, 1]] {
        let names = order.map(|index| format!("exports/small-{index}-of-4.tribosweep"));
        let mut words = vec!["store", "merge"];
        words.extend(names.iter().map(String::as_str));
        words.extend(["--into", "merged"]);
        let said = place.words(&words);
        assert_eq!(said.code, 1);
        let conflict = said.out.lines().find(|line| line.starts_with("conflict: ")).unwrap();
        assert!(
            conflict.contains(&key)
                && conflict.contains("small-1-of")
                && conflict.contains("small-4-of"),
            "{conflict}"
        );
        assert!(said.out.contains("added 5 records"), "{}", said.out);
        assert!(said.out.contains("1 export is by version 0.0.1 of the program: "), "{}", said.out);
        let merged = Store::read(&place.path("merged")).unwrap();
        assert!(!merged.keys().unwrap().iter().any(|job| job.to_string() == key));
        drop(merged);
        fs::remove_dir_all(place.path("merged")).unwrap();
    }
    let refused = place.call("query small --store exports");
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("have different results of job"), "{}", refused.err);
    let verified = place.json("store verify --json --store exports");
    assert_eq!(verified["faults"].as_array().unwrap().len(), 1, "{verified}");
}

#[test]
fn what_does_not_belong_together_is_refused_in_words() {
    let place = sharded();
    place.write("other.toml", with_files().replace("Does it slip?", "Does it stick?"));
    assert_eq!(place.call("run other.toml --workers 2 --store other").code, 0);
    fs::copy(path(&place, 1), place.path("later.tribosweep")).unwrap();
    let mut bytes = fs::read(place.path("later.tribosweep")).unwrap();
    bytes[18] = 9;
    // A later format has another mark of its frames.
    bytes[20] ^= 1;
    place.write("later.tribosweep", bytes);
    place.write("letter.tribosweep", "dear reader");
    let header = ExportHeader {
        program: "0.1.0".to_owned(),
        shard: Some(ShardName { study: "small".to_owned(), index: 3, count: 16 }),
    };
    ExportWriter::open(&place.path("three.tribosweep"), &header).unwrap().close().unwrap();
    insta::assert_snapshot!(place.transcript(&[
        &["store", "merge", "exports", "other", "--into", "merged"],
        &["store", "merge", "exports", "three.tribosweep", "--into", "merged"],
        &["store", "merge", "exports", "later.tribosweep", "--into", "merged"],
        &["store", "merge", "exports", "letter.tribosweep", "--into", "merged"],
        &["store", "merge", "other", "--into", "three.tribosweep"],
        &["store", "merge", "--into", "merged"],
        &["store", "merge", "exports"],
        &["store", "import"],
    ]));
    assert!(!place.path("merged").exists());
}

#[test]
fn a_file_that_is_no_export_is_skipped_in_words() {
    let place = sharded();
    place.write("exports/letter.tribosweep", "dear reader, this is no export");
    let asked = place.call("query small --store exports");
    assert_eq!(asked.code, 0, "{}", asked.err);
    let reason = "nothing of it is read: it is not an export: it begins with other words";
    let said = format!("read from 4 exports\nexports/letter.tribosweep is damaged: {reason}\n");
    assert_eq!(asked.err, said);
    for line in ["store verify --store exports", "store merge exports --into merged"] {
        let said = place.call(line);
        assert_eq!(said.code, 2, "{}", said.out);
        let words = format!("\ndamaged: exports/letter.tribosweep: {reason}\n");
        assert!(said.out.contains(&words), "{}", said.out);
        assert!(!said.out.contains("no end: "), "{}", said.out);
    }
    assert_eq!(place.json("run small.toml --json --store merged")["run"]["cached"], 6);
}

#[test]
fn a_store_forgets_an_earlier_division_of_a_study() {
    let place = sharded();
    assert_eq!(place.call("store merge exports --into merged").code, 0);
    let header = ExportHeader {
        program: env!("CARGO_PKG_VERSION").to_owned(),
        shard: Some(ShardName { study: "small".to_owned(), index: 1, count: 1 }),
    };
    let mut writer = ExportWriter::open(&place.path("whole.tribosweep"), &header).unwrap();
    writer.note(finished().to_string().as_bytes());
    writer.close().unwrap();
    let merged = place.call("store merge whole.tribosweep --into merged");
    assert_eq!(merged.code, 0, "{}", merged.out);
    assert!(
        merged.out.contains(
            "`small`: 4 shards that were remembered of 4 are forgotten, because it is in 1 shard \
             now; their results stay\n`small`: 1 of 1 shards, all finished\n"
        ),
        "{}",
        merged.out
    );
    let back = place.json("store merge exports --into merged --json");
    assert_eq!(back["forgotten"], json!([{"study": "small", "index": 1, "count": 1}]));
}

#[test]
fn damage_to_exports_is_found_and_another_copy_heals_it() {
    let place = sharded();
    assert_eq!(place.call("store merge exports --into copy.tribosweep").code, 0);
    let file = path(&place, 2);
    let bytes = fs::read(&file).unwrap();
    let reader = Store::read(&file).unwrap();
    let key = reader.keys().unwrap()[0];
    let record = reader.get(&key).unwrap().unwrap();
    let fields = Record::decode(&record).unwrap().fields.unwrap();
    let digest: Digest = store::Blobs::kept_digest(&fields).unwrap();
    let place_of =
        |needle: &[u8]| bytes.windows(needle.len()).rposition(|window| window == needle).unwrap();
    // In the body of the record, and in that of its file of fields.
    for offset in [place_of(&key.0) + 80, place_of(&digest.0) + 80] {
        let mut flipped = bytes.clone();
        flipped[offset] ^= 1;
        fs::write(&file, &flipped).unwrap();
        let verified = place.call("store verify --store exports");
        assert_eq!(verified.code, 2, "{}", verified.out);
        assert!(verified.out.contains("damaged: "), "{}", verified.out);
        let merged = place.call("store merge exports --into merged");
        assert_eq!(merged.code, 2, "{}", merged.out);
        let said = without_hashes(&merged.out);
        let is_record = said.contains("\nleft out: ") && said.contains("added 4 records");
        let is_file = said.contains("\nmerged without its file of fields: job ")
            && said.contains("added 6 records");
        assert!(is_record || is_file, "{said}");
        let unfinished = "  unfinished 2: 2 of 2 jobs solved, 0 failed and 0 left, but its end or \
                          some of its results are not here; `";
        assert!(said.contains(unfinished), "{said}");
        let again = place.call("store merge exports --into merged");
        assert_eq!(again.code, 2, "{}", again.out);
        assert!(again.out.contains(unfinished), "{}", again.out);
        let healed = place.call("store merge exports copy.tribosweep --into merged");
        assert!([0, 2].contains(&healed.code), "{}", healed.out);
        assert_eq!(
            place.json("store verify --json --store merged")["sound"],
            true,
            "{}",
            healed.out
        );
        fs::remove_dir_all(place.path("merged")).unwrap();
    }
    // A shard that is running, or was copied in part, is read up to its last whole frame.
    fs::write(&file, &bytes[..bytes.len() - 30]).unwrap();
    let verified = place.call("store verify --store exports");
    assert_eq!(verified.code, 0, "{}", verified.out);
    assert!(verified.out.contains("no end: exports/small-2-of-4.tribosweep"), "{}", verified.out);
    assert_eq!(place.call("query small --store exports").code, 0);
}
