//! The display of a run: a bar on a terminal, JSON lines on request, else only what needs
//! attention.

use std::fmt;
use std::io::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use answers::rows::digits;
use identity::JobKey;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use runner::{Event, EventKind};
use serde::Serialize;

use crate::output;
use crate::time_left::{Calibration, TimeLeft};
use crate::words::{count, duration};

/// A display of the runner's events.
pub(crate) struct ProgressDisplay {
    bar: ProgressBar,
    json: bool,
    cached: usize,
    /// The estimate of the time left, which the bar asks whenever it is drawn.
    clock: Arc<Mutex<RunClock>>,
}

/// The time of a run, and the estimate of what is left of it.
struct RunClock {
    left: TimeLeft,
    /// The time of the last event since the start of the run \[s\], and when that was.
    heard: Option<HeardEvent>,
}

/// The time of an event.
#[derive(Clone, Copy)]
struct HeardEvent {
    /// The time since the start of the run \[s\].
    seconds: f64,
    instant: Instant,
}

/// An event as a line of JSON, with what it tells of the time left.
#[derive(Serialize)]
struct EventLine<'a> {
    #[serde(flatten)]
    event: &'a Event,
    /// The estimate of the time that is left of the run \[s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds_left: Option<f64>,
}

/// The time between two drawings of the bar, so that the time left goes down between two events.
const TICK: Duration = Duration::from_secs(1);

impl ProgressDisplay {
    /// Returns the display of a run of so many tasks, beside `cached` results, with the estimate of
    /// the time left.
    pub(crate) fn new(tasks: usize, cached: usize, json: bool, left: TimeLeft) -> Self {
        let clock = Arc::new(Mutex::new(RunClock { left, heard: None }));
        let bar = ProgressBar::new(tasks as u64);
        bar.set_draw_target(if json {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        });
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}{left}") {
            let clock = Arc::clone(&clock);
            let left = move |_: &ProgressState, writer: &mut dyn fmt::Write| {
                if let Some(seconds) = locked(&clock).seconds() {
                    // Writing to a line of text does not fail.
                    let _ = write!(writer, ", about {} left", duration(seconds));
                }
            };
            bar.set_style(style.with_key("left", left));
        }
        if !json {
            bar.enable_steady_tick(TICK);
        }
        Self { bar, json, cached, clock }
    }

    /// Returns what the run has told of the times that jobs take.
    pub(crate) fn calibration(&self) -> Calibration {
        locked(&self.clock).left.calibration().clone()
    }

    /// Returns the estimate of the time that the jobs that are left would take \[s\]; `None` if no
    /// job was handed out.
    pub(crate) fn seconds_left(&self) -> Option<f64> {
        let clock = locked(&self.clock);
        clock.left.seconds(clock.heard?.seconds)
    }

    /// Takes note of an event and shows it.
    pub(crate) fn show(&mut self, event: &Event) {
        {
            let mut clock = locked(&self.clock);
            clock.left.hear(event);
            clock.heard = Some(HeardEvent { seconds: event.seconds, instant: Instant::now() });
        }
        if self.json {
            let seconds_left = locked(&self.clock).seconds().map(|seconds| digits(seconds, 2));
            if let Ok(line) = serde_json::to_string(&EventLine { event, seconds_left }) {
                // A reader that stops listening does not stop the run.
                let _ = writeln!(std::io::stdout(), "{}", wording::escaped_json(&line));
            }
            return;
        }
        match &event.kind {
            EventKind::Quarantined { key, reason, attempts } => {
                let tried = count(*attempts as usize, "attempt", "attempts");
                self.notice(&format!("job {} is set aside after {tried}: {reason}", short(key)));
            }
            EventKind::Retried { key, attempt, reason } => {
                self.notice(&format!("attempt {attempt} of job {} failed: {reason}", short(key)))
            }
            EventKind::WorkersLimited { workers, reason } => self
                .notice(&format!("{} at a time: {reason}", count(*workers, "worker", "workers"))),
            EventKind::Returned { key, reason } => {
                self.notice(&format!("job {} goes back to the queue: {reason}", short(key)))
            }
            EventKind::Postponed { key, reason, .. } => {
                self.notice(&format!("job {} is left for another run: {reason}", short(key)));
            }
            EventKind::WorkerLost { worker, how, .. } => {
                self.notice(&format!("worker {worker} is lost: {how}"))
            }
            EventKind::Interrupted { now: false } => {
                self.notice("stopping after the jobs in flight; Ctrl-C again stops now")
            }
            EventKind::Interrupted { now: true } => self.notice("stopping now"),
            EventKind::TimeUp { now: false } => {
                self.notice("stopping in time: no further job is begun")
            }
            EventKind::TimeUp { now: true } => {
                self.notice("stopping now: the jobs in flight are given up for another run")
            }
            _ => {}
        }
        let counts = &event.counts;
        self.bar.set_position((counts.done + counts.quarantined + counts.postponed) as u64);
        self.bar.set_message(format!(
            "{} cached, {} failed, {} workers",
            self.cached, counts.quarantined, counts.workers
        ));
    }

    /// Clears the bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn notice(&self, text: &str) {
        self.bar.suspend(|| {
            output::say(text);
        });
    }
}

impl RunClock {
    /// Returns the estimate of the time left now \[s\].
    fn seconds(&self) -> Option<f64> {
        let HeardEvent { seconds, instant } = self.heard?;
        self.left.seconds(seconds + instant.elapsed().as_secs_f64())
    }
}

/// Locks the clock. Whoever held it when it panicked has left nothing half done.
fn locked(clock: &Mutex<RunClock>) -> MutexGuard<'_, RunClock> {
    clock.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the first characters of a key, enough to name it.
fn short(key: &JobKey) -> String {
    key.to_string()[..12].to_owned()
}
