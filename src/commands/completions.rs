//! `completions`: a completion script for a shell.

use anyhow::Result;
use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::output::{self, Finish};

/// Prints a completion script for a shell.
pub(crate) fn completions(shell: Shell) -> Result<Finish> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "tribosweep", &mut script);
    output::print_raw(&String::from_utf8_lossy(&script))
}
