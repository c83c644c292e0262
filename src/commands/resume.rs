//! `resume`: continues a study from the store alone.

use anyhow::Result;
use store::Store;

use crate::cli::ResumeArgs;
use crate::execution::{StudyToRun, execute};
use crate::output::Finish;
use crate::stored::stored_study;

/// Continues a study whose file need not exist any more.
pub(crate) fn resume(args: &ResumeArgs) -> Result<Finish> {
    // A resume that finds no study must not leave an empty store behind.
    let study = stored_study(&Store::read(&args.store.store)?, &args.name)?;
    execute(StudyToRun { study, file: None }, &args.store.store, &args.execution, None)
}
