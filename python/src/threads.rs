//! The threads that solve.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
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
