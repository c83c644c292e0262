//! A query says the same whether it reads the records of a study or the table that is kept of them.

use std::fs;
use std::path::Path;
use std::time::SystemTime;

use identity::JobKey;
use store::{Digest, Glance, Store};

use super::failed::PULLED;
use crate::place::{PATH, Place, SMALL, Said};

/// The folder of tables.
const TABLES: &str = ".tribosweep/tables";

/// Asks without a table, then with that which the first question has left, and returns what both
/// say.
fn said_twice(place: &Place, words: &[&str]) -> Said {
    if place.has(TABLES) {
        place.remove(TABLES);
    }
    let file = if words[0] == "plot" { "rows.svg" } else { "rows" };
    let ask = || {
        let said = place.words(words);
        let written = fs::read(place.path(file)).unwrap_or_default();
        if place.has(file) {
            place.remove(file);
        }
        (said, written)
    };
    let (first, one) = ask();
    if !place.has(TABLES) {
        place.words(&["query", words[1], "--select", "key"]);
    }
    let (second, other) = ask();
    assert_eq!((first.code, &first.out, &first.err), (second.code, &second.out, &second.err));
    assert!(one == other, "{words:?}");
    first
}

/// Asks much of a study, with and without its table.
fn assert_same_rows(place: &Place, study: &str) {
    let columns = place.json(&format!("query {study} --columns --json"));
    let names: Vec<&str> = columns["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["column"].as_str().unwrap())
        .collect();
    let keys = place.words(&["query", study, "--select", "key", "--format", "csv"]).out;
    let keys: Vec<&str> = keys.lines().skip(1).collect();
    let axis = names[0];
    let of_key = format!("key == \"{}\" || key == \"{}\"", keys[0], keys[keys.len() / 2]);
    let is_there = format!("{axis} != null && status == \"certified\"");
    let descending = format!("--sort=-{axis},status");
    let three = format!("{axis},key,status,reason");
    let all = names.join(",");
    let questions: &[&[&str]] = &[
        &[],
        &["--json"],
        &["--json", "--select", &all],
        &["--format", "csv", "--select", &all],
        &["--format", "parquet", "--output", "rows"],
        &["--format", "csv", "--output", "rows", "--select", &three, "--where", &is_there],
        &["--format", "parquet", "--output", "rows", "--select", &three, "--where", &of_key],
        &["--select", &three, "--where", &of_key],
        &["--select", &three, &descending],
        &["--where", "status == null || status != \"certified\"", "--json"],
        &["--where", "seconds > 1e9", "--select", &three],
        &["--where", "status > 3", "--select", &three],
        &["--where", "stat == 3", "--select", &three],
        &["--select", "stat"],
        &["--sort", "stat"],
        &["--steps", "--json"],
        &["--shard", "1/2", "--select", &three],
    ];
    for question in questions {
        said_twice(place, &[&["query", study], *question].concat());
    }
    let figure: &[&str] = &["plot", study, "--output", "rows.svg"];
    let page: &[&str] = &["report", study, "--output", "rows"];
    let others: &[&[&str]] = &[
        &["answer", study],
        &["answer", study, "--json"],
        figure,
        &[figure, &["--where", "status == \"certified\" && seconds >= 0"]].concat(),
        &[figure, &["--x", axis, "--y", "seconds,iterations", "--kind", "scatter"]].concat(),
        &[figure, &["--x", axis, "--y", "lode"]].concat(),
        &[figure, &["--steps", "--x", "increment", "--y", "load"]].concat(),
        page,
        &[page, &["--where", &is_there]].concat(),
        &[page, &["--fields", &keys[0][..12]]].concat(),
        &[page, &["--where", "stat == 3"]].concat(),
    ];
    for question in others {
        said_twice(place, question);
    }
    assert_eq!(place.json("store verify --json")["kept_tables"]["notes"], serde_json::json!([]));
    place.words(&["query", study, "--select", "key"]);
    assert!(place.has(".tribosweep/tables/list"));
    let counts = || place.succeed("status --json");
    let said = counts();
    if place.has(".tribosweep/kept") {
        place.remove(".tribosweep/kept");
    }
    assert_eq!(counts(), said, "counted in the table");
    place.remove(TABLES);
    assert_eq!(counts(), said, "counted in the records");
}

/// Studies of several kinds: rows and rows of increments, points that a study chooses, leaves out
/// or compares, and jobs that fail or have no result yet.
#[test]
fn a_query_says_the_same_with_and_without_a_table() {
    let place = Place::run();
    assert_same_rows(&place, "small");
    let place = Place::with("path.toml", PATH);
    place.succeed("run path.toml --workers 1");
    assert_same_rows(&place, "path");
    let large = SMALL.replace("\"small\"", "\"part\"");
    let place = Place::with("part.toml", large);
    assert_eq!(place.call("run part.toml --workers 1 --max-jobs 3").code, 75);
    assert_same_rows(&place, "part");
    let refine = "[refine]\non = \"load\"\nuntil = \"0.01%\"\nat_most = 24\n[sweep]";
    let refined = SMALL.replace("\"small\"", "\"refined\"").replace("[sweep]", refine);
    let place = Place::with("refined.toml", refined);
    place.words(&["run", "refined.toml", "--workers", "1", "--max-jobs", "9"]);
    assert_same_rows(&place, "refined");
    let place = Place::with("pulled.toml", PULLED);
    assert_eq!(place.call("run pulled.toml --workers 1").code, 2);
    assert_same_rows(&place, "pulled");
}

/// A study of more points than are in memory, of which few jobs have run, and the same jobs of
/// parts that are.
#[test]
fn a_long_study_says_of_its_points_what_its_parts_say() {
    let long = SMALL.replace("\"small\"", "\"long\"");
    let (before, _) = long.split_once("[sweep]").unwrap();
    let swept = "[sweep]\nfriction.mu = { from = 0.1, to = 0.9, count = 17000 }\n";
    let place = Place::with("long.toml", format!("{before}{swept}"));
    assert_eq!(place.call("run long.toml --workers 1 --max-jobs 9").code, 75);
    let rows = |words: &[&str]| -> Vec<serde_json::Value> {
        let said = said_twice(&place, &[&["query", "long", "--json"], words].concat());
        serde_json::from_str::<serde_json::Value>(&said.out).unwrap()["rows"]
            .as_array()
            .unwrap()
            .clone()
    };
    let words = ["--steps", "--select", "mu,load,status"];
    let whole = rows(&words);
    let of_shard = |shard| rows(&[&words[..], &["--shard", shard]].concat());
    let mut parts: Vec<_> = ["1/2", "2/2"].into_iter().flat_map(of_shard).collect();
    let mu = |row: &serde_json::Value| row["mu"].as_f64().unwrap();
    parts.sort_by(|one, other| mu(one).total_cmp(&mu(other)));
    assert!(whole == parts && !whole.is_empty());
    for words in [
        &["query", "long", "--where", "lode > 0"][..],
        &["query", "long", "--sort=-load", "--where", "mu > 0.85"],
        &["query", "long", "--steps"],
        &["answer", "long"],
        &["plot", "long", "--output", "rows.svg"],
        &["report", "long", "--output", "rows", "--where", "mu < 0.3 || load > 0"],
    ] {
        let said = said_twice(&place, words);
        let is_wrong = words.contains(&"lode > 0");
        assert_eq!(said.code != 0, is_wrong, "{}", said.err);
    }
    let lines = place.words(&["query", "long"]).out;
    assert_eq!(lines.lines().count(), 17_000 + 5, "two of heads and three rules");
    assert!(place.words(&["answer", "long"]).out.contains(&lines));
    // An export has no table, so that its records are read in blocks.
    place.succeed("store export long.tribosweep");
    let page = |store: &str| {
        let words = ["report", "long", "--output", "rows.html", "--store", store];
        assert_eq!(place.words(&words).code, 0);
        fs::read(place.path("rows.html")).unwrap()
    };
    assert!(page(".tribosweep") == page("long.tribosweep"));
}

/// Runs some jobs of each sweep and asks much of it, with and without its table.
#[test]
#[ignore = "it takes minutes"]
fn a_query_of_any_sweep_says_the_same_with_and_without_a_table() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("sweeps");
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    let mut asked = 0;
    for file in files {
        let place = Place::empty();
        let file = file.to_str().unwrap();
        place.words(&["run", file, "--max-jobs", "6", "--until", "10s", "--workers", "1"]);
        if !place.has(".tribosweep") {
            continue;
        }
        let listed = place.json("status --json");
        for study in listed.as_array().unwrap() {
            let name = study["study"].as_str().unwrap();
            let keys = place.words(&["query", name, "--select", "key", "--format", "csv"]);
            if keys.out.lines().count() > 1 {
                assert_same_rows(&place, name);
                asked += 1;
            }
        }
    }
    println!("{asked} sweeps");
    assert!(asked > 30);
}

/// Changes a byte of the database so that its marks tell nothing.
fn damage_records(place: &Place) {
    let log = place.path(".tribosweep/records/db");
    let changed: SystemTime = fs::metadata(&log).unwrap().modified().unwrap();
    let mut bytes = fs::read(&log).unwrap();
    let places: Vec<usize> = (0..bytes.len() - 20)
        .filter(|start| {
            bytes[*start..].starts_with(b"flat-disk") || bytes[*start..].starts_with(b"\"sphere\"")
        })
        .collect();
    assert!(!places.is_empty());
    for place in places {
        bytes[place + 2] ^= 1;
    }
    fs::write(&log, bytes).unwrap();
    fs::File::options().write(true).open(&log).unwrap().set_modified(changed).unwrap();
}

/// A table that holds is read in place of the records, and is right where they can no longer be
/// read.
#[test]
fn a_table_stands_in_for_the_records_until_something_changes() {
    let place = Place::run();
    let line = "query small --select mu,load --where load>0";
    let said = place.succeed(line);
    assert!(place.has(".tribosweep/tables/list"));
    let files = place.files();
    assert_eq!(place.succeed(line), said);
    assert_eq!(place.files(), files, "nothing is written twice");
    assert_eq!(
        place.json("store verify --json")["kept_tables"],
        serde_json::json!({ "proved": 1, "notes": [] })
    );
    // Nobody else's records come into the table of the study.
    let other = SMALL.replace("\"small\"", "\"other\"").replace("0.6]", "0.5]");
    place.write("other.toml", other);
    place.succeed("run other.toml --workers 1");
    assert_eq!(place.succeed(line), said);
    // A study that is another one is asked of its records.
    place.write("small.toml", SMALL.replace("0.6]", "0.5]"));
    place.succeed("run small.toml --workers 1");
    assert_ne!(place.succeed(line), said);
    place.write("small.toml", SMALL);
    place.succeed("run small.toml --workers 1");
    assert_eq!(place.succeed(line), said);

    place.succeed("query small --select key");
    let all = || {
        place.succeed("query small --format parquet --output rows");
        fs::read(place.path("rows")).unwrap()
    };
    let (written, key) = (all(), place.keys().remove(2));
    damage_records(&place);
    assert_eq!(place.succeed(line), said, "the records are not read");
    assert!(all() == written, "who computed them is known as well");
    let found =
        place.words(&["query", "small", "--select", "key", "--where", &format!("key == '{key}'")]);
    assert_eq!((found.code, found.out.matches(&key[..20]).count()), (0, 1), "{}", found.out);
    place.remove(TABLES);
    let refused = place.call(line);
    assert_ne!(refused.code, 0, "{}", refused.out);
    assert!(!place.has(".tribosweep/tables/list"), "no table is made of damaged records");
}

/// A table that is wrong, whoever made it, is found by `store verify`, and a damaged one by the
/// query itself.
#[test]
fn a_table_that_is_wrong_is_found_and_a_damaged_one_is_made_anew() {
    let place = Place::run();
    let line = "query small --select mu,load";
    let said = place.succeed(line);
    let table = || {
        let files = place.files().into_iter().map(|(path, _)| path);
        let mut tables = files.filter(|path| {
            path.parent().is_some_and(|folder| folder.ends_with("tables"))
                && !path.ends_with("list")
        });
        let table = tables.next().unwrap();
        assert!(tables.next().is_none());
        table
    };
    let whole = fs::read(table()).unwrap();
    for start in (0..whole.len()).step_by(97) {
        let mut damaged = whole.clone();
        damaged[start] ^= 16;
        fs::write(table(), &damaged).unwrap();
        assert_eq!(place.succeed(line), said, "byte {start}");
    }
    assert_eq!(place.succeed(line), said);

    // Somebody has made a table of other figures.
    let list = fs::read(place.path(".tribosweep/tables/list")).unwrap();
    let head: Digest = table().file_name().unwrap().to_str().unwrap().parse().unwrap();
    let start = list.windows(32).position(|bytes| bytes == head.0).unwrap();
    let meaning = Digest(list[start - 32..start].try_into().unwrap());
    let store = place.path(".tribosweep");
    let kept = Glance::at(&store).unwrap().table("small", &meaning).unwrap();
    let mut pieces: Vec<Vec<u8>> =
        (0..kept.column_count()).map(|column| kept.piece(column, 0).unwrap()).collect();
    let keys: Vec<JobKey> = place.keys().iter().map(|key| key.parse().unwrap()).collect();
    // Numbers that are not all the same begin so.
    let piece = pieces.iter_mut().rfind(|piece| piece.starts_with(&[1, 0])).unwrap();
    piece[2] ^= 1;
    let mut builder = Store::read(&store).unwrap().table_builder(pieces.len()).unwrap();
    builder.push(&keys, &pieces).unwrap();
    builder.finish("small", &meaning, kept.caption().to_vec(), true).unwrap();
    let verified = place.json("store verify --json");
    assert_eq!(verified["sound"], true);
    let note = "the table that was kept of `small` is not right, and is forgotten";
    let expected = serde_json::json!({ "proved": 0, "notes": [note] });
    assert_eq!(verified["kept_tables"], expected);
    assert_eq!(place.succeed(line), said);
    assert_eq!(place.json("store verify --json")["kept_tables"]["proved"], 1);
}
