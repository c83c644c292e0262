//! `run`: launches or continues a study.

use anyhow::Result;

use crate::cli::RunArgs;
use crate::execution::execute;
use crate::output::Finish;
use crate::study_file::read_study;

/// Launches a study or continues it.
pub(crate) fn run(args: &RunArgs) -> Result<Finish> {
    execute(read_study(&args.study)?, &args.store.store, &args.execution)
}
