//! This file says what the process does when it gets a signal.

#![allow(unsafe_code)]

use std::io::ErrorKind;
use std::os::fd::AsFd;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicI64, Ordering};

use nix::libc;
use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, sigaction};
use rustix::time::{ClockId, clock_gettime};

use crate::interrupt::Interrupt;

/// The request that a signal raises.
static RAISED: OnceLock<Interrupt> = OnceLock::new();

/// The number of requests that a run obeys: to finish the jobs in flight, and to stop at once.
const HEARD: u32 = 2;

/// The exit code of a process that SIGTERM or SIGUSR1 ends: it should be started again
/// (EX_TEMPFAIL of `sysexits.h`).
const TRY_AGAIN: i32 = 75;

/// The time in which further requests for an end in time are the same request \[ms\]. Slurm sends
/// SIGTERM to all processes of a job, and a script that gets it too may pass it on.
const SAME_END: i64 = 2000;

/// The time of the last end in time that was counted, by the clock that never goes back \[ms\].
static LAST_END: AtomicI64 = AtomicI64::new(i64::MIN);

/// Raises a request whenever the process gets SIGINT or SIGHUP, and asks it for an end in time at
/// SIGTERM and SIGUSR1, by which batch systems tell that the time is up. A signal that is ignored
/// when the program starts stays ignored, as `nohup` and `trap ''` want it. Who asks three times is
/// not heard, because the process waits for something else than its run, and then it ends at once.
///
/// # Errors
/// The system refuses to tell the process about signals, or they raise another request already.
pub fn raise_on_signals(interrupt: &Interrupt) -> std::io::Result<()> {
    if RAISED.set(interrupt.clone()).is_err() {
        let words = "the signals of this process raise another request already";
        return Err(std::io::Error::new(ErrorKind::AlreadyExists, words));
    }
    for signal in [Signal::SIGINT, Signal::SIGHUP, Signal::SIGTERM, Signal::SIGUSR1] {
        let before = set(signal, SigHandler::Handler(raise))?;
        if matches!(before.handler(), SigHandler::SigIgn) {
            set(signal, SigHandler::SigIgn)?;
        }
    }
    Ok(())
}

extern "C" fn raise(signal: libc::c_int) {
    if let Some(interrupt) = RAISED.get() {
        let is_end = matches!(signal, libc::SIGTERM | libc::SIGUSR1);
        if is_end {
            if !is_new_end() {
                return;
            }
            interrupt.end_in_time();
        } else {
            interrupt.raise();
        }
        if interrupt.raised().saturating_add(interrupt.ends()) > HEARD {
            // SAFETY: `_exit` may be called in a signal handler; it runs no destructor. That loses
            // nothing that is done, and the next run clears up.
            unsafe { libc::_exit(if is_end { TRY_AGAIN } else { 128 + signal }) }
        }
    }
}

/// Tells whether a request for an end in time is another one than the last, and remembers it.
fn is_new_end() -> bool {
    // clock_gettime(2) may be called in a signal handler.
    let clock = clock_gettime(ClockId::Monotonic);
    let now = clock.tv_sec.saturating_mul(1000).saturating_add(clock.tv_nsec / 1_000_000);
    // Two signals may be handled at the same time by two threads, of which one is first.
    LAST_END
        .fetch_update(Ordering::SeqCst, Ordering::SeqCst, |last| {
            (now.saturating_sub(last) >= SAME_END).then_some(now)
        })
        .is_ok()
}

/// Makes a worker deaf to SIGTERM and SIGUSR1, which batch systems send to all processes of a run:
/// the coordinator hears them, and decides what becomes of the job.
///
/// # Errors
/// The system refuses.
pub(crate) fn leave_ends_to_the_coordinator() -> std::io::Result<()> {
    set(Signal::SIGTERM, SigHandler::SigIgn)?;
    set(Signal::SIGUSR1, SigHandler::SigIgn).map(drop)
}

/// Makes a write beyond the largest size that a file may have (`ulimit -f`) an error instead of a
/// signal that ends the process. Processes that it starts inherit that.
///
/// # Errors
/// The system refuses.
pub(crate) fn refuse_oversized_writes() -> std::io::Result<()> {
    set(Signal::SIGXFSZ, SigHandler::SigIgn).map(drop)
}

/// Lets the process end with words when it meets memory that the system cannot give it, because
/// somebody else has filled the shared memory.
///
/// # Errors
/// The system refuses to tell the process about signals.
pub(crate) fn explain_missing_memory() -> std::io::Result<()> {
    set(Signal::SIGBUS, SigHandler::Handler(explain)).map(drop)
}

extern "C" fn explain(_: libc::c_int) {
    const WORDS: &[u8] =
        b"error: the run stopped: shared memory ran out of space, because /dev/shm \
        is full; what is done is kept: free some room there and start the same command again\n";
    // The signal comes again as soon as this function returns, so the process ends here.
    let _ = rustix::io::write(std::io::stderr().as_fd(), WORDS);
    // SAFETY: `_exit` may be called in a signal handler; it runs no destructor.
    unsafe { libc::_exit(1) }
}

fn set(signal: Signal, handler: SigHandler) -> std::io::Result<SigAction> {
    let action = SigAction::new(handler, SaFlags::SA_RESTART, SigSet::empty());
    // SAFETY: the handlers in this file do nothing but atomic operations, clock_gettime(2),
    // write(2) and _exit(2), which POSIX allows in a handler.
    Ok(unsafe { sigaction(signal, &action) }?)
}
