//! This file saves what can be read of a damaged store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use rustix::io::Errno;

use identity::JobKey;

use crate::blob::Blobs;
use crate::core::{RECORDS, lock_for_writing};
use crate::database::{Database, Fault};
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::manifest::{FILE, Manifest, Unreadable};
use crate::record;

/// The directory of the sound database while it is being written.
const SALVAGED: &str = "records.salvaged";

/// The result of a salvage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Salvage {
    /// The number of saved records.
    pub kept: usize,
    /// The number of records that the manifest promised. It is `None` if the manifest could not be
    /// read either; then the names of the studies are lost with it.
    pub promised: Option<u64>,
    /// The number of saved studies.
    pub studies: usize,
    /// The studies whose definition is damaged or gone. They are no longer listed, and running
    /// their files brings them back.
    pub lost_studies: Vec<String>,
    /// The new path of the damaged database, or `None` if there was none.
    pub damaged: Option<PathBuf>,
}

pub(crate) fn salvage(directory: &Path) -> Result<Salvage, OpenError> {
    let io = |action, path: &Path| {
        let path = path.to_owned();
        move |source| OpenError::Io { action, path, source }
    };
    if !directory.join(FILE).exists() && !directory.join(RECORDS).exists() {
        return Err(OpenError::Missing { directory: directory.to_owned() });
    }
    let _lock = lock_for_writing(directory, None)?;
    let (promised, studies) = match Manifest::read(directory) {
        Ok(manifest) => (Some(manifest.records), manifest.studies),
        Err(Unreadable::Format(found)) => {
            return Err(OpenError::Format { directory: directory.to_owned(), found });
        }
        Err(Unreadable::Io(source)) => return Err(io("read", &directory.join(FILE))(source)),
        Err(Unreadable::Absent | Unreadable::Damaged(_)) => (None, BTreeMap::new()),
    };
    let (records, salvaged) = (directory.join(RECORDS), directory.join(SALVAGED));
    if !records.exists() && salvaged.exists() {
        // An earlier salvage was killed at its last step.
        fs::rename(&salvaged, &records).map_err(io("put into place", &salvaged))?;
    }
    if salvaged.exists() {
        fs::remove_dir_all(&salvaged).map_err(io("remove", &salvaged))?;
    }

    // sled enlarges and rewrites its files when it opens them.
    WriteError::require_space(directory, 0)?;
    let sound = if records.exists() {
        readable(&records).map_err(io("read", &records))?
    } else {
        BTreeMap::new()
    };
    WriteError::require_space(directory, sound.values().map(|sealed| sealed.len() as u64).sum())?;
    let failed = |fault| match fault {
        Fault::Io(source) => io("write the database", &salvaged)(source),
        Fault::Damaged(what) => OpenError::Damaged { directory: directory.to_owned(), what },
    };
    durable::create_directory(&salvaged).map_err(io("create", &salvaged))?;
    let database = Database::open(&salvaged).map_err(failed)?;
    database.insert(sound.iter().map(|(key, sealed)| (key, sealed.clone()))).map_err(failed)?;
    database.sync().map_err(failed)?;
    database.sync_files().map_err(io("make durable", &salvaged))?;
    drop(database);

    let blobs = Blobs::of(directory);
    let (mut kept, mut lost) = (BTreeMap::new(), Vec::new());
    for (name, digest) in studies {
        match blobs.get(&digest) {
            Ok(Some(_)) => drop(kept.insert(name, digest)),
            Err(ReadError::Io { path, source }) if !is_damage(&source) => {
                return Err(io("read", &path)(source));
            }
            _ => lost.push(name),
        }
    }
    let manifest = Manifest::new(sound.len() as u64, kept);
    manifest.write(directory).map_err(io("write", &directory.join(FILE)))?;
    let damaged = records.exists().then(|| unused(directory));
    if let Some(damaged) = &damaged {
        fs::rename(&records, damaged).map_err(io("put aside", &records))?;
    }
    fs::rename(&salvaged, &records).map_err(io("put into place", &salvaged))?;
    durable::sync_directory(directory).map_err(io("make durable", directory))?;
    Ok(Salvage {
        kept: sound.len(),
        promised,
        studies: manifest.studies.len(),
        lost_studies: lost,
        damaged,
    })
}

/// Reads the sealed records that open. It reads from both ends, so one unreadable page hides only
/// itself.
///
/// # Errors
/// The operating system refused for lack of descriptors or of space, which says nothing about the
/// content of the database.
fn readable(records: &Path) -> io::Result<BTreeMap<JobKey, Vec<u8>>> {
    let mut sound = BTreeMap::new();
    let database = match unless_refused(Database::open(records))? {
        Some(database) => Some(database),
        // The log alone is enough: without a snapshot and a configuration, sled derives them anew.
        None => {
            set_aside_derived(records)?;
            unless_refused(Database::open(records))?
        }
    };
    if let Some(database) = database {
        let mut keep = |key: &[u8], sealed: &[u8]| {
            if let Ok(key) = key.try_into().map(JobKey)
                && record::unseal(&key, sealed).is_ok()
            {
                sound.insert(key, sealed.to_vec());
            }
        };
        if unless_refused(database.visit(&mut keep))?.is_none() {
            unless_refused(database.visit_backwards(keep))?;
        }
    }
    Ok(sound)
}

/// Returns the result of a call to the database, or `None` if the database is damaged there.
fn unless_refused<T>(outcome: Result<T, Fault>) -> io::Result<Option<T>> {
    match outcome {
        Ok(had) => Ok(Some(had)),
        Err(Fault::Io(error)) if !is_damage(&error) => Err(error),
        Err(_) => Ok(None),
    }
}

/// Returns true if the error is about the bytes on the disk: the disk cannot read them, or sled
/// makes no sense of them. Every other error may be gone at the next attempt.
fn is_damage(error: &io::Error) -> bool {
    match error.kind() {
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData => true,
        // sled has its own words for a lock.
        io::ErrorKind::Other => !error.to_string().contains("could not acquire lock"),
        _ => Errno::from_io_error(error) == Some(Errno::IO),
    }
}

/// Renames the files of a sled database that only repeat its log.
fn set_aside_derived(records: &Path) -> io::Result<()> {
    for entry in fs::read_dir(records)? {
        let name = entry?.file_name();
        let text = name.to_string_lossy();
        if text.starts_with("snap.") || text == "conf" {
            fs::rename(records.join(&name), records.join(format!("damaged.{text}")))?;
        }
    }
    Ok(())
}

/// Returns a path for the damaged database that is not taken.
fn unused(directory: &Path) -> PathBuf {
    let mut number = 1u32;
    loop {
        let path = directory.join(format!("records.damaged-{number}"));
        if !path.exists() {
            return path;
        }
        number += 1;
    }
}
