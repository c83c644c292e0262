//! The options of a run are plain data with a check.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use crate::error::RunError;

/// The options of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The number of worker processes at a time, at least 1.
    pub workers: usize,
    /// The number of threads that a worker started by `worker_command` uses for a job, at least 1.
    pub threads: usize,
    /// The program and the arguments that start a worker.
    /// [`WorkerArguments`](crate::WorkerArguments) are appended as one argument.
    pub worker_command: Vec<OsString>,
    /// The directory through which jobs and results travel that are too large for a message, on the
    /// volume that keeps the results. The run makes it, and removes it with all that is in it. Only
    /// one run may use it at a time.
    pub bodies: PathBuf,
    /// The memory that all jobs which run at the same time may need together, by prediction
    /// \[bytes\]. A job that needs more by itself is left for another run.
    pub memory_limit: u64,
    /// The address space that a worker may use beyond `memory_limit` for its program, its stacks
    /// and shared memory \[bytes\].
    pub address_space_margin: u64,
    /// The number of failed attempts after which a job is quarantined, at least 1.
    pub attempts: u32,
    /// The time that a worker may take before it asks for its first job.
    pub start_timeout: Duration,
    /// The interval at which a busy worker gives a sign of life.
    pub heartbeat: Duration,
    /// The time after which a busy worker without a sign of life is killed.
    pub silence: Duration,
    /// The constant term of the deadline: a worker that finished nothing for `grace + patience ×
    /// predicted` is killed.
    pub grace: Duration,
    /// The factor of the predicted time in the deadline (see `grace`).
    pub patience: f64,
    /// The time since the start of the run after which no further job is begun, and into which a
    /// job must fit by prediction to be begun at all.
    pub until: Option<Duration>,
    /// The time that jobs in flight may still take after `until`, or after a request to end in
    /// time. Then they are given up, which is no attempt.
    pub overtime: Duration,
    /// It is true if one job is begun although `until` has passed or none fits, so that runs with
    /// too little time get on nevertheless.
    pub begins_one: bool,
}

impl Options {
    /// Returns the usual options: one worker per core, three attempts, deadlines of one minute plus
    /// thirty times the prediction, and no end of time. The jobs in flight have 20 s when somebody
    /// asks for an end, because batch systems kill 30 s after they have asked.
    pub fn new(worker_command: Vec<OsString>, bodies: PathBuf, memory_limit: u64) -> Options {
        Options {
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            threads: 1,
            worker_command,
            bodies,
            memory_limit,
            address_space_margin: 4 << 30,
            attempts: 3,
            start_timeout: Duration::from_secs(60),
            heartbeat: Duration::from_secs(1),
            silence: Duration::from_secs(30),
            grace: Duration::from_secs(60),
            patience: 30.0,
            until: None,
            overtime: Duration::from_secs(20),
            begins_one: true,
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
        if self.threads == 0 {
            return refuse("threads is 0, at least 1 is needed");
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
