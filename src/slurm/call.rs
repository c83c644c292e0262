//! The calls of `sbatch` that submit arrays of shards and the merge after them.

use serde::Serialize;

use crate::slurm::array::Array;
use crate::slurm::script::option_word;

/// The script of an array.
pub(crate) const ARRAY_SCRIPT: &str = "array.sh";

/// The script of the merge.
pub(crate) const MERGE_SCRIPT: &str = "merge.sh";

/// A call of `sbatch`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SbatchCall {
    /// The shards of an array, empty for the merge.
    pub(crate) shards: Vec<u32>,
    /// The words after `sbatch`.
    #[serde(skip)]
    pub(crate) words: Vec<String>,
    /// The command, ready to be pasted in the directory of the scripts.
    pub(crate) command: String,
    /// The number that the scheduler gave; `None` in a dry run.
    pub(crate) job: Option<String>,
}

/// Returns the call that submits an array. If only so many elements may run at a time, an array
/// waits for the one before it.
pub(crate) fn array_call(
    array: &Array,
    at_a_time: Option<u32>,
    before: Option<&SbatchCall>,
) -> SbatchCall {
    let mut words = vec!["--parsable".to_owned(), format!("--array={}", array.option(at_a_time))];
    if let (Some(before), Some(_)) = (before, at_a_time) {
        words.push(depend(&[before]));
    }
    words.extend([ARRAY_SCRIPT.to_owned(), array.first.to_string()]);
    call(array.shards().collect(), words)
}

/// Returns the call that submits the merge after all arrays, however they end; without an array,
/// every shard is finished.
pub(crate) fn merge_call(arrays: &[SbatchCall]) -> SbatchCall {
    let mut words = vec!["--parsable".to_owned()];
    if !arrays.is_empty() {
        words.push(depend(&arrays.iter().collect::<Vec<_>>()));
        words.push("--kill-on-invalid-dep=yes".to_owned());
    }
    words.push(MERGE_SCRIPT.to_owned());
    call(Vec::new(), words)
}

fn call(shards: Vec<u32>, words: Vec<String>) -> SbatchCall {
    let shown: Vec<String> = words.iter().map(|word| option_word(word)).collect();
    SbatchCall { shards, command: format!("sbatch {}", shown.join(" ")), words, job: None }
}

/// Returns the option that lets a job wait for the end of others. Jobs that have no number yet are
/// called by their place.
fn depend(calls: &[&SbatchCall]) -> String {
    let mut option = "--dependency=afterany".to_owned();
    for (index, call) in calls.iter().enumerate() {
        let job = call.job.clone().unwrap_or_else(|| match calls {
            [_] => "ARRAY".to_owned(),
            _ => format!("ARRAY{}", index + 1),
        });
        option += &format!(":{job}");
    }
    option
}
