//! The threads that share the work of this process.

use anyhow::{Context, Result};

use crate::output;

/// The most threads for each core that are of any use.
const MOST_PER_CORE: usize = 8;

/// Makes this thread one of `count` that share the work; for 0, of as many as the machine or
/// RAYON_NUM_THREADS has. The thread works itself: handing over to another one and waiting would
/// take as long as the smallest parts of a small solve.
pub(crate) fn share_among(count: usize) -> Result<()> {
    let count = if count == 0 { threads_asked_for() } else { count };
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .use_current_thread()
        .build_global()
        .context("cannot start threads")
}

/// Returns how many of so many cores may be used: no more than RAYON_NUM_THREADS, by which a batch
/// job says how many of a node's are its own.
pub(crate) fn usable(cores: usize) -> usize {
    asked_for().map_or(cores, |count| count.clamp(1, cores.max(1)))
}

/// Limits the threads that other work is shared among, if RAYON_NUM_THREADS asks for more than the
/// machine can use. Otherwise they start when they are needed.
pub(crate) fn limit() -> Result<()> {
    if asked_for().is_some_and(|count| count > most()) {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(threads_asked_for());
        threads.build_global().context("cannot start threads")?;
    }
    Ok(())
}

/// Returns the number of threads that RAYON_NUM_THREADS asks for, but no more than the machine can
/// use; 0 if it leaves the number to the machine.
fn threads_asked_for() -> usize {
    let most = most();
    match asked_for() {
        Some(count) if count > most => {
            output::say(&format!("{most} threads instead of RAYON_NUM_THREADS={count}"));
            most
        }
        count => count.unwrap_or(0),
    }
}

fn asked_for() -> Option<usize> {
    let text = std::env::var("RAYON_NUM_THREADS").ok()?;
    // The library reads a sign as well. A number that is too large to be read is too large to be
    // used.
    let digits = text.strip_prefix('+').unwrap_or(&text);
    if !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()) {
        Some(digits.parse().unwrap_or(usize::MAX))
    } else {
        None
    }
}

fn most() -> usize {
    MOST_PER_CORE * std::thread::available_parallelism().map_or(1, usize::from)
}
