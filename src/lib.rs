//! The program `tribosweep`: wires studies, answers, runner, store and report together.
//!
//! Each command stands in `commands` under its own name. The other files are what several
//! commands share: arguments, output, and the way from a study to its stored results. Beside the
//! commands stands [`library`], by which other languages use the same ways in process.
#![forbid(unsafe_code)]

mod account;
mod answer_text;
mod below_surface;
mod bounded_file;
mod citation_text;
mod cli;
mod commands;
mod earlier_results;
mod effect_text;
mod execution;
mod exporting;
mod failure_limit;
mod fields;
mod figures;
mod frozen_study;
mod garbage;
mod increments;
mod influence_figure;
mod job_list;
mod job_pattern;
mod kept_study;
mod labels;
mod ledger;
pub mod library;
mod local_store;
mod machine;
mod merge_rules;
mod merged;
mod one_result;
mod output;
mod patience;
mod progress;
mod proposal;
mod reference_pages;
mod run_jobs;
mod scheduler;
mod series;
mod shard_choice;
mod shard_states;
mod slurm;
mod solving;
mod stored;
mod stored_results;
mod study_file;
mod study_table;
mod submission;
mod summary;
mod table_file;
mod table_part;
mod table_proof;
mod threads;
mod time_budget;
mod time_left;
mod typed_values;
mod wire;
mod words;
mod written_file;

use std::process::ExitCode;

use anyhow::Result;
use clap::{CommandFactory, Parser};

use crate::cli::{Cli, Command};
use crate::output::Finish;

/// Returns the commands and options of the program, of which the manual pages are made.
pub fn usage() -> clap::Command {
    Cli::command()
}

/// Carries out the command that the arguments of this process give.
pub fn main() -> ExitCode {
    // Reading the command line takes more stack than there may be.
    if let Err(error) = runner::enough_stack() {
        output::complain(&error.into());
        return Finish::Mistake.into();
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // The arguments that it quotes may hold anything. A closed pipe is nobody's mistake.
            let plain = error.render().to_string();
            if wording::visible(&plain) == plain {
                let _ = error.print();
            } else {
                output::say(plain.trim_end());
            }
            return if error.use_stderr() {
                Finish::Mistake.into()
            } else {
                Finish::AllDone.into()
            };
        }
    };
    match prepare(&cli.command).and_then(|()| commands::run(cli.command)) {
        Ok(finish) => finish.into(),
        Err(error) => {
            output::complain(&error);
            Finish::Mistake.into()
        }
    }
}

/// Prepares the process for a command within the limits that the system sets it. The helpers of a
/// run inherit that.
fn prepare(command: &Command) -> Result<()> {
    match command {
        Command::Completions { .. }
        | Command::Keys(_)
        | Command::Columns(_)
        | Command::Reference { .. }
        | Command::Worker { .. }
        | Command::Measured { .. } => Ok(()),
        // What is too little is a finding of the doctor.
        Command::Doctor(_) => Ok(()),
        Command::Solve(_) => Ok(runner::prepare_process()?),
        _ => {
            runner::prepare_process()?;
            runner::keep_little();
            threads::limit()
        }
    }
}
