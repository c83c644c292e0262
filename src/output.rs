//! Standard output, standard error and exit codes.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use answers::AnswerError;
use anyhow::{Context, Result};
use report::TerminalLayout;
use study::StudyError;
use wording::{escaped_json, visible};

/// The end of a command. An error is a mistake of the user or of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Finish {
    /// Everything asked for was done.
    AllDone,
    /// Something that was asked for is not possible.
    Mistake,
    /// The command finished, but some jobs failed.
    SomeFailed,
    /// The command finished, and what it compared differs.
    Differs,
    /// More jobs failed than were allowed, and some are left.
    TooManyFailed,
    /// The command stopped within its time or its number of jobs, and some are left.
    StoppedInTime,
    /// The command was interrupted.
    Interrupted,
}

impl From<Finish> for ExitCode {
    fn from(finish: Finish) -> Self {
        ExitCode::from(match finish {
            Finish::AllDone => 0,
            Finish::Mistake => 1,
            Finish::SomeFailed | Finish::Differs => 2,
            Finish::TooManyFailed => 3,
            // EX_TEMPFAIL of sysexits.h: to be started again.
            Finish::StoppedInTime => 75,
            Finish::Interrupted => 130,
        })
    }
}

/// Prints words to standard output, with everything [visible] that a terminal would obey.
pub(crate) fn print(text: &str) -> Result<Finish> {
    print_raw(&visible(text))
}

/// Prints to standard output what must stay as it is: colours, and formats that other programs
/// read. A reader that has gone away, as `head` does, is no error.
pub(crate) fn print_raw(text: &str) -> Result<Finish> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(Finish::AllDone),
    }
}

/// Says something beside the results, on standard error, with everything [visible] that a terminal
/// would obey. A closed standard error is no error.
pub(crate) fn say(text: &str) {
    say_raw(&visible(text));
}

fn say_raw(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Prints a value as indented JSON.
pub(crate) fn print_json(value: &impl serde::Serialize) -> Result<Finish> {
    print_raw(&escaped_json(&(serde_json::to_string_pretty(value)? + "\n")))
}

/// Prints an error with its causes to standard error.
pub(crate) fn complain(error: &anyhow::Error) {
    // The errors of a study are whole pictures of the file and begin with `error:` themselves.
    match study_error(error) {
        Some(study) => {
            let colours = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            say_raw(study.render(colours).trim_end());
        }
        None => say(&format!("error: {}", words(error))),
    }
}

/// Returns the words of an error with those of its causes.
pub(crate) fn words(error: &anyhow::Error) -> String {
    if let Some(study) = study_error(error) {
        return study.render(false).trim_end().to_owned();
    }
    let mut said = String::new();
    for cause in error.chain().map(ToString::to_string) {
        // A cause that its effect already quotes is not said twice.
        if !said.contains(&cause) {
            said = if said.is_empty() { cause } else { format!("{said}: {cause}") };
        }
    }
    said
}

/// Returns the error as one in a study's file, if it is one.
pub(crate) fn study_error(error: &anyhow::Error) -> Option<&StudyError> {
    match error.downcast_ref::<AnswerError>() {
        Some(AnswerError::Study(error)) => Some(error),
        _ => error.downcast_ref::<StudyError>(),
    }
}

/// Returns the columns of the terminal behind standard output; `None` if there is none.
pub(crate) fn terminal_width() -> Option<usize> {
    if !io::stdout().is_terminal() {
        return None;
    }
    terminal_size::terminal_size().map(|(width, _)| usize::from(width.0))
}

/// Returns the layout of tables on standard output.
pub(crate) fn layout() -> TerminalLayout {
    TerminalLayout { width: terminal_width(), digits: 6, prefixes: true, unicode: true }
}
