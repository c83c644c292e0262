//! A request from outside to give up.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to give up, shared by whoever may make it and the solvers, which look at it between
/// their steps. A solve that was given up ends with what it has, which is no solution.
#[derive(Clone, Debug, Default)]
pub struct Cancellation(Arc<AtomicBool>);

impl Cancellation {
    /// Asks the solvers to give up.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns whether somebody asked for it.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
