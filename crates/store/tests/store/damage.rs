//! Files are cut short, bits are flipped, garbage is written. All of it is reported: there is never
//! a panic and never a silent loss.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use identity::JobKey;
use store::{Digest, OpenError, Store};

use super::child::{Player, command};
use super::{key, record, records};

const COUNT: u64 = 1500;

/// Makes a store in good order with enough records for several of sled's segments.
fn make(directory: &Path) {
    for group in 0..3 {
        // The store is reopened, so that sled has a snapshot that can be damaged.
        let store = Store::open(directory).unwrap();
        store.commit(&records(group * COUNT / 3..(group + 1) * COUNT / 3)).unwrap();
        store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

fn files(directory: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(directory).unwrap().map(Result::unwrap) {
        if entry.path().is_dir() {
            all.extend(files(&entry.path()));
        } else {
            all.push(entry.path());
        }
    }
    all.sort();
    all
}

fn inspect(directory: &Path) -> String {
    let transcript = Player::start(command("inspect", directory, COUNT)).transcript();
    assert_eq!(transcript.len(), 1, "{transcript:?}");
    transcript[0].clone()
}

fn acceptable(said: &str) -> bool {
    said == "sound"
        || said.ends_with(" reported")
        || said.starts_with("refused: ")
        || said.starts_with("study: ")
}

/// Every file of the store is damaged in every way, each time from a sound copy and in a process of
/// its own: sled may take down its threads, and would take down the process if it could.
#[test]
fn damage_to_any_file_is_survived_and_said() {
    let original = tempfile::tempdir().unwrap();
    make(original.path());
    let mut random = 7u64;
    let mut draw = |below: usize| {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (random >> 33) as usize % below.max(1)
    };
    let mut refused = 0;
    for file in files(original.path()) {
        let name = file.strip_prefix(original.path()).unwrap().to_owned();
        let sound = fs::read(&file).unwrap();
        let size = sound.len();
        let mut damages: Vec<(String, Option<Vec<u8>>)> = vec![
            ("removed".into(), None),
            ("emptied".into(), Some(Vec::new())),
            ("zeroed".into(), Some(vec![0; size])),
            ("replaced by garbage".into(), Some((0..size).map(|_| draw(256) as u8).collect())),
        ];
        for _ in 0..if name.ends_with("db") { 25 } else { 4 } {
            let offset = draw(size);
            damages.push((format!("cut to {offset}"), Some(sound[..offset].to_vec())));
            let mut flipped = sound.clone();
            if let Some(byte) = flipped.get_mut(offset) {
                *byte ^= 1 << draw(8);
            }
            damages.push((format!("flipped at {offset}"), Some(flipped)));
            let mut blotted = sound.clone();
            let end = size.min(offset + 1 + draw(20_000));
            blotted[offset..end].iter_mut().for_each(|byte| *byte = draw(256) as u8);
            damages.push((format!("blotted from {offset} to {end}"), Some(blotted)));
        }
        for (what, content) in damages {
            let copied = tempfile::tempdir().unwrap();
            copy(original.path(), copied.path());
            match content {
                Some(content) => fs::write(copied.path().join(&name), content).unwrap(),
                None => fs::remove_file(copied.path().join(&name)).unwrap(),
            }
            let said = inspect(copied.path());
            eprintln!("{} {what}: {said}", name.display());
            assert!(acceptable(&said), "{} {what}: {said}", name.display());
            refused += usize::from(said != "sound");
        }
    }
    assert!(refused > 30, "only {refused} damages were noticed");
}

#[test]
fn a_database_that_opens_empty_is_refused_and_can_be_salvaged() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    fs::remove_dir_all(directory.path().join("records")).unwrap();
    let error = Store::open(directory.path()).err().unwrap();
    assert!(matches!(error, OpenError::Damaged { .. }), "{error}");
    assert!(error.to_string().contains("promises 1500 records"), "{error}");
    assert!(matches!(Store::read(directory.path()), Err(OpenError::Damaged { .. })));

    let salvage = Store::salvage(directory.path(), |_, _| Vec::new()).unwrap();
    assert_eq!((salvage.kept, salvage.promised, salvage.studies), (0, Some(COUNT), 1));
    let store = Store::open(directory.path()).unwrap();
    assert_eq!(store.study("sweep").unwrap().unwrap(), b"mu = [0.1, 0.3]");
    store.commit(&records(0..10)).unwrap();
}

#[test]
fn a_lost_manifest_is_said_and_every_record_salvaged() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    for damage in [None, Some(&b"{ \"format\": 1, "[..]), Some(b"\0\0\0\0")] {
        let manifest = directory.path().join("manifest.json");
        match damage {
            None => fs::remove_file(&manifest).unwrap(),
            Some(garbage) => fs::write(&manifest, garbage).unwrap(),
        }
        let error = Store::open(directory.path()).err().unwrap();
        assert!(
            matches!(&error, OpenError::Damaged { what, .. } if what.contains("manifest.json")),
            "{error}"
        );
        let salvage = Store::salvage(directory.path(), |_, _| Vec::new()).unwrap();
        assert_eq!((salvage.kept as u64, salvage.promised, salvage.studies), (COUNT, None, 0));
        assert!(salvage.damaged.unwrap().join("db").is_file());
        let store = Store::open(directory.path()).unwrap();
        assert!((0..COUNT).all(|i| store.get(&key(i)).unwrap() == Some(record(i))));
    }
}

#[test]
fn what_only_repeats_the_log_costs_no_record() {
    for prefix in ["snap.", "conf"] {
        let directory = tempfile::tempdir().unwrap();
        make(directory.path());
        for file in files(&directory.path().join("records")) {
            if file.file_name().unwrap().to_string_lossy().starts_with(prefix) {
                fs::write(&file, vec![0; fs::metadata(&file).unwrap().len() as usize]).unwrap();
            }
        }
        assert!(
            matches!(Store::open(directory.path()), Err(OpenError::Damaged { .. })),
            "{prefix}"
        );
        let salvage = Store::salvage(directory.path(), |_, _| Vec::new()).unwrap();
        assert_eq!((salvage.kept as u64, salvage.studies), (COUNT, 1), "{prefix}");
        let store = Store::open(directory.path()).unwrap();
        assert!((0..COUNT).all(|i| store.get(&key(i)).unwrap() == Some(record(i))));
    }
}

#[test]
fn a_database_cut_short_is_salvaged_up_to_the_cut() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let log = directory.path().join("records/db");
    let length = fs::metadata(&log).unwrap().len();
    fs::File::options().write(true).open(&log).unwrap().set_len(length * 9 / 10).unwrap();
    let error = Store::open(directory.path()).err().unwrap();
    assert!(matches!(error, OpenError::Damaged { .. }), "{error}");
    let salvage = Store::salvage(directory.path(), |_, _| Vec::new()).unwrap();
    assert!((1000..COUNT as usize).contains(&salvage.kept), "{salvage:?}");
    assert_eq!(salvage.promised, Some(COUNT));
    let store = Store::open(directory.path()).unwrap();
    assert!(store.records().all(|(_, record)| record.is_ok()));
    assert_eq!(store.len(), salvage.kept);
}

#[test]
fn a_later_format_is_left_alone() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let manifest = directory.path().join("manifest.json");
    fs::write(&manifest, br#"{ "format": 3 }"#).unwrap();
    let error = Store::open(directory.path()).err().unwrap();
    assert!(matches!(error, OpenError::Format { found: 3, .. }), "{error}");
    assert!(matches!(
        Store::salvage(directory.path(), |_, _| Vec::new()),
        Err(OpenError::Format { found: 3, .. })
    ));
    assert_eq!(fs::read(&manifest).unwrap(), br#"{ "format": 3 }"#);
}

#[test]
fn a_killed_salvage_is_cleared_away_or_finished_by_the_next_writer() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let (records, salvaged) =
        (directory.path().join("records"), directory.path().join("records.salvaged"));
    copy(&records, &salvaged);
    fs::write(salvaged.join("db"), b"half of it").unwrap();
    assert_eq!(Store::open(directory.path()).unwrap().len() as u64, COUNT);
    assert!(!salvaged.exists());
    // A kill between the last two steps leaves the sound database under its other name.
    fs::rename(&records, &salvaged).unwrap();
    assert_eq!(Store::open(directory.path()).unwrap().len() as u64, COUNT);
    fs::rename(&records, &salvaged).unwrap();
    let salvage = Store::salvage(directory.path(), |_, _| Vec::new()).unwrap();
    assert_eq!(salvage.kept as u64, COUNT);
}

/// Every file in turn has a directory in its place, which is damage and no refusal of the system.
#[test]
fn a_directory_in_the_place_of_any_file_is_healed() {
    let original = tempfile::tempdir().unwrap();
    make(original.path());
    let whole = files(original.path());
    assert!(whole.len() >= 5, "{whole:?}");
    for file in whole {
        let name = file.strip_prefix(original.path()).unwrap();
        for inner in [None, Some("file")] {
            let copied = tempfile::tempdir().unwrap();
            copy(original.path(), copied.path());
            let path = copied.path().join(name);
            fs::remove_file(&path).unwrap();
            fs::create_dir(&path).unwrap();
            if let Some(inner) = inner {
                fs::write(path.join(inner), b"something").unwrap();
                if name == Path::new("lock") {
                    let error = Store::open(copied.path()).err().unwrap().to_string();
                    assert!(error.contains("store salvage` put it aside"), "{error}");
                }
            }
            let salvage = match Store::salvage(copied.path(), |_, _| Vec::new()) {
                Ok(salvage) => salvage,
                Err(error) => panic!("{}: {error}", name.display()),
            };
            let is_log = name.ends_with("db");
            let kept = if is_log { 0 } else { COUNT };
            assert_eq!(salvage.kept as u64, kept, "{}", name.display());
            let store = Store::open(copied.path()).unwrap();
            store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
            store.commit(&records(0..COUNT)).unwrap();
            drop(store);
            assert_eq!(inspect(copied.path()), "sound", "{}", name.display());
        }
    }
}

/// A pipe, a socket, a file or a link that leads nowhere is in the place of what a salvage needs.
#[test]
fn anything_in_the_place_of_a_part_of_the_store_is_healed() {
    let original = tempfile::tempdir().unwrap();
    make(original.path());
    for (name, kept) in [("manifest.json", COUNT), ("records", 0), ("records.salvaged", COUNT)] {
        for kind in ["pipe", "socket", "file", "link"] {
            let copied = tempfile::tempdir().unwrap();
            copy(original.path(), copied.path());
            let path = copied.path().join(name);
            match fs::symlink_metadata(&path) {
                Ok(found) if found.is_dir() => fs::remove_dir_all(&path).unwrap(),
                Ok(_) => fs::remove_file(&path).unwrap(),
                Err(_) => {}
            }
            match kind {
                "pipe" => assert!(Command::new("mkfifo").arg(&path).status().unwrap().success()),
                "socket" => drop(std::os::unix::net::UnixListener::bind(&path).unwrap()),
                "file" => fs::write(&path, b"garbage").unwrap(),
                _ => std::os::unix::fs::symlink("/nowhere/at all", &path).unwrap(),
            }
            let salvage = match Store::salvage(copied.path(), |_, _| Vec::new()) {
                Ok(salvage) => salvage,
                Err(error) => panic!("{kind} as {name}: {error}"),
            };
            assert_eq!(salvage.kept as u64, kept, "{kind} as {name}");
            let store = Store::open(copied.path()).unwrap();
            store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
            store.commit(&records(0..COUNT)).unwrap();
            drop(store);
            assert_eq!(inspect(copied.path()), "sound", "{kind} as {name}");
        }
    }
}

/// sled's own files may be torn by a kill or a power failure before anything was acknowledged.
#[test]
fn a_store_that_promises_nothing_recovers_from_any_first_write() {
    let original = tempfile::tempdir().unwrap();
    drop(Store::open(original.path()).unwrap());
    let log = fs::read(original.path().join("records/db")).unwrap();
    let conf = fs::read(original.path().join("records/conf")).unwrap();
    for (name, content) in [
        ("db", vec![0xa5; log.len()]),
        ("db", log[..log.len() / 3].to_vec()),
        ("conf", conf[..conf.len() - 3].to_vec()),
        ("conf", vec![0; conf.len()]),
        ("snap.0000000000000027", b"torn".to_vec()),
        ("snap.0000000000000027.generating", b"torn".to_vec()),
    ] {
        let copied = tempfile::tempdir().unwrap();
        copy(original.path(), copied.path());
        fs::write(copied.path().join("records").join(name), &content).unwrap();
        let reader = Store::read(copied.path()).unwrap();
        assert_eq!(reader.keys().unwrap(), []);
        let store = Store::open(copied.path())
            .unwrap_or_else(|error| panic!("{name} of {} bytes: {error}", content.len()));
        store.commit(&records(0..10)).unwrap();
        drop(store);
        assert_eq!(Store::open(copied.path()).unwrap().len(), 10);
    }
}

/// A killed process leaves such a file when it opens the store, and sled would read it.
#[test]
fn a_snapshot_that_was_never_finished_is_no_damage() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let unfinished = directory.path().join("records/snap.7FFFFFFFFFFFFFFF.generating");
    fs::write(&unfinished, b"half a snapsh").unwrap();
    assert_eq!(Store::read(directory.path()).unwrap().keys().unwrap().len() as u64, COUNT);
    assert_eq!(Store::open(directory.path()).unwrap().len() as u64, COUNT);
    assert!(!unfinished.exists());
}

/// The record of a job whose fields are lost promises what it cannot keep.
#[test]
fn salvage_gives_up_records_whose_blob_is_lost_or_damaged() {
    let directory = tempfile::tempdir().unwrap();
    let store = Store::open(directory.path()).unwrap();
    let digests: Vec<Digest> =
        (0..4u8).map(|i| store.blobs().put(&vec![i; 5000]).unwrap()).collect();
    let group: Vec<_> = (0..).zip(&digests[..3]).map(|(i, digest)| (key(i), digest.0)).collect();
    store.commit(&group).unwrap();
    store.put_study("sweep", b"a study").unwrap();
    let path = |i: usize| store.blobs().path(&digests[i]);
    fs::remove_file(path(0)).unwrap();
    fs::write(path(1), b"garbage").unwrap();
    fs::remove_file(path(3)).unwrap();
    fs::create_dir(path(3)).unwrap();
    drop(store);
    let references = |_: &JobKey, record: &[u8]| vec![Digest(record.try_into().unwrap())];
    let salvage = Store::salvage(directory.path(), references).unwrap();
    assert_eq!((salvage.kept, salvage.incomplete, salvage.damaged_blobs), (1, 2, 2));
    assert_eq!((salvage.studies, salvage.lost_studies.len()), (1, 0));
    let reader = Store::read(directory.path()).unwrap();
    assert!(reader.verify(references).unwrap().is_sound());
    assert_eq!(reader.keys().unwrap(), [key(2)]);
}

/// sled removes files from there when it opens the store.
#[test]
fn no_link_to_a_directory_is_followed_either() {
    let directory = tempfile::tempdir().unwrap();
    let store = directory.path().join("store");
    fs::create_dir(&store).unwrap();
    make(&store);
    let victim = directory.path().join("victim");
    fs::create_dir(&victim).unwrap();
    fs::write(victim.join("999999999"), b"a letter").unwrap();
    let large = store.join("records/blobs");
    for is_link in [true, false] {
        fs::remove_dir_all(&large).unwrap();
        if is_link {
            std::os::unix::fs::symlink(&victim, &large).unwrap();
        } else {
            fs::write(&large, b"a file").unwrap();
        }
        let error = Store::open(&store).err().unwrap().to_string();
        assert!(error.contains(if is_link { "symbolic link" } else { "another kind" }), "{error}");
        let salvage = Store::salvage(&store, |_, _| Vec::new()).unwrap();
        assert!(salvage.kept > 0, "{salvage:?}");
        Store::open(&store).unwrap().commit(&records(0..COUNT)).unwrap();
        assert_eq!(inspect(&store), "sound");
    }
    assert_eq!(fs::read(victim.join("999999999")).unwrap(), b"a letter");
}

/// Whoever can write in the directory of a store must not lead its owner's writes elsewhere.
#[test]
fn no_link_is_followed_when_a_file_is_opened_for_writing() {
    let original = tempfile::tempdir().unwrap();
    make(original.path());
    for file in files(original.path()) {
        let name = file.strip_prefix(original.path()).unwrap();
        let copied = tempfile::tempdir().unwrap();
        copy(original.path(), copied.path());
        let victim = copied.path().join("letter");
        let path = copied.path().join(name);
        let content = fs::read(&path).unwrap();
        fs::rename(&path, &victim).unwrap();
        std::os::unix::fs::symlink(&victim, &path).unwrap();
        let store = Store::open(copied.path()).or_else(|error| {
            let said = error.to_string();
            assert!(said.contains("symbolic link"), "{}: {said}", name.display());
            Store::salvage(copied.path(), |_, _| Vec::new())?;
            Store::open(copied.path())
        });
        let store = store.unwrap();
        store.commit(&records(COUNT..COUNT + 10)).unwrap();
        store.put_study("sweep", b"mu = [0.2]").unwrap();
        assert_eq!(fs::read(&victim).unwrap(), content, "{}", name.display());
    }
}

/// A sound store is not taken for a damaged one because its files could not be opened.
#[test]
fn a_salvage_that_is_refused_a_file_leaves_all_as_it_is() {
    let original = tempfile::tempdir().unwrap();
    make(original.path());

    let mut refused = 0;
    for descriptors in 5..16 {
        let copied = tempfile::tempdir().unwrap();
        copy(original.path(), copied.path());
        let inner = command("salvage", copied.path(), 0);
        let mut outer = Command::new("bash");
        outer.arg("-c").arg(format!("ulimit -n {descriptors}; exec \"$0\" \"$@\""));
        outer.arg(inner.get_program()).args(inner.get_args());
        outer.envs(inner.get_envs().filter_map(|(name, value)| Some((name, value?))));
        outer.stdin(Stdio::piped()).stdout(Stdio::piped());
        let said = Player::start(outer).transcript().concat();
        eprintln!("{descriptors} descriptors: {said}");
        if said.starts_with("refused: ") {
            refused += 1;
            assert!(!copied.path().join("records.damaged-1").exists(), "{said}");
            assert_eq!(inspect(copied.path()), "sound");
        } else {
            assert_eq!(said, format!("kept {COUNT}, studies 1"));
        }
    }
    assert!(refused > 0, "{refused} were refused");
}
