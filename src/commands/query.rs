//! `query`: the results of a study as a table.

use std::borrow::Cow;

use answers::{Accounts, AnswerError, Results, RowKeeper, RowSource, Selection, TabledRows};
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
use crate::study_table::{StudyTable, TableKeeper, has_plain_columns};
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
    let mut selection = Selection {
        filter: args.filter.clone(),
        sort: args.sort.clone(),
        columns: args.select.clone(),
        steps: args.steps,
    };
    let directory = &args.store.store;
    let known = StudyTable::of(directory, &args.name).filter(|_| args.shard.is_none());
    let mut is_kept = false;
    if let Some((table, study)) = known.filter(|_| !args.columns) {
        match query_table(args, format, selection.clone(), &study, &table) {
            Err(AnswerError::Records(_)) => {}
            // The records say what is wrong.
            Err(_) | Ok(None) => {
                let lacks_usual = selection.columns.is_empty() && table.usual_columns().is_none();
                is_kept = !lacks_usual || !has_plain_columns(&study);
            }
            Ok(Some((rows, selection))) => {
                let source = RowSource::Table(&table);
                return write(
                    args,
                    format,
                    rows.of(args, &selection, &study, source)?,
                    &selection,
                    &study,
                );
            }
        }
    }
    let reader = read_store(directory)?;
    let records = &StoreSource::Reader(&reader);
    let mut study = stored_large_study(&reader, &args.name)?;
    if let Some(shard) = args.shard {
        study = part(&study, shard)?;
    }
    if args.columns {
        let table = columns(&study, args.steps)?;
        let rows = TableRows::Whole { table, accounts: Cow::Owned(Accounts::default()) };
        return write(args, format, rows, &selection, &study);
    }
    let keeper = TableKeeper::of(&reader, &study);
    let keeper = Some(&keeper).filter(|_| !is_kept && args.shard.is_none());
    let source =
        RowSource::Records { records, keeper: keeper.map(|keeper| keeper as &dyn RowKeeper) };
    if let Some(rows) = chosen(args, format, &mut selection, &study, source)? {
        return write(args, format, rows.of(args, &selection, &study, source)?, &selection, &study);
    }
    let results = Results::read(study, records)?;
    if selection.columns.is_empty() {
        selection.columns = results.usual_columns(args.steps)?;
    }
    let table = selection.of(&results)?;
    if let Some(keeper) = keeper {
        if has_plain_columns(results.study())
            && let Ok(usual) = results.usual_columns(false)
        {
            keeper.set_usual_columns(usual);
        }
        results.keep_rows(keeper);
    }
    let accounts = Cow::Borrowed(results.accounts());
    write(args, format, TableRows::Whole { table, accounts }, &selection, results.study())
}

/// The rows that are shown.
enum ChosenRows {
    /// They are written as they are read.
    Read,
    /// They are in memory.
    Gathered { table: DataTable, accounts: Accounts },
    /// There are too many for that.
    TooMany,
}

impl ChosenRows {
    /// Returns the rows to be written, of a study whose rows come from some source.
    fn of<'r>(
        self,
        args: &QueryArgs,
        selection: &'r Selection,
        study: &'r Study,
        source: RowSource<'r>,
    ) -> Result<TableRows<'r>> {
        match self {
            ChosenRows::Read => Ok(TableRows::Selected { selection, study, source }),
            ChosenRows::Gathered { table, accounts } => {
                Ok(TableRows::Whole { table, accounts: Cow::Owned(accounts) })
            }
            ChosenRows::TooMany => {
                let part = format!("1/{}", study.len().div_ceil(MOST_POINTS));
                bail!(
                    "the study `{}` has {} points, and {MOST_POINTS} rows at most are a table in \
                     memory; --where may choose fewer, --format parquet or csv with --select and \
                     without --sort writes them one after the other, and this asks for a part of \
                     them: {}",
                    args.name,
                    study.len(),
                    proposal::command(&args.store.store, ["query", &args.name, "--shard", &part])
                )
            }
        }
    }
}

/// Chooses rows from the table of a study as they would be chosen of its records; `None` if it
/// takes the records.
fn query_table(
    args: &QueryArgs,
    format: TableFormat,
    mut selection: Selection,
    study: &Study,
    table: &StudyTable,
) -> Result<Option<(ChosenRows, Selection)>, AnswerError> {
    complete(format, &mut selection, study);
    if let ([], true, Some(usual)) =
        (&selection.columns[..], study.is_listed(), table.usual_columns())
    {
        selection.columns = usual.to_vec();
    }
    if selection.columns.is_empty() && study.is_listed() || !selection.is_in_table(study, table) {
        return Ok(None);
    }
    let rows = match chosen(args, format, &mut selection, study, RowSource::Table(table))? {
        Some(ChosenRows::Read) => {
            // What was written to a pipe cannot be taken back.
            let unreadable = |error: std::io::Error| AnswerError::Records(error.into());
            table.verify(&selection.mentioned_columns(study)).map_err(unreadable)?;
            ChosenRows::Read
        }
        Some(rows) => rows,
        None => ChosenRows::Gathered {
            table: selection.of_table(study, table)?,
            accounts: table.accounts(),
        },
    };
    Ok(Some((rows, selection)))
}

/// Names all columns of a study where no columns are named for a Parquet file.
fn complete(format: TableFormat, selection: &mut Selection, study: &Study) {
    if matches!(format, TableFormat::Parquet) && selection.columns.is_empty() {
        let all = selection.all_columns(study);
        selection.columns = all.into_iter().map(|column| column.name.into_owned()).collect();
    }
}

/// Chooses the rows of a study where that does not take all of its results in memory; `None` where
/// it does.
fn chosen(
    args: &QueryArgs,
    format: TableFormat,
    selection: &mut Selection,
    study: &Study,
    source: RowSource<'_>,
) -> Result<Option<ChosenRows>, AnswerError> {
    complete(format, selection, study);
    let is_file = matches!(format, TableFormat::Parquet | TableFormat::Csv);
    if is_file && !selection.columns.is_empty() && selection.is_separable(study) {
        selection.check(study)?;
        return Ok(Some(ChosenRows::Read));
    }
    let gathered = |selection: &Selection, most| {
        let gathered = selection.gathered(study, source, most)?;
        let whole = gathered.map(|(table, accounts)| ChosenRows::Gathered { table, accounts });
        Ok(Some(whole.unwrap_or(ChosenRows::TooMany)))
    };
    if args.shard.is_none() && !study.is_listed() {
        if selection.columns.is_empty() && !args.steps {
            selection.columns = Selection::usual_columns(study);
        }
        return match study.is_one_run() && selection.has_own_rows(study) {
            true => gathered(selection, MOST_POINTS),
            false => Ok(Some(ChosenRows::TooMany)),
        };
    }
    let is_known = !selection.columns.is_empty();
    if study.point_count() > IN_MEMORY && is_known && selection.has_own_rows(study) {
        return gathered(selection, usize::MAX);
    }
    Ok(None)
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
