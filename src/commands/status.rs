//! `status`: how far the studies of a store are.

use answers::Results;
use anyhow::Result;
use report::{Cell, DataTable, TableColumn};
use store::Store;

use crate::cli::StatusArgs;
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, stored_study, tell_origin};

/// Lists studies with their numbers of points.
pub(crate) fn status(args: &StatusArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let studies = match &args.name {
        Some(name) => vec![stored_study(&reader, name)?],
        // One damaged study must not hide the others.
        None => {
            let found = reader.study_names()?.into_iter().map(|name| stored_study(&reader, &name));
            found.filter_map(|study| study.map_err(|error| output::complain(&error)).ok()).collect()
        }
    };
    let mut rows = Vec::new();
    let mut listed = Vec::new();
    for study in studies {
        let name = study.name().to_owned();
        let source = StoreSource::Reader(&reader);
        let results = match Results::read(study, &source) {
            Ok(results) => results,
            Err(error) if args.name.is_none() => {
                let error = anyhow::Error::from(error);
                output::complain(&error.context(format!("study `{name}`")));
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        let (progress, inaccurate) = (results.progress(), results.inaccurate());
        let question = results.study().question();
        listed.push(serde_json::json!({
            "study": name, "question": question, "progress": progress, "inaccurate": inaccurate,
        }));
        let mut row = vec![Cell::Text(name)];
        row.extend(
            [progress.points, progress.done, progress.failed, progress.left, inaccurate]
                .map(|count| Cell::Integer(count as i64)),
        );
        row.push(Cell::Text(question.to_owned()));
        rows.push(row);
    }
    if args.json {
        return output::print_json(&listed);
    }
    if rows.is_empty() && reader.study_names()?.is_empty() {
        return output::print("no studies so far\n");
    }
    let heads = ["study", "points", "certified", "failed", "left", "inaccurate", "question"]
        .map(|name| TableColumn::new(name, ""));
    output::print(&DataTable::new(heads.to_vec(), rows)?.terminal(&layout()))
}
