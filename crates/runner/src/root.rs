//! This file holds the directory of a run, the names of its shared memory, and the removal of what
//! dead runs left.
//!
//! The processes of a run meet in one directory of `/dev/shm`, where its shared memory is anyway:
//! the path of a socket holds 108 bytes, and this one is short whatever TMPDIR and HOME are. Jobs
//! and results that are too large for a message travel through another directory, on the volume
//! that keeps the results; a link in the first leads to it.
//!
//! As long as it lives, a coordinator holds the kernel's lock (`flock`) on its directory. Whoever
//! can take that lock may remove the directory and all shared memory of the same tag. Nobody judges
//! by process ids: they mean nothing between containers that share `/dev/shm`.

use std::fs::{DirBuilder, File, Metadata, Permissions};
use std::io::{ErrorKind, Read};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
use rustix::process::getuid;

/// The directory of POSIX shared memory.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// The beginning of every name of the runner.
const NAME: &str = "tribo-";
/// The number of characters of a tag, with 6 random bits each: as many as fit twice into the path
/// of a socket.
const TAG: usize = 18;
const TAG_CHARACTERS: &[u8; 64] =
    b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_";
/// The name of the link to the directory of large bodies.
const BODIES: &str = "bodies";

/// The reason why a run has no directory.
#[derive(Debug, thiserror::Error)]
#[error("cannot make {}: {why}", .path.display())]
pub struct RootError {
    path: PathBuf,
    why: std::io::Error,
}

/// The directory of one run. When it is dropped, it is removed with all shared memory of the run
/// and the directory of large bodies.
#[derive(Debug)]
pub(crate) struct Root {
    path: PathBuf,
    tag: String,
    /// The directory of large bodies.
    bodies: PathBuf,
    /// The descriptor that holds the lock on the directory.
    lock: File,
}

impl Root {
    /// Makes a new directory, for this user only, and an empty one for large bodies.
    pub(crate) fn new(bodies: &Path) -> Result<Root, RootError> {
        let bodies = std::path::absolute(bodies)
            .map_err(|why| RootError { path: bodies.to_owned(), why })?;
        let mut path = PathBuf::from(SHARED_MEMORY);
        let made = new_tag().and_then(|tag| {
            path = Path::new(SHARED_MEMORY).join(format!("{NAME}{tag}"));
            let lock = make_locked(&path)?;
            Ok(Root { path: path.clone(), tag, bodies: bodies.clone(), lock })
        });
        let root = made.map_err(|why| RootError { path, why })?;
        // Whoever holds the store may remove what a killed run left in it.
        remove_bodies(&bodies)
            .and_then(|()| private_directory(&bodies))
            .map_err(|why| RootError { path: bodies.clone(), why })?;
        let link = root.path.join(BODIES);
        std::os::unix::fs::symlink(&bodies, &link)
            .map_err(|why| RootError { path: link.clone(), why })?;
        Ok(root)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the directory anew if somebody has removed it. Channels that are open live on without
    /// it; new ones need it.
    pub(crate) fn restore(&mut self) -> Result<(), RootError> {
        let explain = |why| RootError { path: self.path.clone(), why };
        if !is_gone(&self.lock).map_err(explain)? {
            return Ok(());
        }
        self.lock = make_locked(&self.path).map_err(explain)?;
        std::os::unix::fs::symlink(&self.bodies, self.path.join(BODIES)).map_err(explain)
    }

    /// Returns the beginning of the names of one worker's channel. The end mark keeps worker 1
    /// apart from worker 10.
    pub(crate) fn prefix(&self, worker: u32) -> String {
        format!("{NAME}{}{}_", self.tag, base36(worker))
    }

    /// Removes every trace of one channel.
    pub(crate) fn remove_channel(&self, worker: u32) {
        let prefix = self.prefix(worker);
        remove_prefixed(Path::new(SHARED_MEMORY), &prefix);
        remove_prefixed(&self.path, &prefix);
        remove_prefixed(&self.bodies, &prefix);
    }
}

impl Drop for Root {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.bodies);
        remove_run(&self.path, &self.tag);
    }
}

/// Returns the directory of large bodies of the run in this directory, as a path that stays valid
/// when the run's directory is removed.
pub(crate) fn bodies(root: &Path) -> PathBuf {
    let link = root.join(BODIES);
    std::fs::read_link(&link).unwrap_or(link)
}

/// Removes what a killed run left in the directory of large bodies that it was given. Only the
/// holder of the store that it belongs to may do so.
///
/// # Errors
/// The directory cannot be removed.
pub fn remove_bodies(directory: &Path) -> std::io::Result<()> {
    match std::fs::symlink_metadata(directory) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
        Ok(found) if found.is_dir() => std::fs::remove_dir_all(directory),
        // A link is removed and not followed.
        Ok(_) => std::fs::remove_file(directory),
    }
}

/// Removes the shared memory and the directories of runs whose coordinator is dead, and returns the
/// number of removed directories. Runs that live, in whatever container, other users and other
/// software are left alone.
pub fn sweep_leftovers() -> usize {
    let mut removed = 0;
    for (name, path) in entries(Path::new(SHARED_MEMORY), NAME) {
        let Some(tag) = name.strip_prefix(NAME).filter(|tag| is_tag(tag)) else { continue };
        // The lock is held during the removal, so that nobody else removes it as well.
        if let Ok(Some(_lock)) = lock(&path) {
            remove_run(&path, tag);
            removed += 1;
        }
    }
    removed
}

/// Removes the shared memory of a run and then its directory, which bears the lock.
fn remove_run(path: &Path, tag: &str) {
    remove_prefixed(Path::new(SHARED_MEMORY), &format!("{NAME}{tag}"));
    let _ = std::fs::remove_dir_all(path);
}

/// Makes a new directory and takes its lock. A sweep that sees it before it is locked takes it for
/// a leftover, and then it is made again.
fn make_locked(path: &Path) -> std::io::Result<File> {
    let mut swept = std::io::Error::other("it is removed whenever it is made");
    for _ in 0..100 {
        match private_directory(path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            // It was removed before it got its rights; or there is no place for it.
            Err(error) if error.kind() == ErrorKind::NotFound => swept = error,
            Err(error) => return Err(error),
            Ok(()) => match lock(path) {
                Ok(Some(lock)) if !is_gone(&lock)? => return Ok(lock),
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
                _ => {}
            },
        }
        std::thread::yield_now();
    }
    Err(swept)
}

fn private_directory(path: &Path) -> std::io::Result<()> {
    DirBuilder::new().mode(0o700).create(path)?;
    // The umask may have taken rights from the owner.
    std::fs::set_permissions(path, Permissions::from_mode(0o700))
}

/// Takes the lock of a directory of this user, or returns `None` if another has it.
fn lock(path: &Path) -> std::io::Result<Option<File>> {
    let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    let directory = File::from(open(path, flags, Mode::empty())?);
    if !is_mine(&directory.metadata()?) {
        return Ok(None);
    }
    match flock(&directory, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(Some(directory)),
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Returns true if an open directory has been removed.
fn is_gone(directory: &File) -> std::io::Result<bool> {
    Ok(directory.metadata()?.nlink() == 0)
}

fn is_mine(metadata: &Metadata) -> bool {
    metadata.uid() == getuid().as_raw()
}

/// Lists the names and paths of the entries whose names begin with `prefix` and that belong to this
/// user. Of the others nothing is asked: many workers have thousands of entries together.
pub(crate) fn entries(dir: &Path, prefix: &str) -> Vec<(String, PathBuf)> {
    let Ok(found) = std::fs::read_dir(dir) else { return Vec::new() };
    let named =
        found.flatten().filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry)));
    let ours = named.filter(|(name, entry)| {
        name.starts_with(prefix) && entry.metadata().is_ok_and(|metadata| is_mine(&metadata))
    });
    ours.map(|(name, entry)| (name, entry.path())).collect()
}

/// Removes the files in a directory and below whose names begin with `prefix`.
fn remove_prefixed(dir: &Path, prefix: &str) {
    let is_dir = |path: &Path| std::fs::symlink_metadata(path).is_ok_and(|found| found.is_dir());
    for (_, path) in entries(dir, prefix) {
        if !is_dir(&path) {
            let _ = std::fs::remove_file(path);
        }
    }
    if dir == Path::new(SHARED_MEMORY) {
        return;
    }
    for (_, path) in entries(dir, "").into_iter().filter(|(_, path)| is_dir(path)) {
        remove_prefixed(&path, prefix);
    }
}

/// The shared memory of the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SharedMemory {
    /// The size of all of it \[bytes\].
    pub size: u64,
    /// The free part \[bytes\].
    pub free: u64,
}

/// Returns how much shared memory there is.
///
/// # Errors
/// The system does not tell; that it is not there is [`ErrorKind::NotFound`].
pub fn shared_memory() -> std::io::Result<SharedMemory> {
    let volume = rustix::fs::statvfs(SHARED_MEMORY)?;
    Ok(SharedMemory {
        size: volume.f_blocks.saturating_mul(volume.f_frsize),
        free: volume.f_bavail.saturating_mul(volume.f_frsize),
    })
}

/// Returns the free shared memory \[bytes\], or `None` if the system does not tell.
pub(crate) fn free_shared_memory() -> Option<u64> {
    shared_memory().ok().map(|memory| memory.free)
}

fn new_tag() -> std::io::Result<String> {
    let mut random = [0; TAG];
    File::open("/dev/urandom")?.read_exact(&mut random)?;
    Ok(random.map(|byte| char::from(TAG_CHARACTERS[usize::from(byte % 64)])).iter().collect())
}

fn is_tag(text: &str) -> bool {
    text.len() == TAG && text.bytes().all(|byte| TAG_CHARACTERS.contains(&byte))
}

fn base36(mut number: u32) -> String {
    let mut digits = Vec::new();
    while number > 0 || digits.is_empty() {
        digits.push(char::from_digit(number % 36, 36).unwrap_or('0'));
        number /= 36;
    }
    digits.iter().rev().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of bytes that iceoryx2 leaves of a socket's path for root and prefix together:
    /// the path holds 107 bytes, a separator, a number of up to 39 digits and the suffix `.e`.
    const LONGEST: usize = 107 - 1 - 39 - 2;

    fn shm(name: String) -> PathBuf {
        Path::new(SHARED_MEMORY).join(name)
    }

    /// A run that begins while another one clears up is not stopped by that.
    #[test]
    fn a_directory_that_is_swept_while_it_is_made_is_made_again() {
        let is_over = std::sync::atomic::AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(std::sync::atomic::Ordering::Relaxed) {
                    sweep_leftovers();
                }
            });
            for _ in 0..3000 {
                let tag = new_tag().unwrap();
                let path = Path::new(SHARED_MEMORY).join(format!("{NAME}{tag}"));
                let made = make_locked(&path).map(drop);
                remove_run(&path, &tag);
                if made.is_err() {
                    is_over.store(true, std::sync::atomic::Ordering::Relaxed);
                }
                made.unwrap();
            }
            is_over.store(true, std::sync::atomic::Ordering::Relaxed);
        });
    }

    #[test]
    fn every_name_fits_into_the_path_of_a_socket() {
        let bodies = tempfile::tempdir().unwrap();
        let root = Root::new(&bodies.path().join("b")).unwrap();
        let length = root.path().as_os_str().len() + root.prefix(u32::MAX).len();
        assert!(length <= LONGEST, "{length}");
        assert!(is_tag(&root.tag));
        let mode = std::fs::metadata(root.path()).unwrap().mode();
        assert_eq!(mode & 0o777, 0o700);
    }

    #[test]
    fn a_sweep_takes_the_dead_and_leaves_the_rest() {
        let place = tempfile::tempdir().unwrap();
        let live = Root::new(&place.path().join("live")).unwrap();
        let dead = Root::new(&place.path().join("dead")).unwrap();
        let (path, tag) = (dead.path().to_owned(), dead.tag.clone());
        let bodies = place.path().join("dead");
        // The lock of a killed process is released, and nothing else of it is cleaned up.
        flock(&dead.lock, FlockOperation::Unlock).unwrap();
        std::mem::forget(dead);
        let (ours, kept) =
            (shm(format!("{NAME}{tag}1_x.data")), shm(format!("{}x.data", live.prefix(1))));
        let stranger = shm(format!("{NAME}{}", "notes-of-a-stranger"));
        for path in [&ours, &kept, &stranger] {
            std::fs::write(path, b"").unwrap();
        }
        std::fs::create_dir_all(path.join("nodes")).unwrap();
        sweep_leftovers();
        assert!(!ours.exists() && !path.exists());
        assert!(kept.exists() && stranger.exists() && live.path().exists());
        assert!(bodies.exists(), "they belong to whoever holds the store");
        remove_bodies(&bodies).unwrap();
        assert!(!bodies.exists());
        std::fs::remove_file(stranger).unwrap();
        let path = live.path().to_owned();
        drop(live);
        assert!(!kept.exists() && !path.exists());
    }

    #[test]
    fn a_directory_that_somebody_removes_is_made_again_under_the_same_name() {
        let place = tempfile::tempdir().unwrap();
        let mut root = Root::new(&place.path().join("b")).unwrap();
        root.restore().unwrap();
        std::fs::remove_dir_all(root.path()).unwrap();
        root.restore().unwrap();
        assert!(root.path().is_dir());
        assert_eq!(bodies(root.path()), place.path().join("b"));
        assert!(lock(root.path()).unwrap().is_none(), "and it is locked again");
    }

    #[test]
    fn a_link_in_the_place_of_the_bodies_is_not_followed() {
        let place = tempfile::tempdir().unwrap();
        let (target, link) = (place.path().join("target"), place.path().join("b"));
        std::fs::create_dir(&target).unwrap();
        std::fs::write(target.join("precious"), b"").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let root = Root::new(&link).unwrap();
        assert!(target.join("precious").exists());
        assert!(std::fs::symlink_metadata(&link).unwrap().is_dir());
        drop(root);
        assert!(target.join("precious").exists());
    }

    #[test]
    fn a_root_without_a_place_is_an_error_in_words() {
        let error = Root::new(Path::new("/proc/bodies")).unwrap_err().to_string();
        assert!(error.starts_with("cannot make /proc/bodies: "), "{error}");
    }
}
