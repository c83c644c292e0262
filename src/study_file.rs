//! Study files and the files that they name.

use std::path::Path;

use anyhow::{Context, Result};
use study::edit::EditError;
use study::{ReadFile, Study};

/// Reads a study file. Files that it names are looked for beside it.
pub(crate) fn read_study(path: &Path) -> Result<Study> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the study file {}", path.display()))?;
    Ok(parse_study(&text, path)?)
}

/// Parses the text of a study file as if it stood at `path`.
pub(crate) fn parse_study(text: &str, path: &Path) -> Result<Study, study::StudyError> {
    Study::parse(text, &path.display().to_string(), &mut files_beside(path))
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

/// Returns a reader of the files that a study at `path` names.
fn files_beside(path: &Path) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let beside = path.parent().unwrap_or(Path::new("."));
    move |name| std::fs::read(beside.join(name)).map_err(|error| error.to_string())
}
