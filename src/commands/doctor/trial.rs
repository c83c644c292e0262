//! A run of one job, in a store of its own beside the one that is asked about.

use std::collections::HashSet;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use runner::{Event, EventKind, Interrupt};
use store::Store;
use study::Study;

use super::observation::Observation;
use super::trial_place::trial_place;
use crate::account::this_run;
use crate::execution::single_worker;
use crate::failure_limit::FailureCount;
use crate::ledger::StoreLedger;
use crate::output;
use crate::run_jobs::{ExaminedJobs, RunJobs};
use crate::stored::WrittenStore;
use crate::words::duration;

/// A sphere that is pressed and shifted, on a coarse mesh.
const STUDY: &str = r#"
name = "doctor"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "20 um", shift_x = "1 um" }]
[numerics]
mesh = 12
"#;

/// Runs the job with a worker of its own, and says how that went; `None` if it was interrupted.
pub(super) fn trial(store: &Path) -> Option<Observation> {
    let start = Instant::now();
    let outcome = interrupt().and_then(|interrupt| run(store, &interrupt));
    match outcome {
        Ok(true) => Some(Observation::fine(
            "a run",
            format!(
                "a worker solved a scene over shared memory, its certified result was kept: {}",
                duration(start.elapsed().as_secs_f64())
            ),
        )),
        Ok(false) => None,
        Err(error) => Some(Observation::missing("a run", output::words(&error))),
    }
}

/// Returns the interrupt that signals raise from now on.
fn interrupt() -> Result<Interrupt> {
    let interrupt = Interrupt::new().context("cannot prepare for Ctrl-C")?;
    runner::raise_on_signals(&interrupt).context("cannot prepare for Ctrl-C")?;
    Ok(interrupt)
}

/// Runs the job, and tells whether it ended before the interrupt came.
fn run(store: &Path, interrupt: &Interrupt) -> Result<bool> {
    let place = trial_place(store)?;
    let study = Study::parse(STUDY, "doctor", &mut |_| Err("it names no file".to_owned()))?;
    let store = Store::open(place.path())?;
    let jobs = RunJobs::of_axes(&study)?;
    let left =
        jobs.left(ExaminedJobs::default(), &WrittenStore::new(&store), false, &HashSet::new())?;
    let texts = |job: usize| left.text(job);
    let account = this_run(&study, None);
    let mut failures = FailureCount::default();
    let mut last = None;
    let outcome = runner::run(
        &left,
        &mut StoreLedger::new(&store, &texts, None, &account, &mut failures),
        &single_worker(place.path())?,
        interrupt,
        &mut |event| last = failure(event).or(last.take()),
    );
    let certified = outcome.map_err(anyhow::Error::from).and_then(|summary| {
        if summary.unfinished > 0 {
            return Ok(false);
        }
        jobs.require_certified(&store).map(|()| true)
    });
    certified.map_err(|error| with_cause(error, last))
}

/// Returns what an event says of a failure, if it is one.
fn failure(event: &Event) -> Option<String> {
    match &event.kind {
        EventKind::WorkerLost { how, .. } => Some(format!("the worker is lost: {how}")),
        EventKind::Retried { reason, .. }
        | EventKind::Returned { reason, .. }
        | EventKind::Postponed { reason, .. }
        | EventKind::Quarantined { reason, .. } => Some(reason.clone()),
        _ => None,
    }
}

/// Adds what failed last to an error that does not say it.
fn with_cause(error: anyhow::Error, last: Option<String>) -> anyhow::Error {
    let words = output::words(&error);
    match last {
        Some(last) if !words.contains(&last) => anyhow!("{words}; before that: {last}"),
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_is_interrupted_is_no_finding() {
        let place = tempfile::tempdir().unwrap();
        let interrupt = Interrupt::new().unwrap();
        // Twice, so that the worker is not waited for.
        interrupt.raise();
        interrupt.raise();
        assert!(!run(&place.path().join("store"), &interrupt).unwrap());
        assert_eq!(place.path().read_dir().unwrap().count(), 0);
    }

    #[test]
    fn the_cause_of_a_lost_worker_is_said() {
        // The program of this test is no worker: it ends at once.
        let place = tempfile::tempdir().unwrap();
        let error = run(&place.path().join("store"), &Interrupt::new().unwrap()).unwrap_err();
        assert!(output::words(&error).contains("exit status"), "{}", output::words(&error));
        let said = |last: &str| output::words(&with_cause(anyhow!("no result"), Some(last.into())));
        assert_eq!(said("signal 9"), "no result; before that: signal 9");
        assert_eq!(said("no result"), "no result");
    }
}
