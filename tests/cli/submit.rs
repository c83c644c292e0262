//! `submit` with programs of Slurm that only write down what they are told.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use serde_json::Value;

use crate::place::{ONE, Place, SMALL, Said};

/// A map of 2 × 2 heights.
const MAP: &str = "0 1\n1 2\n";

/// What the programs of Slurm do. They keep what they are told in `told`, and read limits and
/// refusals from files.
const PROGRAMS: [(&str, &str); 4] = [
    ("scontrol", "read -r size < size; echo \"MaxArraySize = $size\"; echo 'MaxJobCount = 50'"),
    (
        "sbatch",
        "read -r last < last; job=$((last + 1)); echo \"sbatch $*\" >> told\n\
         if [ \"$job\" = \"$(cat refused)\" ]; then echo 'sbatch: error: Invalid account' >&2; exit 1; fi\n\
         echo $job > last; echo \"$job;cluster\"",
    ),
    ("squeue", "echo \"squeue $*\" >> told; cat queued"),
    ("scancel", "echo \"scancel $*\" >> told"),
];

/// A directory with a study and a Slurm of its own.
struct Site(Place);

impl Site {
    fn with(file: &str, text: &str) -> Self {
        let place = Place::with(file, text);
        fs::create_dir_all(place.path("bin")).unwrap();
        fs::create_dir_all(place.path("slurm")).unwrap();
        for (name, body) in PROGRAMS {
            let path = place.path(&format!("bin/{name}"));
            let slurm = place.path("slurm");
            fs::write(&path, format!("#!/bin/sh\ncd '{}'\n{body}\n", slurm.display())).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        let site = Self(place);
        for (file, text) in [("size", "8\n"), ("last", "100\n"), ("refused", ""), ("queued", "")] {
            site.set(file, text);
        }
        site
    }

    fn set(&self, file: &str, text: &str) {
        self.0.write(&format!("slurm/{file}"), text);
    }

    /// Runs a command that finds the programs of this Slurm, or none.
    fn call(&self, line: &str, programs: &str) -> Said {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut command = self.0.command(&words);
        let path = self.0.path(programs).display().to_string();
        let path = if programs == "bin" { format!("{path}:/usr/bin:/bin") } else { path };
        self.0.said(command.env("PATH", path))
    }

    fn submit(&self, line: &str) -> Said {
        self.call(&format!("submit {line}"), "bin")
    }

    /// Returns what the programs were told since the last time.
    fn told(&self) -> String {
        let path = self.0.path("slurm/told");
        let told = fs::read_to_string(&path).unwrap_or_default();
        let _ = fs::remove_file(path);
        told
    }

    fn read(&self, file: &str) -> String {
        fs::read_to_string(self.0.path(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }
}

/// A study of as many jobs as asked for, which take next to no time.
fn study(jobs: usize) -> String {
    let values: Vec<String> = (1..=jobs).map(|n| format!("{}", n as f64 / 100.0)).collect();
    format!(
        "name = \"many\"\n[scene]\nfoundation.base = {{ shear_modulus = \"80 GPa\", poisson = 0.3 }}\n\
         punch = {{ shape = \"flat-disk\", radius = \"1 mm\" }}\n\
         loading.steps = [{{ approach = \"1 um\" }}]\n[numerics]\nmesh = 4\n\
         [sweep]\n\"friction.mu\" = [{}]\n",
        values.join(", ")
    )
}

#[test]
fn a_dry_run_shows_everything_and_leaves_nothing() {
    let site = Site::with("small.toml", SMALL);
    let before = site.0.files();
    let line = "submit small.toml --shards 4 --cpus-per-task 8 --mem 16G --time 2:00:00 \
                --partition short --account physics --dry-run -- --qos=long --comment=it's";
    let said = site.call(line, "bin");
    insta::assert_snapshot!(said.transcript());
    assert_eq!(site.0.files(), before);
    let said = site.call("submit small.toml --shards 2 --dry-run", "none");
    assert_eq!(said.code, 0);
    assert_eq!(said.err, "Slurm is not installed here: MaxArraySize is taken for 1001\n");
    assert_eq!(site.0.files(), before);
}

#[test]
fn more_shards_than_an_array_has_indices_take_several_arrays() {
    let site = Site::with("many.toml", &study(20));
    let said = site.submit("many.toml --shards 20 --cpus-per-task 2 --json");
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(
        site.told(),
        "sbatch --parsable --array=0-7 array.sh 1\n\
         sbatch --parsable --array=0-7 array.sh 9\n\
         sbatch --parsable --array=0-3 array.sh 17\n\
         sbatch --parsable --dependency=afterany:101:102:103 --kill-on-invalid-dep=yes merge.sh\n"
    );
    let report: Value = serde_json::from_str(&said.out).unwrap();
    let arrays = report["arrays"].as_array().unwrap();
    let shards = arrays.iter().flat_map(|array| array["shards"].as_array().unwrap());
    assert!(shards.map(|shard| shard.as_u64().unwrap()).eq(1..=20));
    assert_eq!(report["merge"]["job"], "104");
    assert_eq!(report["merged"], "many-shards/many.tribosweep");
    let submission: Value =
        serde_json::from_str(&site.read("many-shards/submission.json")).unwrap();
    assert_eq!(submission["jobs"], serde_json::json!(["101", "102", "103", "104"]));

    // At most so many nodes at a time, whatever the number of arrays.
    let said = site.submit("many.toml --shards 20 --nodes 3 --directory other/place/ --only 2,9,3");
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(
        site.told(),
        "sbatch --parsable --array=1-2%3 array.sh 1\n\
         sbatch --parsable --array=0%3 --dependency=afterany:105 array.sh 9\n\
         sbatch --parsable --dependency=afterany:105:106 --kill-on-invalid-dep=yes merge.sh\n"
    );
    assert!(said.out.starts_with("many: 3 of 20 shards submitted in 2 arrays"), "{}", said.out);
}

#[test]
fn a_copy_of_the_study_is_submitted_with_the_files_that_it_names() {
    let site = Site::with("unused", "");
    fs::create_dir_all(site.0.path("deep/er")).unwrap();
    fs::create_dir_all(site.0.path("deep/maps")).unwrap();
    let text = ONE.replace("rough.csv", "er/../../maps/map.txt");
    fs::create_dir_all(site.0.path("deep/er/er")).unwrap();
    site.0.write("deep/er/study.toml", &text);
    site.0.write("deep/maps/map.txt", MAP);
    let said = site.submit("deep/er/study.toml --shards 1");
    assert_eq!(said.code, 0, "{}", said.err);
    let file = "one-shards/study/in/one.toml";
    assert_eq!(site.read(file), text);
    assert!(site.read("one-shards/array.sh").contains("\nstudy=study/in/one.toml\n"));

    // The copy is the same study, though the files it came from are gone.
    let plan = |file: &str| site.call(&format!("plan {file} --json"), "bin").out;
    let before = plan("deep/er/study.toml");
    site.0.write("deep/maps/map.txt", "5 4\n4 3\n");
    assert_eq!(plan(file), before);
    site.told();

    // The same submission goes on, with other resources; one of the edited study does not mix in.
    let said = site.submit("deep/er/study.toml --shards 1");
    assert_eq!((said.code, site.told().as_str()), (1, ""));
    assert!(said.err.contains("belongs to another study, or to this one before it was edited"));
    site.0.write("deep/maps/map.txt", MAP);
    let said = site.submit("deep/er/study.toml --shards 1 --time 45");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(site.read("one-shards/array.sh").contains("--time=45\n"));
    site.told();
    site.set("queued", "103_0 RUNNING\n");
    let said = site.submit("deep/er/study.toml --shards 1");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("still queued or running: 1 job"), "{}", said.err);
    assert!(said.err.ends_with("cancel them by: scancel 103,104\n"), "{}", said.err);
    assert_eq!(site.told(), "squeue --noheader --format=%i %T --jobs=103,104\n");
}

#[test]
fn shards_that_are_finished_are_not_submitted_again() {
    let site = Site::with("many.toml", &study(20));
    assert_eq!(site.submit("many.toml --shards 10").code, 0);
    let study = "many-shards/study/many.toml";
    for shard in [1, 4, 9] {
        let line = format!("run {study} --shard {shard}/10 --export many-shards/exports");
        assert_eq!(site.0.call(&line).code, 0);
    }
    site.told();
    assert_eq!(site.submit("many.toml --shards 10").code, 0);
    assert!(
        site.told()
            .contains("--array=1-2,4-7 array.sh 1\nsbatch --parsable --array=1 array.sh 9\n")
    );
    assert_eq!(site.submit("many.toml --shards 10 --only 4").code, 0);
    assert!(site.told().contains("--array=3 array.sh 1\n"));
    for shard in (1..=10).filter(|shard| ![1, 4, 9].contains(shard)) {
        let line = format!("run {study} --shard {shard}/10 --export many-shards/exports");
        assert_eq!(site.0.call(&line).code, 0);
    }
    let said = site.submit("many.toml --shards 10");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.starts_with("many: all shards are finished, only their merge submitted"));
    assert!(site.told().ends_with("sbatch --parsable merge.sh\n"));
}

#[test]
fn a_file_named_by_an_absolute_path_stays_and_is_said() {
    let site = Site::with("unused", "");
    let map = site.0.path("map.txt");
    site.0.write("map.txt", MAP);
    let text = ONE.replace("rough.csv", map.to_str().unwrap());
    site.0.write("study.toml", &text);
    let said = site.submit("study.toml --shards 1 --dry-run");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.err.contains("[directory]/map.txt is named by an absolute path and not copied"),
        "{}",
        said.err
    );
}

#[test]
fn what_the_scheduler_refuses_leaves_nothing() {
    let site = Site::with("many.toml", &study(20));
    let before = site.0.files();
    site.set("refused", "101");
    let said = site.submit("many.toml --shards 20");
    assert_eq!(said.code, 1);
    assert_eq!(
        said.err,
        "error: sbatch refuses `sbatch --parsable --array=0-7 array.sh 1`: sbatch: error: Invalid \
         account\n"
    );
    // The merge is refused when the arrays are queued already.
    site.told();
    site.set("refused", "104");
    let said = site.submit("many.toml --shards 20");
    assert_eq!(said.code, 1);
    assert!(
        said.err.starts_with("error: 3 arrays submitted before were cancelled: sbatch refuses")
    );
    assert!(site.told().ends_with("merge.sh\nscancel 101 102 103\n"));
    site.set("refused", "");
    site.set("last", "100\n");
    assert_eq!(site.0.files(), before);
}

#[test]
fn mistakes_are_refused_before_anything_is_written() {
    let site = Site::with("small.toml", SMALL);
    site.0.write("bad.toml", "name = \"bad\"\n[scene]\npunch.shape = \"cube\"\n");
    fs::create_dir_all(site.0.path("small-shards")).unwrap();
    site.0.write("small-shards/precious", "");
    let before = site.0.files();
    let lines = [
        "small.toml",
        "small.toml --shards 0",
        "small.toml --shards 7",
        "small.toml --shards 3 --only 4",
        "small.toml --shards 3 --time 55m",
        "small.toml --shards 3 --time soon",
        "small.toml --shards 3 --mem 8GiB",
        "small.toml --shards 3 --engine pbs",
        "small.toml --shards 3 --array=1-3",
        "small.toml --shards 3 -- --array=1-3",
        "small.toml --shards 3 -- --dep=afterok:7",
        "small.toml --shards 3 -- --wrap=ls",
        "small.toml --shards 3 -- -t5",
        "small.toml --shards 3 -- --constraint haswell",
        "small.toml --shards 3 -- script.sh",
        "small.toml --shards 3",
        "small.toml --shards 3 --directory 50%off",
        "bad.toml --shards 1",
        "none.toml --shards 1",
    ];
    let said: String = lines
        .iter()
        .map(|line| format!("$ tribosweep submit {line}\n{}\n", site.submit(line).transcript()))
        .collect();
    insta::assert_snapshot!(said);
    for line in lines {
        assert_eq!(site.submit(line).code, 1, "{line}");
    }
    let said = site.call("submit small.toml --shards 3 --directory new", "none");
    assert_eq!(said.code, 1);
    assert!(said.err.starts_with("error: Slurm is not installed here"), "{}", said.err);
    site.set("size", "0\n");
    let said = site.submit("small.toml --shards 3 --directory new");
    assert_eq!(said.err, "error: this cluster allows no arrays: its MaxArraySize is 0\n");
    site.set("size", "8\n");
    assert_eq!(site.told(), "", "nothing was submitted");
    assert_eq!(site.0.files(), before);
    site.0.write("large.toml", study(60));
    let said = site.submit("large.toml --shards 50");
    assert!(said.err.contains("at most 50 jobs at a time (MaxJobCount)"), "{}", said.err);
}

#[test]
fn times_of_different_nodes_are_warned_of() {
    let cost = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/sweeps/cost.toml"));
    // A ladder stays in one shard, so that there must be two.
    let ladders = cost.replace("[sweep]\n", "[sweep]\nfriction.mu = [0.1, 0.3]\n");
    let site = Site::with("cost.toml", cost);
    site.0.write("ladders.toml", &ladders);
    let said = site.submit("ladders.toml --shards 2 --dry-run");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("those of different nodes do not compare"), "{}", said.err);
    assert!(said.out.contains("#SBATCH --exclusive\n"));
    let said = site.submit("cost.toml --shards 1 --dry-run");
    assert!(!said.err.contains("do not compare"), "{}", said.err);
}

#[test]
fn a_shard_is_told_to_stop_in_less_than_half_of_its_time() {
    let site = Site::with("small.toml", SMALL);
    for (time, signal) in [("1", 29), ("2", 59), ("0:30", 29), ("4:00", 119), ("1:00:00", 120)] {
        let said = site.submit(&format!("small.toml --shards 1 --time {time} --dry-run"));
        assert!(said.out.contains(&format!("#SBATCH --signal=B:USR1@{signal}\n")), "{time}");
    }
    let said = site.submit("small.toml --shards 1 --dry-run");
    assert!(said.out.contains("#SBATCH --signal=B:USR1@120\n"));
}
