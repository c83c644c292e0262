//! The `tribosweep` command: wires studies, runner, store and report together.
#![forbid(unsafe_code)]

mod accuracy;
mod adaptive;
mod cli;
mod compare;
mod cost;
mod draw;
mod effects;
mod launch;
mod ledger;
mod measure;
mod output;
mod patches;
mod progress;
mod query;
mod results;
mod show;
mod solutions;
mod solve;
mod store_commands;
mod work;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use crate::cli::{Cli, Command};
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
    let finished = match cli.command {
        Command::Run(args) => launch::run(&args),
        Command::Plan(args) => launch::plan(&args),
        Command::Effects(args) => measure::measure(&args),
        Command::Cost(args) => launch::cost(&args),
        Command::Resume(args) => launch::resume(&args),
        Command::Status(args) => query::status(&args),
        Command::Answer(args) => query::answer(&args),
        Command::Query(args) => query::query(&args),
        Command::Show(args) => show::show(&args),
        Command::Plot(args) => draw::plot(&args),
        Command::Solve(args) => solve::solve(&args),
        Command::Store(command) => store_commands::run(&command),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "tribosweep", &mut script);
            output::print(&String::from_utf8_lossy(&script))
        }
        Command::Measured { repeat } => measure::measured(repeat),
        Command::Worker { threads, argument } => work::run(threads, &argument),
    };
    match finished {
        Ok(finish) => finish.into(),
        Err(error) => {
            output::complain(&error);
            Finish::Mistake.into()
        }
    }
}
