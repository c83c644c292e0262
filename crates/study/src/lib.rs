//! What a study is: its file, its axes, its jobs and the record that a job leaves.
#![forbid(unsafe_code)]

pub mod job;

pub use job::{Job, JobKey};
