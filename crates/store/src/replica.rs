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
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use crate::access::{self, Wanted};
use crate::core::{read_manifest, require_log, require_promised};
use crate::database::{Fault, LARGE, RECORDS};
use crate::error::OpenError;
use crate::flat::FlatRecords;
use crate::manifest::Manifest;
use crate::scratch::{ScratchDirectory, ScratchError};
use crate::traces::{SETTLED, Trace, Traces};

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

    /// Returns the marks that the store had while it was copied, if nothing changed meanwhile.
    pub(crate) fn marks(&self) -> Option<&Traces> {
        self.traces.as_ref()
    }

    /// Returns true if nothing has changed in the store in `directory` since it was copied.
    pub(crate) fn is_current(&self, directory: &Path) -> bool {
        let is_same = |then: &Traces| Traces::of(directory).is_ok_and(|now| now.is_same(then));
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
