//! The directory in which the doctor runs its trial, and those that a killed doctor has left.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use anyhow::{Context, Result};
use rustix::fs::Access;
use store::{OpenError, Store};
use tempfile::TempDir;

use super::resources::directory_of;

/// The beginning of the names of these directories.
const PREFIX: &str = ".tribosweep-doctor-";

/// The age from which a directory that no process holds is taken for a leftover. It is far more
/// than the time between the making of a directory and that of the lock in it.
const OLD: Duration = Duration::from_secs(3600);

/// Makes a directory for a trial on the file system of a store, and removes old leftovers beside
/// it. It is removed when it is dropped.
pub(super) fn trial_place(store: &Path) -> Result<TempDir> {
    let there = directory_of(store)
        .with_context(|| format!("no directory can be made at {}", store.display()))?;
    let cannot = || format!("cannot write in {}", there.display());
    rustix::fs::access(&there, Access::WRITE_OK | Access::EXEC_OK).with_context(cannot)?;
    let make = |place: &Path| tempfile::Builder::new().prefix(PREFIX).tempdir_in(place);
    let beside = beside(store).and_then(|place| Some((make(&place).ok()?, place)));
    let (made, place) = match beside {
        Some(made) => made,
        None => (make(&there).with_context(cannot)?, there.clone()),
    };
    sweep(&place);
    Ok(made)
}

/// Returns the directory in which a store stands, if it is there and on the same file system.
fn beside(store: &Path) -> Option<PathBuf> {
    let store = fs::canonicalize(store).ok()?;
    let parent = store.parent()?;
    let device = |place: &Path| fs::metadata(place).map(|found| found.dev());
    (device(&store).ok()? == device(parent).ok()?).then(|| parent.to_owned())
}

/// Removes the directories of doctors that were killed. What cannot be removed stays.
fn sweep(place: &Path) {
    for entry in place.read_dir().into_iter().flatten().flatten() {
        let is_named = entry.file_name().to_string_lossy().starts_with(PREFIX);
        // A link is not followed.
        let is_leftover = |found: fs::Metadata| {
            let age = SystemTime::now().duration_since(found.modified().ok()?).ok()?;
            (found.is_dir() && age > OLD && !is_held(&entry.path())).then_some(())
        };
        if is_named && entry.metadata().ok().and_then(is_leftover).is_some() {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Tells whether a living process has the store in a directory.
fn is_held(directory: &Path) -> bool {
    matches!(Store::open(directory), Err(OpenError::Held { .. } | OpenError::HeldByUnknown { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_is_beside_its_store_and_sweeps_what_nobody_holds() {
        let place = tempfile::tempdir().unwrap();
        let store = place.path().join("store");
        let name = |made: &TempDir| made.path().parent().unwrap().to_owned();
        assert_eq!(name(&trial_place(&store).unwrap()), place.path());
        fs::create_dir(&store).unwrap();
        assert_eq!(name(&trial_place(&store).unwrap()), place.path().canonicalize().unwrap());

        let make = |end: &str, age: Duration| {
            let path = place.path().join(format!("{PREFIX}{end}"));
            let store = Store::open(&path).unwrap();
            let directory = fs::File::open(&path).unwrap();
            directory.set_modified(SystemTime::now() - age).unwrap();
            (path, store)
        };
        let (old, held, young) =
            (make("old", 2 * OLD), make("held", 2 * OLD), make("new", OLD / 2));
        drop((old.1, young.1));
        trial_place(&store).unwrap();
        assert!(!old.0.exists(), "a leftover stays");
        assert!(held.0.exists(), "what a process holds is removed");
        assert!(young.0.exists(), "what may be about to be held is removed");
    }
}
