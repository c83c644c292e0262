//! The files that the program writes where somebody asked for them: tables, figures, fields, pages.
//!
//! A file is there whole or not at all, and a link keeps leading to it. What is there and no
//! regular file, such as a pipe or a device, is written into and stays what it is.

use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use tempfile::NamedTempFile;

/// The beginning of the name of a file that is not whole yet.
const UNFINISHED: &str = ".unfinished-";
/// The most links that lead to each other, as Linux has it.
const MOST_LINKS: usize = 40;

/// Refuses a place where nothing can be written, before anything is read or computed.
pub(crate) fn check(file: &Path) -> Result<()> {
    let target = target(file)?;
    let found = fs::metadata(file).ok();
    if found.as_ref().is_some_and(fs::Metadata::is_dir) {
        bail!("cannot write {}: it is a directory", file.display());
    }
    if found.is_some_and(|found| found.is_file() && is_standard_output(&found)) {
        bail!("{} is where standard output goes; leave --output out", file.display());
    }
    let directory = directory(&target);
    if !directory.is_dir() {
        bail!("cannot write {}: there is no directory {}", file.display(), directory.display());
    }
    Ok(())
}

/// Refuses a place where no regular file can be written, before anything is read or computed.
pub(crate) fn check_regular(file: &Path) -> Result<()> {
    if fs::metadata(file).is_ok_and(|found| !found.is_file()) {
        bail!("{} is something else than a file; name one with --output", file.display());
    }
    check(file)
}

/// Refuses what is there and no file of its own, for a file whose name nobody has chosen: a link
/// would lead to a file of somebody else, and a pipe would wait for a reader.
pub(crate) fn check_own(file: &Path) -> Result<()> {
    if fs::symlink_metadata(file).is_ok_and(|found| !found.is_file()) {
        bail!("{} is something else than a file; remove it", file.display());
    }
    check(file)
}

/// Writes a file.
pub(crate) fn write(file: &Path, bytes: &[u8]) -> Result<()> {
    let written = WrittenFile::create(file)?;
    written.sink().write_all(bytes).with_context(|| failure(file))?;
    written.settle()
}

/// A file that is being written. It takes its place when it is settled; otherwise nothing is left
/// of it, except for what a pipe or a device has got.
pub(crate) struct WrittenFile<'p> {
    path: &'p Path,
    open: OpenFile,
}

/// The place to which bytes go before the file is whole.
enum OpenFile {
    /// The bytes go into a file beside that which it becomes.
    Beside { file: NamedTempFile, target: PathBuf },
    /// The bytes go into what is there.
    Present(File),
}

impl<'p> WrittenFile<'p> {
    /// Opens a file to be written.
    pub(crate) fn create(path: &'p Path) -> Result<Self> {
        check(path)?;
        let open = || -> Result<OpenFile, io::Error> {
            let found = match fs::metadata(path) {
                Ok(found) if !found.is_file() => {
                    return Ok(OpenFile::Present(File::options().write(true).open(path)?));
                }
                Ok(found) => {
                    // A file that may not be written is not replaced either.
                    File::options().write(true).open(path)?;
                    Some(found)
                }
                Err(_) => None,
            };
            let target = target(path)?;
            let file = tempfile::Builder::new()
                .prefix(UNFINISHED)
                // The umask is subtracted, as for any file.
                .permissions(Permissions::from_mode(0o666))
                .tempfile_in(directory(&target))?;
            if let Some(found) = found {
                file.as_file().set_permissions(found.permissions())?;
            }
            Ok(OpenFile::Beside { file, target })
        };
        Ok(WrittenFile { path, open: open().with_context(|| failure(path))? })
    }

    /// Returns the file that takes the bytes.
    pub(crate) fn sink(&self) -> &File {
        match &self.open {
            OpenFile::Beside { file, .. } => file.as_file(),
            OpenFile::Present(file) => file,
        }
    }

    /// Lets the file take its place, durably.
    pub(crate) fn settle(self) -> Result<()> {
        let OpenFile::Beside { file, target } = self.open else { return Ok(()) };
        let settled = || -> io::Result<()> {
            file.as_file().sync_all()?;
            file.persist(&target).map_err(|failed| failed.error)?;
            File::open(directory(&target))?.sync_all()
        };
        settled().with_context(|| failure(self.path))
    }
}

/// Says that a file cannot be written; the cause follows.
pub(crate) fn failure(file: &Path) -> String {
    format!("cannot write {}", file.display())
}

/// Returns the path to which the links at a path lead, whether something is there or not.
fn target(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = directory(&target).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::from_raw_os_error(rustix::io::Errno::LOOP.raw_os_error()))
}

/// Returns whether what was found is what standard output is written to.
fn is_standard_output(found: &fs::Metadata) -> bool {
    let output = io::stdout().as_fd().try_clone_to_owned().map(File::from);
    let output = output.and_then(|output| output.metadata());
    output.is_ok_and(|output| (output.dev(), output.ino()) == (found.dev(), found.ino()))
}

fn directory(file: &Path) -> &Path {
    match file.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<String> =
            entries.map(|entry| name(entry).into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("table.csv");
        fs::write(place.path().join("table.csv.part"), "of somebody else").unwrap();
        fs::write(&file, "before").unwrap();
        fs::set_permissions(&file, Permissions::from_mode(0o600)).unwrap();
        let given_up = WrittenFile::create(&file).unwrap();
        given_up.sink().write_all(b"half").unwrap();
        drop(given_up);
        assert_eq!(fs::read(&file).unwrap(), b"before");
        write(&file, b"after").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"after");
        assert_eq!(fs::metadata(&file).unwrap().mode() & 0o777, 0o600);
        assert_eq!(names(place.path()), ["table.csv", "table.csv.part"]);
        assert_eq!(fs::read(place.path().join("table.csv.part")).unwrap(), b"of somebody else");
    }

    #[test]
    fn a_link_keeps_leading_to_the_file() {
        let place = tempfile::tempdir().unwrap();
        let link = place.path().join("link");
        fs::create_dir(place.path().join("below")).unwrap();
        symlink("below/file", &link).unwrap();
        for bytes in [b"one", b"two"] {
            write(&link, bytes).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(fs::read(place.path().join("below/file")).unwrap(), bytes);
        }
        assert!(check_own(&link).is_err() && check_regular(&link).is_ok());
        symlink("round", place.path().join("round")).unwrap();
        assert!(write(&place.path().join("round"), b"").is_err());
    }

    #[test]
    fn a_pipe_is_written_into_and_stays_one() {
        use std::os::unix::fs::FileTypeExt;
        let place = tempfile::tempdir().unwrap();
        let pipe = place.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write(&pipe, b"words").unwrap();
        assert_eq!(reader.join().unwrap(), b"words");
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        assert!(check(&pipe).is_ok() && check_regular(&pipe).is_err());
        write(Path::new("/dev/null"), b"words").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    fn places_without_a_directory_are_refused() {
        let place = tempfile::tempdir().unwrap();
        let refusal = |file: &Path| check(file).unwrap_err().to_string();
        assert!(refusal(place.path()).ends_with("it is a directory"));
        assert!(refusal(&place.path().join("no/file")).contains("there is no directory"));
        fs::write(place.path().join("file"), "").unwrap();
        assert!(refusal(&place.path().join("file/file")).contains("there is no directory"));
    }
}
