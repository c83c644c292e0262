//! Child processes: how they are started, how they ended, and what they promise when they begin.

use std::ffi::OsString;
use std::io::{ErrorKind, Read, Write, stderr};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStderr, Command, Stdio};

use rustix::io::ioctl_fionbio;
use rustix::process::{Pid, PidfdFlags, Resource, Rlimit, Signal, getppid, pidfd_open, setrlimit};

use crate::loss::{Cause, Loss};

/// The path of the program that a process runs, even if its file has been replaced or removed.
pub const RUNNING_IMAGE: &str = "/proc/self/exe";

/// A worker process. It is killed and reaped when it is dropped.
#[derive(Debug)]
pub(crate) struct Process {
    child: Child,
    /// The descriptor that is readable once the process has ended, so that its death wakes the
    /// coordinator at once.
    end: OwnedFd,
    /// The standard error of the process, until it is closed.
    words: Option<ChildStderr>,
    /// The end of what the process said there.
    last_words: Vec<u8>,
    /// It is true once the coordinator has killed the process, which then was not the system.
    is_killed: bool,
}

/// The number of bytes that are kept of what a process says. A backtrace may follow the words that
/// tell why it was aborted.
const LAST_WORDS: usize = 64 << 10;
/// The number of bytes that are read of it at a time, at least as many as a pipe holds.
const MOST_WORDS: usize = 128 << 10;

impl Process {
    /// Starts `command` with one more argument. Its standard input and output are closed, and what
    /// it says on standard error is passed on. It is in a process group of its own, so that Ctrl-C
    /// at the terminal reaches the coordinator alone.
    pub(crate) fn start(command: &[OsString], argument: &str) -> Result<Process, String> {
        let (program, arguments) = command.split_first().ok_or("no command")?;
        let mut command = Command::new(program);
        // The command line shows the name by which the program was started.
        if let Some(name) = std::env::args_os().next().filter(|_| *program == *RUNNING_IMAGE) {
            command.arg0(name);
        }
        command
            .args(arguments)
            .arg(argument)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .process_group(0);
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        let words = child.stderr.take();
        let unblocked = words.as_ref().map_or(Ok(()), |pipe| ioctl_fionbio(pipe, true));
        let end = pidfd_open(Pid::from_child(&child), PidfdFlags::empty());
        match unblocked.and(end) {
            Ok(end) => Ok(Process { child, end, words, last_words: Vec::new(), is_killed: false }),
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                Err(format!("cannot watch process {}: {error}", child.id()))
            }
        }
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends SIGKILL, which also ends a stopped process.
    pub(crate) fn kill(&mut self) {
        // The signal fails only if the process has ended already.
        self.is_killed |= self.child.kill().is_ok();
    }

    pub(crate) fn end(&self) -> BorrowedFd<'_> {
        self.end.as_fd()
    }

    /// Returns the descriptor that is readable when the process has said something on standard
    /// error.
    pub(crate) fn words(&self) -> Option<BorrowedFd<'_>> {
        self.words.as_ref().map(AsFd::as_fd)
    }

    /// Passes on what the process has said on standard error, and keeps the end of it.
    pub(crate) fn pass_words_on(&mut self) {
        let (mut buffer, mut total) = ([0; 4096], 0);
        while let Some(pipe) = &mut self.words {
            match pipe.read(&mut buffer) {
                Ok(0) => self.words = None,
                Ok(length) => {
                    // Nobody may be there to read it.
                    let _ = stderr().write_all(&buffer[..length]);
                    self.last_words.extend_from_slice(&buffer[..length]);
                    let excess = self.last_words.len().saturating_sub(LAST_WORDS);
                    self.last_words.drain(..excess);
                    total += length;
                    if total >= MOST_WORDS {
                        return;
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(_) => self.words = None,
            }
        }
    }

    /// Returns how the process ended, or `None` while it lives. `is_starved` says whether the
    /// system has begun to kill processes for want of memory.
    pub(crate) fn ended(&mut self, is_starved: impl FnOnce() -> bool) -> Option<Loss> {
        match self.child.try_wait() {
            Ok(None) => None,
            Ok(Some(status)) => {
                self.pass_words_on();
                let last_words = String::from_utf8_lossy(&self.last_words);
                let is_starved = || !self.is_killed && is_starved();
                Some(Loss::of(status, &last_words, is_starved))
            }
            Err(error) => Some(Loss {
                how: format!("its exit status cannot be had: {error}"),
                cause: Cause::Circumstances,
            }),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
        let _ = self.child.wait();
        self.pass_words_on();
    }
}

/// Makes a worker die when its coordinator does. It fails if the coordinator is already gone.
pub(crate) fn die_with(coordinator: u32) -> Result<(), String> {
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL))
        .map_err(|error| format!("cannot ask for the parent-death signal: {error}"))?;
    // The coordinator may have died before the line above, and then nobody will signal.
    if is_parent(coordinator) {
        Ok(())
    } else {
        Err(format!("process {coordinator}, its coordinator, is not its parent"))
    }
}

/// Makes the system prefer a worker to its coordinator when it must kill for want of memory: a job
/// can be tried again. A system that does not allow it changes nothing.
pub(crate) fn volunteer_for_want_of_memory() {
    let _ = std::fs::write("/proc/self/oom_score_adj", "500");
}

/// Gives the process the name of its program for lists of processes. One that was started through
/// [`RUNNING_IMAGE`] would be called `exe`.
pub(crate) fn keep_name() {
    let name = std::env::args_os().next().and_then(|name| {
        let name = std::path::Path::new(&name).file_name()?.as_encoded_bytes().to_owned();
        std::ffi::CString::new(name).ok()
    });
    if let Some(name) = name {
        let _ = rustix::thread::set_name(&name);
    }
}

/// Returns true in a worker whose coordinator lives.
pub(crate) fn is_parent(coordinator: u32) -> bool {
    getppid().is_some_and(|parent| parent.as_raw_nonzero().get().unsigned_abs() == coordinator)
}

/// Limits the address space of a worker to `bytes`. An allocation beyond it fails, and the process
/// with it.
pub(crate) fn limit_address_space(bytes: u64) -> Result<(), String> {
    let hard = rustix::process::getrlimit(Resource::As).maximum;
    let bytes = hard.map_or(bytes, |hard| hard.min(bytes));
    setrlimit(Resource::As, Rlimit { current: Some(bytes), maximum: Some(bytes) })
        .map_err(|error| format!("cannot limit the address space to {bytes} bytes: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Memory may run out at the same time elsewhere.
    #[test]
    fn what_the_coordinator_kills_was_not_killed_for_want_of_memory() {
        let mut process = Process::start(&["sleep".into()], "60").unwrap();
        process.kill();
        let loss = loop {
            if let Some(loss) = process.ended(|| true) {
                break loss;
            }
            std::thread::yield_now();
        };
        assert_eq!(loss, Loss { how: "signal 9, SIGKILL".into(), cause: Cause::Job });
    }
}
