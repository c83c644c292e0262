//! A reader that no process answers takes a private copy of the records and reads that.
//!
//! sled writes to the files that it opens, so it never opens those of a store that is only read:
//! they may be on a read-only medium or belong to another user, and a reader must not stand in the
//! way of a writer. The copy needs no lock. It is whole if nothing changed while it was taken,
//! which the times and sizes of the files tell. If the store is written to all the time, a copy
//! counts if it holds as many records as the manifest had promised before, and if each of them is
//! sound: such a copy may lack the records of the last moments.

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::access::{self, Wanted};
use crate::core::{read_manifest, require_log, require_promised};
use crate::database::{self, Fault, LARGE, RECORDS};
use crate::error::OpenError;
use crate::flat::FlatRecords;
use crate::manifest::Manifest;
use crate::scratch::{ScratchDirectory, ScratchError};

/// The age from which on a file is known to have changed if it changes again: the clock of a file
/// system moves in steps of a few milliseconds.
const SETTLED: Duration = Duration::from_millis(20);

/// The time for which a copy is sought during which nothing changed.
const QUIET_PATIENCE: Duration = Duration::from_secs(1);

/// The time after which a store counts as unreadable that is written to all the time.
const PATIENCE: Duration = Duration::from_secs(8);

/// The records of a store in a private copy, which nobody finds and which is gone when it is
/// dropped.
pub(crate) struct Replica {
    pub(crate) records: FlatRecords,
    /// The marks that the store had while it was copied, if nothing changed meanwhile.
    traces: Option<Traces>,
}

/// The reason why there is no copy.
enum CopyError {
    /// A file has disappeared.
    Changed,
    /// There is something wrong with the files.
    Damaged(String),
    /// The copy cannot be had at all.
    Impossible(OpenError),
}

impl Replica {
    /// Copies the records of the store in `directory`.
    pub(crate) fn take(directory: &Path) -> Result<Self, OpenError> {
        let start = Instant::now();
        let mut candidate = None;
        loop {
            let manifest = read_manifest(directory)?
                .ok_or_else(|| OpenError::Missing { directory: directory.to_owned() })?;
            let before = Traces::settled(directory)?;
            let copied = Self::copy(directory, &manifest, &before);
            let is_whole = before.tell_changes && Traces::of(directory)? == before;
            let last = match copied {
                Ok(replica) if is_whole => {
                    return Ok(Replica { traces: Some(before), ..replica });
                }
                Ok(replica) => {
                    // A record of another version is sound; one that was damaged before stays so,
                    // and is not waited for for ever.
                    let is_late = start.elapsed() > PATIENCE;
                    if is_late || replica.records.is_sound() {
                        candidate = Some(replica);
                    }
                    "it changed meanwhile".to_owned()
                }
                Err(CopyError::Impossible(error)) => return candidate.ok_or(error),
                // Nothing was acknowledged yet, so nothing is lost.
                Err(CopyError::Damaged(_)) if is_whole && manifest.records == 0 => {
                    return Self::empty(directory);
                }
                Err(CopyError::Damaged(what)) if is_whole => {
                    return Err(OpenError::Damaged { directory: directory.to_owned(), what });
                }
                Err(CopyError::Damaged(what)) => what,
                Err(CopyError::Changed) => "a file has disappeared".to_owned(),
            };
            if start.elapsed() > QUIET_PATIENCE
                && let Some(replica) = candidate.take()
            {
                return Ok(replica);
            }
            if start.elapsed() > PATIENCE {
                return Err(OpenError::Changing { directory: directory.to_owned(), last });
            }
            thread::sleep(SETTLED);
        }
    }

    /// Returns true if nothing has changed in the store in `directory` since it was copied.
    pub(crate) fn is_current(&self, directory: &Path) -> bool {
        let is_same =
            |then: &Traces| Traces::of(directory).is_ok_and(|now| now.files == then.files);
        self.traces.as_ref().is_some_and(is_same)
    }

    /// Returns the records of a store that has none.
    fn empty(directory: &Path) -> Result<Self, OpenError> {
        let scratch = ScratchDirectory::new(0).map_err(|error| no_room(directory, error))?;
        let records = FlatRecords::of(scratch.path(), scratch.path())
            .map_err(|fault| not_opened(scratch.path(), fault))?;
        Ok(Replica { records, traces: None })
    }

    fn copy(directory: &Path, manifest: &Manifest, traces: &Traces) -> Result<Self, CopyError> {
        require_log(directory, manifest).map_err(CopyError::of_store)?;
        let from = directory.join(RECORDS);
        // The records are copied twice: as the files of the database, and from it.
        let scratch = ScratchDirectory::new(traces.bytes().saturating_mul(2))
            .map_err(|error| CopyError::Impossible(no_room(directory, error)))?;
        fs::create_dir(scratch.path().join(LARGE))
            .map_err(|source| CopyError::of_copy(scratch.path(), source))?;
        // The log is copied after its snapshots, and before what it refers to.
        for Trace { name, .. } in &traces.files {
            copy_file(&from.join(name), &scratch.path().join(name))?;
        }
        let records =
            FlatRecords::of(scratch.path(), scratch.path()).map_err(|fault| match fault {
                Fault::Damaged(what) => CopyError::Damaged(what),
                fault => CopyError::Impossible(not_opened(scratch.path(), fault)),
            })?;
        require_promised(directory, manifest, records.len() as u64).map_err(CopyError::of_store)?;
        Ok(Replica { records, traces: None })
    }
}

impl CopyError {
    fn of_store(error: OpenError) -> Self {
        match error {
            OpenError::Damaged { what, .. } => CopyError::Damaged(what),
            error => CopyError::Impossible(error),
        }
    }

    fn of_copy(path: &Path, source: io::Error) -> Self {
        CopyError::Impossible(OpenError::io("copy the records to", Wanted::Write, path, source))
    }
}

fn no_room(directory: &Path, error: ScratchError) -> OpenError {
    let ScratchError { bytes, tried } = error;
    OpenError::NoRoom { directory: directory.to_owned(), bytes, tried }
}

fn not_opened(scratch: &Path, fault: Fault) -> OpenError {
    let source = match fault {
        Fault::Io(error) => error,
        Fault::Damaged(what) => io::Error::other(what),
    };
    OpenError::io("open the copy of the records in", Wanted::Write, scratch, source)
}

/// Copies as much of a file as it has when the copying begins.
fn copy_file(from: &Path, to: &Path) -> Result<(), CopyError> {
    let read = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => CopyError::Changed,
        _ if access::is_damage(&source) => {
            CopyError::Damaged(format!("{}: {source}", from.display()))
        }
        _ => CopyError::Impossible(OpenError::io("read", Wanted::Read, from, source)),
    };
    let file = access::open_to_read(from).map_err(read)?;
    let length = file.metadata().map_err(read)?.len();
    let mut copy = File::create_new(to).map_err(|source| CopyError::of_copy(to, source))?;
    match io::copy(&mut file.take(length), &mut copy) {
        Ok(_) => Ok(()),
        Err(error) if access::is_damage(&error) => Err(read(error)),
        Err(error) => Err(CopyError::of_copy(to, error)),
    }
}

/// The marks that changes leave on the files of a database.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Traces {
    files: Vec<Trace>,
    /// True if every change of a file from now on will show in these marks.
    tell_changes: bool,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Trace {
    /// The path of the file below the directory of the database.
    name: PathBuf,
    inode: u64,
    bytes: u64,
    /// The time of the last change, since 1970-01-01 UTC.
    changed: Duration,
}

impl Traces {
    fn of(directory: &Path) -> Result<Self, OpenError> {
        let path = directory.join(RECORDS);
        let refused = |source| OpenError::io("read", Wanted::Read, &path, source);
        let mut files = Vec::new();
        let names = match database::own_files(&path) {
            Ok(names) => names.into_iter().map(PathBuf::from).collect(),
            // The manifest is older than the database.
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) if access::is_damage(&error) => Vec::new(),
            Err(error) => return Err(refused(error)),
        };
        let mut large = match fs::read_dir(path.join(LARGE)) {
            Ok(entries) => entries
                .map(|entry| entry.map(|entry| Path::new(LARGE).join(entry.file_name())))
                .collect::<io::Result<Vec<_>>>()
                .map_err(refused)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) if access::is_damage(&error) => Vec::new(),
            Err(error) => return Err(refused(error)),
        };
        large.sort();
        let mut newest = Duration::ZERO;
        for name in names.into_iter().chain(large) {
            // A file that has disappeared is missing from the next list too.
            let Ok(found) = fs::metadata(path.join(&name)) else { continue };
            let seconds = found.mtime().max(0).cast_unsigned();
            let nanoseconds = u32::try_from(found.mtime_nsec()).unwrap_or(0);
            let changed = Duration::new(seconds, nanoseconds);
            newest = newest.max(changed);
            files.push(Trace { name, inode: found.ino(), bytes: found.len(), changed });
        }
        // A time in the future differs from that of any change now.
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let tell_changes = now.abs_diff(newest) > SETTLED;
        Ok(Traces { files, tell_changes })
    }

    /// Returns the traces as soon as they would tell of changes, or those of a store that is being
    /// written to.
    fn settled(directory: &Path) -> Result<Self, OpenError> {
        let traces = Self::of(directory)?;
        if traces.tell_changes {
            return Ok(traces);
        }
        thread::sleep(SETTLED + SETTLED / 2);
        Self::of(directory)
    }

    /// Returns the size of all files together \[bytes\].
    fn bytes(&self) -> u64 {
        self.files.iter().fold(0, |sum, file| sum.saturating_add(file.bytes))
    }
}
