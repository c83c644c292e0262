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
    (
        "scontrol",
        "case $1:$2 in show:config) ;; show:job)\n\
         if [ -s silent ]; then sed -i 1d silent; echo 'no answer' >&2; exit 1; fi\n\
         cat state; exit ;; *) echo \"scontrol $*\" >> told-by-jobs; exit ;; esac\n\
         read -r size < size; echo \"MaxArraySize = $size\"; echo 'MaxJobCount = 50'",
    ),
    (
        "sbatch",
        "read -r last < last; job=$((last + 1)); echo \"sbatch $*\" >> told\n\
         if [ -f environment ]; then env | grep '^S[A-Z]*_' > environment; fi\n\
         if [ \"$job\" = \"$(cat refused)\" ]; then echo 'sbatch: error: Invalid account' >&2; exit 1; fi\n\
         echo $job > last; echo \"$job;cluster\"",
    ),
    (
        "squeue",
        "echo \"squeue $*\" >> told; cat queued\n\
         if [ -s lost ]; then cat lost >&2; exit 1; fi",
    ),
    ("scancel", "echo \"scancel $*\" >> told; if [ -s lost ]; then cat lost >&2; exit 1; fi"),
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
        for (file, text) in [
            ("size", "8\n"),
            ("last", "100\n"),
            ("refused", ""),
            ("queued", ""),
            ("lost", ""),
            ("silent", ""),
            ("state", "JobState=RUNNING\n"),
        ] {
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

/// A study of 600 000 points.
fn huge() -> String {
    study(1).replace("\"friction.mu\" = [0.01]", "\"friction.mu\" = { from = 0.1, to = 0.9, count = 800 }\nfoundation.base.poisson = { from = 0, to = 0.45, count = 750 }").replace("\"many\"", "\"huge\"")
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
        said.err.starts_with(
            "error: jobs 101, 102, 103, submitted before, were cancelled: sbatch refuses"
        ),
        "{}",
        said.err
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
    site.0.write("huge.toml", huge());
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
        "huge.toml --shards 2",
        "small.toml --shards 3 --merge-mem much",
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

#[test]
fn a_submission_that_cannot_be_taken_back_is_remembered() {
    let site = Site::with("many.toml", &study(20));
    site.set("refused", "103");
    site.set("lost", "scancel: error: Unable to contact slurm controller\n");
    let said = site.submit("many.toml --shards 20");
    assert_eq!(said.code, 1);
    assert!(
        said.err.starts_with(
            "error: jobs 101, 102, submitted before, could not be cancelled (scancel says scancel: \
             error: Unable to contact slurm controller); cancel by: scancel 101 102: sbatch refuses"
        ),
        "{}",
        said.err
    );
    let submission: Value =
        serde_json::from_str(&site.read("many-shards/submission.json")).unwrap();
    assert_eq!(submission["jobs"], serde_json::json!(["101", "102"]));

    // They still run, or may do so as long as the controller does not answer.
    site.set("refused", "");
    site.told();
    let said = site.submit("many.toml --shards 20");
    assert_eq!(said.code, 1);
    assert!(said.err.contains("not known whether the jobs 101, 102"), "{}", said.err);
    site.set("lost", "");
    site.set("queued", "101_0 RUNNING\n");
    let said = site.submit("many.toml --shards 20");
    assert!(said.err.ends_with("cancel them by: scancel 101,102\n"), "{}", said.err);
    assert!(!site.told().contains("sbatch"));
    // The controller has forgotten them, which is not a failure.
    site.set("queued", "");
    site.set("lost", "slurm_load_jobs error: Invalid job id specified\n");
    let said = site.submit("many.toml --shards 20");
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn a_shard_of_an_edited_study_is_not_finished_by_the_export_of_the_former() {
    let site = Site::with("many.toml", &study(20));
    let run = "run many.toml --shard 1/10 --export exports";
    assert_eq!(site.0.call(run).code, 0);
    let line = "many.toml --shards 10 --exports exports --directory";
    assert_eq!(site.submit(&format!("{line} first")).code, 0);
    assert!(site.told().starts_with("sbatch --parsable --array=1-7 array.sh 1\n"));
    site.0.write("many.toml", study(20).replace("80 GPa", "70 GPa"));
    assert_eq!(site.submit(&format!("{line} second")).code, 0);
    assert!(site.told().starts_with("sbatch --parsable --array=0-7 array.sh 1\n"));
}

#[test]
fn the_merge_has_time_and_memory_of_its_own() {
    let site = Site::with("small.toml", SMALL);
    let line = "small.toml --shards 1 --mem 2G --time 30 --dry-run";
    let merge =
        |said: Said| said.out.split("== small-shards/merge.sh ==").nth(1).unwrap().to_owned();
    let script = merge(site.submit(line));
    assert!(script.contains("#SBATCH --mem=2G\n") && script.contains("#SBATCH --time=30\n"));
    let said = site.submit(&format!("{line} --merge-mem 64G --merge-time 4:00:00"));
    assert_eq!(said.out.matches("#SBATCH --mem=2G\n").count(), 1, "the shards keep theirs");
    let script = merge(said);
    assert!(script.contains("#SBATCH --mem=64G\n"), "{script}");
    assert!(script.contains("#SBATCH --time=4:00:00\n"), "{script}");
}

#[test]
fn variables_do_not_overrule_what_is_submitted() {
    let site = Site::with("small.toml", SMALL);
    site.set("environment", "");
    let submit = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut command = site.0.command(&words);
        command.env("PATH", format!("{}:/usr/bin:/bin", site.0.path("bin").display()));
        for variable in ["SBATCH_CLUSTERS", "SLURM_CLUSTERS", "SBATCH_MEM_PER_CPU", "SBATCH_QOS"] {
            command.env(variable, "7");
        }
        assert_eq!(site.0.said(&mut command).code, 0);
        let environment = site.read("slurm/environment");
        let names = environment.lines().filter_map(|line| line.split_once('='));
        let is_slurm = |name: &&str| name.starts_with("SBATCH_") || name.starts_with("SLURM_");
        names
            .map(|(name, _)| name)
            .filter(is_slurm)
            .map(str::to_owned)
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(submit("submit small.toml --shards 1 --mem 2G"), "SBATCH_QOS");
    let both = submit("submit small.toml --shards 1 --directory other");
    assert_eq!(both.split(' ').count(), 2, "{both}");
    assert!(both.contains("SBATCH_MEM_PER_CPU"), "without --mem it is obeyed: {both}");
}

/// Runs the script of an array's first element as Slurm does, and returns what it said.
fn stint(site: &Site, restarts: u32) -> Said {
    let mut bash = std::process::Command::new("bash");
    bash.args(["array.sh", "1"]).current_dir(site.0.path("many-shards"));
    bash.env("PATH", format!("{}:/usr/bin:/bin", site.0.path("bin").display()));
    bash.env("SLURM_ARRAY_JOB_ID", "101").env("SLURM_ARRAY_TASK_ID", "0");
    bash.env("SLURM_RESTART_COUNT", restarts.to_string()).env("TMPDIR", site.0.path("tmp"));
    site.0.said(&mut bash)
}

/// A study that is submitted as one shard, whose program runs out of time before any job ends.
fn out_of_time() -> Site {
    let site = Site::with("many.toml", &study(20));
    fs::create_dir_all(site.0.path("tmp")).unwrap();
    assert_eq!(site.submit("many.toml --shards 1").code, 0);
    let script = site.read("many-shards/array.sh");
    let line = script.lines().find(|line| line.starts_with("program=")).unwrap();
    let program = line.strip_prefix("program=").unwrap();
    let stub = site.0.path("stub");
    fs::write(&stub, format!("#!/bin/sh\n[ \"$1\" != run ] || exit 75\nexec {program} \"$@\"\n"))
        .unwrap();
    fs::set_permissions(&stub, fs::Permissions::from_mode(0o755)).unwrap();
    let edited = script.replace(line, &format!("program='{}'", stub.display()));
    site.0.write("many-shards/array.sh", edited);
    site
}

#[test]
fn a_shard_of_which_no_job_ends_in_time_is_not_queued_for_ever() {
    let site = out_of_time();
    for restart in 0..3 {
        let said = stint(&site, restart);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        assert!(said.out.contains("is not finished, and queues again"), "{}", said.out);
    }
    let said = stint(&site, 3);
    assert_eq!(said.code, 75);
    assert!(
        said.out.ends_with("no job ended within the time, 3 times in a row: give more --time\n"),
        "{}",
        said.out
    );
    assert!(site.read("slurm/told-by-jobs").matches("scontrol requeue 101_0").count() == 3);

    // Submitted anew, it is tried again; results set the count back, and so does a stint that was
    // cut short by somebody else.
    for restart in [0, 1, 2] {
        assert_eq!(stint(&site, restart).code, 0);
    }
    let run = "run many-shards/study/many.toml --shard 1/1 --export many-shards/exports";
    assert_eq!(site.0.call(run).code, 0);
    for restart in [3, 4, 5] {
        let said = stint(&site, restart);
        assert!(said.out.contains("queues again"), "{}", said.out);
    }
    assert_eq!(stint(&site, 6).code, 75);
}

#[test]
fn a_controller_that_does_not_answer_is_asked_again() {
    let site = out_of_time();
    site.set("silent", "1\n");
    let said = stint(&site, 0);
    assert!(said.out.contains("queues again"), "{}{}", said.out, said.err);
    // What is not known is no reason to give up.
    site.set("silent", "1\n2\n3\n4\n5\n");
    let said = stint(&site, 1);
    assert!(said.out.contains("does not learn from the controller"), "{}", said.out);
    assert!(said.out.contains("queues again"), "{}", said.out);
    site.set("silent", "");
    site.set("state", "JobState=CANCELLED\n");
    let said = stint(&site, 0);
    assert!(said.out.contains("is not finished, and was cancelled"), "{}", said.out);
    assert_eq!(said.code, 75);
}
