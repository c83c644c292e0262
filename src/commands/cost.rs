//! `cost`: the time that accuracy costs.

use anyhow::Result;
use study::edit::with_cost_ladder;

use crate::account::study_file;
use crate::cli::CostArgs;
use crate::execution::{StudyToRun, execute};
use crate::output::Finish;
use crate::study_file::{edit_study, parse_study, read_text};

/// Runs a study of cost, or the one that is made for the scene of another study.
pub(crate) fn cost(args: &CostArgs) -> Result<Finish> {
    let path = &args.study;
    let text = read_text(path)?;
    let study = parse_study(&edit_study(with_cost_ladder, &text, path, &args.set)?, path)?;
    let file = Some(study_file(path, &text));
    execute(StudyToRun { study, file }, &args.store.store, &args.execution, None)
}
