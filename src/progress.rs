//! The display of a run: a bar on a terminal, JSON lines on request, else only what needs
//! attention.

use std::collections::HashMap;
use std::io::Write;
use std::time::Instant;

use identity::JobKey;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use runner::{Event, EventKind, Task};

use crate::output;
use crate::words::{count, duration};

/// A display of the runner's events.
pub(crate) struct ProgressDisplay {
    bar: ProgressBar,
    json: bool,
    /// The predicted cost of each job \[s\].
    costs: HashMap<JobKey, f64>,
    cached: usize,
    cost_done: f64,
    cost_left: f64,
    started: Instant,
}

impl ProgressDisplay {
    /// Returns the display of a run of some tasks, beside `cached` results.
    pub(crate) fn new(tasks: &[Task], cached: usize, json: bool) -> Self {
        let costs: HashMap<JobKey, f64> = tasks.iter().map(|task| (task.key, task.cost)).collect();
        let bar = ProgressBar::new(tasks.len() as u64);
        bar.set_draw_target(if json {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        });
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}") {
            bar.set_style(style);
        }
        // The sum is in the order of the tasks: over a hash map its last digits would differ.
        Self {
            bar,
            json,
            cached,
            cost_done: 0.0,
            cost_left: tasks.iter().map(|task| task.cost).sum(),
            costs,
            started: Instant::now(),
        }
    }

    /// Returns the number of jobs.
    pub(crate) fn jobs(&self) -> usize {
        self.costs.len()
    }

    /// Takes note of an event and shows it.
    pub(crate) fn show(&mut self, event: &Event) {
        if self.json {
            if let Ok(line) = serde_json::to_string(event) {
                // A reader that stops listening does not stop the run.
                let _ = writeln!(std::io::stdout(), "{}", wording::escaped_json(&line));
            }
            return;
        }
        match &event.kind {
            EventKind::Done { key, .. } => self.ended(key),
            EventKind::Quarantined { key, reason, attempts } => {
                self.ended(key);
                let tried = if *attempts == 0 {
                    String::new()
                } else {
                    format!(" after {}", count(*attempts as usize, "attempt", "attempts"))
                };
                self.notice(&format!("job {} is set aside{tried}: {reason}", short(key)));
            }
            EventKind::Retried { key, attempt, reason } => {
                self.notice(&format!("attempt {attempt} of job {} failed: {reason}", short(key)))
            }
            EventKind::WorkerLost { worker, how, .. } => {
                self.notice(&format!("worker {worker} is lost: {how}"))
            }
            EventKind::Interrupted { now: false } => {
                self.notice("stopping after the jobs in flight; Ctrl-C again stops now")
            }
            EventKind::Interrupted { now: true } => self.notice("stopping now"),
            _ => {}
        }
        let counts = &event.counts;
        self.bar.set_position((counts.done + counts.quarantined) as u64);
        self.bar.set_message(format!(
            "{} cached, {} failed, {} workers{}",
            self.cached,
            counts.quarantined,
            counts.workers,
            self.left()
        ));
    }

    /// Clears the bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn ended(&mut self, key: &JobKey) {
        let cost = self.costs.get(key).copied().unwrap_or(0.0);
        self.cost_done += cost;
        self.cost_left = (self.cost_left - cost).max(0.0);
    }

    /// Returns the rate and the time left, by predicted cost rather than by count: jobs differ by
    /// orders of magnitude.
    fn left(&self) -> String {
        if self.cost_done <= 0.0 {
            return String::new();
        }
        let elapsed = self.started.elapsed().as_secs_f64();
        let pace = elapsed / self.cost_done;
        format!(
            ", {:.1}/s, about {} left",
            self.bar.position() as f64 / elapsed.max(1e-9),
            duration(self.cost_left * pace)
        )
    }

    fn notice(&self, text: &str) {
        self.bar.suspend(|| {
            output::say(text);
        });
    }
}

/// Returns the first characters of a key, enough to name it.
fn short(key: &JobKey) -> String {
    key.to_string()[..12].to_owned()
}
