//! Programs of the system that are asked something, and that may never answer.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Seek};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{MemfdFlags, memfd_create};
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};

/// Runs a program, and returns what it said. After a time it is killed with all that it started.
///
/// # Errors
/// The program cannot be started, or it did not answer in time ([`ErrorKind::TimedOut`]).
pub(crate) fn answer_within(command: &mut Command, limit: Duration) -> Result<Output> {
    // A pipe would stay open as long as anything that the program has started.
    let (mut out, mut err) = (memory_file()?, memory_file()?);
    command.stdin(Stdio::null()).stdout(out.try_clone()?).stderr(err.try_clone()?);
    let mut child = command.process_group(0).spawn()?;
    match ends_within(&child, limit) {
        Ok(true) => {}
        outcome => {
            let _ = kill_process_group(Pid::from_child(&child), Signal::KILL);
            // What hangs in the kernel dies when that lets go of it, and is not waited for.
            let _ = child.try_wait();
            let words = format!("it did not answer within {} s", limit.as_secs_f64());
            return Err(outcome.err().unwrap_or(Error::new(ErrorKind::TimedOut, words)));
        }
    }
    let status = child.wait()?;
    Ok(Output { status, stdout: whole(&mut out)?, stderr: whole(&mut err)? })
}

fn memory_file() -> Result<File> {
    Ok(memfd_create("answer", MemfdFlags::CLOEXEC)?.into())
}

fn whole(file: &mut File) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Waits for the end of a process, and tells whether it came in time.
fn ends_within(child: &Child, limit: Duration) -> Result<bool> {
    let end = pidfd_open(Pid::from_child(child), PidfdFlags::empty())?;
    let start = Instant::now();
    loop {
        let left = limit.saturating_sub(start.elapsed());
        let left = Timespec::try_from(left).map_err(Error::other)?;
        match poll(&mut [PollFd::new(&end, PollFlags::IN)], Some(&left)) {
            Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
            Ok(ready) => return Ok(ready > 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(line: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", line]);
        command
    }

    #[test]
    fn an_answer_is_returned_with_its_end() {
        let said =
            answer_within(&mut shell("echo a; echo b >&2; exit 3"), Duration::from_secs(600))
                .unwrap();
        assert_eq!((said.stdout, said.stderr), (b"a\n".to_vec(), b"b\n".to_vec()));
        assert_eq!(said.status.code(), Some(3));
        let nowhere = answer_within(&mut Command::new("no-such-program"), Duration::from_secs(600));
        assert_eq!(nowhere.unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[test]
    fn what_does_not_answer_is_killed_with_what_it_started() {
        let place = tempfile::tempdir().unwrap();
        let pids = place.path().join("pids");
        let mut command = shell("sleep 1000 & echo $! > new; mv new pids; wait");
        command.current_dir(place.path());
        // As long as it takes until the sleeper is there.
        let mut limit = Duration::from_millis(200);
        while !pids.exists() {
            let error = answer_within(&mut command, limit).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::TimedOut);
            assert!(error.to_string().starts_with("it did not answer within "), "{error}");
            limit *= 2;
        }
        let pid: u32 = std::fs::read_to_string(pids).unwrap().trim().parse().unwrap();
        let is_asleep = || {
            let line = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            line.contains("(sleep) S")
        };
        while is_asleep() {
            std::thread::yield_now();
        }
    }
}
