//! The `tribosweep` command: wires studies, answers, runner, store and report together.
//!
//! Each command stands in [`commands`] under its own name. The other files are what several
//! commands share: arguments, output, and the way from a study to its stored results.
#![forbid(unsafe_code)]

mod answer_text;
mod bounded_file;
mod cli;
mod commands;
mod effect_text;
mod execution;
mod fields;
mod figures;
mod job_list;
mod ledger;
mod one_result;
mod output;
mod progress;
mod stored;
mod study_file;
mod summary;
mod threads;
mod wire;
mod words;

use std::process::ExitCode;

use clap::Parser;

use crate::cli::Cli;
use crate::output::Finish;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // A closed pipe is nobody's mistake.
            let _ = error.print();
            return if error.use_stderr() {
                Finish::Mistake.into()
            } else {
                Finish::AllDone.into()
            };
        }
    };
    match commands::run(cli.command) {
        Ok(finish) => finish.into(),
        Err(error) => {
            output::complain(&error);
            Finish::Mistake.into()
        }
    }
}
