//! `query`: the results of a study as a table.

use answers::Results;
use anyhow::{Result, anyhow};
use report::{Cell, DataTable, FilterError, TableColumn, TableError};
use study::Study;
use study::columns::{Role, along_path, nearest_name};
use wording::escaped_json;

use crate::cli::{QueryArgs, TableFormat};
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, read_store, stored_large_study, stored_study};
use crate::study_file::part;

/// Prints the results of a study as a table.
pub(crate) fn query(args: &QueryArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let source = StoreSource::Reader(&reader);
    let study = match args.shard {
        None => stored_study(&reader, &args.name)?,
        Some(shard) => part(&stored_large_study(&reader, &args.name)?, shard)?,
    };
    let results = Results::read(study, &source)?;
    let meant = |error| with_suggestion(error, results.study());
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
            table = table.filter(expression).map_err(|error| meant(error.into()))?;
            if table.rows().is_empty() {
                output::say("no row matches");
            }
        }
        if !args.sort.is_empty() {
            table = table.sort(&args.sort).map_err(|error| meant(error.into()))?;
        }
        table.select(&selected).map_err(|error| meant(error.into()))?
    };
    match format {
        TableFormat::Table => output::print(&table.terminal(&layout())),
        TableFormat::Csv => output::print_raw(&table.csv()),
        TableFormat::Json => output::print_raw(&escaped_json(&table.json())),
    }
}

/// Returns the error about a column that is not there with the column that others call so, unless
/// it names one that is spelled like it.
fn with_suggestion(error: anyhow::Error, study: &Study) -> anyhow::Error {
    let unknown = match (error.downcast_ref::<TableError>(), error.downcast_ref::<FilterError>()) {
        (Some(TableError::UnknownColumn(unknown)), _) => unknown,
        (_, Some(FilterError::UnknownColumn(unknown))) => unknown,
        _ => return error,
    };
    match nearest_name(&study.columns(), &unknown.name) {
        Some(name) if unknown.close.is_empty() => {
            anyhow!("there is no column `{}`; did you mean {name}?", unknown.name)
        }
        _ => error,
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
