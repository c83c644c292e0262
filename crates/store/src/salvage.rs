//! This file saves what can be read of a damaged store.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use identity::JobKey;

use crate::access::Wanted;
use crate::blob::{BlobFile, Blobs};
use crate::core::SALVAGED;
use crate::database::{Database, Fault, LARGE, RECORDS};
use crate::digest::Digest;
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::grouped::GroupWriter;
use crate::manifest::{FILE, Manifest, Unreadable};
use crate::record;

/// The result of a salvage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Salvage {
    /// The number of saved records.
    pub kept: usize,
    /// The number of records that the manifest promised. It is `None` if the manifest could not be
    /// read either; then the names of the studies are lost with it.
    pub promised: Option<u64>,
    /// The number of records that could be read and were given up because a blob that they refer to
    /// is damaged or gone.
    pub incomplete: usize,
    /// The number of damaged blobs, which were put aside.
    pub damaged_blobs: usize,
    /// The number of saved studies.
    pub studies: usize,
    /// The studies whose definition is damaged or gone. They are no longer listed, and running
    /// their files brings them back.
    pub lost_studies: Vec<String>,
    /// The new path of the damaged database, or `None` if there was none.
    pub damaged: Option<PathBuf>,
}

/// Saves what can be read of the store in `directory`, whose lock is held.
pub(crate) fn salvage(
    directory: &Path,
    mut references: impl FnMut(&JobKey, &[u8]) -> Vec<Digest>,
) -> Result<Salvage, OpenError> {
    let io = |action, path: &Path| {
        let path = path.to_owned();
        move |source| OpenError::io(action, Wanted::Write, &path, source)
    };
    let (promised, studies, labels) = match Manifest::read(directory) {
        Ok(manifest) => (Some(manifest.records), manifest.studies, manifest.labels),
        Err(Unreadable::Format(found)) => {
            return Err(OpenError::Format { directory: directory.to_owned(), found });
        }
        Err(Unreadable::Io(source)) => return Err(io("read", &directory.join(FILE))(source)),
        Err(Unreadable::Absent | Unreadable::Damaged(_)) => {
            (None, BTreeMap::new(), BTreeMap::new())
        }
    };
    let (records, salvaged) = (directory.join(RECORDS), directory.join(SALVAGED));
    if !durable::is_present(&records) && durable::is_real_directory(&salvaged) {
        // An earlier salvage was killed at its last step.
        fs::rename(&salvaged, &records).map_err(io("put into place", &salvaged))?;
    }
    durable::clear_away(&salvaged).map_err(io("remove", &salvaged))?;

    // sled enlarges and rewrites its files when it opens them.
    WriteError::require_space(directory, 0)?;
    let blobs = Blobs::of(directory);
    let damaged_blobs = put_damaged_aside(&blobs)?;
    // Something else than a directory is in its place, and holds no records.
    let damaged_records = match records.is_dir() {
        true => reopened(&records).map_err(io("read", &records))?,
        false => None,
    };
    let mut is_whole = |key: &JobKey, payload: &[u8]| {
        references(key, payload).iter().all(|digest| blobs.contains(digest))
    };
    let refused = |source| io("read", &records)(source);
    let (mut bytes, mut incomplete) = (0, 0);
    if let Some(damaged_records) = &damaged_records {
        let measure = |key: JobKey, sealed: &[u8], payload: &[u8]| {
            match is_whole(&key, payload) {
                true => bytes += sealed.len() as u64,
                false => incomplete += 1,
            }
            Ok(())
        };
        visit_sound(damaged_records, measure, refused)?;
    }
    WriteError::require_space(directory, bytes)?;
    let failed = |fault| match fault {
        Fault::Io(source) => io("write the database", &salvaged)(source),
        Fault::Damaged(what) => OpenError::Damaged { directory: directory.to_owned(), what },
    };
    durable::create_directory(&salvaged).map_err(io("create", &salvaged))?;
    let database = Database::open(&salvaged).map_err(failed)?;
    let mut writer = GroupWriter::new(&database);
    if let Some(damaged_records) = damaged_records {
        let keep = |key: JobKey, sealed: &[u8], payload: &[u8]| {
            if is_whole(&key, payload) {
                writer.push(key, sealed.to_vec()).map_err(failed)?;
            }
            Ok(())
        };
        visit_sound(&damaged_records, keep, refused)?;
    }
    let found = writer.finish().map_err(failed)?;
    drop(database);

    let (mut kept, mut lost) = (BTreeMap::new(), Vec::new());
    for (name, digest) in studies {
        if blobs.contains(&digest) {
            kept.insert(name, digest);
        } else {
            lost.push(name);
        }
    }
    let manifest = Manifest::new(found as u64, kept, labels);
    manifest.write(directory).map_err(io("write", &directory.join(FILE)))?;
    let damaged = if durable::is_present(&records) {
        durable::put_aside(&records).map_err(io("put aside", &records))?
    } else {
        None
    };
    fs::rename(&salvaged, &records).map_err(io("put into place", &salvaged))?;
    durable::sync_directory(directory).map_err(io("make durable", directory))?;
    Ok(Salvage {
        kept: found,
        promised,
        incomplete,
        damaged_blobs,
        studies: manifest.studies.len(),
        lost_studies: lost,
        damaged,
    })
}

/// Opens a damaged database, if that can be done at all.
///
/// # Errors
/// The operating system refused for lack of descriptors or of space, which says nothing about the
/// content of the database.
fn reopened(records: &Path) -> io::Result<Option<Database>> {
    // What a link leads to is not the store's, and nothing writes there.
    let is_foreign = |name: &str| {
        fs::symlink_metadata(records.join(name))
            .is_ok_and(|found| found.is_symlink() || (name == LARGE && !found.is_dir()))
    };
    if durable::is_real_directory(records) {
        set_aside(records, is_foreign)?;
    }
    if let Some(database) = unless_refused(Database::open(records))? {
        return Ok(Some(database));
    }
    // The log alone is enough: without a snapshot and a configuration, sled derives them anew.
    set_aside(records, |name| name.starts_with("snap.") || name == "conf")?;
    unless_refused(Database::open(records))
}

/// Visits the records that open, each once: its key, its sealed bytes and its payload. It reads
/// from both ends, so one unreadable page hides only itself.
fn visit_sound(
    database: &Database,
    mut keep: impl FnMut(JobKey, &[u8], &[u8]) -> Result<(), OpenError>,
    refused: impl Fn(io::Error) -> OpenError,
) -> Result<(), OpenError> {
    let mut outcome = Ok(());
    let last: Cell<Option<JobKey>> = Cell::new(None);
    let mut visit = |key: &[u8], sealed: &[u8]| {
        let Ok(key) = key.try_into().map(JobKey) else { return true };
        if let Ok(payload) = record::unseal(&key, sealed) {
            outcome = keep(key, sealed, payload);
        }
        last.set(Some(key));
        outcome.is_ok()
    };
    let forwards = database.visit_while(&mut visit);
    let seen = last.get();
    let visited = unless_refused(forwards).map_err(&refused)?;
    if visited.is_none() {
        let is_new = |key: &[u8]| seen.is_none_or(|seen| key > &seen.0[..]);
        let backwards = database.visit_backwards(|key, sealed| is_new(key) && visit(key, sealed));
        unless_refused(backwards).map_err(refused)?;
    }
    outcome
}

/// Returns the result of a call to the database, or `None` if the database is damaged there.
fn unless_refused<T>(outcome: Result<T, Fault>) -> io::Result<Option<T>> {
    match outcome {
        Ok(had) => Ok(Some(had)),
        Err(fault) if fault.is_damage() => Ok(None),
        Err(Fault::Io(error)) => Err(error),
        Err(Fault::Damaged(_)) => Ok(None),
    }
}

/// Renames the blobs that differ from what was written, and returns how many there were. They are
/// not removed: a disk that failed to read may read again.
fn put_damaged_aside(blobs: &Blobs) -> Result<usize, OpenError> {
    let refused = |error: ReadError| match error {
        ReadError::Io { path, source } => OpenError::io("read", Wanted::Read, &path, source),
        error => OpenError::Io {
            action: "read",
            path: blobs.directory().to_owned(),
            source: io::Error::other(error.to_string()),
        },
    };
    let mut aside = 0;
    for found in blobs.files().map_err(refused)? {
        let BlobFile::Blob { digest, path, .. } = found else { continue };
        match blobs.is_sound(&digest) {
            Ok(_) => {}
            Err(ReadError::Blob { .. }) => {
                durable::put_aside(&path)
                    .map_err(|source| OpenError::io("put aside", Wanted::Write, &path, source))?;
                aside += 1;
            }
            Err(error) => return Err(refused(error)),
        }
    }
    Ok(aside)
}

/// Renames those files of a sled database for which `is_concerned` holds, so that sled does not see
/// them.
fn set_aside(records: &Path, is_concerned: impl Fn(&str) -> bool) -> io::Result<()> {
    for entry in fs::read_dir(records)? {
        let name = entry?.file_name();
        let text = name.to_string_lossy();
        if is_concerned(&text) {
            fs::rename(records.join(&name), records.join(format!("damaged.{text}")))?;
        }
    }
    Ok(())
}
