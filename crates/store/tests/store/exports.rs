//! Exports are written, continued, damaged and read.

use std::fs;
use std::path::Path;
use std::process::Command;

use store::{
    Blobs, Digest, ExportError, ExportHeader, ExportWriter, OpenError, ReadError, RecordOrigin,
    RecordRank, References, ShardName, Store, StoreReader,
};

use super::child::{Player, command};
use super::{RULES, field, key, ranked, record};

fn shard(index: u32, count: u32) -> ExportHeader {
    let study = "sweep".to_owned();
    ExportHeader { program: "0.1.0".to_owned(), shard: Some(ShardName { study, index, count }) }
}

/// Returns the blobs of a store with the fields of two machines.
fn blobs(directory: &Path) -> Blobs {
    let store = Store::open(&directory.join("source")).unwrap();
    for machine in [200, 201] {
        store.blobs().put(&field(machine)).unwrap();
    }
    store.blobs().clone()
}

/// Writes a small export with a frame of every kind that a shard writes.
fn small(path: &Path, blobs: &Blobs) {
    let mut writer = ExportWriter::open(path, &shard(3, 16)).unwrap();
    writer.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
    let bytes = ranked(RecordRank::Finished, 1, 200);
    writer.append(&key(1), &bytes, blobs, [Digest::of(&field(200))]).unwrap();
    writer.flush().unwrap();
    writer.append(&key(2), &ranked(RecordRank::Unfinished, 2, 1), blobs, []).unwrap();
    writer.note(b"half");
    writer.flush().unwrap();
    writer.append(&key(2), &ranked(RecordRank::Finished, 2, 1), blobs, []).unwrap();
    writer.note(b"all");
    writer.close().unwrap();
}

fn references(job: &identity::JobKey, bytes: &[u8]) -> References {
    (RULES.examine)(job, bytes).map_or_else(|_| References::default(), |found| found.references)
}

/// Returns the records that a reader has, without those that are damaged.
fn sound(reader: &StoreReader) -> Vec<(identity::JobKey, Vec<u8>)> {
    let records = reader.records().unwrap();
    records.filter_map(|(job, record)| Some((job, record.ok()?))).collect()
}

#[test]
fn an_export_is_read_like_a_store() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("out/three.tribosweep");
    small(&path, &blobs(directory.path()));
    // Neither a store of such a name nor what was being written is an export.
    drop(Store::open(&path.parent().unwrap().join("store.tribosweep")).unwrap());
    fs::write(path.with_file_name(".unfinished-three.tribosweep-x1"), "half").unwrap();
    for place in [path.as_path(), path.parent().unwrap()] {
        let reader = Store::read(place).unwrap();
        assert_eq!(reader.origin(), RecordOrigin::Exports { count: 1 });
        assert_eq!(reader.origin().to_string(), "read from 1 export");
        let mut keys = vec![key(1), key(2)];
        keys.sort();
        assert_eq!(reader.keys().unwrap(), keys);
        assert_eq!(reader.contains(&[key(1), key(3)]).unwrap(), [true, false]);
        // The last record of a job counts.
        let last = ranked(RecordRank::Finished, 2, 1);
        assert_eq!(reader.get(&key(2)).unwrap().as_ref(), Some(&last));
        assert_eq!(reader.get(&key(3)).unwrap(), None);
        assert_eq!(reader.study_names().unwrap(), ["sweep"]);
        assert_eq!(reader.study("sweep").unwrap().unwrap(), b"mu = [0.1, 0.3]");
        let digest = Digest::of(&field(200));
        assert_eq!(reader.blobs().get(&digest).unwrap(), Some(field(200)));
        assert!(reader.blobs().contains(&digest) && reader.blobs().is_sound(&digest).unwrap());
        assert_eq!(reader.blobs().get(&Digest::of(&field(201))).unwrap(), None);
        assert!(reader.blobs().put(b"more").is_err());
        let found = reader.verify(references).unwrap();
        assert!(found.is_sound() && found.open_exports.is_empty(), "{found:?}");
        assert_eq!((found.records, found.blobs, found.studies), (2, 2, 1));
        let exports = reader.exports();
        assert_eq!((exports.len(), exports[0].records), (1, 2));
        assert_eq!(
            (&exports[0].header, exports[0].path.as_path()),
            (&shard(3, 16), path.as_path())
        );
        assert_eq!(exports[0].note.as_deref(), Some(&b"all"[..]));
        assert!(exports[0].is_closed && exports[0].changed.is_some());
    }
    assert!(matches!(Store::open(path.parent().unwrap()), Err(OpenError::OnlyRead { .. })));
    assert!(matches!(Store::open(&path), Err(OpenError::OnlyRead { .. })));
    assert!(matches!(Store::open_existing(&path), Err(OpenError::OnlyRead { .. })));
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 3);
}

#[test]
fn an_export_is_continued() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let path = directory.path().join("three.tribosweep");
    small(&path, &blobs);
    let mut earlier = ExportWriter::open(&path, &shard(3, 16)).unwrap();
    earlier.flush().unwrap();
    assert!(earlier.contains(&key(1)) && earlier.contains(&key(2)) && !earlier.contains(&key(3)));
    let mut writer = ExportWriter::open(&path, &shard(3, 16)).unwrap();
    assert!(writer.damage().is_empty());
    writer.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
    assert_eq!(writer.study("sweep").unwrap().unwrap(), b"mu = [0.1, 0.3]");
    assert_eq!(writer.study("other").unwrap(), None);
    assert!(matches!(
        writer.put_study("sweep", b"mu = [0.2]"),
        Err(ExportError::StudyDiffers { .. })
    ));
    writer.append(&key(3), &record(3), &blobs, []).unwrap();
    writer.note(&vec![7; 1 << 20]);
    assert!(writer.flush().unwrap_err().to_string().contains("a note has 1048576 bytes"));
    writer.flush().unwrap();
    // Whoever wrote to the file before writes to one without a name now.
    earlier.append(&key(4), &record(4), &blobs, []).unwrap();
    assert!(matches!(earlier.flush(), Err(ExportError::TakenOver { .. })));
    let reader = Store::read(&path).unwrap();
    assert_eq!(reader.keys().unwrap().len(), 3);
    assert_eq!(reader.exports()[0].note, None, "whoever goes on says anew how far it is");
    assert!(!reader.exports()[0].is_closed);
    writer.note(b"all");
    writer.flush().unwrap();
    assert_eq!(Store::read(&path).unwrap().exports()[0].note.as_deref(), Some(&b"all"[..]));

    for (header, found) in [
        (shard(4, 16), "shard 3/16 of the study `sweep`, and shard 4/16"),
        (shard(3, 8), "and shard 3/8 of the study `sweep` was to be written there"),
        (ExportHeader { shard: None, ..shard(1, 1) }, "an export that is not of a shard"),
    ] {
        let refused = ExportWriter::open(&path, &header).err().unwrap().to_string();
        assert!(refused.contains(found), "{refused}");
    }
    let refused = ExportWriter::open(&directory.path().join("copy"), &shard(3, 16)).err().unwrap();
    assert!(refused.to_string().contains("store merge STORE --into DIRECTORY"), "{refused}");
    let refused = ExportWriter::open(&path, &shard(17, 16)).err().unwrap().to_string();
    assert!(refused.contains("shard 17 of 16, which cannot be"), "{refused}");
    let other = directory.path().join("other.tribosweep");
    fs::write(&other, "a letter that is longer than the first line").unwrap();
    // What is no export is in nobody's way, and stays.
    let writer = ExportWriter::open(&other, &shard(3, 16)).unwrap();
    assert_eq!(
        writer.damage(),
        ["what was there is no export (it begins with other words) and is put aside as \
         other.tribosweep.damaged-1"]
    );
    assert!(Store::read(&other).unwrap().exports()[0].damage.is_empty());
    let aside = directory.path().join("other.tribosweep.damaged-1");
    assert_eq!(fs::read(&aside).unwrap()[..8], *b"a letter");
    let folder = directory.path().join("folder.tribosweep");
    fs::create_dir(&folder).unwrap();
    assert!(matches!(
        ExportWriter::open(&folder, &shard(3, 16)),
        Err(ExportError::Open(OpenError::NotAnExport { .. }))
    ));
    // Nothing half-written is left.
    let names = fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(names.into_iter().all(|name| !name.to_string_lossy().starts_with('.')));
}

#[test]
fn a_shard_is_finished_if_its_file_is_whole() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let path = directory.path().join("one.tribosweep");
    let mut writer = ExportWriter::open(&path, &shard(1, 2)).unwrap();
    for i in 0..3 {
        writer.append(&key(i), &ranked(RecordRank::Finished, i, 1), &blobs, []).unwrap();
        writer.note(format!("{i} done").as_bytes());
        writer.flush().unwrap();
    }
    writer.note(b"all done!");
    writer.flush().unwrap();
    let note = || {
        let reader = Store::read_by(&path, &RULES).unwrap();
        let [state] = &reader.shards()[..] else { panic!() };
        String::from_utf8(state.note.clone().unwrap()).unwrap()
    };
    assert_eq!(note(), "all done", "the writer has not closed it");
    writer.close().unwrap();
    assert_eq!(note(), "all done!");
    let bytes = fs::read(&path).unwrap();
    for offset in [200, bytes.len() - 60] {
        let mut flipped = bytes.clone();
        flipped[offset] ^= 1;
        fs::write(&path, &flipped).unwrap();
        let reader = Store::read_by(&path, &RULES).unwrap();
        assert_eq!(reader.exports()[0].damage.len(), 1, "{offset}");
        assert_eq!(note(), "all done", "{offset}");
    }
    fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    assert_eq!(note(), "all done", "its end was cut off");
    fs::write(&path, [&bytes[..], b"more"].concat()).unwrap();
    assert_eq!(note(), "all done", "something stands after its end");
    fs::write(&path, &bytes).unwrap();
    drop(ExportWriter::open(&path, &shard(1, 2)).unwrap());
    let reader = Store::read_by(&path, &RULES).unwrap();
    assert_eq!((reader.exports()[0].note.as_ref(), reader.keys().unwrap().len()), (None, 3));
}

#[test]
fn a_writer_knows_the_very_bytes_of_its_file() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let path = directory.path().join("three.tribosweep");
    small(&path, &blobs);
    let (first, last) = (ranked(RecordRank::Unfinished, 2, 1), ranked(RecordRank::Finished, 2, 1));
    let mut writer = ExportWriter::open(&path, &shard(3, 16)).unwrap();
    assert!(writer.holds(&key(2), &last) && !writer.holds(&key(2), &first));
    assert!(writer.holds(&key(1), &ranked(RecordRank::Finished, 1, 200)));
    assert!(!writer.holds(&key(3), &last));
    let (there, absent) = (Digest::of(&field(200)), Digest::of(&field(201)));
    assert!(writer.has_blob(&there) && !writer.has_blob(&absent));
    writer.append(&key(2), &first, &blobs, [absent]).unwrap();
    assert!(writer.holds(&key(2), &first) && !writer.holds(&key(2), &last));
    assert!(writer.has_blob(&absent));
    writer.flush().unwrap();
    let writer = ExportWriter::open(&path, &shard(3, 16)).unwrap();
    assert!(writer.holds(&key(2), &first) && writer.has_blob(&absent));
    assert_eq!((writer.len(), writer.damage().len()), (2, 0));
}

#[test]
fn an_export_that_was_cut_at_any_byte_is_read_up_to_its_last_whole_frame() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let (whole, path) =
        (directory.path().join("whole.tribosweep"), directory.path().join("cut.tribosweep"));
    small(&whole, &blobs);
    let bytes = fs::read(&whole).unwrap();
    let mut counts = Vec::new();
    for length in 0..bytes.len() {
        // The field is long, and nothing is special about its middle.
        if length > 500 && length + 700 < bytes.len() && length % 97 != 0 {
            continue;
        }
        fs::write(&path, &bytes[..length]).unwrap();
        let reader = match Store::read(&path) {
            Ok(reader) => reader,
            Err(error) => {
                assert!(length < 20 && matches!(error, OpenError::NotAnExport { .. }), "{error}");
                continue;
            }
        };
        let found = reader.verify(references).unwrap();
        // A writer gives a file its name when it has a header, so only a copy can lack it.
        let has_header = found.damaged_exports.is_empty();
        assert!(found.is_sound() || !has_header && length < 200, "{length}: {found:?}");
        assert_eq!(found.open_exports.len(), 1, "{length}");
        counts.push(found.records);
        // Going on takes the disk some milliseconds.
        if length % 23 != 0 {
            continue;
        }
        let mut writer = ExportWriter::open(&path, &shard(3, 16)).unwrap();
        assert_eq!(writer.len(), found.records);
        writer.append(&key(7), &record(7), &blobs, []).unwrap();
        writer.close().unwrap();
        let reader = Store::read(&path).unwrap();
        assert!(reader.verify(references).unwrap().is_sound(), "{length}");
        assert_eq!(reader.keys().unwrap().len(), found.records + 1);
    }
    assert!(counts.is_sorted());
    counts.dedup();
    assert_eq!(counts, [0, 1, 2]);
}

#[test]
fn no_flipped_bit_in_an_export_passes_unnoticed() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let (whole, path) =
        (directory.path().join("whole.tribosweep"), directory.path().join("flipped.tribosweep"));
    small(&whole, &blobs);
    let bytes = fs::read(&whole).unwrap();
    let expected = sound(&Store::read(&whole).unwrap());
    for offset in 0..bytes.len() {
        if offset > 1000 && offset + 1500 < bytes.len() && offset % 53 != 0 {
            continue;
        }
        let mut flipped = bytes.clone();
        flipped[offset] ^= 1 << (offset % 8);
        fs::write(&path, &flipped).unwrap();
        let reader = Store::read(&path).unwrap();
        let found = reader.verify(references).unwrap();
        assert!(!found.is_sound(), "byte {offset} of {}", bytes.len());
        // Nothing that is read is wrong, and one frame at most is lost.
        let read = sound(&reader);
        let is_earlier = |(job, bytes): &(identity::JobKey, Vec<u8>)| {
            *job == key(2) && *bytes == ranked(RecordRank::Unfinished, 2, 1)
        };
        assert!(read.iter().all(|record| expected.contains(record) || is_earlier(record)));
        assert!(!read.is_empty(), "{offset}");
        // Going on leaves out what is damaged; it takes the disk some milliseconds.
        if offset % 23 != 0 && offset != 7 {
            continue;
        }
        match ExportWriter::open(&path, &shard(3, 16)) {
            Ok(writer) => {
                drop(writer);
                let healed = Store::read(&path).unwrap();
                assert!(healed.verify(|_, _| Vec::new()).unwrap().is_sound(), "{offset}");
            }
            Err(error) => panic!("{offset}: {error}"),
        }
    }
}

#[test]
fn an_export_of_another_format_is_refused_in_words() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("later.tribosweep");
    small(&path, &blobs(directory.path()));
    let mut bytes = fs::read(&path).unwrap();
    bytes[18] = 2;
    // A later format has another mark of its frames.
    bytes[20..28].copy_from_slice(b"\x89tsframf");
    fs::write(&path, &bytes).unwrap();
    let refused = Store::read(&path).err().unwrap().to_string();
    assert!(refused.contains("has format 2, this program reads format 1"), "{refused}");
    assert!(ExportWriter::open(&path, &shard(3, 16)).is_err());
    assert_eq!(fs::read(&path).unwrap(), bytes);
}

#[test]
fn exports_in_the_directory_of_a_store_are_mentioned() {
    let directory = tempfile::tempdir().unwrap();
    let place = directory.path().join("store");
    let store = Store::open(&place).unwrap();
    small(&place.join("three.tribosweep"), &blobs(directory.path()));
    let words = "; 1 export in the same directory is not read: name one of them, or bring them";
    let served = Store::read(&place).unwrap().origin().to_string();
    assert!(served.starts_with("served by ") && served.contains(words), "{served}");
    drop(store);
    let reader = Store::read(&place).unwrap();
    assert!(reader.keys().unwrap().is_empty());
    let said = reader.origin().to_string();
    assert!(said.starts_with("read from disk; 1 export") && said.contains(words), "{said}");
}

#[test]
fn a_definition_that_can_be_read_is_chosen() {
    let directory = tempfile::tempdir().unwrap();
    let definitions = ["a|mu", "b|mu"];
    let smaller = usize::from(Digest::of(b"a|mu") > Digest::of(b"b|mu"));
    for order in [[0, 1], [1, 0]] {
        let place = directory.path().join(format!("exports {order:?}"));
        let path = |i: usize| place.join(format!("{i}.tribosweep"));
        for (index, i) in (1..).zip(order) {
            let mut writer = ExportWriter::open(&path(index), &shard(index as u32, 2)).unwrap();
            writer.put_study("sweep", definitions[i].as_bytes()).unwrap();
            writer.close().unwrap();
        }
        // The one that would be chosen is damaged.
        let index = 1 + order.iter().position(|i| *i == smaller).unwrap();
        let mut bytes = fs::read(path(index)).unwrap();
        let name = bytes.windows(5).rposition(|window| window == b"sweep").unwrap();
        bytes[name + 8] ^= 1;
        fs::write(path(index), bytes).unwrap();
        let reader = Store::read_by(&place, &RULES).unwrap();
        assert_eq!(reader.verify(references).unwrap().corrupt_blobs.len(), 1);
        let chosen = reader.study("sweep").unwrap().unwrap();
        assert_eq!(chosen, definitions[1 - smaller].as_bytes());
    }
}

#[test]
fn a_file_that_cannot_be_read_hides_no_other() {
    let directory = tempfile::tempdir().unwrap();
    let place = directory.path().join("exports");
    small(&place.join("b.tribosweep"), &blobs(directory.path()));
    fs::write(place.join("a.tribosweep"), "a letter that is longer than the first line").unwrap();
    fs::write(place.join("c.tribosweep"), "").unwrap();
    std::os::unix::fs::symlink("nowhere", place.join("d.tribosweep")).unwrap();
    let reader = Store::read_by(&place, &RULES).unwrap();
    assert_eq!(sound(&reader).len(), 2);
    let found = reader.verify(references).unwrap();
    assert!(!found.is_sound() && found.open_exports.is_empty(), "{found:?}");
    let reasons = [
        "it is not an export: it begins with other words",
        "it is not an export: it is shorter than its first line",
        "No such file or directory",
    ];
    assert_eq!(found.damaged_exports.len(), reasons.len());
    for (said, reason) in found.damaged_exports.iter().zip(reasons) {
        assert!(said.contains(&format!("nothing of it is read: {reason}")), "{said}");
    }
    // One that is named alone must be readable, and so must one of several.
    fs::remove_file(place.join("b.tribosweep")).unwrap();
    for path in [&place, &place.join("a.tribosweep")] {
        assert!(matches!(Store::read(path), Err(OpenError::NotAnExport { .. })));
    }
}

#[test]
fn exports_may_repeat_each_other_and_may_not_contradict() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let place = directory.path().join("exports");
    let write = |name: &str, index: u32, bytes: &[u8]| {
        let mut writer =
            ExportWriter::open(&place.join(format!("{name}.tribosweep")), &shard(index, 2))
                .unwrap();
        writer.put_study("sweep", format!("{name}|mu").as_bytes()).unwrap();
        writer.append(&key(1), bytes, &blobs, [Digest::of(&field(200))]).unwrap();
        writer.close().unwrap();
    };
    write("a", 1, &ranked(RecordRank::Unfinished, 5, 1));
    write("b", 2, &ranked(RecordRank::Finished, 5, 2));
    let finished = ranked(RecordRank::Finished, 5, 2);
    let read = || Store::read_by(&place, &RULES).unwrap();
    assert_eq!(read().get(&key(1)).unwrap().unwrap(), finished);
    assert_eq!(read().study_names().unwrap(), ["sweep"]);
    assert!(read().study("sweep").unwrap().is_some());
    let refused = Store::read(&place).unwrap().study_names().unwrap_err();
    assert!(matches!(&refused, ReadError::StudiesDiffer { .. }), "{refused}");
    // A copy that is damaged hides no sound one.
    let path = place.join("b.tribosweep");
    let bytes = fs::read(&path).unwrap();
    fs::write(place.join("c.tribosweep"), &bytes).unwrap();
    for offset in (bytes.len() / 4..bytes.len()).step_by(101) {
        let mut flipped = bytes.clone();
        flipped[offset] ^= 4;
        fs::write(&path, &flipped).unwrap();
        assert_eq!(read().get(&key(1)).unwrap().unwrap(), finished, "{offset}");
        let blob = read().blobs().get(&Digest::of(&field(200)));
        assert_eq!(blob.unwrap(), Some(field(200)), "{offset}");
    }
    fs::remove_file(place.join("b.tribosweep")).unwrap();
    write("b", 2, &ranked(RecordRank::Finished, 6, 2));
    let refused = read().get(&key(1)).unwrap_err().to_string();
    assert!(
        refused.contains("b.tribosweep and") && refused.contains("different results"),
        "{refused}"
    );
}

#[test]
fn a_writer_that_was_killed_has_lost_nothing_that_it_flushed() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("one.tribosweep");
    let mut random = 7u64;
    let mut flushed = 0;
    for round in 0..15 {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let mut writer = Player::start(command("export", directory.path(), 0));
        for _ in 0..random >> 60 {
            flushed = writer.line().unwrap().parse().unwrap();
        }
        std::thread::sleep(std::time::Duration::from_micros((random >> 40) % 3000));
        writer.kill();
        while let Some(line) = writer.line() {
            flushed = line.parse().unwrap();
        }
        if flushed == 0 {
            continue;
        }
        let reader = Store::read(&path).unwrap();
        assert!(reader.verify(|_, _| Vec::new()).unwrap().is_sound(), "round {round}");
        for i in 0..flushed {
            assert_eq!(reader.get(&key(i)).unwrap(), Some(record(i)), "round {round}");
        }
    }
    assert!(flushed > 100, "the writers were killed too early to show anything");
    ExportWriter::open(&path, &shard(1, 2)).unwrap();
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1, "leftovers are removed");
}

/// The file may not grow as it must.
#[test]
fn an_export_without_room_keeps_what_was_flushed_and_goes_on_later() {
    let directory = tempfile::tempdir().unwrap();
    let inner = command("export", directory.path(), 0);
    let mut outer = Command::new("bash");
    outer.arg("-c").arg("trap '' XFSZ; ulimit -f 300; exec \"$0\" \"$@\"");
    outer.arg(inner.get_program()).args(inner.get_args());
    outer.envs(inner.get_envs().filter_map(|(name, value)| Some((name, value?))));
    outer.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let transcript = Player::start(outer).transcript();
    let (last, before) = transcript.split_last().unwrap();
    assert!(
        last.starts_with("failed: there is no room for") && last.contains("run the same again")
    );
    let flushed: u64 = before.last().unwrap().parse().unwrap();
    let path = directory.path().join("one.tribosweep");
    let reader = Store::read(&path).unwrap();
    assert!(reader.verify(|_, _| Vec::new()).unwrap().is_sound());
    assert!(flushed > 100 && (0..flushed).all(|i| reader.get(&key(i)).unwrap() == Some(record(i))));
    let writer = ExportWriter::open(&path, &shard(1, 2)).unwrap();
    assert!(writer.len() as u64 >= flushed && writer.damage().is_empty());
}

/// A process may have few files open, and a study many shards.
#[test]
fn many_exports_are_read_with_few_of_them_open() {
    let directory = tempfile::tempdir().unwrap();
    let blobs = blobs(directory.path());
    let place = directory.path().join("exports");
    let path = |i: u32| place.join(format!("{i:03}.tribosweep"));
    for i in 1..=200 {
        let mut writer = ExportWriter::open(&path(i), &shard(i, 200)).unwrap();
        let bytes = ranked(RecordRank::Finished, i.into(), if i == 190 { 201 } else { 1 });
        let fields = (i == 190).then(|| Digest::of(&field(201)));
        writer.append(&key(i.into()), &bytes, &blobs, fields).unwrap();
        writer.close().unwrap();
    }
    let open_files = || fs::read_dir("/proc/self/fd").unwrap().count();
    let before = open_files();
    let reader = Store::read_by(&place, &RULES).unwrap();
    assert!(open_files() < before + 190, "other tests open files too");
    let found = reader.verify(references).unwrap();
    assert!(found.is_sound() && found.records == 200, "{found:?}");
    assert_eq!(reader.blobs().get(&Digest::of(&field(201))).unwrap(), Some(field(201)));
    assert!(reader.get(&key(195)).unwrap().is_some());
    // A run that is started again puts another file in its place.
    ExportWriter::open(&path(195), &shard(195, 200)).unwrap();
    let refused = reader.get(&key(195)).unwrap_err().to_string();
    assert!(refused.contains("195.tribosweep") && refused.contains("ask again"), "{refused}");
    ExportWriter::open(&path(5), &shard(5, 200)).unwrap();
    assert!(reader.get(&key(5)).unwrap().is_some(), "an open file stays as it was");
    let again = Store::read_by(&place, &RULES).unwrap();
    assert!(again.get(&key(195)).unwrap().is_some());
}
