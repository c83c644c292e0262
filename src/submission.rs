//! A submission: the directory with a study's scripts, exports and logs, and what was handed to a
//! cluster from there.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use study::Study;

use crate::cli::SubmitArgs;
use crate::frozen_study::{freeze, is_same, place};
use crate::scheduler::queued;
use crate::slurm::{ARRAY_SCRIPT, MERGE_SCRIPT, Scripts};
use crate::words::count;

/// The file with what was submitted, in the directory of the scripts.
const SUBMISSION: &str = "submission.json";

/// The directory with the study and the files that it names.
const FROZEN: &str = "study";

/// The directory with what the jobs say.
const LOG: &str = "log";

/// The record of a submission, which stands in [`SUBMISSION`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Submission {
    pub(crate) study: String,
    pub(crate) shards: u32,
    /// The study file, below the directory.
    pub(crate) file: PathBuf,
    /// The directory of the exports, absolute or below the directory.
    pub(crate) exports: PathBuf,
    /// The file with the results of all shards.
    pub(crate) merged: PathBuf,
    /// The numbers that the scheduler gave to the arrays and the merge.
    pub(crate) jobs: Vec<String>,
}

/// Refuses a directory in which Slurm would find no log.
pub(crate) fn check_directory(directory: &Path) -> Result<()> {
    let path = std::path::absolute(directory).context("cannot find the current directory")?;
    let Some(text) = path.to_str() else {
        bail!("--directory must be a path in UTF-8");
    };
    if text.contains(['%', '\\', '\n']) {
        bail!(
            "Slurm takes % and \\ in a path for patterns: {}; give a --directory without them",
            wording::excerpt(text, 200)
        );
    }
    Ok(())
}

/// Returns what is to be submitted. A directory of an earlier submission must be of the same study
/// and shards, whose jobs have ended.
pub(crate) fn submission(args: &SubmitArgs, study: &Study, directory: &Path) -> Result<Submission> {
    let exports = args.exports.as_deref().map(std::path::absolute).transpose()?;
    if exports.as_deref().is_some_and(|exports| exports.to_str().is_none()) {
        bail!("--exports must be a path in UTF-8");
    }
    let new = Submission {
        study: study.name().to_owned(),
        shards: args.shards,
        file: Path::new(FROZEN).join(place(study)),
        exports: exports.clone().unwrap_or_else(|| "exports".into()),
        merged: format!("{}.tribosweep", study.name()).into(),
        jobs: Vec::new(),
    };
    if !directory.exists() {
        return Ok(new);
    }
    let shown = directory.display();
    let path = directory.join(SUBMISSION);
    let bytes = fs::read(&path).map_err(|error| {
        anyhow!("{shown} is there, and not by `submit` ({SUBMISSION}: {error}); give another --directory")
    })?;
    let former: Submission = serde_json::from_slice(&bytes)
        .with_context(|| format!("{} is damaged; give another --directory", path.display()))?;
    let file = directory.join(&former.file);
    if former.study != new.study || !is_same(study, &file)? {
        bail!(
            "{shown} belongs to another study, or to this one before it was edited ({}); give another \
             --directory, or remove it",
            file.display()
        );
    }
    if former.shards != new.shards {
        bail!(
            "{shown} belongs to {} of this study; go on with --shards {}, or give another --directory",
            count(former.shards as usize, "shard", "shards"),
            former.shards
        );
    }
    if exports.is_some_and(|exports| exports != former.exports) {
        bail!("{shown} has its exports in {}; leave out --exports", former.exports.display());
    }
    if args.dry_run {
        return Ok(former);
    }
    let queued = queued(&former.jobs)?;
    if !queued.is_empty() {
        let jobs = former.jobs.join(",");
        bail!(
            "the shards in {shown} are still queued or running: {}; wait for them, or cancel them by: \
             scancel {jobs}",
            count(queued.lines().count(), "job", "jobs")
        );
    }
    Ok(former)
}

/// Writes the directory of a submission: whole, or not at all if it is new. In one that is there,
/// only the scripts are written.
pub(crate) fn write_directory(
    study: &Study,
    submission: &Submission,
    scripts: &Scripts<'_>,
    directory: &Path,
) -> Result<()> {
    if directory.exists() {
        return write_scripts(scripts, directory);
    }
    // Without what may stand at the end of it, a slash.
    let mut draft = directory.components().as_path().as_os_str().to_owned();
    draft.push(format!(".{}", std::process::id()));
    let draft = PathBuf::from(draft);
    let write = || {
        fs::create_dir_all(draft.join(LOG))?;
        freeze(study, &draft.join(FROZEN))?;
        write_scripts(scripts, &draft)?;
        write_submission(submission, &draft)?;
        fs::create_dir_all(draft.join(&submission.exports))?;
        Ok(fs::rename(&draft, directory)?)
    };
    let written: Result<()> = write();
    if written.is_err() {
        // What is left of a draft is of no use; the error that made it so matters more.
        let _ = fs::remove_dir_all(&draft);
    }
    written.with_context(|| format!("cannot write {}", directory.display()))
}

fn write_scripts(scripts: &Scripts<'_>, directory: &Path) -> Result<()> {
    for (name, text) in [(ARRAY_SCRIPT, scripts.array()), (MERGE_SCRIPT, scripts.merge())] {
        let path = directory.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

pub(crate) fn write_submission(submission: &Submission, directory: &Path) -> Result<()> {
    let path = directory.join(SUBMISSION);
    let draft = directory.join(format!("{SUBMISSION}.{}", std::process::id()));
    fs::write(&draft, serde_json::to_string_pretty(submission)? + "\n")
        .and_then(|()| fs::rename(&draft, &path))
        .with_context(|| format!("cannot write {}", path.display()))
}
