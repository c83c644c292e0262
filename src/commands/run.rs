//! `run`: launches or continues a study, or a part of it.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use answers::shards::Shard;
use anyhow::{Context, Result, bail};
use store::{Digest, Glance, ShardName, Store};
use study::Study;

use crate::account::study_file;
use crate::cli::RunArgs;
use crate::execution::{ShardRun, StudyToRun, execute};
use crate::exporting::ExportPlace;
use crate::kept_study::KeptStudy;
use crate::local_store::LocalStore;
use crate::output::Finish;
use crate::proposal::USUAL_STORE;
use crate::study_file::{StudyShard, read_shard};

/// Launches a study or continues it.
pub(crate) fn run(args: &RunArgs) -> Result<Finish> {
    let StudyShard { study, shard, partition } =
        read_shard(&args.study, args.shard, &mut |study| is_known(study, &usual(args)))?;
    let file = Some(study_file(&args.study, study.text()));
    let to_run = |study: Study| StudyToRun { study, file };
    if args.shard.is_none() && args.export.is_none() {
        return execute(to_run(study), &usual(args), &args.execution, None);
    }
    let mut part =
        ShardRun { shard, results: usual(args), export: None, command: command(args, shard) };
    let Some(exports) = &args.export else {
        return execute(to_run(study), &usual(args), &args.execution, Some(part));
    };
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let is_one = args.store.as_ref().is_some_and(|store| absolute(store) == absolute(exports));
    if is_one || Store::is_at(exports)? {
        bail!(
            "{} is a store, and a store hides the exports in its directory; name another directory \
             for them",
            exports.display()
        );
    }
    let name =
        ShardName { study: study.name().to_owned(), index: shard.index(), count: shard.count() };
    let export = ExportPlace::of(exports, name, &args.study, partition);
    part.results.clone_from(&export.path);
    part.export = Some(export);
    match &args.store {
        Some(store) => execute(to_run(study), store, &args.execution, Some(part)),
        None => {
            let local = LocalStore::open(&label(&study, shard, exports)?)?;
            let finish = execute(to_run(study), local.path(), &args.execution, Some(part));
            let finish = finish.with_context(|| {
                format!(
                    "what is not exported is kept in {}, from where the same command goes on",
                    local.path().display()
                )
            })?;
            local.remove();
            Ok(finish)
        }
    }
}

/// Returns whether this program has run the very study to its end in a store, so that all its
/// points make sense.
fn is_known(study: &Study, store: &Path) -> bool {
    let kept = Glance::at(store).and_then(|glance| KeptStudy::at_a_glance(&glance, study.name()));
    kept.is_some_and(|kept| kept.is_about(study))
}

fn usual(args: &RunArgs) -> PathBuf {
    args.store.clone().unwrap_or_else(|| USUAL_STORE.into())
}

/// Returns a name for the local store of a shard that no other study has, nor the same study that
/// exports to another place: both may run on a machine at a time.
fn label(study: &Study, shard: Shard, exports: &Path) -> Result<String> {
    let exports = std::path::absolute(exports).context("cannot find the current directory")?;
    let unique = [&study.definition(), exports.as_os_str().as_encoded_bytes()].concat();
    let digest = Digest::of(&unique).to_string();
    Ok(format!("{}-{}-{}-of-{}", study.name(), &digest[..8], shard.index(), shard.count()))
}

/// Returns the command that goes on with a shard.
fn command(args: &RunArgs, shard: Shard) -> String {
    let option = |name: &str, path: &Path| -> [OsString; 2] {
        [name.into(), wording::file_argument(path).into_owned()]
    };
    let mut words: Vec<OsString> =
        vec!["run".into(), wording::file_argument(&args.study).into_owned()];
    if args.shard.is_some() {
        words.extend(["--shard".into(), shard.to_string().into()]);
    }
    words.extend(args.export.iter().flat_map(|path| option("--export", path)));
    words.extend(args.store.iter().flat_map(|path| option("--store", path)));
    wording::command(words.iter().map(OsStr::new))
}
