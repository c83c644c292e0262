//! The worker: takes jobs, runs them one at a time, reports.
//!
//! It talks while it works: a request goes out as soon as the last was answered and there is
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

/// What a worker does with a job.
pub trait Executor {
    /// Runs one job: payload in, result out. The same payload gives the same result, whatever ran
    /// before; what is kept between jobs only saves time. A panic ends this attempt, not the
    /// worker.
    fn run(&mut self, payload: &[u8]) -> Vec<u8>;
}

/// Result bytes in one request, beyond the first result.
const MOST_BYTES: usize = 512 << 10;

/// Characters kept of what a panic said.
const LONGEST_REASON: usize = 4 << 10;

/// Works until told to stop. After a panic the work is made afresh, for what it kept may be half
/// written.
pub(crate) fn serve<W: Executor>(
    link: &mut impl Link,
    fresh: impl Fn() -> W,
) -> Result<(), TransportError> {
    let mut work = fresh();
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
                // Report what gathered meanwhile before the next job, which may be long.
                continue;
            }
            None => {}
        }
        if let Some(Assignment { lease, payload }) = jobs.pop_front() {
            link.begin(lease)?;
            results.push_back(attempt(&mut work, &fresh, lease, payload));
        }
    }
}

/// As many results as one message should carry, at least one if there is one.
fn portion(results: &mut VecDeque<Report<Bytes>>) -> Vec<Report<Bytes>> {
    let size = |report: &Report<Bytes>| match &report.outcome {
        AttemptOutcome::Completed(bytes) => bytes.len(),
        AttemptOutcome::Failed(reason) => reason.len(),
    };
    let mut total = 0;
    let fits = |report: &&Report<Bytes>| {
        total += size(report);
        total <= MOST_BYTES
    };
    let count = results.iter().take_while(fits).count().max(1).min(results.len());
    results.drain(..count).collect()
}

fn attempt<W: Executor>(
    work: &mut W,
    fresh: impl Fn() -> W,
    lease: LeaseId,
    payload: Result<Bytes, String>,
) -> Report<Bytes> {
    let start = Instant::now();
    let outcome = match payload {
        Err(reason) => AttemptOutcome::Failed(reason),
        Ok(payload) => {
            IN_JOB.store(true, Ordering::SeqCst);
            let result = catch_unwind(AssertUnwindSafe(|| work.run(&payload)));
            IN_JOB.store(false, Ordering::SeqCst);
            match result {
                Ok(result) => AttemptOutcome::Completed(result),
                Err(panic) => {
                    *work = fresh();
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

/// Where a job panicked, from the hook to the report.
static PLACE: Mutex<Option<String>> = Mutex::new(None);
static IN_JOB: AtomicBool = AtomicBool::new(false);

/// In a worker process: a panic in a job is reported with its place, and not printed as well, in
/// the middle of what the coordinator shows. Any other panic prints as ever.
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
