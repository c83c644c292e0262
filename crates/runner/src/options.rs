//! How to run.

use std::ffi::OsString;
use std::time::Duration;

use crate::error::RunError;

/// How to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Worker processes at a time, at least 1.
    pub workers: usize,
    /// Program and arguments that start a worker; [`WorkerArguments`](crate::WorkerArguments) are appended as one argument.
    pub worker_command: Vec<OsString>,
    /// Bytes that all jobs which run at the same time may need together, by prediction. A job that
    /// needs more by itself is quarantined at once.
    pub memory_limit: u64,
    /// Bytes of address space that a worker may use beyond `memory_limit`: its program, stacks,
    /// shared memory.
    pub address_space_margin: u64,
    /// Failed attempts after which a job is quarantined, at least 1.
    pub attempts: u32,
    /// How long a worker may take before it asks for its first job.
    pub start_timeout: Duration,
    /// How often a busy worker gives a sign of life.
    pub heartbeat: Duration,
    /// Without one for so long, a busy worker is killed.
    pub silence: Duration,
    /// A worker that finished nothing for `grace + patience × predicted` is killed.
    pub grace: Duration,
    /// See `grace`.
    pub patience: f64,
}

impl Options {
    /// The usual options: one worker per core, three attempts, deadlines of one minute plus thirty
    /// times the prediction.
    pub fn new(worker_command: Vec<OsString>, memory_limit: u64) -> Options {
        Options {
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            worker_command,
            memory_limit,
            address_space_margin: 4 << 30,
            attempts: 3,
            start_timeout: Duration::from_secs(60),
            heartbeat: Duration::from_secs(1),
            silence: Duration::from_secs(30),
            grace: Duration::from_secs(60),
            patience: 30.0,
        }
    }

    pub(crate) fn command_line(&self) -> String {
        self.worker_command.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    pub(crate) fn checked(&self) -> Result<(), RunError> {
        let refuse = |what| Err(RunError::Options { what });
        if self.workers == 0 {
            return refuse("workers is 0, at least 1 is needed");
        }
        if self.worker_command.is_empty() {
            return refuse(
                "worker_command is empty, it should name the program that calls runner::work",
            );
        }
        if self.attempts == 0 {
            return refuse("attempts is 0, at least 1 is needed");
        }
        if !(self.patience.is_finite() && self.patience >= 0.0) {
            return refuse("patience should be a finite number, 0 or more");
        }
        if self.heartbeat.is_zero() || self.silence <= self.heartbeat {
            return refuse("silence should be longer than heartbeat, and heartbeat longer than 0");
        }
        Ok(())
    }
}
