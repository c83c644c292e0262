//! Copies of studies with the files that they name, which later edits do not change.

use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, bail};
use study::Study;

use crate::study_file::read_large_study;

/// The name of the directories that stand in place of those above the study.
const LEVEL: &str = "in";

/// Returns the path of a study's copy below the directory that [`freeze`] writes.
pub(crate) fn place(study: &Study) -> PathBuf {
    let levels = named(study).map(|(name, _)| levels_above(name)).max().unwrap_or(0);
    let beside: PathBuf = std::iter::repeat_n(LEVEL, levels).collect();
    beside.join(format!("{}.toml", study.name()))
}

/// Writes a study and the files that it names below a directory, each where the study looks for it.
///
/// A file that the study names by an absolute path is not copied, since its name is a part of the
/// study's results; [`fixed_files`] lists these.
pub(crate) fn freeze(study: &Study, directory: &Path) -> Result<()> {
    let file = directory.join(place(study));
    let beside = file.parent().unwrap_or(directory);
    write(beside, Path::new(&format!("{}.toml", study.name())), study.text().as_bytes())?;
    for (name, bytes) in named(study) {
        write(beside, name, bytes)?;
    }
    Ok(())
}

/// Returns the files that a study names by relative paths.
fn named(study: &Study) -> impl Iterator<Item = (&Path, &[u8])> {
    let paths = study.named_files().map(|(name, bytes)| (Path::new(name), bytes));
    paths.filter(|(name, _)| name.is_relative())
}

/// Tells whether the file of a study and those that it names have the content of another study's.
pub(crate) fn is_same(study: &Study, file: &Path) -> Result<bool> {
    let frozen = read_large_study(file)?;
    Ok(frozen.text() == study.text() && frozen.named_files().eq(study.named_files()))
}

/// Returns the names of the files that a copy of the study does not have, but names.
pub(crate) fn fixed_files(study: &Study) -> impl Iterator<Item = &str> {
    study.named_files().map(|(name, _)| name).filter(|name| Path::new(name).is_absolute())
}

/// Returns the number of directories that a relative path leaves above the one it starts from.
fn levels_above(path: &Path) -> usize {
    let (mut depth, mut above) = (0_usize, 0);
    for component in path.components() {
        match component {
            Component::ParentDir if depth == 0 => above += 1,
            Component::ParentDir => depth -= 1,
            Component::Normal(_) => depth += 1,
            _ => {}
        }
    }
    above
}

/// Writes a file, and every directory that its relative path goes through.
fn write(beside: &Path, name: &Path, bytes: &[u8]) -> Result<()> {
    let path = beside.join(name);
    let write = || {
        let mut directory = beside.to_owned();
        fs::create_dir_all(&directory)?;
        for component in name.parent().into_iter().flat_map(Path::components) {
            directory.push(component);
            fs::create_dir_all(&directory)?;
        }
        match fs::read(&path) {
            Ok(present) => Ok(present == bytes),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                fs::write(&path, bytes).map(|()| true)
            }
            Err(error) => Err(error),
        }
    };
    let is_alone = write().with_context(|| format!("cannot write {}", path.display()))?;
    if !is_alone {
        bail!(
            "the study names two files that have the same place in a copy: {}; name them by paths \
             without links",
            name.display()
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_above_the_study_are_counted() {
        for (path, levels) in
            [("a", 0), ("a/b", 0), ("../a", 1), ("a/../../b", 1), ("../../a/../b", 2), ("./a", 0)]
        {
            assert_eq!(levels_above(Path::new(path)), levels, "{path}");
        }
    }
}
