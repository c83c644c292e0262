//! `query`: the results of a study as a table.

use answers::{Accounts, Results, Selection};
use anyhow::{Context, Result, bail};
use report::{Cell, DataTable, TableColumn};
use study::columns::along_path;
use study::{MOST_POINTS, Study};
use wording::escaped_json;

use crate::cli::{QueryArgs, TableFormat};
use crate::output::{self, Finish, layout};
use crate::proposal;
use crate::stored::{StoreSource, read_store, stored_large_study};
use crate::study_file::part;
use crate::table_file::{TableRows, write_csv, write_parquet};
use crate::written_file;

/// The number of points above which only the rows that are chosen are in memory.
const IN_MEMORY: usize = 16_384;

/// Prints the results of a study as a table, or writes them to a file.
pub(crate) fn query(args: &QueryArgs) -> Result<Finish> {
    let format = if args.json { TableFormat::Json } else { args.format };
    if matches!(format, TableFormat::Parquet) && (args.output.is_none() || args.columns) {
        bail!("--format parquet writes results to a file: --output {}.parquet", args.name);
    }
    if let Some(file) = &args.output {
        match format {
            // The figures at the end of it tell where its parts are, so that nobody reads a pipe.
            TableFormat::Parquet => written_file::check_regular(file)?,
            _ => written_file::check(file)?,
        }
    }
    let reader = read_store(&args.store.store)?;
    let source = StoreSource::Reader(&reader);
    let mut selection = Selection {
        filter: args.filter.clone(),
        sort: args.sort.clone(),
        columns: args.select.clone(),
        steps: args.steps,
    };
    let mut study = stored_large_study(&reader, &args.name)?;
    if let Some(shard) = args.shard {
        study = part(&study, shard)?;
    }
    if matches!(format, TableFormat::Parquet) && selection.columns.is_empty() {
        let all = selection.all_columns(&study);
        selection.columns = all.into_iter().map(|column| column.name.into_owned()).collect();
    }
    let is_file = matches!(format, TableFormat::Parquet | TableFormat::Csv);
    let is_known = !selection.columns.is_empty() && !args.columns;
    if is_file && is_known && selection.is_separable(&study) {
        selection.check(&study)?;
        let rows = TableRows::Selected { selection: &selection, study: &study, source: &source };
        return write(args, format, rows, &selection, &study);
    }
    if args.shard.is_none() && !study.is_listed() && !args.columns {
        if selection.columns.is_empty() && !args.steps {
            selection.columns = Selection::usual_columns(&study);
        }
        let gathered = match study.is_one_run() && selection.has_own_rows(&study) {
            true => selection.gathered(&study, &source, MOST_POINTS)?,
            false => None,
        };
        let Some((table, accounts)) = gathered else {
            let part = format!("1/{}", study.len().div_ceil(MOST_POINTS));
            bail!(
                "the study `{}` has {} points, and {MOST_POINTS} rows at most are a table in \
                 memory; --where may choose fewer, --format parquet or csv with --select and \
                 without --sort writes them one after the other, and this asks for a part of \
                 them: {}",
                args.name,
                study.len(),
                proposal::command(&args.store.store, ["query", &args.name, "--shard", &part])
            );
        };
        let rows = TableRows::Whole { table, accounts: &accounts };
        return write(args, format, rows, &selection, &study);
    }
    if args.columns {
        let table = columns(&study, args.steps)?;
        let rows = TableRows::Whole { table, accounts: &Accounts::default() };
        return write(args, format, rows, &selection, &study);
    }
    if study.point_count() > IN_MEMORY && is_known && selection.has_own_rows(&study) {
        let gathered = selection.gathered(&study, &source, usize::MAX)?;
        if let Some((table, accounts)) = gathered {
            let rows = TableRows::Whole { table, accounts: &accounts };
            return write(args, format, rows, &selection, &study);
        }
    }
    let results = Results::read(study, &source)?;
    if selection.columns.is_empty() {
        selection.columns = results.usual_columns(args.steps)?;
    }
    let table = selection.of(&results)?;
    let accounts = results.accounts();
    write(args, format, TableRows::Whole { table, accounts }, &selection, results.study())
}

/// Writes a table in a format, to standard output or a file.
fn write(
    args: &QueryArgs,
    format: TableFormat,
    rows: TableRows<'_>,
    selection: &Selection,
    study: &Study,
) -> Result<Finish> {
    if let (TableFormat::Table | TableFormat::Json, TableRows::Whole { table, .. }) =
        (format, &rows)
        && args.filter.is_some()
        && table.rows().is_empty()
    {
        output::say("no row matches");
    }
    let path = args.output.as_deref();
    let text = match (format, rows) {
        (TableFormat::Csv, rows) => {
            return written(args, write_csv(&rows, path)?);
        }
        (TableFormat::Table, TableRows::Whole { table, .. }) => {
            let text = table.terminal(&layout());
            if path.is_none() {
                return output::print(&text);
            }
            text
        }
        (TableFormat::Json, TableRows::Whole { table, .. }) => {
            escaped_json(&table.json()).into_owned()
        }
        (_, rows) => {
            let path = path.context("--format parquet needs --output")?;
            return written(args, write_parquet(&rows, selection.typed_columns(study)?, path)?);
        }
    };
    match path {
        Some(path) => {
            written_file::write(path, text.as_bytes())?;
            output::print(&format!("{}\n", path.display()))
        }
        None => output::print_raw(&text),
    }
}

/// Says which file so many rows were written to, if it was one.
fn written(args: &QueryArgs, rows: u64) -> Result<Finish> {
    if args.filter.is_some() && rows == 0 {
        output::say("no row matches");
    }
    match &args.output {
        Some(path) => output::print(&format!("{}\n", path.display())),
        None => Ok(Finish::AllDone),
    }
}

/// Returns the columns that can be selected, as a table.
fn columns(study: &Study, steps: bool) -> Result<DataTable> {
    let columns = if steps { along_path(study.columns()) } else { study.columns() };
    let rows = columns
        .iter()
        .map(|column| {
            [&column.name, column.unit(), column.role.name(), column.meaning]
                .map(|text| Cell::Text(text.to_owned()))
                .to_vec()
        })
        .collect();
    Ok(DataTable::new(
        ["column", "unit", "kind", "meaning"].map(|name| TableColumn::new(name, "")).to_vec(),
        rows,
    )?)
}
