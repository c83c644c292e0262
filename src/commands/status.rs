//! `status`: how far the studies of a store are.

use answers::Progress;
use anyhow::{Context, Result};
use report::{Cell, DataTable, TableColumn};
use store::StoreReader;
use study::Study;

use crate::cli::StatusArgs;
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, read_store, stored_study};

/// Lists studies with their numbers of points.
pub(crate) fn status(args: &StatusArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let names = match &args.name {
        Some(name) => vec![name.clone()],
        None => reader.study_names()?,
    };
    let mut finish = Finish::AllDone;
    let mut rows = Vec::new();
    let mut listed = Vec::new();
    for name in &names {
        let StudyStatus { study, progress } = match read(&reader, name) {
            Ok(read) => read,
            // One damaged study must not hide the others, nor pass for one that is not there.
            Err(error) if args.name.is_none() => {
                output::complain(&error);
                finish = Finish::Mistake;
                continue;
            }
            Err(error) => return Err(error),
        };
        listed.push(serde_json::json!({
            "study": study.name(), "question": study.question(), "progress": progress,
        }));
        let mut row = vec![Cell::Text(study.name().to_owned())];
        row.extend(
            [progress.points, progress.done, progress.failed, progress.left]
                .map(|count| Cell::Integer(count as i64)),
        );
        row.push(Cell::Text(study.question().to_owned()));
        rows.push(row);
    }
    if args.json {
        output::print_json(&listed)?;
        return Ok(finish);
    }
    if names.is_empty() {
        return output::print("no studies so far\n");
    }
    if rows.is_empty() {
        return Ok(finish);
    }
    let heads = ["study", "points", "certified", "failed", "left", "question"]
        .map(|name| TableColumn::new(name, ""));
    output::print(&DataTable::new(heads.to_vec(), rows)?.terminal(&layout()))?;
    Ok(finish)
}

/// A study with the numbers of its points.
struct StudyStatus {
    study: Study,
    progress: Progress,
}

/// Reads a study and its progress.
fn read(reader: &StoreReader, name: &str) -> Result<StudyStatus> {
    let study = stored_study(reader, name)?;
    let progress = Progress::read(&study, &StoreSource::Reader(reader))
        .with_context(|| format!("study `{name}`"))?;
    Ok(StudyStatus { study, progress })
}
