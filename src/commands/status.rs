//! `status`: how far the studies of a store are.

use answers::Results;
use anyhow::{Context, Result};
use report::{Cell, DataTable, TableColumn};
use store::StoreReader;

use crate::cli::StatusArgs;
use crate::labels::{self, add_json};
use crate::output::{self, Finish, layout};
use crate::shard_states::StudyShards;
use crate::stored::{StoreSource, read_store, stored_large_study, stored_study};

/// Lists studies with their numbers of points.
pub(crate) fn status(args: &StatusArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let names = match &args.name {
        Some(name) => vec![name.clone()],
        None => reader.study_names()?,
    };
    let mut finish = Finish::AllDone;
    let source = StoreSource::Reader(&reader);
    let mut rows = Vec::new();
    let mut listed = Vec::new();
    let exports = reader.exports();
    let mut sharded = Vec::new();
    let mut labels = Vec::new();
    let all_labels = reader.labels()?;
    let of_study = |name: &String| all_labels.get(name).cloned().unwrap_or_default();
    for name in &names {
        let large = stored_large_study(&reader, name).ok().filter(|study| !study.is_listed());
        if let Some(study) = large {
            // Only its shards say how far it is.
            let shards = StudyShards::of(name, &exports);
            let listed_shards: Vec<_> = shards.iter().flat_map(|shards| &shards.rows).collect();
            let mut entry = serde_json::json!({
                "study": name, "question": study.question(),
                "progress": { "points": study.len() },
                "shards": listed_shards,
            });
            add_json(&mut entry, &of_study(name));
            listed.push(entry);
            labels.push(of_study(name));
            let mut row = vec![Cell::Text(name.clone()), Cell::Integer(study.len() as i64)];
            row.resize(6, Cell::Missing);
            row.push(Cell::Text(study.question().to_owned()));
            rows.push(row);
            sharded.extend(shards);
            continue;
        }
        let results = match read(&reader, name, &source) {
            Ok(results) => results,
            // One damaged study must not hide the others, nor pass for one that is not there.
            Err(error) if args.name.is_none() => {
                output::complain(&error);
                finish = Finish::Mistake;
                continue;
            }
            Err(error) => return Err(error),
        };
        let (progress, inaccurate) = (results.progress(), results.inaccurate());
        let question = results.study().question();
        let mut entry = serde_json::json!({
            "study": name, "question": question, "progress": progress, "inaccurate": inaccurate,
        });
        let shards = StudyShards::of(name, &exports);
        if !shards.is_empty() {
            let all: Vec<_> = shards.iter().flat_map(|shards| &shards.rows).collect();
            entry["shards"] = serde_json::to_value(all)?;
        }
        add_json(&mut entry, &of_study(name));
        listed.push(entry);
        labels.push(of_study(name));
        sharded.extend(shards);
        let mut row = vec![Cell::Text(name.clone())];
        row.extend(
            [progress.points, progress.done, progress.failed, progress.left, inaccurate]
                .map(|count| Cell::Integer(count as i64)),
        );
        row.push(Cell::Text(question.to_owned()));
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
    let mut heads = ["study", "points", "certified", "failed", "left", "inaccurate", "question"]
        .map(|name| TableColumn::new(name, ""))
        .to_vec();
    let (label_heads, cells) = labels::columns(&labels);
    heads.extend(label_heads);
    rows.iter_mut().zip(cells).for_each(|(row, cells)| row.extend(cells));
    let mut text = DataTable::new(heads, rows)?.terminal(&layout());
    for shards in sharded {
        text += &format!("\n{}", shards.words()?);
    }
    output::print(&text)?;
    Ok(finish)
}

/// Reads the results of a study.
fn read<'r>(reader: &StoreReader, name: &str, source: &'r StoreSource<'r>) -> Result<Results<'r>> {
    Results::read(stored_study(reader, name)?, source).with_context(|| format!("study `{name}`"))
}
