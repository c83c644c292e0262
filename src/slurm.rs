//! The words for Slurm's `sbatch`: arrays of shards, the scripts of their elements, times and
//! options. Nothing here runs a program or touches a file.
//!
//! A shard is an element of an array. The index of an element has a limit (`MaxArraySize`), so that
//! many shards take several arrays.

mod array;
mod call;
mod config;
mod passed;
mod script;
mod time_limit;

pub(crate) use array::{Array, arrays};
pub(crate) use call::{ARRAY_SCRIPT, MERGE_SCRIPT, SbatchCall, array_call, merge_call};
pub(crate) use config::ControllerConfig;
pub(crate) use passed::check_passed;
pub(crate) use script::{Resources, Scripts};
pub(crate) use time_limit::TimeLimit;
