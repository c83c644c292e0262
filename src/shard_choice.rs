//! The choice of a shard: by its numbers, or by what a scheduler tells the elements of a job array.

use std::env::VarError;

use answers::shards::{Shard, ShardError};
use anyhow::{Context, Result, bail};

/// A shard as the command line chooses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShardChoice {
    /// The shard itself.
    Given(Shard),
    /// The index and the number of the elements of a job array.
    Auto,
    /// The index of an element of a job array, of so many.
    AutoOf(u64),
}

/// Reads the choice of a shard.
pub(crate) fn shard_choice(text: &str) -> Result<ShardChoice, ShardError> {
    match text.split_once('/') {
        None if text == "auto" => Ok(ShardChoice::Auto),
        Some(("auto", count)) => {
            let count = count.parse().map_err(|_| ShardError::Form)?;
            Shard::new(1, count).map(|_| ShardChoice::AutoOf(count))
        }
        _ => text.parse().map(ShardChoice::Given),
    }
}

/// The variables by which a scheduler tells an element of a job array what it is.
struct Scheduler {
    name: &'static str,
    index: &'static str,
    /// The first index, if there is a variable that says it.
    first: Option<&'static str>,
    /// The last index, if there is a variable that says it.
    last: Option<&'static str>,
    /// The index of the first element where the scheduler alone decides that.
    counts_from: Option<u64>,
}

/// The schedulers. Their manuals: sbatch(1), OpenPBS qsub(1B), TORQUE qsub(1), LSF bsub(1), Grid
/// Engine qsub(1), Kubernetes "Indexed Job".
const SCHEDULERS: [Scheduler; 6] = [
    Scheduler {
        name: "Slurm",
        index: "SLURM_ARRAY_TASK_ID",
        first: Some("SLURM_ARRAY_TASK_MIN"),
        last: Some("SLURM_ARRAY_TASK_MAX"),
        counts_from: None,
    },
    Scheduler { name: "PBS", index: "PBS_ARRAY_INDEX", first: None, last: None, counts_from: None },
    Scheduler { name: "TORQUE", index: "PBS_ARRAYID", first: None, last: None, counts_from: None },
    // LSB_JOBINDEX_END is smaller when only some elements are submitted again.
    Scheduler { name: "LSF", index: "LSB_JOBINDEX", first: None, last: None, counts_from: None },
    Scheduler {
        name: "Grid Engine",
        index: "SGE_TASK_ID",
        first: Some("SGE_TASK_FIRST"),
        last: Some("SGE_TASK_LAST"),
        counts_from: None,
    },
    Scheduler {
        name: "Kubernetes",
        index: "JOB_COMPLETION_INDEX",
        first: None,
        last: None,
        counts_from: Some(0),
    },
];

/// A reader of environment variables.
type Variables<'a> = dyn Fn(&str) -> Result<String, VarError> + 'a;

impl ShardChoice {
    /// Returns the shard that is chosen in the environment of this process.
    ///
    /// # Errors
    /// This is no element of a job array, or one that is no shard.
    pub(crate) fn shard(self) -> Result<Shard> {
        self.shard_in(&|name| std::env::var(name))
    }

    fn shard_in(self, variables: &Variables<'_>) -> Result<Shard> {
        let count = match self {
            ShardChoice::Given(shard) => return Ok(shard),
            ShardChoice::Auto => None,
            ShardChoice::AutoOf(count) => Some(count),
        };
        // LSF sets an index of 0 outside of arrays, and Grid Engine says "undefined" there.
        let is_set = |scheduler: &&Scheduler| {
            let index = variables(scheduler.index).unwrap_or_default();
            let is_outside = scheduler.name == "LSF" && index == "0";
            !index.is_empty() && index != "undefined" && !is_outside
        };
        let set: Vec<&Scheduler> = SCHEDULERS.iter().filter(is_set).collect();
        match set[..] {
            [] => {
                let names = SCHEDULERS.map(|scheduler| scheduler.index).join(", ");
                bail!(
                    "--shard auto works in an element of a job array, where one of {names} is set; \
                     none is, so name the shard: --shard 3/16"
                )
            }
            [scheduler] => scheduler.shard(variables, count),
            [one, other, ..] => bail!(
                "both {} and {} are set, so it is not clear what --shard auto should take; name the \
                 shard: --shard 3/16",
                one.index,
                other.index
            ),
        }
    }
}

impl Scheduler {
    fn shard(&self, variables: &Variables<'_>, count: Option<u64>) -> Result<Shard> {
        let number = |name: &str| -> Result<u64> {
            let text = variables(name).unwrap_or_default();
            text.trim().parse().with_context(|| {
                format!("{name} of {} is `{}` and no whole number", self.name, text)
            })
        };
        let index = number(self.index)?;
        let known = |name: Option<&str>| name.map(number).transpose();
        let (from, count) = match (count, known(self.last)?) {
            // An element that is submitted again alone is the same one as before.
            (Some(count), _) => (self.counts_from.unwrap_or(1), count),
            (None, Some(last)) => {
                let first = known(self.first)?.unwrap_or(1);
                if first > 1 {
                    bail!(
                        "the job array begins at {first}, so --shard auto cannot tell how many \
                         shards there are; write --shard auto/N, with indices from 1"
                    );
                }
                self.require_all(variables, first, last)?;
                (first, (last + 1).saturating_sub(first))
            }
            (None, None) => bail!(
                "{} does not tell how many elements the job array has; write --shard auto/N",
                self.name
            ),
        };
        let position = (index + 1)
            .checked_sub(from)
            .with_context(|| format!("{} is {index}, but indices count from {from}", self.index))?;
        Shard::new(position, count).with_context(|| format!("{} is {index}", self.index))
    }

    /// Refuses a job array that leaves out elements between its first and its last one.
    fn require_all(&self, variables: &Variables<'_>, first: u64, last: u64) -> Result<()> {
        if self.name == "Slurm" {
            let elements = variables("SLURM_ARRAY_TASK_COUNT").unwrap_or_default();
            if elements.parse() != Ok((last + 1).saturating_sub(first)) {
                bail!(
                    "the job array has {elements} elements from {first} to {last}, so it leaves \
                     some out; write --shard auto/N"
                );
            }
        }
        // Only Grid Engine tells its step. Outside of arrays it says "undefined".
        let step = variables("SGE_TASK_STEPSIZE").unwrap_or_default();
        if self.name == "Grid Engine" && !["", "1", "undefined"].contains(&step.as_str()) {
            bail!(
                "the job array has a step of {step} between its elements from {first} to {last} \
                 (SGE_TASK_STEPSIZE); submit all of them, with a step of 1"
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns what is chosen with some variables, given as "NAME=value NAME=value".
    fn chosen(choice: &str, variables: &str) -> Result<String, String> {
        let read = |name: &str| {
            let pairs = variables.split_whitespace().filter_map(|pair| pair.split_once('='));
            pairs
                .filter(|(known, _)| *known == name)
                .map(|(_, value)| value.to_owned())
                .next()
                .ok_or(VarError::NotPresent)
        };
        let choice = shard_choice(choice).map_err(|error| error.to_string())?;
        choice.shard_in(&read).map(|shard| shard.to_string()).map_err(|error| format!("{error:#}"))
    }

    #[test]
    fn elements_of_job_arrays_are_shards() {
        let slurm = |id: u32, first: u32, last: u32, count: u32| {
            format!(
                "SLURM_ARRAY_TASK_ID={id} SLURM_ARRAY_TASK_MIN={first} \
                 SLURM_ARRAY_TASK_MAX={last} SLURM_ARRAY_TASK_COUNT={count}"
            )
        };
        for (choice, variables, shard) in [
            ("3/16", "", "3/16"),
            ("auto", &*slurm(3, 1, 16, 16), "3/16"),
            ("auto", &slurm(0, 0, 15, 16), "1/16"),
            ("auto/16", &slurm(7, 7, 7, 1), "7/16"),
            ("auto/16", "PBS_ARRAY_INDEX=3", "3/16"),
            ("auto/16", "PBS_ARRAYID=16", "16/16"),
            ("auto/16", "LSB_JOBINDEX=3 LSB_JOBINDEX_END=7", "3/16"),
            ("auto", "SGE_TASK_ID=3 SGE_TASK_FIRST=1 SGE_TASK_LAST=16", "3/16"),
            ("auto", "SGE_TASK_ID=3 SGE_TASK_FIRST=1 SGE_TASK_LAST=16 SGE_TASK_STEPSIZE=1", "3/16"),
            ("auto/16", "JOB_COMPLETION_INDEX=0", "1/16"),
            ("auto/16", "JOB_COMPLETION_INDEX=15 SGE_TASK_ID=undefined LSB_JOBINDEX=0", "16/16"),
        ] {
            assert_eq!(chosen(choice, variables).as_deref(), Ok(shard), "{choice} {variables}");
        }
    }

    /// Every shard of a partition can be exported.
    #[test]
    fn partitions_and_exports_have_the_same_bound() {
        assert_eq!(study::MOST_SHARDS, store::SHARD_LIMIT);
    }

    #[test]
    fn what_is_no_shard_is_refused_in_words() {
        for (choice, variables, words) in [
            ("auto", "", "--shard auto works in an element of a job array"),
            ("auto", "JOB_COMPLETION_INDEX=0", "write --shard auto/N"),
            // Two elements of sixteen were submitted again.
            ("auto", "LSB_JOBINDEX=3 LSB_JOBINDEX_END=7", "write --shard auto/N"),
            (
                "auto",
                "SGE_TASK_ID=3 SGE_TASK_FIRST=1 SGE_TASK_LAST=15 SGE_TASK_STEPSIZE=2",
                "a step of 2 between its elements from 1 to 15",
            ),
            ("auto", "SGE_TASK_ID=3 PBS_ARRAY_INDEX=3", "both PBS_ARRAY_INDEX and SGE_TASK_ID"),
            ("auto/4", "PBS_ARRAY_INDEX=5", "there is no shard 5 of 4"),
            ("auto/4", "PBS_ARRAY_INDEX=0", "counted from 1"),
            ("auto/4", "PBS_ARRAY_INDEX=x", "`x` and no whole number"),
            ("auto/0", "", "1 to 65536 shards, and not 0"),
            ("auto/x", "", "a shard is written INDEX/COUNT"),
            (
                "auto",
                "SLURM_ARRAY_TASK_ID=7 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_MAX=7 \
                 SLURM_ARRAY_TASK_COUNT=2",
                "leaves some out",
            ),
            (
                "auto",
                "SLURM_ARRAY_TASK_ID=7 SLURM_ARRAY_TASK_MIN=7 SLURM_ARRAY_TASK_MAX=7 \
                 SLURM_ARRAY_TASK_COUNT=1",
                "begins at 7",
            ),
        ] {
            let refused = chosen(choice, variables).unwrap_err();
            assert!(refused.contains(words), "{choice} {variables}: {refused}");
        }
    }
}
