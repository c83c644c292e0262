//! Files that the user names, read with a bound: study files, and the height maps and profiles that
//! they name.

use std::fs::{File, OpenOptions};
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

use indicatif::BinaryBytes;
use rustix::fs::OFlags;

/// The largest study file \[bytes\].
pub(crate) const LARGEST_STUDY: u64 = 16 << 20;

/// The largest height map or profile \[bytes\].
pub(crate) const LARGEST_MAP: u64 = 256 << 20;

/// Reads a regular file of at most `largest` bytes.
///
/// # Errors
/// Returns in words why it cannot: the system's reason, that it is no regular file, or that it is
/// too large. The size is checked before and while the file is read, for it may grow, and some
/// files of the system do not state theirs.
pub(crate) fn read_bounded(path: &Path, largest: u64) -> Result<Vec<u8>, String> {
    let words = |error: std::io::Error| error.to_string();
    // A pipe without a writer would keep the program waiting for ever.
    let mut options = OpenOptions::new();
    options.read(true).custom_flags(OFlags::NONBLOCK.bits() as i32);
    // A directory or a socket may not even be opened.
    let metadata = std::fs::metadata(path).map_err(words)?;
    refuse_special(metadata.file_type())?;
    let file = options.open(path).map_err(words)?;
    // The name may have become another's in the meantime.
    let metadata = file.metadata().map_err(words)?;
    refuse_special(metadata.file_type())?;
    let most = BinaryBytes(largest);
    if metadata.len() > largest {
        return Err(format!("it has {}; it may have at most {most}", BinaryBytes(metadata.len())));
    }
    let bytes = read_at_most(file, metadata.len(), largest + 1).map_err(words)?;
    match bytes.len() as u64 > largest {
        true => Err(format!("it has more than {most}, the most that it may have")),
        false => Ok(bytes),
    }
}

fn read_at_most(file: File, size: u64, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a study file, which is text.
///
/// # Errors
/// Returns in words why it cannot.
pub(crate) fn read_study_text(path: &Path) -> Result<String, String> {
    let bytes = read_bounded(path, LARGEST_STUDY)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        format!("line {line} is not text in UTF-8, in which study files are written")
    })?;
    // Editors of other systems write a mark of the byte order.
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn refuse_special(kind: std::fs::FileType) -> Result<(), String> {
    let noun = if kind.is_file() {
        return Ok(());
    } else if kind.is_dir() {
        "a directory"
    } else if kind.is_fifo() {
        "a pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    };
    Err(format!("it is {noun}, not a regular file"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_within_the_bound_are_read() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        std::fs::write(&path, [7; 10]).unwrap();
        assert_eq!(read_bounded(&path, 10), Ok(vec![7; 10]));
        let refusal = |path: &Path, largest| read_bounded(path, largest).unwrap_err();
        assert_eq!(refusal(&path, 9), "it has 10 B; it may have at most 9 B");
        assert_eq!(refusal(directory.path(), 9), "it is a directory, not a regular file");
        assert_eq!(refusal(Path::new("/dev/zero"), 9), "it is a device, not a regular file");
        // The files of /proc state no size.
        assert_eq!(
            refusal(Path::new("/proc/self/status"), 9),
            "it has more than 9 B, the most that it may have"
        );
        let sparse = directory.path().join("sparse");
        File::create(&sparse).unwrap().set_len(100 << 30).unwrap();
        assert_eq!(
            refusal(&sparse, LARGEST_MAP),
            "it has 100.00 GiB; it may have at most 256.00 MiB"
        );
        let pipe = directory.path().join("pipe");
        rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR).unwrap();
        assert_eq!(refusal(&pipe, 9), "it is a pipe, not a regular file");
        std::fs::write(&path, b"name\n\xff").unwrap();
        assert!(read_study_text(&path).unwrap_err().starts_with("line 2 is not text in UTF-8"));
        std::fs::write(&path, "\u{feff}name").unwrap();
        assert_eq!(read_study_text(&path).as_deref(), Ok("name"));
    }
}
