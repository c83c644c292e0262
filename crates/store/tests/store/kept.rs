//! Words that are kept about studies hold for the records that there are, or are not shown.

use std::fs;
use std::path::Path;
use std::time::Duration;

use store::{Glance, KeptWords, Store};

use super::child::{Player, command};
use super::{key, record, records};

fn words(text: &str, is_final: bool) -> KeptWords {
    KeptWords { words: text.as_bytes().to_vec(), is_final }
}

/// Makes a store of ten records and two studies, with words about both.
fn make(directory: &Path) {
    let store = Store::open(directory).unwrap();
    store.put_study("done", b"ten points").unwrap();
    store.put_study("open", b"more points").unwrap();
    store.commit(&records(0..10)).unwrap();
    store.keep_words("done", words("10", true));
    store.keep_words("open", words("10 of 20", false));
}

/// Returns the words about the two studies that a glance shows.
fn shown(directory: &Path) -> [Option<String>; 2] {
    let glance = Glance::at(directory);
    ["done", "open"].map(|study| {
        let words = glance.as_ref()?.words(study)?;
        Some(String::from_utf8(words.to_vec()).unwrap())
    })
}

const BOTH: [Option<&str>; 2] = [Some("10"), Some("10 of 20")];
const FINAL: [Option<&str>; 2] = [Some("10"), None];
const NONE: [Option<&str>; 2] = [None, None];

/// A directory that stands in the place of the file costs no result.
#[test]
fn a_directory_in_the_place_of_the_words_is_left_alone() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    fs::remove_file(directory.path().join("kept")).unwrap();
    fs::create_dir(directory.path().join("kept")).unwrap();
    assert_eq!(shown(directory.path()), [None, None]);
    let store = Store::open(directory.path()).unwrap();
    assert_eq!(store.get(&key(3)).unwrap().unwrap(), record(3));
    drop(store);
    assert!(directory.path().join("kept").is_dir());
}

#[test]
fn words_are_shown_as_long_as_they_hold() {
    /// A change of the store, and the words that hold after it.
    type Change = (&'static str, fn(&Store), [Option<&'static str>; 2]);
    let changes: [Change; 7] = [
        ("nothing", |_| {}, BOTH),
        ("a study", |store| store.put_study("other", b"x").unwrap(), BOTH),
        ("a label", |store| store.set_labels("done", Default::default()).unwrap(), BOTH),
        ("further records", |store| store.commit(&records(10..12)).unwrap(), FINAL),
        ("another record", |store| store.commit(&[(key(3), record(4))]).unwrap(), NONE),
        ("a record fewer", |store| assert_eq!(store.remove(&[key(3)]).unwrap(), 1), NONE),
        ("no record fewer", |store| assert_eq!(store.remove(&[key(99)]).unwrap(), 0), BOTH),
    ];
    for (name, change, expected) in changes {
        let directory = tempfile::tempdir().unwrap();
        make(directory.path());
        assert_eq!(shown(directory.path()), BOTH.map(|words| words.map(str::to_owned)), "{name}");
        let store = Store::open(directory.path()).unwrap();
        assert_eq!(shown(directory.path()), [None, None], "a process may be changing it: {name}");
        change(&store);
        drop(store);
        let expected = expected.map(|words| words.map(str::to_owned));
        assert_eq!(shown(directory.path()), expected, "{name}");
        // A glance and a reader change nothing.
        drop(Store::read(directory.path()).unwrap());
        assert_eq!(shown(directory.path()), expected, "{name}");
    }
}

#[test]
fn damaged_words_and_those_of_other_files_are_not_shown() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    make(path);
    let file = path.join("kept");
    let whole = fs::read(&file).unwrap();
    for place in (0..whole.len()).step_by(7) {
        let mut flipped = whole.clone();
        flipped[place] ^= 4;
        fs::write(&file, flipped).unwrap();
        assert_eq!(shown(path), [None, None], "byte {place}");
        fs::write(&file, &whole[..place]).unwrap();
        assert_eq!(shown(path), [None, None], "cut to {place}");
    }
    fs::write(&file, &whole).unwrap();
    assert_eq!(shown(path)[0].as_deref(), Some("10"));
    // Another program, which knows nothing of the words, writes to the database.
    let log = path.join("records/db");
    let bytes = fs::read(&log).unwrap();
    fs::write(&log, bytes).unwrap();
    assert_eq!(shown(path), [None, None]);
    // The words of a copy are those of its own files.
    make(path);
    Store::forget_words(path).unwrap();
    assert!(!file.exists());
    assert_eq!(shown(path), [None, None]);
    Store::forget_words(path).unwrap();
}

#[test]
fn words_that_are_too_long_are_not_kept() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let store = Store::open(directory.path()).unwrap();
    store.keep_words("done", words(&"x".repeat(2 << 20), true));
    drop(store);
    assert_eq!(shown(directory.path())[0].as_deref(), None);
}

/// Kills processes that keep words, and holds what is shown afterwards against the records.
fn kill(rounds: u64) -> u64 {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let (mut random, mut right) = (1u64, 0);
    for round in 0..rounds {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let mut player = Player::start(command("keep", path, 1_000_000 * round));
        for _ in 0..random >> 62 {
            player.line().expect("it goes on until it is killed");
        }
        std::thread::sleep(Duration::from_micros((random >> 40) % 20_000));
        player.kill();
        let shown = Glance::at(path)
            .and_then(|glance| Some(String::from_utf8(glance.words("sweep")?.to_vec()).unwrap()));
        let records = Store::open(path).unwrap().len();
        if let Some(shown) = shown {
            assert_eq!(shown, records.to_string(), "round {round}");
            right += 1;
        }
    }
    right
}

#[test]
fn no_kill_leaves_words_that_are_wrong() {
    kill(25);
}

#[test]
#[ignore = "it takes minutes"]
fn no_kill_of_500_leaves_words_that_are_wrong() {
    let right = kill(500);
    println!("500 kills left right words {right} times, and none in the other cases");
    assert!(right > 0);
}
