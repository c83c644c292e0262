//! The scripts of an array of shards and of the merge after it.

use std::path::Path;

use wording::shell_word;

use crate::slurm::time_limit::TimeLimit;

/// The resources and options of the jobs.
#[derive(Clone, Debug)]
pub(crate) struct Resources {
    /// The processors of a shard.
    pub(crate) cpus: u32,
    /// The memory of a shard as `sbatch` has it.
    pub(crate) memory: Option<String>,
    /// The time of a shard.
    pub(crate) time: Option<TimeLimit>,
    /// The memory of the merge as `sbatch` has it.
    pub(crate) merge_memory: Option<String>,
    /// The time of the merge.
    pub(crate) merge_time: Option<TimeLimit>,
    /// The partition of all jobs.
    pub(crate) partition: Option<String>,
    /// The account of all jobs.
    pub(crate) account: Option<String>,
    /// The wish to have a node for a shard alone.
    pub(crate) exclusive: bool,
    /// The other options of all jobs, checked by [`check_passed`](super::check_passed).
    pub(crate) passed: Vec<String>,
}

/// The scripts of a study, with what they need to know. Paths are absolute, or relative to the
/// directory in which the scripts lie.
#[derive(Clone, Debug)]
pub(crate) struct Scripts<'s> {
    /// The name of the study.
    pub(crate) name: &'s str,
    pub(crate) shards: u32,
    /// The program on the nodes.
    pub(crate) program: &'s Path,
    /// The study file.
    pub(crate) study: &'s Path,
    /// The directory of the exports.
    pub(crate) exports: &'s Path,
    /// The file with the results of all shards.
    pub(crate) merged: &'s Path,
    pub(crate) resources: &'s Resources,
    /// The time before the end at which a shard is told to stop \[s\].
    pub(crate) lead: u64,
    /// The number of times that a shard may start again.
    pub(crate) restarts: u32,
}

/// The part of the array's script that is the same for all studies.
const SHARD: &str = include_str!("script/shard.sh");

/// The part of the merge's script that is the same for all studies.
const MERGE: &str = include_str!("script/merge.sh");

impl Scripts<'_> {
    /// Returns the script of an element of the array, which is a shard.
    pub(crate) fn array(&self) -> String {
        let Resources { cpus, memory, time, exclusive, .. } = self.resources;
        let mut options = vec![
            format!("--job-name={}", self.name),
            "--nodes=1".to_owned(),
            "--ntasks=1".to_owned(),
            format!("--cpus-per-task={cpus}"),
        ];
        options.extend(memory.iter().map(|memory| format!("--mem={memory}")));
        options.extend(time.iter().map(|time| format!("--time={time}")));
        if *exclusive {
            options.push("--exclusive".to_owned());
        }
        options.push(format!("--signal=B:USR1@{}", self.lead));
        options.extend(self.common("log/%A_%a.log"));
        let settings = [
            self.program_line(),
            assignment("study", self.study),
            assignment("exports", self.exports),
            format!("shards={}\n", self.shards),
            format!("most_restarts={}\n", self.restarts),
        ];
        let title = format!(
            "A shard of the study {} in each element of an array. By hand, shards 1 to 4 are:\n\
             #   sbatch --array=0-3 array.sh 1",
            self.name
        );
        script(&title, &options, &settings.concat(), SHARD)
    }

    /// Returns the script that merges the exports of the shards.
    pub(crate) fn merge(&self) -> String {
        let mut options = vec![
            format!("--job-name={}-merge", self.name),
            "--nodes=1".to_owned(),
            "--ntasks=1".to_owned(),
            "--cpus-per-task=1".to_owned(),
        ];
        let Resources { merge_memory, merge_time, .. } = self.resources;
        options.extend(merge_memory.iter().map(|memory| format!("--mem={memory}")));
        options.extend(merge_time.iter().map(|time| format!("--time={time}")));
        options.extend(self.common("log/merge-%j.log"));
        let settings = [
            self.program_line(),
            assignment("exports", self.exports),
            assignment("merged", self.merged),
        ];
        let title = format!("Merges the shards of the study {}, as often as you like.", self.name);
        script(&title, &options, &settings.concat(), MERGE)
    }

    /// Returns the options of both scripts. What a job says goes to `log`.
    fn common(&self, log: &str) -> Vec<String> {
        let Resources { partition, account, passed, .. } = self.resources;
        let mut options = vec![
            "--requeue".to_owned(),
            "--open-mode=append".to_owned(),
            format!("--output={log}"),
        ];
        options.extend(partition.iter().map(|partition| format!("--partition={partition}")));
        options.extend(account.iter().map(|account| format!("--account={account}")));
        options.extend(passed.iter().cloned());
        options
    }

    fn program_line(&self) -> String {
        assignment("program", self.program)
    }
}

/// Returns a script of bash.
fn script(title: &str, options: &[String], settings: &str, body: &str) -> String {
    let options: String =
        options.iter().map(|option| format!("#SBATCH {}\n", option_word(option))).collect();
    format!(
        "#!/bin/bash\n# {title}\n# tribosweep {} has written this.\n{options}set -eu\n\n\
         {settings}\n{body}",
        env!("CARGO_PKG_VERSION")
    )
}

/// Returns an option as one word of a command, of which only the value is quoted.
pub(crate) fn option_word(option: &str) -> String {
    let is_name =
        |name: &str| name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
    match option.split_once('=') {
        Some((name, value)) if is_name(name) => format!("{name}={}", shell_word(value)),
        _ => shell_word(option),
    }
}

/// Returns the line that gives a variable a path.
fn assignment(variable: &str, path: &Path) -> String {
    format!("{variable}={}\n", shell_word(wording::file_argument(path)))
}
