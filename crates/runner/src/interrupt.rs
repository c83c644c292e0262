//! The request to stop, from a signal handler or another thread.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::event::{EventfdFlags, eventfd};

/// Asks a run to stop: raised once, no job is begun any more and those in flight are kept; twice,
/// now.
///
/// Clones are the same request. Raising is one atomic and one write, so a signal handler may do it.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    raised: AtomicU32,
    /// Wakes the coordinator out of its wait.
    wake: OwnedFd,
}

impl Interrupt {
    /// A request that nobody has made yet. Fails if the process has no file descriptor left.
    pub fn new() -> std::io::Result<Interrupt> {
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Interrupt(Arc::new(Shared { raised: AtomicU32::new(0), wake })))
    }

    /// Asks once more.
    pub fn raise(&self) {
        self.0.raised.fetch_add(1, Ordering::SeqCst);
        // Fails only when 2⁶⁴ − 1 wake-ups are pending, and then the coordinator is awake.
        let _ = rustix::io::write(&self.0.wake, &1u64.to_ne_bytes());
    }

    /// How often it was asked.
    pub fn raised(&self) -> u32 {
        self.0.raised.load(Ordering::SeqCst)
    }

    /// Readable after `raise`, until `rearm`.
    pub(crate) fn wake(&self) -> BorrowedFd<'_> {
        self.0.wake.as_fd()
    }

    /// Consumes the wake-up, or the coordinator would spin on it.
    pub(crate) fn rearm(&self) {
        let _ = rustix::io::read(&self.0.wake, &mut [0u8; 8]);
    }
}
