//! This file opens the files of a store with care and says who may use them.
//!
//! A store may lie where others can write, so no symbolic link is followed when a file is opened
//! for writing, and nothing but a regular file is read: a pipe would stop the reader for good.

use std::fs::{self, File, Permissions};
use std::io::{self, Read};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, fchown};
use std::path::Path;

use rustix::fs::{Access, OFlags, access};
use rustix::io::Errno;
use rustix::process::geteuid;

/// The largest part of the list of users that is read \[bytes\].
const USERS_LIMIT: u64 = 1 << 20;

/// The advice about something that is in the place of the lock.
const WAY_OUT: &str = "remove it, or let `tribosweep store salvage` put it aside";

/// The use of a file that the system refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The file was to be read.
    Read,
    /// The file was to be written.
    Write,
}

/// Opens a regular file for reading.
pub(crate) fn open_to_read(path: &Path) -> io::Result<File> {
    // Without the flag, opening a pipe would wait for its writer.
    let opened =
        File::options().read(true).custom_flags(OFlags::NONBLOCK.bits().cast_signed()).open(path);
    let file = match opened {
        // A socket, or a device that does not exist, cannot even be opened.
        Err(error) if Errno::from_io_error(&error) == Some(Errno::NXIO) => {
            return Err(not_regular());
        }
        opened => opened?,
    };
    require_regular(&file)?;
    Ok(file)
}

/// Reads a regular file of at most `limit` bytes.
pub(crate) fn read_within(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let file = open_to_read(path)?;
    let length = file.metadata()?.len();
    if length > limit {
        let reason = format!("it has {length} bytes, and at most {limit} are expected");
        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
    }
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens a file that only this user may use, whatever the umask, and creates it if it is absent.
///
/// # Errors
/// There is something else in its place: a symbolic link, a file of another user, or a file that
/// has a second name.
pub(crate) fn open_private(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.read(true).write(true).mode(0o600);
    options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed());
    let file = loop {
        match options.clone().create_new(true).open(path) {
            Ok(file) => {
                inherit_owner(&file, path)?;
                break file;
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
        match options.open(path) {
            Ok(file) => break file,
            // Somebody has just removed it.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // An empty directory in its place is in nobody's way. A file is never removed by this.
            Err(error) if error.kind() == io::ErrorKind::IsADirectory => {
                fs::remove_dir(path).map_err(|_| other(format!("it is a directory; {WAY_OUT}")))?;
            }
            Err(error) if Errno::from_io_error(&error) == Some(Errno::LOOP) => {
                let what = "it is a symbolic link, which is not followed";
                return Err(other(format!("{what}; {WAY_OUT}")));
            }
            Err(error) => return Err(error),
        }
    };
    let found = file.metadata()?;
    if !found.is_file() {
        return Err(other(format!("it is no regular file; {WAY_OUT}")));
    }
    let user = geteuid();
    if found.uid() != user.as_raw() && !user.is_root() {
        return Err(other(format!("it belongs to {}", user_name(found.uid()))));
    }
    if found.nlink() > 1 {
        return Err(other("it is a file that has another name elsewhere; remove it"));
    }
    if found.mode() & 0o077 != 0 {
        // An earlier version of this program made it with the mode that the umask left.
        file.set_permissions(Permissions::from_mode(0o600))?;
    }
    Ok(file)
}

/// Gives a new file or directory of root to whom the directory around it belongs, so that a run as
/// root does not shut the owner of a store out of it.
pub(crate) fn inherit_owner(file: &File, path: &Path) -> io::Result<()> {
    if !geteuid().is_root() {
        return Ok(());
    }
    let above = path.parent().filter(|above| !above.as_os_str().is_empty());
    let above = fs::metadata(above.unwrap_or(Path::new(".")))?;
    if above.uid() == 0 {
        return Ok(());
    }
    fchown(file, Some(above.uid()), Some(above.gid()))
}

/// Opens a directory itself, and no link to one.
pub(crate) fn open_directory(path: &Path) -> io::Result<File> {
    let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW;
    File::options().read(true).custom_flags(flags.bits().cast_signed()).open(path)
}

/// Gives what root has made at `path`, a file or a directory, to whom the directory around it
/// belongs. What somebody else's is stays so, and so does a file that has another name elsewhere. A
/// link is left as it is, and what is gone is no error.
pub(crate) fn hand_over(path: &Path) -> io::Result<()> {
    if !geteuid().is_root() {
        return Ok(());
    }
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    match File::options().read(true).custom_flags(flags.bits().cast_signed()).open(path) {
        Ok(file) => {
            let found = file.metadata()?;
            let is_ours = found.uid() == 0 && (found.is_dir() || found.nlink() == 1);
            if is_ours { inherit_owner(&file, path) } else { Ok(()) }
        }
        Err(error) if Errno::from_io_error(&error) == Some(Errno::LOOP) => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error),
    }
}

/// Creates a directory with all that are missing above it, and gives what root has made of them to
/// whom the directory around belongs.
pub(crate) fn create_directories(path: &Path) -> io::Result<()> {
    let missing: Vec<&Path> = path
        .ancestors()
        .take_while(|above| !above.as_os_str().is_empty() && !above.exists())
        .collect();
    fs::create_dir_all(path)?;
    missing.into_iter().rev().try_for_each(hand_over)
}

/// Refuses what is not a regular file.
fn require_regular(file: &File) -> io::Result<()> {
    let kind = file.metadata()?.file_type();
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
    }
    Err(not_regular())
}

fn not_regular() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "it is not a regular file")
}

fn other(reason: impl Into<String>) -> io::Error {
    io::Error::other(reason.into())
}

/// Returns true if the error is about what is on the disk: the disk cannot read it, or something
/// else is in its place. Every other error may be gone at the next attempt.
pub(crate) fn is_damage(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidData, IsADirectory, NotADirectory, UnexpectedEof};
    matches!(error.kind(), UnexpectedEof | InvalidData | IsADirectory | NotADirectory)
        || Errno::from_io_error(error) == Some(Errno::IO)
}

/// Returns the reason in words why the system has refused this user `path`, or `None` if the error
/// is of another kind.
pub(crate) fn refusal(path: &Path, wanted: Wanted, error: &io::Error) -> Option<String> {
    match error.kind() {
        io::ErrorKind::ReadOnlyFilesystem => Some(
            "it is on a file system that is mounted read-only; it can be read, and a run needs \
             another store: name one with --store"
                .to_owned(),
        ),
        io::ErrorKind::PermissionDenied => Some(blame(path, wanted)),
        _ => None,
    }
}

/// Says whose file keeps this user from using `path`: the file itself or the nearest directory
/// above it that may not be used.
fn blame(path: &Path, wanted: Wanted) -> String {
    let (needed, verb) = match wanted {
        Wanted::Read => (Access::READ_OK, "read it"),
        Wanted::Write => (Access::WRITE_OK, "write to it"),
    };
    let above = path.parent().filter(|above| !above.as_os_str().is_empty());
    let there = above.unwrap_or(Path::new("."));
    let culprit = match fs::metadata(path) {
        Ok(_) if access(path, needed).is_err() => path,
        _ => there.ancestors().find(|above| fs::metadata(above).is_ok()).unwrap_or(there),
    };
    let user = geteuid().as_raw();
    match fs::metadata(culprit) {
        Ok(found) if found.uid() != user => format!(
            "{} belongs to {}; this user ({}) may not {verb}",
            culprit.display(),
            user_name(found.uid()),
            user_name(user)
        ),
        Ok(found) => format!(
            "{} has the mode {:04o}, so this user ({}) may not {verb}",
            culprit.display(),
            found.mode() & 0o7777,
            user_name(user)
        ),
        Err(error) => format!("{}: {error}", culprit.display()),
    }
}

/// Returns true if this user may write in the directory.
pub(crate) fn is_writable(directory: &Path) -> bool {
    access(directory, Access::WRITE_OK).is_ok()
}

/// Returns the name of the user to whom `path` belongs, if it is another one than this.
pub(crate) fn other_owner(path: &Path) -> Option<String> {
    let owner = fs::metadata(path).ok()?.uid();
    (owner != geteuid().as_raw()).then(|| user_name(owner))
}

/// Returns the name of a user, or the number where the machine's list of users has no name.
pub(crate) fn user_name(user: u32) -> String {
    let mut list = String::new();
    let read =
        File::open("/etc/passwd").and_then(|file| file.take(USERS_LIMIT).read_to_string(&mut list));
    let name = read.ok().and_then(|_| name_in(&list, user));
    name.map_or_else(|| format!("user {user}"), str::to_owned)
}

fn name_in(list: &str, user: u32) -> Option<&str> {
    list.lines().find_map(|line| {
        let mut words = line.split(':');
        let name = words.next()?;
        (words.nth(1)?.parse() == Ok(user)).then_some(name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn users_have_names() {
        let list = "root:x:0:0:root:/root:/bin/sh\nanna:x:1000:1000::/home/anna:/bin/sh\nbroken\n";
        assert_eq!(name_in(list, 1000), Some("anna"));
        assert_eq!(name_in(list, 1001), None);
    }

    #[test]
    fn a_private_file_is_for_its_owner_and_no_link_is_followed() {
        let directory = tempfile::tempdir().unwrap();
        let path = |name: &str| directory.path().join(name);
        let mode = |name: &str| fs::metadata(path(name)).unwrap().mode() & 0o777;
        open_private(&path("new")).unwrap();
        assert_eq!(mode("new"), 0o600);
        fs::write(path("old"), "words").unwrap();
        fs::set_permissions(path("old"), Permissions::from_mode(0o644)).unwrap();
        open_private(&path("old")).unwrap();
        assert_eq!((mode("old"), fs::read(path("old")).unwrap()), (0o600, b"words".to_vec()));

        fs::create_dir(path("empty")).unwrap();
        open_private(&path("empty")).unwrap();
        fs::create_dir_all(path("full/inner")).unwrap();
        open_private(&path("full")).unwrap_err();

        fs::write(path("letter"), "dear").unwrap();
        std::os::unix::fs::symlink(path("letter"), path("link")).unwrap();
        fs::hard_link(path("letter"), path("second")).unwrap();
        for (name, reason) in [("link", "symbolic link"), ("second", "another name")] {
            let error = open_private(&path(name)).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
        assert_eq!(fs::read(path("letter")).unwrap(), b"dear");
    }

    /// A user and a group that are nobody's on this machine.
    const STRANGER: u32 = 54_321;

    #[test]
    fn what_root_makes_is_the_owners_and_nothing_else_is_given_away() {
        if !geteuid().is_root() {
            eprintln!("skipped: only root may give files away");
            return;
        }
        let directory = tempfile::tempdir().unwrap();
        let path = |name: &str| directory.path().join(name);
        let owner = |name: &str| fs::metadata(path(name)).unwrap().uid();
        let give = |name: &str, user| {
            std::os::unix::fs::chown(path(name), Some(user), Some(user)).unwrap();
        };
        fs::create_dir(path("home")).unwrap();
        give("home", STRANGER);
        create_directories(&path("home/a/b/c")).unwrap();
        for name in ["home/a", "home/a/b", "home/a/b/c"] {
            assert_eq!(owner(name), STRANGER, "{name}");
        }
        // A file of root that its user has linked into the directory stays root's.
        fs::write(path("secret"), "words").unwrap();
        fs::hard_link(path("secret"), path("home/link")).unwrap();
        fs::write(path("home/third"), "words").unwrap();
        give("home/third", STRANGER + 1);
        fs::write(path("home/new"), "words").unwrap();
        for name in ["home/link", "home/third", "home/new"] {
            hand_over(&path(name)).unwrap();
        }
        assert_eq!((owner("secret"), owner("home/third")), (0, STRANGER + 1));
        assert_eq!(owner("home/new"), STRANGER);
    }

    #[test]
    fn only_regular_files_are_read_and_only_up_to_a_limit() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        rustix::fs::mknodat(
            rustix::fs::CWD,
            &pipe,
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
            0,
        )
        .unwrap();
        for (path, reason) in
            [(pipe.as_path(), "not a regular file"), (directory.path(), "is a directory")]
        {
            let error = read_within(path, 10).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
        let file = directory.path().join("file");
        fs::write(&file, "0123456789").unwrap();
        assert_eq!(read_within(&file, 10).unwrap(), b"0123456789");
        assert!(read_within(&file, 9).unwrap_err().to_string().contains("10 bytes"));
    }
}
