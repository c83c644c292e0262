//! `worker`: does jobs for a coordinator.

use answers::{Performed, perform};
use anyhow::Result;
use contact::Operators;
use runner::{WorkerArguments, work};
use study::record_format::{encode_ending, encode_fields};

use crate::output::Finish;
use crate::threads::share_among;
use crate::wire::{JobReply, OrderedJob, decode_order, encode};

/// A worker that keeps operators between its jobs.
#[derive(Default)]
struct JobWorker {
    operators: Operators,
}

impl JobWorker {
    fn reply(&mut self, payload: &[u8]) -> Result<JobReply> {
        let OrderedJob { job, surfaces } = decode_order(payload)?;
        let Performed { ending, fields, times } = perform(&job, &surfaces, &mut self.operators)?;
        Ok(JobReply::Ended {
            ending: encode_ending(&ending),
            fields: fields.map(|fields| encode_fields(&fields)),
            times,
        })
    }
}

impl runner::Executor for JobWorker {
    fn run(&mut self, payload: &[u8]) -> Vec<u8> {
        let reply =
            self.reply(payload).unwrap_or_else(|error| JobReply::Refused(format!("{error:#}")));
        encode(&reply).expect("a reply is plain data")
    }
}

/// Does jobs for the coordinator that the argument names, each on so many threads.
pub(crate) fn worker(threads: usize, argument: &str) -> Result<Finish> {
    share_among(threads)?;
    work(&WorkerArguments::parse(argument)?, JobWorker::default)?;
    Ok(Finish::AllDone)
}
