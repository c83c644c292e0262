//! The request to stop comes from a signal handler or from another thread.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::event::{EventfdFlags, eventfd};

/// A request that asks a run to stop. If it was raised once, no further job is begun and those in
/// flight are kept. If it was raised twice, the run stops at once. If the first of them asked for
/// an end in time, those in flight are kept only if they end within the overtime of the
/// [options](crate::Options).
///
/// Clones are the same request. Raising it takes one atomic operation and one write, so a signal
/// handler may do it.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    raised: AtomicU32,
    /// The number of those that asked for an end in time.
    ends: AtomicU32,
    /// The descriptor that wakes the coordinator out of its wait.
    wake: OwnedFd,
}

impl Interrupt {
    /// Makes a request that nobody has raised yet.
    ///
    /// # Errors
    /// The process has no file descriptor left.
    pub fn new() -> std::io::Result<Interrupt> {
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Interrupt(Arc::new(Shared { raised: AtomicU32::new(0), ends: AtomicU32::new(0), wake })))
    }

    /// Raises the request once more.
    pub fn raise(&self) {
        self.count(&self.0.raised);
    }

    /// Asks once more for an end in time, as when the time of the run is up.
    pub fn end_in_time(&self) {
        self.count(&self.0.ends);
    }

    fn count(&self, requests: &AtomicU32) {
        requests.fetch_add(1, Ordering::SeqCst);
        // The write fails only when 2⁶⁴ − 1 wake-ups are pending, and then the coordinator is
        // awake.
        let _ = rustix::io::write(&self.0.wake, &1u64.to_ne_bytes());
    }

    /// Returns how often the request was raised without asking for an end in time.
    pub fn raised(&self) -> u32 {
        self.0.raised.load(Ordering::SeqCst)
    }

    /// Returns how often an end in time was asked for.
    pub fn ends(&self) -> u32 {
        self.0.ends.load(Ordering::SeqCst)
    }

    /// Returns the descriptor that is readable after a request until `rearm`.
    pub(crate) fn wake(&self) -> BorrowedFd<'_> {
        self.0.wake.as_fd()
    }

    /// Consumes the wake-up. Without it the coordinator would spin.
    pub(crate) fn rearm(&self) {
        let _ = rustix::io::read(&self.0.wake, &mut [0u8; 8]);
    }
}
