//! `worker`: does jobs for a coordinator.

use answers::perform::{Done, perform};
use anyhow::Result;
use contact::Operators;
use runner::{WorkerArguments, work};
use study::record_format::encode_fields;

use crate::output::Finish;
use crate::threads::share_among;
use crate::wire::{Answer, encode, ordered};

/// Solves jobs, keeping operators between them.
#[derive(Default)]
struct Solver {
    operators: Operators,
}

impl Solver {
    fn run(&mut self, payload: &[u8]) -> Result<Answer> {
        let (job, surfaces) = ordered(payload)?;
        let Done { ending, fields, times } = perform(&job, &surfaces, &mut self.operators)?;
        Ok(Answer::Ended {
            ending: Box::new(ending),
            fields: fields.map(|fields| encode_fields(&fields)),
            times,
        })
    }
}

impl runner::Executor for Solver {
    fn run(&mut self, payload: &[u8]) -> Vec<u8> {
        let answer = Solver::run(self, payload)
            .unwrap_or_else(|error| Answer::Refused(format!("{error:#}")));
        encode(&answer).expect("an answer is plain data")
    }
}

/// The hidden command `worker`.
pub(crate) fn worker(threads: usize, argument: &str) -> Result<Finish> {
    share_among(threads)?;
    work(&WorkerArguments::parse(argument)?, Solver::default)?;
    Ok(Finish::AllDone)
}
