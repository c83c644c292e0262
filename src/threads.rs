//! The threads that share the work of this process.

use anyhow::{Context, Result};

/// Makes this thread one of `count` that share the work; for 0, of as many as the machine or
/// RAYON_NUM_THREADS has. The thread works itself: handing over to another one and waiting would
/// take as long as the smallest parts of a small solve.
pub(crate) fn share_among(count: usize) -> Result<()> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .use_current_thread()
        .build_global()
        .context("cannot start threads")
}
