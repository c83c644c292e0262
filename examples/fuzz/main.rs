//! Feeds mutated study files, height maps, profiles, filters, records and messages to their
//! readers, in process: none may panic, take more than a gibibyte or more than five seconds.
//!
//! ```text
//! cargo run --release --example fuzz -- --count 1000000 --seed 1
//! cargo run --release --example fuzz -- --seed 1 --show 4711     # prints one input
//! ```
//!
//! The inputs are read by child processes of limited memory. The child leaves the number of its
//! input in a file before it reads it, so that the input that ends a child is known. A fault is a
//! line that begins with FAULT; the last line is a summary in JSON. `scripts/attack` runs this.

mod child;
mod corpus;
mod filters;
mod mutation;
mod parent;
mod studies;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

/// Feeds mutated input to every reader.
#[derive(Parser)]
struct Arguments {
    /// The number of inputs.
    #[arg(long, default_value_t = 10_000)]
    count: u64,
    /// The place where random numbers begin.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The number of processes.
    #[arg(long, default_value_t = 2)]
    processes: u64,
    /// Prints this input instead.
    #[arg(long)]
    show: Option<u64>,
    /// Reads inputs from this one on and leaves the number of each in a file.
    #[arg(long, hide = true, requires = "progress")]
    from: Option<u64>,
    #[arg(long, hide = true)]
    progress: Option<std::path::PathBuf>,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = Arguments::parse();
    let corpus = corpus::Corpus::new()?;
    if let Some(number) = arguments.show {
        let input = corpus.input(arguments.seed, number);
        println!("{:?}\n{}", input.kind, String::from_utf8_lossy(&input.bytes));
        return Ok(ExitCode::SUCCESS);
    }
    if let (Some(from), Some(progress)) = (arguments.from, &arguments.progress) {
        let inputs = (from..arguments.count).step_by(arguments.processes.max(1) as usize);
        child::read(&corpus, arguments.seed, inputs, progress)?;
        return Ok(ExitCode::SUCCESS);
    }
    let faults = parent::run(arguments.count, arguments.seed, arguments.processes.max(1))?;
    Ok(if faults == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
