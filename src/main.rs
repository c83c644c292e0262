//! The `tribosweep` command: wires studies, runner, store and report together.
#![forbid(unsafe_code)]

mod accuracy;
mod adaptive;
mod cli;
mod commands;
mod compare;
mod cost;
mod edit;
mod effects;
mod execution;
mod fields;
mod figures;
mod found;
mod job_list;
mod ladders;
mod ledger;
mod one_result;
mod output;
mod patches;
mod perform;
mod progress;
mod results;
mod rows;
mod solutions;
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
            // a closed pipe is nobody's mistake
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
