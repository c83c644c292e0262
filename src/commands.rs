//! The commands, a file each under its own name.
//!
//! They may use every other file of the program; no command uses another.

mod answer;
mod cite;
mod columns;
mod completions;
mod cost;
mod diff;
mod doctor;
mod effects;
mod keys;
mod measured;
mod note;
mod plan;
mod plot;
mod query;
mod reference;
mod report;
mod resume;
mod rm;
mod run;
mod show;
mod solve;
mod status;
mod store;
mod submit;
mod tag;
mod worker;

use anyhow::Result;

use crate::cli::Command;
use crate::output::Finish;

/// Carries out a command.
pub(crate) fn run(command: Command) -> Result<Finish> {
    match command {
        Command::Run(args) => run::run(&args),
        Command::Submit(args) => submit::submit(&args),
        Command::Plan(args) => plan::plan(&args),
        Command::Effects(args) => effects::effects(&args),
        Command::Cost(args) => cost::cost(&args),
        Command::Resume(args) => resume::resume(&args),
        Command::Status(args) => status::status(&args),
        Command::Answer(args) => answer::answer(&args),
        Command::Query(args) => query::query(&args),
        Command::Cite(args) => cite::cite(&args),
        Command::Report(args) => report::report(&args),
        Command::Show(args) => show::show(&args),
        Command::Plot(args) => plot::plot(&args),
        Command::Diff(args) => diff::diff(&args),
        Command::Tag(args) => tag::tag(&args),
        Command::Note(args) => note::note(&args),
        Command::Rm(args) => rm::rm(&args),
        Command::Solve(args) => solve::solve(&args),
        Command::Store(command) => store::store(&command),
        Command::Doctor(args) => doctor::doctor(&args),
        Command::Keys(args) => keys::keys(&args),
        Command::Columns(args) => columns::columns(&args),
        Command::Reference { directory } => reference::reference(&directory),
        Command::Completions { shell } => completions::completions(shell),
        Command::Measured { repeat } => measured::measured(repeat),
        Command::Worker { threads, argument } => worker::worker(threads, &argument),
    }
}
