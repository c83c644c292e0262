//! This file holds the heartbeat of a worker.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use iceoryx2::port::notifier::Notifier;

use super::channel::{HEARTBEAT, Shm};
use crate::error::TransportError;

/// A thread that gives signs of life while the worker is busy, and only then.
#[derive(Debug)]
pub(super) struct Pulse(Arc<(Mutex<Beat>, Condvar)>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Beat {
    Rest,
    Busy,
    End,
}

impl Pulse {
    pub(super) fn new(interval: Duration, up: Arc<Notifier<Shm>>) -> Result<Pulse, TransportError> {
        let shared = Arc::new((Mutex::new(Beat::Rest), Condvar::new()));
        let state = shared.clone();
        let beat = move || {
            let (state, changed) = &*state;
            let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
            loop {
                now = match *now {
                    Beat::End => return,
                    Beat::Rest => changed.wait(now).unwrap_or_else(PoisonError::into_inner),
                    Beat::Busy => {
                        // A failure shows as silence, and silence it is.
                        let _ = up.notify_with_custom_event_id(HEARTBEAT);
                        changed
                            .wait_timeout_while(now, interval, |beat| *beat == Beat::Busy)
                            .unwrap_or_else(PoisonError::into_inner)
                            .0
                    }
                };
            }
        };
        let thread = std::thread::Builder::new().name("heartbeat".into()).stack_size(256 << 10);
        thread.spawn(beat).map_err(TransportError::when("cannot start the heartbeat"))?;
        Ok(Pulse(shared))
    }

    fn set(&self, beat: Beat) {
        let (state, changed) = &*self.0;
        let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
        if *now != beat {
            *now = beat;
            changed.notify_one();
        }
    }

    pub(super) fn beat(&self, busy: bool) {
        self.set(if busy { Beat::Busy } else { Beat::Rest });
    }
}

impl Drop for Pulse {
    fn drop(&mut self) {
        self.set(Beat::End);
    }
}
