//! `query`: the results of a study as a table.

use answers::Results;
use anyhow::Result;
use report::{Cell, DataTable, TableColumn};
use study::Study;
use study::columns::{Role, along_path};
use wording::escaped_json;

use crate::cli::{QueryArgs, TableFormat};
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, read_store, stored_study};

/// Prints the results of a study as a table.
pub(crate) fn query(args: &QueryArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let source = StoreSource::Reader(&reader);
    let results = Results::read(stored_study(&reader, &args.name)?, &source)?;
    let format = if args.json { TableFormat::Json } else { args.format };
    let table = if args.columns {
        columns(results.study(), args.steps)?
    } else {
        let selected = if args.select.is_empty() {
            results.usual_columns(args.steps)?
        } else {
            args.select.clone()
        };
        let mut table = if args.steps {
            results.increments()?
        } else {
            let mentions = selected.iter().chain(&args.sort).chain(&args.filter);
            results.table(&mentions.collect::<Vec<_>>())?
        };
        if let Some(expression) = &args.filter {
            table = table.filter(expression)?;
            if table.rows().is_empty() {
                output::say("no row matches");
            }
        }
        if !args.sort.is_empty() {
            table = table.sort(&args.sort)?;
        }
        table.select(&selected)?
    };
    match format {
        TableFormat::Table => output::print(&table.terminal(&layout())),
        TableFormat::Csv => output::print_raw(&table.csv()),
        TableFormat::Json => output::print_raw(&escaped_json(&table.json())),
    }
}

/// Returns the columns that can be selected, as a table.
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
        .map(|column| {
            [&column.name, column.unit(), role(column.role), column.meaning]
                .map(|text| Cell::Text(text.to_owned()))
                .to_vec()
        })
        .collect();
    Ok(DataTable::new(
        ["column", "unit", "kind", "meaning"].map(|name| TableColumn::new(name, "")).to_vec(),
        rows,
    )?)
}
