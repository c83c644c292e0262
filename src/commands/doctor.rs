//! `doctor`: what this machine gives a run, what is short, and what to do about it.
//!
//! Limits are asked of the code that a run asks, and what can be tried is tried.

mod observation;
mod resources;
mod surroundings;
mod trial;
mod trial_place;

use anyhow::Result;
use serde::Serialize;

use self::observation::{Observation, Soundness};
use crate::cli::DoctorArgs;
use crate::output::{self, Finish};
use crate::threads;

/// The observations of a machine, and what follows from them.
#[derive(Serialize)]
struct Diagnosis {
    /// It is true if a run can be done here. Nothing is known if the trial was interrupted.
    possible: Option<bool>,
    /// The largest number of workers that a run would have; what a study needs may leave fewer.
    workers: usize,
    observations: Vec<Observation>,
}

/// Looks at the machine, tries a run, and says what was found.
pub(crate) fn doctor(args: &DoctorArgs) -> Result<Finish> {
    let diagnosis = examine(args);
    if args.json {
        output::print_json(&diagnosis)?;
    } else {
        output::print(&words(&diagnosis))?;
    }
    Ok(match diagnosis.possible {
        Some(true) => Finish::AllDone,
        Some(false) => Finish::Mistake,
        None => Finish::Interrupted,
    })
}

fn examine(args: &DoctorArgs) -> Diagnosis {
    // A run raises the limits that it may raise before it meets them.
    let process = runner::prepare_process().map_err(anyhow::Error::from);
    let process = process.and_then(|()| threads::limit());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let room = process.is_ok().then(|| runner::room(cores, 1));
    let limited = room.clone().flatten();
    let store = &args.store.store;
    let mut observations = vec![
        surroundings::program(),
        surroundings::machine(),
        resources::cores(cores),
        resources::memory(),
        resources::shared_memory(cores),
        resources::open_files(),
        resources::threads(),
        resources::temporary_files(),
        resources::store(store),
        surroundings::clock(),
        surroundings::locale(),
        surroundings::slurm(),
        surroundings::python(),
    ];
    let (mut workers, mut is_interrupted) = (0, false);
    match (process, room) {
        (Err(error), _) => {
            observations.push(Observation::missing("limits", output::words(&error)));
        }
        (Ok(()), room) => {
            workers = room.flatten().map_or(cores, |room| room.workers);
            observations.push(resources::workers(cores, limited.as_ref()));
            let seen = trial::trial(store);
            is_interrupted = seen.is_none();
            observations.extend(seen);
        }
    }
    let is_complete = observations.iter().all(|seen| seen.soundness != Soundness::Missing);
    let possible = (!is_interrupted).then_some(is_complete);
    Diagnosis { possible, workers, observations }
}

fn words(diagnosis: &Diagnosis) -> String {
    let mut text: String = diagnosis.observations.iter().map(Observation::words).collect();
    text += "\n";
    text += &match (diagnosis.possible, diagnosis.workers) {
        (None, _) => {
            "Interrupted during the trial, so that it is not known whether a run is possible.\n"
                .to_owned()
        }
        (Some(true), 1) => "A run is possible here, with 1 worker at a time.\n".to_owned(),
        (Some(true), workers) => {
            format!("A run is possible here, with up to {workers} workers at a time.\n")
        }
        (Some(false), _) => {
            let missing = diagnosis.observations.iter();
            let missing = missing.filter(|seen| seen.soundness == Soundness::Missing);
            let subjects: Vec<&str> = missing.map(|seen| seen.subject).collect();
            format!("No run is possible here: {}.\n", subjects.join(", "))
        }
    };
    text
}
