//! Study files and the files that they name.

use std::collections::BTreeMap;
use std::path::Path;

use answers::shards::{Partition, Shard};
use anyhow::{Context, Result};
use store::Digest;
use study::edit::EditError;
use study::{IsKnown, NamedFile, ReadFile, Study};

use crate::bounded_file::{LARGEST_MAP, read_bounded, read_study_text};
use crate::shard_choice::ShardChoice;

/// Reads a study file. Files that it names are looked for beside it.
pub(crate) fn read_study(path: &Path) -> Result<Study> {
    Ok(parse_study(&read_text(path)?, path)?)
}

/// A part of a study.
pub(crate) struct StudyShard {
    pub(crate) study: Study,
    pub(crate) shard: Shard,
    /// The digest of the partition, if the study was cut.
    pub(crate) partition: Option<String>,
}

impl StudyShard {
    /// Returns a whole study as its only shard.
    ///
    /// # Errors
    /// The study has more than one run takes.
    pub(crate) fn whole(study: Study) -> Result<StudyShard> {
        study.require_listed()?;
        Ok(StudyShard { study, shard: Shard::WHOLE, partition: None })
    }
}

/// Reads a study file, which may have more points than one run takes.
pub(crate) fn read_large_study(path: &Path) -> Result<Study> {
    let text = read_text(path)?;
    Ok(Study::parse_sharded(&text, &path.display().to_string(), &mut files_beside(path))?)
}

/// Reads a study file, and takes the part of it that is chosen; without a choice, all of it. The
/// points of a study that `is_known` make sense.
pub(crate) fn read_shard(
    path: &Path,
    choice: Option<ShardChoice>,
    is_known: IsKnown<'_>,
) -> Result<StudyShard> {
    let Some(choice) = choice else {
        let (text, named) = (read_text(path)?, path.display().to_string());
        let study = Study::parse_known(&text, &named, &mut files_beside(path), is_known)?;
        return Ok(StudyShard { study, shard: Shard::WHOLE, partition: None });
    };
    let shard = choice.shard()?;
    let whole = read_large_study(path)?;
    let partition = Partition::of(&whole, shard.count())?;
    let digest = Digest::of(&partition.identity()).to_string()[..16].to_owned();
    Ok(StudyShard { study: partition.part(&whole, shard)?, shard, partition: Some(digest) })
}

/// Returns a part of a study.
pub(crate) fn part(study: &Study, shard: Shard) -> Result<Study> {
    Ok(Partition::of(study, shard.count())?.part(study, shard)?)
}

/// Reads the text of a study file.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    let text = read_study_text(path).map_err(anyhow::Error::msg);
    text.with_context(|| format!("cannot read the study file {}", path.display()))
}

/// Parses the text of a study file as if it stood at `path`.
pub(crate) fn parse_study(text: &str, path: &Path) -> Result<Study, study::StudyError> {
    Study::parse(text, &path.display().to_string(), &mut files_beside(path))
}

/// Parses the text of a study as if it stood at `path`, with files that stand nowhere else.
pub(crate) fn parse_with_files(
    text: &str,
    path: &Path,
    files: &BTreeMap<String, Vec<u8>>,
) -> Result<Study, study::StudyError> {
    let mut beside = files_beside(path);
    let mut read = |name: &str| match files.get(name) {
        Some(bytes) => Ok(NamedFile { bytes: bytes.clone(), may_quote: true }),
        None => beside(name),
    };
    Study::parse(text, &path.display().to_string(), &mut read)
}

/// An edit of a study's text, given with its path, the settings and a reader of the files that it
/// names.
type Edit = fn(&str, &str, &[String], &mut ReadFile<'_>) -> Result<String, EditError>;

/// Edits the text of a study file that stands at `path`.
pub(crate) fn edit_study(
    edit: Edit,
    text: &str,
    path: &Path,
    settings: &[String],
) -> Result<String> {
    let edited = edit(text, &path.display().to_string(), settings, &mut files_beside(path));
    edited.map_err(|error| match error {
        // The error is shown as a picture of the file.
        EditError::Study(error) => error.into(),
        error => error.into(),
    })
}

/// Returns a reader of the files that a study at `path` names. Messages may quote a file only if
/// it lies in the study's directory, wherever its name and links lead.
fn files_beside(path: &Path) -> impl FnMut(&str) -> Result<NamedFile, String> {
    let beside = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    move |name| {
        let file = beside.join(name);
        let bytes = read_bounded(&file, LARGEST_MAP)?;
        let places = (std::fs::canonicalize(&file), std::fs::canonicalize(beside));
        let may_quote = matches!(&places, (Ok(file), Ok(beside)) if file.starts_with(beside));
        Ok(NamedFile { bytes, may_quote })
    }
}
