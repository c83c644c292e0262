//! A study in shards: every part by itself, in any order, gives what one machine gives.

use std::fs::{self, File};
use std::path::Path;

use super::adaptive::halved;
use crate::place::{Place, SMALL, Said};

/// Returns the table of a study by every column that says neither when nor how long.
fn rows(place: &Place, study: &str, store: &str) -> String {
    let columns = place.json(&format!("query {study} --columns --json --store {store}"));
    let names: Vec<&str> = columns["rows"].as_array().unwrap().iter().filter_map(name).collect();
    assert!(names.len() > 30);
    let said = place.words(&[
        "query",
        study,
        "--store",
        store,
        "--format",
        "csv",
        "--select",
        &names.join(","),
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    said.out
}

/// Returns the name of a column, unless it tells of the run rather than of the result.
fn name(column: &serde_json::Value) -> Option<&str> {
    column["column"].as_str().filter(|_| column["kind"] != "provenance")
}

/// Runs a shard with its temporary files here.
fn shard(place: &Place, line: &str) -> Said {
    fs::create_dir_all(place.path("tmp")).unwrap();
    let words: Vec<&str> = line.split_whitespace().collect();
    let output = place.command(&words).env("TMPDIR", place.path("tmp")).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let code = output.status.code().expect("it ended by itself");
    Said { code, out: text(output.stdout), err: text(output.stderr) }
}

/// Returns true if nothing is in the directory for temporary files.
fn is_clean(place: &Place) -> bool {
    fs::read_dir(place.path("tmp")).unwrap().next().is_none()
}

#[test]
fn shards_in_any_order_give_the_results_of_one_machine() {
    let line = halved("friction.mu", "[0.1, 0.5]", "mu > 0.3");
    let axes = "[sweep]\n\"foundation.base.shear_modulus\" = [1e9, 2e9, 3e9]\n";
    let lines = line.replace("[sweep]\n", axes);
    assert_ne!(line, lines);
    for (text, study) in [(SMALL, "small"), (&*lines, "halved")] {
        let file = format!("{study}.toml");
        let place = Place::with(&file, text);
        assert_eq!(place.call(&format!("run {file}")).code, 0);
        let whole = rows(&place, study, ".tribosweep");
        for (count, order) in [(2, &[2, 1][..]), (3, &[2, 3, 1]), (8, &[8, 1, 5, 2, 7, 3, 6, 4])] {
            let exports = format!("exports-{count}");
            for index in order {
                let said = shard(
                    &place,
                    &format!("run {file} --shard {index}/{count} --export {exports}"),
                );
                assert_eq!(said.code, 0, "{}", said.err);
                assert!(is_clean(&place));
            }
            assert_eq!(rows(&place, study, &exports), whole);
            let merged = place.call(&format!("store merge {exports} --into merged-{count}"));
            assert_eq!(merged.code, 0, "{}{}", merged.out, merged.err);
            assert_eq!(rows(&place, study, &format!("merged-{count}")), whole);
            let status = place.call(&format!("status --store {exports}"));
            assert!(
                status.out.contains(&format!("{study}: {count} of {count} shards finished")),
                "{}",
                status.out
            );
        }
    }
}

#[test]
fn a_shard_goes_on_from_its_export_alone() {
    let place = Place::with("small.toml", SMALL);
    let line = "run small.toml --shard 1/2 --export exports --until 1ms --workers 1 --json";
    let mut starts = 0;
    loop {
        let said = shard(&place, line);
        starts += 1;
        assert!(is_clean(&place));
        if said.code == 0 {
            break;
        }
        assert_eq!(said.code, 75, "{}", said.err);
        assert!(starts < 100, "{}", said.err);
        let status = place.json("status --store exports --json");
        let state = &status[0]["shards"][0]["state"];
        assert_eq!(state, "unfinished", "{status}");
        let merged = place.call("store merge exports --into half");
        assert_eq!(merged.code, 2);
        assert!(merged.out.contains("missing 2: `tribosweep run small.toml --shard 2/2 --export"));
    }
    assert!(starts > 1);
    let said = shard(&place, "run small.toml --shard 1/2 --export exports --json");
    let summary: serde_json::Value =
        serde_json::from_str(said.out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["run"]["computing"], 0, "{summary}");
}

#[test]
fn a_torn_export_is_gone_on_from_what_is_whole() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(shard(&place, "run small.toml --shard 1/2 --export exports").code, 0);
    let whole = rows(&place, "small", "exports");
    let file = place.path("exports/small.1-of-2.tribosweep");
    let length = fs::metadata(&file).unwrap().len();
    File::options().write(true).open(&file).unwrap().set_len(length / 2).unwrap();
    let said = shard(&place, "run small.toml --shard 1/2 --export exports");
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(rows(&place, "small", "exports"), whole);
}

/// The export lies on a file system that has no room for the fields of all results.
#[test]
fn a_shard_whose_export_is_not_whole_is_not_finished() {
    let place = Place::with("small.toml", SMALL.replace("mesh = 6", "mesh = 64"));
    let line = "run small.toml --shard 1/1 --export exports";
    fs::create_dir(place.path("exports")).unwrap();
    fs::create_dir(place.path("tmp")).unwrap();
    let program = place.command(&[]);
    let mount = "mount -t tmpfs -o size=64k tmpfs exports && exec \"$0\" \"$@\"";
    let mut full = std::process::Command::new("unshare");
    full.args(["-m", "sh", "-c", mount]).arg(program.get_program()).args(line.split(' '));
    full.current_dir(place.path("")).env("TMPDIR", place.path("tmp"));
    let tried = std::process::Command::new("unshare")
        .args(["-m", "mount", "-t", "tmpfs", "tmpfs", "/tmp"])
        .output();
    if !tried.is_ok_and(|tried| tried.status.success()) {
        eprintln!("skipped: mounting takes privileges that this user lacks");
        return;
    }
    let ended = full.output().unwrap();
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    for words in ["there is no room for", "is not whole", "what is not exported is kept in"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let summary = shard(&place, &format!("{line} --json"));
    assert_eq!(summary.code, 0, "{}", summary.err);
    let summary: serde_json::Value =
        serde_json::from_str(summary.out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["run"]["computing"], 0, "the local store has kept everything");
    assert_eq!(place.call("store verify --store exports").code, 0);
    assert!(is_clean(&place));
}

#[test]
fn what_an_export_has_lost_comes_again_from_the_store() {
    let place = Place::with("small.toml", SMALL.replace("mesh = 6", "mesh = 40"));
    let line = "run small.toml --shard 1/1 --export exports --store store";
    assert_eq!(place.call(line).code, 0);
    let whole = rows(&place, "small", "exports");
    let file = place.path("exports/small.1-of-1.tribosweep");
    let bytes = fs::read(&file).unwrap();
    for position in [bytes.len() / 8, bytes.len() / 2, bytes.len() * 7 / 8] {
        let mut damaged = bytes.clone();
        damaged[position] ^= 1;
        fs::write(&file, damaged).unwrap();
        assert_eq!(place.call("store verify --store exports").code, 2);
        let said = place.call(line);
        assert_eq!(said.code, 0, "{}", said.err);
        let verified = place.call("store verify --store exports");
        assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
        assert_eq!(rows(&place, "small", "exports"), whole);
    }
}

#[test]
fn shards_of_different_numbers_are_told_apart() {
    let place = Place::with("small.toml", SMALL);
    for shards in ["1/2", "2/2", "3/3"] {
        let line = format!("run small.toml --shard {shards} --export exports");
        assert_eq!(shard(&place, &line).code, 0);
    }
    let status = place.call("status --store exports").out;
    for words in ["2 of 2 shards finished", "1 of 3 shards finished, 0 unfinished, 2 missing"] {
        assert!(status.contains(words), "{words}: {status}");
    }
    for line in [
        "run small.toml --shard 1/2 --export both --store both",
        "run small.toml --shard 1/2 --export store",
    ] {
        fs::create_dir_all(place.path("store")).unwrap();
        assert_eq!(place.call("run small.toml --store store").code, 0);
        let said = shard(&place, line);
        assert_eq!(said.code, 1, "{line}");
        assert!(said.err.contains("a store hides the exports in its directory"), "{}", said.err);
    }
}

/// A cluster may have the file of a study in another place on each machine.
#[test]
fn a_shard_goes_on_under_another_path_of_its_study() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(shard(&place, "run small.toml --shard 1/2 --export e --until 1ms").code, 75);
    fs::create_dir(place.path("there")).unwrap();
    fs::copy(place.path("small.toml"), place.path("there/small.toml")).unwrap();
    let said = shard(&place, "run there/small.toml --shard 1/2 --export e");
    assert_eq!(said.code, 0, "{}", said.err);
    let verified = place.call("store verify --store e");
    assert_eq!(verified.code, 0, "{}{}", verified.out, verified.err);
}

/// Everything that is refused leaves no export behind.
#[test]
fn shards_that_fit_nothing_are_refused_in_words() {
    let place = Place::with("small.toml", SMALL);
    for (line, words) in [
        ("run small.toml --shard 0/2 --export e", "shards are counted from 1"),
        ("run small.toml --shard 3/2 --export e", "there is no shard 3 of 2"),
        ("run small.toml --shard 1/0 --export e", "1 to 65536 shards, and not 0"),
        ("run small.toml --shard auto --export e", "--shard auto works in an element of a job"),
        ("plan small.toml --shards 0", "0 is not in 1..=65536"),
        ("plan small.toml --shards 2 --shard 1/2", "cannot be used with"),
    ] {
        let said = shard(&place, line);
        assert_eq!(said.code, 1, "{line}");
        assert!(said.err.contains(words), "{line}: {}", said.err);
    }
    assert!(!place.path("e").exists());
    // An export of another number of shards, and one of another study of this name.
    assert_eq!(shard(&place, "run small.toml --shard 1/2 --export e").code, 0);
    fs::rename(place.path("e/small.1-of-2.tribosweep"), place.path("e/small.1-of-3.tribosweep"))
        .unwrap();
    let said = shard(&place, "run small.toml --shard 1/3 --export e");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("holds shard 1/2 of the study `small`"), "{}", said.err);
    place.write("other.toml", SMALL.replace("0.3", "0.25"));
    fs::remove_file(place.path("e/small.1-of-3.tribosweep")).unwrap();
    assert_eq!(shard(&place, "run small.toml --shard 1/2 --export e").code, 0);
    let said = shard(&place, "run other.toml --shard 1/2 --export e");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("holds another study called \"small\""), "{}", said.err);
}

/// A directory that somebody else has put in the place of the temporary store is not used.
#[test]
fn a_strange_temporary_directory_is_refused() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(shard(&place, "run small.toml --shard 1/2 --export e --until 1ms").code, 75);
    fs::create_dir(place.path("elsewhere")).unwrap();
    // The name, in which that of the exports has a part, is found where these cannot be written.
    place.write("f", "");
    let said = shard(&place, "run small.toml --shard 2/2 --export f");
    assert_eq!(said.code, 1, "{}", said.out);
    fs::remove_file(place.path("f")).unwrap();
    let left: Vec<_> = fs::read_dir(place.path("tmp")).unwrap().map(Result::unwrap).collect();
    assert_eq!(left.len(), 1, "what is not exported is kept");
    let local = left[0].path();
    fs::remove_dir_all(&local).unwrap();
    std::os::unix::fs::symlink(place.path("elsewhere"), &local).unwrap();
    let said = shard(&place, "run small.toml --shard 2/2 --export f");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("is not a directory of this user"), "{}", said.err);
    assert!(fs::read_dir(place.path("elsewhere")).unwrap().next().is_none());
}

#[test]
fn plans_show_what_each_shard_has() {
    let place = Place::with("small.toml", SMALL);
    let plan = place.json("plan small.toml --shards 4 --json");
    let shards = plan["shards"].as_array().unwrap();
    let points = |shard: &serde_json::Value| shard["points"].as_u64().unwrap();
    assert_eq!(shards.iter().map(points).sum::<u64>(), 6);
    for (index, listed) in (1..).zip(shards) {
        let alone = place.json(&format!("plan small.toml --shard {index}/4 --json"));
        assert_eq!(alone["points"], listed["points"]);
        assert_eq!(alone["shard"], format!("{index}/4"));
    }
    assert!(!Path::new(&place.path(".tribosweep")).exists());
}

/// A study that is too large to be listed is run, counted and read in parts.
#[test]
fn a_study_that_is_too_large_for_one_run_is_read_in_parts() {
    let axis = |name: &str, from: &str, to: &str| {
        format!("\"{name}\" = {{ from = {from}, to = {to}, count = 1100 }}\n")
    };
    let (head, _) = SMALL.split_once("[sweep]").unwrap();
    let sweep =
        [axis("friction.mu", "0.1", "0.9"), axis("foundation.base.shear_modulus", "1e9", "9e9")];
    let place = Place::with("large.toml", format!("{head}[sweep]\n{}", sweep.concat()));
    let said = place.call("run large.toml");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("run the study in 7 shards or more"), "{}", said.err);
    let said = place.call("run large.toml --shard 1/2");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("needs more shards"), "{}", said.err);
    let said = shard(&place, "run large.toml --shard 50000/50000 --export exports");
    assert_eq!(said.code, 0, "{}", said.err);
    let said = place.call("query small --store exports");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("query small --shard 1/7 --store exports"), "{}", said.err);
    let rows = place.call("query small --shard 50000/50000 --format csv --store exports");
    assert_eq!((rows.code, rows.out.lines().count()), (0, 25), "{}{}", rows.out, rows.err);
    assert!(rows.out.lines().skip(1).all(|row| row.ends_with("certified")), "{}", rows.out);
    let status = place.call("status --store exports");
    assert_eq!(status.code, 0, "{}", status.err);
    for words in ["1210000", "1 of 50000 shards finished", "24 jobs certified"] {
        assert!(status.out.contains(words), "{words}: {}", status.out);
    }
}
