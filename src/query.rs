//! `status` and `query`: what a store knows.

use anyhow::Result;
use report::{Cell, DataTable, TableColumn, TerminalLayout};
use store::{Origin, Reader, Store};
use study::Study;
use study::columns::{Role, along_path};

use crate::cli::{AnswerArgs, QueryArgs, StatusArgs, TableFormat};
use crate::output::{self, Finish};
use crate::results::{Progress, Results, Source, stored_study};

/// How tables are laid out on standard output.
pub(crate) fn layout() -> TerminalLayout {
    TerminalLayout { width: output::terminal_width(), digits: 6, prefixes: true, unicode: true }
}

/// Says where numbers come from when a run is still adding to them.
pub(crate) fn tell_origin(reader: &Reader) {
    if let origin @ Origin::Process { .. } = reader.origin() {
        output::say(&origin.to_string());
    }
}

pub(crate) fn status(args: &StatusArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let studies = match &args.name {
        Some(name) => vec![stored_study(&reader, name)?],
        // one damaged study must not hide the others
        None => {
            let found = reader.study_names()?.into_iter().map(|name| stored_study(&reader, &name));
            found.filter_map(|study| study.map_err(|error| output::complain(&error)).ok()).collect()
        }
    };
    let mut rows = Vec::new();
    let mut listed = Vec::new();
    for study in studies {
        let progress = match Progress::read(Source::Reader(&reader), &study) {
            Ok(progress) => progress,
            Err(error) if args.name.is_none() => {
                output::complain(&error.context(format!("study `{}`", study.name())));
                continue;
            }
            Err(error) => return Err(error),
        };
        listed.push(serde_json::json!({ "study": study.name(), "question": study.question(), "progress": progress }));
        let mut row = vec![Cell::Text(study.name().to_owned())];
        row.extend(
            [progress.points, progress.done, progress.failed, progress.left]
                .map(|count| Cell::Integer(count as i64)),
        );
        row.push(Cell::Text(study.question().to_owned()));
        rows.push(row);
    }
    if args.json {
        return output::print_json(&listed);
    }
    if rows.is_empty() && reader.study_names()?.is_empty() {
        return output::print("no studies so far\n");
    }
    let heads = ["study", "points", "certified", "failed", "left", "question"]
        .map(|name| TableColumn::new(name, ""));
    output::print(&DataTable::new(heads.to_vec(), rows)?.terminal(&layout()))
}

pub(crate) fn query(args: &QueryArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let results = Results::read(Source::Reader(&reader), stored_study(&reader, &args.name)?)?;
    let format = if args.json { TableFormat::Json } else { args.format };
    let table = if args.columns {
        columns(&results.study, args.steps)?
    } else {
        let mut table = if args.steps { results.increments()? } else { results.table()? };
        if let Some(expression) = &args.filter {
            table = table.filter(expression)?;
            if table.rows().is_empty() {
                output::say("no row matches");
            }
        }
        if !args.sort.is_empty() {
            table = table.sort(&args.sort)?;
        }
        let selected = if args.select.is_empty() {
            results.usual_columns(args.steps)
        } else {
            args.select.clone()
        };
        table.select(&selected)?
    };
    output::print(&match format {
        TableFormat::Table => table.terminal(&layout()),
        TableFormat::Csv => table.csv(),
        TableFormat::Json => table.json(),
    })
}

pub(crate) fn answer(args: &AnswerArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let results = Results::read(Source::Reader(&reader), stored_study(&reader, &args.name)?)?;
    if args.json {
        let progress = results.progress();
        let study = &results.study;
        return output::print_json(&serde_json::json!({
            "study": study.name(), "question": study.question(), "progress": progress, "answers": results.answers_json()?,
        }));
    }
    if results.answers.is_empty() {
        // its rows are the answer
        let rows = results.table()?.select(&results.usual_columns(false))?;
        return output::print(
            format!("{}\n\n{}", results.study.question(), rows.terminal(&layout())).trim_start(),
        );
    }
    output::print(format!("{}\n{}", results.study.question(), results.answers_words()).trim_start())
}

/// What can be selected, as a table itself.
fn columns(study: &Study, steps: bool) -> Result<DataTable> {
    let role = |role: Role| match role {
        Role::Axis => "axis",
        Role::Key => "key",
        Role::Status => "status",
        Role::Place => "place",
        Role::Observable => "observable",
        Role::Certificate => "certificate",
        Role::Error => "error",
        Role::Work => "work",
        Role::Provenance => "provenance",
    };
    let columns = if steps { along_path(study.columns()) } else { study.columns() };
    let rows = columns
        .iter()
        .map(|c| {
            [&c.name, c.unit(), role(c.role), c.meaning].map(|t| Cell::Text(t.to_owned())).to_vec()
        })
        .collect();
    Ok(DataTable::new(
        ["column", "unit", "kind", "meaning"].map(|name| TableColumn::new(name, "")).to_vec(),
        rows,
    )?)
}
