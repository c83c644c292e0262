//! A run of one job, in a store of its own beside or in the one that is asked about.

use std::collections::HashSet;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use runner::Interrupt;
use store::Store;
use study::{Record, Study};

use super::observation::Observation;
use super::resources::directory_of;
use crate::account::this_run;
use crate::execution::single_worker;
use crate::failure_limit::FailureCount;
use crate::job_list::{JobList, JobsLeft};
use crate::ledger::StoreLedger;
use crate::output;
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

/// Runs the job with a worker of its own, and says how that went.
pub(super) fn trial(store: &Path) -> Observation {
    let start = Instant::now();
    match run(store) {
        Ok(()) => Observation::fine(
            "a run",
            format!(
                "a worker solved a scene over shared memory, its certified result was kept: {}",
                duration(start.elapsed().as_secs_f64())
            ),
        ),
        Err(error) => Observation::missing("a run", output::words(&error)),
    }
}

fn run(store: &Path) -> Result<()> {
    let parent = directory_of(store)
        .with_context(|| format!("no directory can be made at {}", store.display()))?;
    let place = tempfile::Builder::new().prefix("doctor-").tempdir_in(&parent);
    let place = place.with_context(|| format!("cannot write in {}", parent.display()))?;
    let study = Study::parse(STUDY, "doctor", &mut |_| Err("it names no file".to_owned()))?;
    let store = Store::open(place.path())?;
    let jobs = JobList::of(&study)?;
    let JobsLeft { tasks, texts, .. } =
        jobs.left(&study, &WrittenStore::new(&store), false, &HashSet::new())?;
    let interrupt = Interrupt::new().context("cannot prepare for Ctrl-C")?;
    runner::raise_on_signals(&interrupt).context("cannot prepare for Ctrl-C")?;
    let account = this_run(&study, None);
    let mut failures = FailureCount::default();
    runner::run(
        tasks,
        &mut StoreLedger::new(&store, texts, None, &account, &mut failures),
        &single_worker(place.path())?,
        &interrupt,
        &mut |_| {},
    )?;
    for key in jobs.keys() {
        let bytes = store.get(&key)?.context("its result is not in the store")?;
        let record = Record::decode(&bytes)?;
        if !record.is_certified() {
            bail!("its result is not certified, but {}", record.standing());
        }
    }
    Ok(())
}
