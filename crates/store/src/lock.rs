//! The lock names the process that has the store open and the address on which it answers.
//!
//! The file `lock` is held with `flock`. The kernel releases it however its holder ends, so there
//! is no stale lock. Its content is believed only while the lock is held.

use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rustix::fs::{FlockOperation, flock};
use serde::{Deserialize, Serialize};

/// The process that has the store open.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Holder {
    pub(crate) pid: u32,
    /// The command line of the process.
    pub(crate) command: String,
    /// The time when it opened the store, in seconds since 1970-01-01 UTC.
    since: u64,
    /// The abstract Unix socket on which it answers readers. It is `None` if the process only reads
    /// and will be gone in a moment.
    pub(crate) address: Option<String>,
}

impl Holder {
    pub(crate) fn this_process(address: Option<String>) -> Self {
        let words: Vec<String> =
            std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
        Holder { pid: std::process::id(), command: words.join(" "), since: now(), address }
    }

    /// Returns the time for which the process has had the store.
    pub(crate) fn held_for(&self) -> Duration {
        Duration::from_secs(now().saturating_sub(self.since))
    }
}

fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

/// The lock, which is held until it is dropped.
#[derive(Debug)]
pub(crate) struct Lock(File);

/// The outcome of an attempt to take the lock.
#[derive(Debug)]
pub(crate) enum Acquired {
    /// The lock was free and is taken.
    Lock(Lock),
    /// Another process holds the lock, or this process already does. The holder is `None` if it has
    /// just locked and not yet signed, or has just released.
    Held(Option<Holder>),
}

impl Lock {
    /// Takes the lock of the store in `directory`, or returns its holder.
    pub(crate) fn acquire(directory: &Path) -> io::Result<Acquired> {
        let file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(directory.join("lock"))?;
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(Acquired::Lock(Lock(file))),
            Err(rustix::io::Errno::WOULDBLOCK) => Ok(Acquired::Held(read(file))),
            Err(error) => Err(error.into()),
        }
    }

    /// Writes into the file who holds the lock.
    pub(crate) fn sign(&mut self, holder: &Holder) -> io::Result<()> {
        let text = serde_json::to_vec(holder)?;
        self.0.set_len(0)?;
        self.0.rewind()?;
        self.0.write_all(&text)
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // This is a courtesy: nobody believes the content once the lock is free.
        let _ = self.0.set_len(0);
    }
}

fn read(mut file: File) -> Option<Holder> {
    let mut text = String::new();
    file.read_to_string(&mut text).ok()?;
    serde_json::from_str(&text).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lock(directory: &Path) -> Lock {
        match Lock::acquire(directory).unwrap() {
            Acquired::Lock(lock) => lock,
            Acquired::Held(holder) => panic!("held by {holder:?}"),
        }
    }

    fn holder(directory: &Path) -> Option<Holder> {
        match Lock::acquire(directory).unwrap() {
            Acquired::Lock(_) => panic!("not held"),
            Acquired::Held(holder) => holder,
        }
    }

    #[test]
    fn the_second_is_told_about_the_first() {
        let directory = tempfile::tempdir().unwrap();
        let mut first = lock(directory.path());
        assert_eq!(holder(directory.path()), None);
        let signature = Holder::this_process(Some("somewhere".to_owned()));
        first.sign(&signature).unwrap();
        assert_eq!(holder(directory.path()), Some(signature));
        drop(first);
        lock(directory.path());
    }
}
