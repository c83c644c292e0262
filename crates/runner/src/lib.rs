//! Runs jobs in worker processes, over shared memory, and keeps every result.
//!
//! One **coordinator** per run, inside [`run`], starts **workers**: child processes of the caller's
//! choosing that call [`work`]. They talk through iceoryx2, one channel per worker. The runner
//! knows neither what a job is ([`Work`]) nor where results go ([`Ledger`]); to it, both are bytes
//! under a [`JobKey`].
//!
//! What it promises:
//! - A result is acknowledged to nobody before [`Ledger::commit`] has returned for it, and is
//!   committed once.
//! - A worker that dies, hangs or stops is replaced, and its job tried again; a job that fails
//!   [`Options::attempts`] times is set aside with the reason, and the rest goes on.
//! - When the coordinator dies, its workers die with it; the next run removes what they left in
//!   shared memory.
//! - Waiting costs no processor time, on either side.
//!
//! Linux only: it needs pidfd, eventfd, `/proc`, `/dev/shm` and the parent-death signal.

mod coordinator;
pub mod event;
mod interrupt;
mod ipc;
mod lease;
mod protocol;
mod queue;
mod root;
mod run;
mod spill;
mod supervise;
mod transport;
mod worker;

pub use event::{Counts, Event, What};
pub use interrupt::Interrupt;
pub use ipc::{WorkerArguments, WorkerError, work};
pub use root::{RootError, sweep_leftovers};
pub use transport::TransportError;
pub use worker::Work;

use identity::JobKey;
use serde::Serialize;
use std::error::Error;
use std::ffi::OsString;
use std::time::Duration;

/// One job to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Its identity; no two tasks of a run share one.
    pub key: JobKey,
    /// What [`Work::run`] receives.
    pub payload: Vec<u8>,
    /// Tasks of one group share something costly and go to one worker one after another.
    pub group: u64,
    /// Predicted seconds. Orders jobs within a group and stretches deadlines; corrected by what
    /// jobs really take.
    pub cost: f64,
    /// Predicted bytes while it runs, on top of what every worker needs.
    pub memory: u64,
}

/// How a job ended for good.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// With what [`Work::run`] returned.
    Completed(Vec<u8>),
    /// Set aside.
    Quarantined {
        /// Why its last attempt failed.
        reason: String,
    },
}

/// A job that ended for good.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// Which job.
    pub key: JobKey,
    /// How it ended.
    pub verdict: Verdict,
    /// Who ran it; nobody, if its worker was lost or it was never run.
    pub worker: Option<u32>,
    /// Wall-clock seconds of the last attempt that came to an end, or 0.
    pub seconds: f64,
    /// Attempts, including a successful one.
    pub attempts: u32,
}

/// Where results are kept.
pub trait Ledger {
    /// Makes these durable; they are when it returns. An error ends the run.
    fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>>;
}

/// How to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Worker processes at a time, at least 1.
    pub workers: usize,
    /// Program and arguments that start a worker; [`WorkerArguments`] are appended as one argument.
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

    fn command_line(&self) -> String {
        self.worker_command.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    fn checked(&self) -> Result<(), RunError> {
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

/// What a run came to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Jobs with a durable result.
    pub done: usize,
    /// Jobs set aside.
    pub quarantined: usize,
    /// Jobs not run, because the run was interrupted.
    pub unfinished: usize,
    /// Attempts that failed.
    pub failures: usize,
    /// Workers that died or were killed.
    pub workers_lost: usize,
    /// Results dropped because their lease was no longer valid.
    pub stale_results: usize,
    /// Seconds that workers spent in jobs, added up.
    pub worker_seconds: f64,
    /// Seconds that the run took.
    pub seconds: f64,
    /// Somebody asked to stop.
    pub interrupted: bool,
}

/// Why a run could not go on. What was committed before stays committed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// An option makes no sense.
    #[error("cannot run with these options: {what}")]
    Options {
        /// Which one, and what would be right.
        what: &'static str,
    },
    /// Two tasks have one key.
    #[error("job {0} is given twice, but a key stands for one job")]
    Duplicate(JobKey),
    /// No place for the run's files.
    #[error("no directory for the run's files")]
    Root(#[from] RootError),
    /// Shared memory is nearly full; going on would end in SIGBUS.
    #[error("{path} has {free} bytes free, but {workers} workers need {needed}: free some, or use fewer workers", path = root::SHARED_MEMORY)]
    SharedMemory {
        /// Bytes that are free.
        free: u64,
        /// Bytes that are needed.
        needed: u64,
        /// For so many workers.
        workers: usize,
    },
    /// Workers do not start.
    #[error("workers cannot be started with `{command}`: {reason}")]
    Start {
        /// The command.
        command: String,
        /// What happened to the last one tried.
        reason: String,
    },
    /// The ledger did not take results.
    #[error("results could not be kept")]
    Ledger(#[source] Box<dyn Error + Send + Sync>),
    /// The coordinator lost its means to hear workers.
    #[error("communication with the workers failed")]
    Transport(#[from] TransportError),
    /// A rule of the coordinator is broken; only checked in debug builds.
    #[error("the coordinator contradicts itself: {0}")]
    Inconsistent(String),
}

/// Runs the tasks in worker processes until each is done or set aside, or `interrupt` is raised.
///
/// Call it on a thread that outlives the run: workers die when the thread that started them does.
/// `on_event` is called on that thread, between the coordinator's steps; it should not block.
pub fn run(
    tasks: Vec<Task>,
    ledger: &mut dyn Ledger,
    options: &Options,
    interrupt: &Interrupt,
    on_event: &mut dyn FnMut(&Event),
) -> Result<Summary, RunError> {
    options.checked()?;
    let mut keys: Vec<_> = tasks.iter().map(|task| task.key).collect();
    keys.sort_unstable();
    if let Some(pair) = keys.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(RunError::Duplicate(pair[0]));
    }
    sweep_leftovers();
    let mut transport = ipc::Processes::new(options, interrupt.clone())?;
    run::drive(&tasks, ledger, options, &mut transport, interrupt, on_event)
}
