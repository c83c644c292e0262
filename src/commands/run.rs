//! `run`: launches or continues a study.

use anyhow::Result;

use crate::cli::RunArgs;
use crate::execution::execute;
use crate::output::Finish;
use crate::proposal::USUAL_STORE;
use crate::study_file::{StudyShard, read_shard};

/// Launches a study or continues it.
pub(crate) fn run(args: &RunArgs) -> Result<Finish> {
    let StudyShard { study, .. } = read_shard(&args.study, args.shard)?;
    let store = args.store.clone().unwrap_or_else(|| USUAL_STORE.into());
    execute(study, &store, &args.execution)
}
