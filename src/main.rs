//! The command `tribosweep`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    tribosweep::main()
}
