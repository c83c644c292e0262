//! The lock names the process that has the store open and the address on which it answers.
//!
//! The file `lock` is held with `flock`. The kernel releases it however its holder ends, so there
//! is no stale lock. Only its owner may open it, so nobody else can hold it, and readers do not
//! lock at all. Its content is believed only while the process that it names is seen: the kernel
//! removes its socket with it.

use std::fs::{self, File};
use std::io::{self, Read, Seek, Write};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::{SocketAddr, UnixStream};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rustix::fs::{FlockOperation, flock};
use rustix::process::{Uid, geteuid};
use serde::{Deserialize, Serialize};

use crate::access;

/// The name of the file.
pub(crate) const FILE: &str = "lock";

/// The largest content that is believed to be a signature \[bytes\].
const SIGNATURE_LIMIT: u64 = 1 << 20;

/// The process that has the store open.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Holder {
    pub(crate) pid: u32,
    /// The command line of the process.
    pub(crate) command: String,
    /// The time when it opened the store, in seconds since 1970-01-01 UTC.
    since: u64,
    /// The abstract Unix socket that it has open.
    pub(crate) address: Option<String>,
    /// True if it answers readers on that socket.
    #[serde(default = "answers")]
    pub(crate) answers: bool,
    /// The user to whom the lock belongs.
    #[serde(skip)]
    owner: u32,
}

/// Returns what holds for the processes of earlier versions, which did not say it.
fn answers() -> bool {
    true
}

impl Holder {
    pub(crate) fn this_process(address: Option<String>, answers: bool) -> Self {
        let words: Vec<String> =
            std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
        Holder {
            pid: std::process::id(),
            command: words.join(" "),
            since: now(),
            address,
            answers,
            owner: geteuid().as_raw(),
        }
    }

    /// Returns the time for which the process has had the store.
    pub(crate) fn held_for(&self) -> Duration {
        Duration::from_secs(now().saturating_sub(self.since))
    }

    /// Returns true if the process is seen from here: by its socket, or by its number and command
    /// where the network is another one.
    fn is_seen(&self) -> bool {
        self.connect().is_ok() || self.is_listed()
    }

    /// Returns true if a process of this number and command is listed here. A holder that is seen
    /// and not listed has another space of process numbers, or it was killed this moment and what
    /// it was starting holds its files a little longer.
    pub(crate) fn is_listed(&self) -> bool {
        fs::read(format!("/proc/{}/cmdline", self.pid)).is_ok_and(|line| {
            let words = line.strip_suffix(b"\0").unwrap_or(&line).split(|byte| *byte == 0);
            let words: Vec<_> = words.map(String::from_utf8_lossy).collect();
            words.join(" ") == self.command
        })
    }

    /// Connects to the socket of the process. A socket of another user than that of the lock cannot
    /// be that of a process that has signed.
    pub(crate) fn connect(&self) -> io::Result<UnixStream> {
        let address = self.address.as_ref().ok_or(io::ErrorKind::AddrNotAvailable)?;
        let stream = UnixStream::connect_addr(&SocketAddr::from_abstract_name(address)?)?;
        if admitted(&stream, Uid::from_raw(self.owner)) {
            Ok(stream)
        } else {
            Err(io::ErrorKind::PermissionDenied.into())
        }
    }
}

/// Returns true if the peer of a stream is a user whom `user` trusts with the content of the store.
pub(crate) fn admitted(stream: &UnixStream, user: Uid) -> bool {
    rustix::net::sockopt::socket_peercred(stream)
        .is_ok_and(|peer| peer.uid == user || peer.uid.is_root())
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
    /// just locked and not yet signed, has just released, or cannot be seen from here.
    Held(Option<Holder>),
}

impl Lock {
    /// Takes the lock of the store in `directory`, or returns its holder.
    pub(crate) fn acquire(directory: &Path) -> io::Result<Acquired> {
        let path = directory.join(FILE);
        loop {
            let mut file = access::open_private(&path)?;
            match flock(&file, FlockOperation::NonBlockingLockExclusive) {
                // Whoever has removed the file in between may hold another one by now.
                Ok(()) if !is_at(&file, &path)? => {}
                Ok(()) => {
                    file.set_len(0)?;
                    file.rewind()?;
                    return Ok(Acquired::Lock(Lock(file)));
                }
                Err(rustix::io::Errno::WOULDBLOCK) => {
                    // A dead process may have left its words.
                    let holder = read(&file).filter(Holder::is_seen);
                    return Ok(Acquired::Held(holder));
                }
                Err(error) => return Err(error.into()),
            }
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
        // This is a courtesy: nobody believes the content once its process is gone.
        let _ = self.0.set_len(0);
    }
}

/// Reads the words of the last process that has locked the store in `directory`, if this user may
/// read them. They may be those of a dead process.
pub(crate) fn last_holder(directory: &Path) -> Option<Holder> {
    read(&access::open_to_read(&directory.join(FILE)).ok()?)
}

/// Returns true if some process holds the lock, as far as this user may know.
pub(crate) fn is_held(directory: &Path) -> bool {
    // The lock is shared for a moment, which a writer that is starting waits for.
    access::open_to_read(&directory.join(FILE)).is_ok_and(|file| {
        flock(&file, FlockOperation::NonBlockingLockShared) == Err(rustix::io::Errno::WOULDBLOCK)
    })
}

/// Returns the owner of a lock that this user may not look at, so that it cannot know whether some
/// process holds it.
pub(crate) fn hidden_owner(directory: &Path) -> Option<String> {
    let path = directory.join(FILE);
    let refused = access::open_to_read(&path).err()?;
    let owner = fs::symlink_metadata(&path).ok()?.uid();
    (refused.kind() == io::ErrorKind::PermissionDenied).then(|| access::user_name(owner))
}

fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    let ours = file.metadata()?;
    match fs::symlink_metadata(path) {
        Ok(there) => Ok((there.dev(), there.ino()) == (ours.dev(), ours.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

fn read(file: &File) -> Option<Holder> {
    let mut text = String::new();
    file.take(SIGNATURE_LIMIT).read_to_string(&mut text).ok()?;
    let owner = file.metadata().ok()?.uid();
    serde_json::from_str(&text).ok().map(|holder| Holder { owner, ..holder })
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixListener;

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
        assert!(is_held(directory.path()));
        assert_eq!(holder(directory.path()), None);
        let address = format!("tribosweep-test-{}-lock", std::process::id());
        let socket = SocketAddr::from_abstract_name(&address).unwrap();
        let listener = UnixListener::bind_addr(&socket).unwrap();
        let this = Holder::this_process(Some(address), true);
        // This process is seen without its socket too.
        let other = Holder { command: "another program".to_owned(), ..this.clone() };
        for signature in [&this, &other] {
            first.sign(signature).unwrap();
            assert_eq!(holder(directory.path()).as_ref(), Some(signature));
        }
        drop(listener);
        assert_eq!(holder(directory.path()), None, "stale words are not repeated");
        first.sign(&this).unwrap();
        assert_eq!(holder(directory.path()), Some(this));
        drop(first);
        assert!(!is_held(directory.path()));
        lock(directory.path());
    }

    #[test]
    fn a_lock_that_was_removed_is_not_taken_for_the_one_that_is_there() {
        let directory = tempfile::tempdir().unwrap();
        let first = lock(directory.path());
        fs::remove_file(directory.path().join(FILE)).unwrap();
        let second = lock(directory.path());
        assert!(!is_at(&first.0, &directory.path().join(FILE)).unwrap());
        assert!(is_at(&second.0, &directory.path().join(FILE)).unwrap());
    }
}
