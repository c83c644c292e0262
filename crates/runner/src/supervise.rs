//! This file starts child processes, tells how they ended, and keeps what they promise when they
//! begin.

use std::ffi::OsString;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};

use rustix::process::{Pid, PidfdFlags, Resource, Rlimit, Signal, getppid, pidfd_open, setrlimit};

/// A worker process. It is killed and reaped when it is dropped.
#[derive(Debug)]
pub(crate) struct Process {
    child: Child,
    /// The descriptor that is readable once the process has ended, so that its death wakes the
    /// coordinator at once.
    end: OwnedFd,
}

impl Process {
    /// Starts `command` with one more argument. Its standard input and output are closed, and it
    /// shares standard error. It is in a process group of its own, so that Ctrl-C at the terminal
    /// reaches the coordinator alone.
    pub(crate) fn start(command: &[OsString], argument: &str) -> Result<Process, String> {
        let (program, arguments) = command.split_first().ok_or("no command")?;
        let mut command = Command::new(program);
        command
            .args(arguments)
            .arg(argument)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .process_group(0);
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        match pidfd_open(Pid::from_child(&child), PidfdFlags::empty()) {
            Ok(end) => Ok(Process { child, end }),
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
        let _ = self.child.kill();
    }

    pub(crate) fn end(&self) -> BorrowedFd<'_> {
        self.end.as_fd()
    }

    /// Returns how the process ended, or `None` while it lives.
    pub(crate) fn ended(&mut self) -> Option<String> {
        match self.child.try_wait() {
            Ok(None) => None,
            Ok(Some(status)) => Some(describe(status)),
            Err(error) => Some(format!("its exit status cannot be had: {error}")),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
        let _ = self.child.wait();
    }
}

fn describe(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("exit status {code}"),
        (None, Some(6)) => "signal 6, SIGABRT: out of memory, or a panic in a panic".into(),
        (None, Some(7)) => {
            "signal 7, SIGBUS: shared memory or a mapped file ran out of space".into()
        }
        (None, Some(9)) => "signal 9, SIGKILL".into(),
        (None, Some(11)) => "signal 11, SIGSEGV: stack overflow, or a fault in memory".into(),
        (None, Some(signal)) => format!("signal {signal}"),
        (None, None) => status.to_string(),
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
