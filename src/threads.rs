//! The threads that share the work of this process.

use anyhow::{Context, Result};

/// Makes this thread one of those that share the work, `count` of them or, for 0, as many as the
/// machine or RAYON_NUM_THREADS has. It works itself: to hand over to another and wait takes as
/// long as a small solve's smallest parts.
pub(crate) fn share_among(count: usize) -> Result<()> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .use_current_thread()
        .build_global()
        .context("cannot start threads")
}
