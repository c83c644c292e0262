//! This file holds the directory of a run, the names of its shared memory, and the removal of what
//! dead runs left.
//!
//! Both names carry the same tag of 16 base-36 digits: the process-id namespace (2), the
//! coordinator's process id (5) and start time (7), and the number of the run in that process (2).
//! So a name alone tells whether its owner lives. Names are short because iceoryx2 puts root and
//! prefix before its own in the path of a socket, which holds 108 bytes.

use std::fs::{DirBuilder, Metadata};
use std::io::ErrorKind;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::process::getuid;

/// The directory of POSIX shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// The beginning of every name of the runner.
const NAME: &str = "tribo";
const TAG: usize = 16;
/// The number of bytes that iceoryx2 leaves of a socket's path for root and prefix together.
const LONGEST: usize = 60;

/// The reason why a run has no directory.
#[derive(Debug, thiserror::Error)]
#[error("none of {} can hold it: {}", list(.tried), .reasons.join("; "))]
pub struct RootError {
    tried: Vec<PathBuf>,
    reasons: Vec<String>,
}

fn list(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// The directory of one run. When it is dropped, it is removed with all shared memory of the run.
#[derive(Debug)]
pub(crate) struct Root {
    path: PathBuf,
    tag: String,
}

impl Root {
    /// Makes a new directory, for this user only, in the first place whose path is short enough.
    pub(crate) fn new() -> Result<Root, RootError> {
        static RUNS: AtomicU64 = AtomicU64::new(0);
        let owner = Owner::this(RUNS.fetch_add(1, Ordering::Relaxed));
        let mut error = RootError { tried: places(), reasons: Vec::new() };
        for place in &error.tried {
            match owner.clone().and_then(|owner| create(place, owner.tag())) {
                Ok(root) => return Ok(root),
                Err(reason) => error.reasons.push(reason),
            }
        }
        Err(error)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the beginning of the names of one worker's channel. The end mark keeps worker 1
    /// apart from worker 10.
    pub(crate) fn prefix(&self, worker: u32) -> String {
        format!("{NAME}{}{}_", self.tag, base36(worker.into(), 4))
    }

    /// Removes every trace of one channel.
    pub(crate) fn remove_channel(&self, worker: u32) {
        let prefix = self.prefix(worker);
        remove_prefixed(Path::new(SHARED_MEMORY), &prefix);
        remove_prefixed(&self.path, &prefix);
    }
}

impl Drop for Root {
    fn drop(&mut self) {
        remove_prefixed(Path::new(SHARED_MEMORY), &format!("{NAME}{}", self.tag));
        let _ = std::fs::remove_dir_all(&self.path);
        // The removal fails, as it should, while other runs are there.
        let _ = self.path.parent().map(std::fs::remove_dir);
    }
}

/// Removes the shared memory and the directories of runs whose coordinator is dead, and returns the
/// number of removed entries. Runs that live, other users and other software are left alone. So are
/// runs in other process-id namespaces, whose life cannot be seen from here.
pub fn sweep_leftovers() -> usize {
    let mut removed = 0;
    for entry in entries(Path::new(SHARED_MEMORY)) {
        let tag = entry
            .0
            .strip_prefix(NAME)
            .and_then(|rest| rest.get(..TAG).filter(|_| is_channel(&rest[TAG..])));
        if tag.and_then(Owner::parse).is_some_and(|owner| owner.is_dead()) {
            removed += usize::from(std::fs::remove_file(&entry.1).is_ok());
        }
    }
    for (name, path) in places().iter().flat_map(|place| entries(place)) {
        if name.len() == TAG && Owner::parse(&name).is_some_and(|owner| owner.is_dead()) {
            removed += usize::from(std::fs::remove_dir_all(&path).is_ok());
        }
    }
    removed
}

/// Returns true if `rest` follows the tag in a name of shared memory: worker, end mark, and what
/// iceoryx2 adds.
fn is_channel(rest: &str) -> bool {
    rest.split_once('_')
        .is_some_and(|(worker, _)| worker.len() >= 4 && worker.bytes().all(is_digit))
}

/// Returns the places for directories of runs, the best first. Each belongs to this user alone.
fn places() -> Vec<PathBuf> {
    let mine = format!("{NAME}-{}", base36(getuid().as_raw().into(), 1));
    let mut places = vec![std::env::temp_dir().join(&mine)];
    if let Some(runtime) = std::env::var_os("XDG_RUNTIME_DIR") {
        places.push(Path::new(&runtime).join(NAME));
    }
    places.push(Path::new("/tmp").join(mine));
    places.retain(|place| place.is_absolute());
    places.dedup();
    places
}

fn create(place: &Path, tag: String) -> Result<Root, String> {
    let path = place.join(&tag);
    let root = Root { path, tag };
    if root.path.to_str().is_none() {
        // The worker reads the path from its command line as text.
        return Err(format!("{} is not UTF-8", place.display()));
    }
    let length = root.path.as_os_str().len() + root.prefix(0).len();
    if length > LONGEST {
        return Err(format!("{} is {} bytes too long", place.display(), length - LONGEST));
    }
    let private = || {
        let mut builder = DirBuilder::new();
        builder.mode(0o700);
        builder
    };
    let explain = |error| format!("{}: {error}", place.display());
    // The run that ends last removes the place. If that happens right now, the place is made again.
    for _ in 0..10 {
        match private().create(place) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(explain(error)),
            _ => {}
        }
        let found = std::fs::symlink_metadata(place);
        if found.is_ok_and(|found| !found.is_dir() || !is_mine(&found) || found.mode() & 0o022 != 0)
        {
            return Err(format!(
                "{} exists and is not a directory of this user alone",
                place.display()
            ));
        }
        match private().create(&root.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            Err(error) => return Err(explain(error)),
            Ok(()) => return Ok(root),
        }
    }
    Err(format!("{} is removed whenever it is made", place.display()))
}

fn is_mine(metadata: &Metadata) -> bool {
    metadata.uid() == getuid().as_raw()
}

/// Lists the names and paths of the entries that belong to this user.
fn entries(dir: &Path) -> Vec<(String, PathBuf)> {
    let Ok(found) = std::fs::read_dir(dir) else { return Vec::new() };
    let mine =
        found.flatten().filter(|entry| entry.metadata().is_ok_and(|metadata| is_mine(&metadata)));
    mine.filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path()))).collect()
}

/// Removes the files in a directory and below whose names begin with `prefix`.
fn remove_prefixed(dir: &Path, prefix: &str) {
    for (name, path) in entries(dir) {
        let is_dir = std::fs::symlink_metadata(&path).is_ok_and(|metadata| metadata.is_dir());
        if !is_dir && name.starts_with(prefix) {
            let _ = std::fs::remove_file(path);
        } else if is_dir && dir != Path::new(SHARED_MEMORY) {
            remove_prefixed(&path, prefix);
        }
    }
}

/// Returns the free shared memory \[bytes\], or `None` if the system does not tell.
pub(crate) fn free_shared_memory() -> Option<u64> {
    rustix::fs::statvfs(SHARED_MEMORY).ok().map(|stat| stat.f_bavail.saturating_mul(stat.f_frsize))
}

/// The owner of a name.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Owner {
    namespace: u64,
    pid: u64,
    /// The clock ticks between boot and the start of the process, which tell a reused process id.
    start: u64,
    run: u64,
}

const NAMESPACES: u64 = 36 * 36;

impl Owner {
    fn this(run: u64) -> Result<Owner, String> {
        let pid = std::process::id().into();
        let ProcessStat { start, .. } =
            process_stat(pid).ok_or("/proc does not show this process")?;
        Ok(Owner {
            namespace: namespace().ok_or("/proc does not show the process-id namespace")?,
            pid,
            start,
            run: run % NAMESPACES,
        })
    }

    fn tag(&self) -> String {
        [(self.namespace, 2), (self.pid, 5), (self.start, 7), (self.run, 2)]
            .map(|(number, width)| base36(number, width))
            .concat()
    }

    fn parse(tag: &str) -> Option<Owner> {
        if tag.len() != TAG || !tag.bytes().all(is_digit) {
            return None;
        }
        let number = |range| u64::from_str_radix(tag.get(range)?, 36).ok();
        Some(Owner {
            namespace: number(0..2)?,
            pid: number(2..7)?,
            start: number(7..14)?,
            run: number(14..16)?,
        })
    }

    fn is_dead(&self) -> bool {
        let gone = || {
            process_stat(self.pid)
                .is_none_or(|process| process.start != self.start || process.is_dead)
        };
        namespace() == Some(self.namespace) && gone()
    }
}

fn is_digit(byte: u8) -> bool {
    byte.is_ascii_digit() || byte.is_ascii_lowercase()
}

fn namespace() -> Option<u64> {
    std::fs::metadata("/proc/self/ns/pid").ok().map(|metadata| metadata.ino() % NAMESPACES)
}

/// The fields of `/proc/PID/stat` that tell whether an owner lives.
struct ProcessStat {
    /// The clock ticks between boot and the start of the process.
    start: u64,
    /// It is true if the process is dead and only not yet reaped.
    is_dead: bool,
}

fn process_stat(pid: u64) -> Option<ProcessStat> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The second field is the program's name in parentheses, which may contain anything.
    let mut fields = stat[stat.rfind(')')? + 1..].split_ascii_whitespace();
    let is_dead = matches!(fields.next()?, "Z" | "X");
    Some(ProcessStat { start: fields.nth(18)?.parse().ok()?, is_dead })
}

fn base36(mut number: u64, width: usize) -> String {
    let mut digits = Vec::new();
    while number > 0 || digits.len() < width {
        digits.push(char::from_digit((number % 36) as u32, 36).unwrap_or('0'));
        number /= 36;
    }
    digits.iter().rev().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_names_its_owner() {
        let owner = Owner::this(3).unwrap();
        assert_eq!(owner.tag().len(), TAG);
        assert_eq!(Owner::parse(&owner.tag()), Some(owner));
        assert!(!owner.is_dead());
        assert!(Owner { start: owner.start + 1, ..owner }.is_dead(), "the process id was reused");
        assert!(Owner { pid: 60_000_000, ..owner }.is_dead());
        assert!(
            !Owner { pid: 60_000_000, namespace: (owner.namespace + 1) % NAMESPACES, ..owner }
                .is_dead(),
            "not ours to judge"
        );
        assert_eq!(Owner::parse("0123456789abcde"), None);
        assert_eq!(Owner::parse("0123456789ABCDEF"), None);
    }

    #[test]
    fn a_place_too_long_or_not_ours_is_refused() {
        let tag = || Owner::this(1295).unwrap().tag();
        let long = std::env::temp_dir().join("x".repeat(40));
        assert!(create(&long, tag()).unwrap_err().contains("bytes too long"));
        assert!(!long.exists());
        assert!(create(Path::new("/proc"), tag()).unwrap_err().contains("/proc"));
        let length = Root::new()
            .map(|root| root.path().as_os_str().len() + root.prefix(36u32.pow(4) - 1).len());
        assert!(length.unwrap() <= LONGEST);
    }

    #[test]
    fn a_sweep_takes_the_dead_and_leaves_the_rest() {
        let live = Root::new().unwrap();
        let dead = Owner { pid: 60_000_000, ..Owner::this(0).unwrap() };
        let shm = |name: String| Path::new(SHARED_MEMORY).join(name);
        let (ours, kept) = (
            shm(format!("{NAME}{}0001_x.data", dead.tag())),
            shm(format!("{}x.data", live.prefix(1))),
        );
        let stranger = shm(format!("{NAME}{}-notes", dead.tag()));
        let dir = live.path().with_file_name(dead.tag());
        for path in [&ours, &kept, &stranger] {
            std::fs::write(path, b"").unwrap();
        }
        std::fs::create_dir_all(dir.join("nodes")).unwrap();
        sweep_leftovers();
        assert!(!ours.exists() && !dir.exists());
        assert!(kept.exists() && stranger.exists() && live.path().exists());
        std::fs::remove_file(stranger).unwrap();
        let path = live.path().to_owned();
        drop(live);
        assert!(!kept.exists() && !path.exists());
    }
}
