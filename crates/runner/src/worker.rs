//! The worker takes jobs, runs them one at a time and reports.
//!
//! It talks while it works: a request goes out as soon as the last one was answered and there is
//! something to report, and the worker goes on with the jobs that it holds. It waits only when it
//! holds none.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use crate::error::TransportError;
use crate::lease::LeaseId;
use crate::protocol::{Assignment, AttemptOutcome, Reply, Report, Request};
use crate::transport::{Bytes, Link};

/// The work of a worker on a job.
pub trait Executor {
    /// Runs one job: it takes the payload and returns the result. The same payload gives the same
    /// result, whatever ran before; anything kept between jobs only saves time. A panic ends this
    /// attempt and not the worker.
    fn run(&mut self, payload: &[u8]) -> Vec<u8>;
}

/// The size of the results in one request beyond the first result \[bytes\].
const MOST_BYTES: usize = 512 << 10;

/// The number of characters that are kept of a panic's message.
const LONGEST_REASON: usize = 4 << 10;

/// Works until it is told to stop. After a panic the executor is made afresh, because the old one
/// may be half changed.
pub(crate) fn serve<E: Executor>(
    link: &mut impl Link,
    fresh: impl Fn() -> E,
) -> Result<(), TransportError> {
    let mut executor = fresh();
    let mut jobs: VecDeque<Assignment<Result<Bytes, String>>> = VecDeque::new();
    let mut results: VecDeque<Report<Bytes>> = VecDeque::new();
    let mut open = false;
    loop {
        if !open && (jobs.is_empty() || !results.is_empty()) {
            let reports = portion(&mut results);
            link.send(Request { idle: jobs.is_empty() && results.is_empty(), reports })?;
            open = true;
        }
        match if open { link.receive(jobs.is_empty())? } else { None } {
            Some(Reply::Stop) => return Ok(()),
            Some(Reply::Jobs(more)) => {
                jobs.extend(more);
                open = false;
                // Results that gathered meanwhile are reported before the next job, which may be
                // long.
                continue;
            }
            None => {}
        }
        if let Some(Assignment { lease, payload }) = jobs.pop_front() {
            link.begin(lease)?;
            results.push_back(attempt(&mut executor, &fresh, lease, payload));
        }
    }
}

/// Takes as many results as one message should carry, at least one if there is one.
fn portion(results: &mut VecDeque<Report<Bytes>>) -> Vec<Report<Bytes>> {
    let size = |report: &Report<Bytes>| match &report.outcome {
        AttemptOutcome::Completed(bytes) => bytes.len(),
        AttemptOutcome::Failed(reason) | AttemptOutcome::Undelivered(reason) => reason.len(),
    };
    let mut total = 0;
    let fits = |report: &&Report<Bytes>| {
        total += size(report);
        total <= MOST_BYTES
    };
    let count = results.iter().take_while(fits).count().max(1).min(results.len());
    results.drain(..count).collect()
}

fn attempt<E: Executor>(
    executor: &mut E,
    fresh: impl Fn() -> E,
    lease: LeaseId,
    payload: Result<Bytes, String>,
) -> Report<Bytes> {
    let start = Instant::now();
    let outcome = match payload {
        Err(reason) => AttemptOutcome::Undelivered(reason),
        Ok(payload) => {
            IN_JOB.store(true, Ordering::SeqCst);
            let result = catch_unwind(AssertUnwindSafe(|| executor.run(&payload)));
            IN_JOB.store(false, Ordering::SeqCst);
            match result {
                Ok(result) => AttemptOutcome::Completed(result),
                Err(panic) => {
                    *executor = fresh();
                    let reason = format!("panicked{}: {}", place(), message(panic.as_ref()));
                    AttemptOutcome::Failed(reason.chars().take(LONGEST_REASON).collect())
                }
            }
        }
    };
    Report { lease, seconds: start.elapsed().as_secs_f64(), outcome }
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| text.to_string());
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "without a message".into())
}

/// The place where a job panicked, from the hook to the report.
static PLACE: Mutex<Option<String>> = Mutex::new(None);
static IN_JOB: AtomicBool = AtomicBool::new(false);

/// Makes a worker process report a panic of a job with its place and not print it as well, in the
/// middle of the coordinator's output. Any other panic is printed as ever.
pub(crate) fn report_panics() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if IN_JOB.load(Ordering::SeqCst) {
            *PLACE.lock().unwrap_or_else(PoisonError::into_inner) =
                panic.location().map(|location| format!(" at {location}"));
        } else {
            print(panic);
        }
    }));
}

fn place() -> String {
    PLACE.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default()
}
