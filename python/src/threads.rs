//! The threads that solve.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use contact::Cancellation;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::exception;

/// The stack of a thread, that of a program's first one.
const STACK: usize = 8 << 20;

/// The threads of a process.
struct ProcessThreads {
    process: u32,
    pool: Arc<ThreadPool>,
}

static THREADS: Mutex<Option<ProcessThreads>> = Mutex::new(None);

/// Returns the threads of this process. A child that was forked, as multiprocessing does, has none
/// of its parent's, and gets its own.
fn threads() -> Result<Arc<ThreadPool>> {
    let process = std::process::id();
    let mut threads = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(threads) = threads.as_ref().filter(|threads| threads.process == process) {
        return Ok(threads.pool.clone());
    }
    let pool = ThreadPoolBuilder::new().stack_size(STACK).build();
    let pool = Arc::new(pool.context("cannot start threads")?);
    let before = threads.replace(ProcessThreads { process, pool: pool.clone() });
    // The parent's threads do not run here, so that nobody could wait for their end.
    std::mem::forget(before);
    Ok(pool)
}

/// Does something on the threads of this process, while Python goes on.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T> + Send,
) -> PyResult<T> {
    let done = py.detach(|| threads()?.install(work));
    done.map_err(|error| exception(py, &error))
}

/// The time after which Python's signals are looked at again.
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// The time that work has to end after it was asked to. What has not ended then goes on to its end
/// on its thread, and what comes of it is dropped.
const PATIENCE: Duration = Duration::from_millis(800);

/// Does something on the threads of this process, while Python goes on. An interrupt (Ctrl-C)
/// requests its cancellation and is then raised.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Cancellation) -> Result<T> + Send + 'static,
) -> PyResult<T> {
    let cancellation = Cancellation::default();
    let requested = cancellation.clone();
    let (sender, mut receiver) = channel();
    let pool = threads().map_err(|error| exception(py, &error))?;
    pool.spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| work(&requested)));
        // Nobody listens any more to what took too long to end.
        let _ = sender.send(done);
    });
    let mut interrupt: Option<(Instant, PyErr)> = None;
    loop {
        let waited;
        (waited, receiver) = py.detach(move || (receiver.recv_timeout(BETWEEN_LOOKS), receiver));
        match (waited, interrupt.take()) {
            (Ok(Err(panic)), _) => resume_unwind(panic),
            (Ok(_) | Err(RecvTimeoutError::Disconnected), Some((_, raised))) => return Err(raised),
            (Ok(Ok(done)), None) => return done.map_err(|error| exception(py, &error)),
            (Err(RecvTimeoutError::Disconnected), None) => {
                let error = anyhow::anyhow!("a thread ended without a word");
                return Err(exception(py, &error));
            }
            (Err(RecvTimeoutError::Timeout), Some((since, raised))) => {
                if since.elapsed() > PATIENCE {
                    return Err(raised);
                }
                interrupt = Some((since, raised));
            }
            (Err(RecvTimeoutError::Timeout), None) => {
                if let Err(raised) = py.check_signals() {
                    cancellation.request();
                    interrupt = Some((Instant::now(), raised));
                }
            }
        }
    }
}
