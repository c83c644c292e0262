//! Saving what can be read of a damaged store.

use crate::blob::Blobs;
use crate::database::{Database, Fault};
use crate::durable;
use crate::error::OpenError;
use crate::manifest::{FILE, Manifest, Unreadable};
use crate::record;
use crate::store::{RECORDS, lock_for_writing};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use study::job::JobKey;

/// The sound database while it is being written.
const SALVAGED: &str = "records.salvaged";

/// What was saved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Salvage {
    /// Records saved.
    pub kept: usize,
    /// Records that the manifest promised; `None` if it could not be read either, and with it the names of the studies.
    pub promised: Option<u64>,
    /// Studies saved.
    pub studies: usize,
    /// Studies whose definition is damaged or gone; they are no longer listed, and running their files brings them back.
    pub lost_studies: Vec<String>,
    /// Where the damaged database is now; `None` if there was none.
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
        Err(Unreadable::Format(found)) => return Err(OpenError::Format { directory: directory.to_owned(), found }),
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

    let sound = if records.exists() { readable(&records) } else { BTreeMap::new() };
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
    let (studies, lost): (BTreeMap<_, _>, BTreeMap<_, _>) =
        studies.into_iter().partition(|(_, digest)| matches!(blobs.get(digest), Ok(Some(_))));
    let manifest = Manifest::new(sound.len() as u64, studies);
    manifest.write(directory).map_err(io("write", &directory.join(FILE)))?;
    let damaged = records.exists().then(|| unused(directory));
    if let Some(damaged) = &damaged {
        fs::rename(&records, damaged).map_err(io("put aside", &records))?;
    }
    fs::rename(&salvaged, &records).map_err(io("put into place", &salvaged))?;
    durable::sync_directory(directory).map_err(io("make durable", directory))?;
    Ok(Salvage { kept: sound.len(), promised, studies: manifest.studies.len(), lost_studies: lost.into_keys().collect(), damaged })
}

/// The sealed records that open, read from both ends so that one unreadable page hides only itself.
fn readable(records: &Path) -> BTreeMap<JobKey, Vec<u8>> {
    let mut sound = BTreeMap::new();
    // The log alone is enough: without a snapshot and a configuration, sled derives them anew.
    let database = Database::open(records).or_else(|fault| match set_aside_derived(records) {
        Ok(()) => Database::open(records),
        Err(_) => Err(fault),
    });
    if let Ok(database) = database {
        let mut keep = |key: &[u8], sealed: &[u8]| {
            if let Ok(key) = key.try_into().map(JobKey)
                && record::unseal(&key, sealed).is_ok()
            {
                sound.insert(key, sealed.to_vec());
            }
        };
        if database.visit(&mut keep).is_err() {
            let _ = database.visit_backwards(keep);
        }
    }
    sound
}

/// Renames the files of a sled database that only repeat what its log says.
fn set_aside_derived(records: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(records)? {
        let name = entry?.file_name();
        let text = name.to_string_lossy();
        if text.starts_with("snap.") || text == "conf" {
            fs::rename(records.join(&name), records.join(format!("damaged.{text}")))?;
        }
    }
    Ok(())
}

/// A name for the damaged database that is not taken.
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
