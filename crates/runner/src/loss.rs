//! A worker is lost in a certain way, and that tells whether the job that it was running is to
//! blame.

use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;

/// The loss of a worker.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Loss {
    /// The signal or exit status in words.
    pub(crate) how: String,
    pub(crate) cause: Cause,
}

/// The cause of a loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// The job that was running brought its worker down. The attempt counts against it.
    Job,
    /// There was too little memory for the job beside the others, or altogether.
    Memory,
    /// Something else than the job ended the worker: a full file system, a limit of the process, a
    /// signal from outside, a failure of the connection.
    Circumstances,
}

impl Loss {
    /// Tells how a process ended whose last words on standard error are known. `is_starved` says
    /// whether the system has begun to kill processes for want of memory; it is asked only if that
    /// matters.
    pub(crate) fn of(
        status: ExitStatus,
        last_words: &str,
        is_starved: impl FnOnce() -> bool,
    ) -> Loss {
        let Some(signal) = status.signal() else {
            let how = match status.code() {
                Some(code) => format!("exit status {code}"),
                None => status.to_string(),
            };
            // A panic of a job is caught, so a worker that leaves by itself has lost its
            // connection.
            return Loss { how, cause: Cause::Circumstances };
        };
        let starved = signal == 9 && is_starved();
        let (name, meaning, cause) = match signal {
            1 => ("SIGHUP", "", Cause::Circumstances),
            2 => ("SIGINT", "", Cause::Circumstances),
            6 if lacked_memory(last_words) => ("SIGABRT", "out of memory", Cause::Memory),
            6 if last_words.contains(NO_STACK) => ("SIGABRT", "a stack overflow", Cause::Job),
            6 => ("SIGABRT", "a panic in a panic, or a call of abort", Cause::Job),
            7 => {
                ("SIGBUS", "shared memory or a mapped file ran out of space", Cause::Circumstances)
            }
            9 if starved => {
                ("SIGKILL", "the system had too little memory and killed it", Cause::Memory)
            }
            9 => ("SIGKILL", "", Cause::Job),
            10 => ("SIGUSR1", "", Cause::Circumstances),
            11 => ("SIGSEGV", "stack overflow, or a fault in memory", Cause::Job),
            15 => ("SIGTERM", "", Cause::Circumstances),
            24 => ("SIGXCPU", "the limit of processor time, `ulimit -t`", Cause::Circumstances),
            25 => ("SIGXFSZ", "the limit of the size of a file, `ulimit -f`", Cause::Circumstances),
            _ => ("", "", Cause::Job),
        };
        let name = if name.is_empty() { String::new() } else { format!(", {name}") };
        let meaning = if meaning.is_empty() { String::new() } else { format!(": {meaning}") };
        Loss { how: format!("signal {signal}{name}{meaning}"), cause }
    }
}

/// The beginning and the end of what the standard library says before it aborts a process that
/// cannot have the memory that it asks for.
const NO_MEMORY: [&str; 2] = ["memory allocation of ", " bytes failed"];
/// The words of the standard library before it aborts a process whose stack is full.
const NO_STACK: &str = "has overflowed its stack";

/// Tells by its last words whether a process was aborted because it lacked memory.
fn lacked_memory(last_words: &str) -> bool {
    let [begin, end] = NO_MEMORY;
    last_words.lines().any(|line| line.starts_with(begin) && line.contains(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_that_kills_for_want_of_memory_is_told_from_others_that_kill() {
        let killed = ExitStatus::from_raw(9);
        assert_eq!(Loss::of(killed, "", || false).cause, Cause::Job);
        let starved = Loss::of(killed, "", || true);
        assert_eq!(starved.cause, Cause::Memory);
        assert!(starved.how.starts_with("signal 9, SIGKILL: the system had too little memory"));
        let left = Loss::of(ExitStatus::from_raw(1 << 8), "", || unreachable!());
        assert_eq!(left, Loss { how: "exit status 1".into(), cause: Cause::Circumstances });
    }

    #[test]
    fn an_abort_is_for_want_of_memory_only_if_the_process_said_so() {
        let aborted = |words: &str| Loss::of(ExitStatus::from_raw(6), words, || unreachable!());
        for (words, meaning, cause) in [
            (
                "warned\nmemory allocation of 3000000000 bytes failed\n",
                "out of memory",
                Cause::Memory,
            ),
            ("\nthread 'main' (7) has overflowed its stack\n", "a stack overflow", Cause::Job),
            (
                "thread panicked while processing panic. aborting.\n",
                "a panic in a panic",
                Cause::Job,
            ),
            ("", "a panic in a panic, or a call of abort", Cause::Job),
        ] {
            let Loss { how, cause: found } = aborted(words);
            assert!(how.starts_with(&format!("signal 6, SIGABRT: {meaning}")), "{how}");
            assert_eq!(found, cause, "{words}");
        }
    }
}
