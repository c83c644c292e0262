//! Study files, and the files that they name.

use std::path::Path;

use anyhow::{Context, Result};
use study::Study;

/// Reads a study file; files that it names are looked for beside it.
pub(crate) fn read_study(path: &Path) -> Result<Study> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the study file {}", path.display()))?;
    Ok(parse_study(&text, path)?)
}

/// Parses the text of a study file as if it stood at `path`.
pub(crate) fn parse_study(text: &str, path: &Path) -> Result<Study, study::StudyError> {
    let beside = path.parent().unwrap_or(Path::new("."));
    Study::parse(text, &path.display().to_string(), &mut |name| {
        std::fs::read(beside.join(name)).map_err(|error| error.to_string())
    })
}
