//! `query`: the results of a study as a table.

use std::borrow::Cow;

use answers::{
    Accounts, AnswerError, POINTS_IN_MEMORY, Results, RowKeeper, RowSource, Selection, TabledRows,
    survey,
};
use anyhow::{Context, Result, bail};
use report::{Cell, DataTable, TableColumn};
use study::columns::along_path;
use study::{MOST_POINTS, Study};

use crate::cli::{QueryArgs, TableFormat};
use crate::output::{self, Finish};
use crate::proposal;
use crate::stored::{StoreSource, read_store, stored_large_study};
use crate::study_file::part;
use crate::study_table::{StudyTable, TableKeeper, has_plain_columns};
use crate::table_file::{TableRows, write_csv, write_json, write_parquet, write_table};
use crate::table_part::TablePart;
use crate::written_file;

/// The number of cells up to which a table to be read is in memory.
const CELLS_IN_MEMORY: usize = 1 << 19;

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
    let mut is_kept = false;
    let mut usual_of_steps = None;
    if let Some((table, whole)) = StudyTable::of(directory, &args.name).filter(|_| !args.columns) {
        let cut = args.shard.map(|shard| part(&whole, shard)).transpose()?;
        let rows = cut.as_ref().map(|part| TablePart::of(&table, &whole, part));
        let study = cut.as_ref().unwrap_or(&whole);
        let (rows, usual): (Option<&dyn TabledRows>, _) = match &rows {
            None => (Some(&table), table.usual_columns()),
            Some(part) => (part.as_ref().map(|part| part as &dyn TabledRows), None),
        };
        let kept = rows.map(|rows| KnownRows { table: &table, rows, usual });
        let chosen = kept.map(|kept| query_table(args, format, selection.clone(), study, kept));
        match chosen.unwrap_or(Ok(None)) {
            Err(AnswerError::Records(_)) => {}
            Err(_) | Ok(None) => {
                // What is wrong with a value is said of the records.
                selection.check(study)?;
                let lacks_usual = selection.columns.is_empty() && table.usual_columns().is_none();
                is_kept = !lacks_usual || !has_plain_columns(&whole);
                let notes = table.notes().filter(|_| args.steps && args.shard.is_none());
                usual_of_steps = notes.map(|notes| notes.usual_columns(true).to_vec());
            }
            Ok(Some(TableAnswer { rows, source, selection })) => {
                let rows = rows.of(args, &selection, study, source)?;
                return write(args, format, rows, &selection, study);
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
    complete(format, &mut selection, &study);
    if selection.columns.is_empty() {
        selection.columns = usual_of_steps.unwrap_or_default();
    }
    let lacks_columns = selection.columns.is_empty();
    let mut is_to_keep = !is_kept && args.shard.is_none();
    if is_long(args, &study)
        && study.has_independent_points()
        && (lacks_columns || is_to_keep && !args.steps)
    {
        // What is wrong is said before so much is read.
        selection.check(&study)?;
        let notes = match is_to_keep {
            true => TableKeeper::make(&reader, &study)?,
            false => survey(&study, records, None)?,
        };
        is_to_keep = false;
        if lacks_columns && (study.is_listed() || args.shard.is_some() || args.steps) {
            selection.columns = notes.usual_columns(args.steps).to_vec();
        }
        let made = StudyTable::of(directory, &args.name).filter(|_| args.shard.is_none());
        if let Some((table, study)) = made {
            let kept = KnownRows { table: &table, rows: &table, usual: table.usual_columns() };
            if let Ok(Some(TableAnswer { rows, source, selection })) =
                query_table(args, format, selection.clone(), &study, kept)
            {
                let rows = rows.of(args, &selection, &study, source)?;
                return write(args, format, rows, &selection, &study);
            }
        }
    }
    let keeper = TableKeeper::of(&reader, &study);
    let keeper = Some(&keeper).filter(|_| is_to_keep);
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

/// Returns whether a study has so many points that their rows are not all in memory.
fn is_long(args: &QueryArgs, study: &Study) -> bool {
    study.point_count() > POINTS_IN_MEMORY && (study.is_one_run() || args.shard.is_some())
}

/// The rows of a study, or of a part of it, in a table that is kept.
#[derive(Clone, Copy)]
struct KnownRows<'t> {
    table: &'t StudyTable,
    rows: &'t dyn TabledRows,
    /// The usual columns of the study, if they are known.
    usual: Option<&'t [String]>,
}

/// The rows that a table of a study gives.
struct TableAnswer<'t> {
    rows: ChosenRows,
    source: RowSource<'t>,
    /// The choice, with the columns that are shown.
    selection: Selection,
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
fn query_table<'t>(
    args: &QueryArgs,
    format: TableFormat,
    mut selection: Selection,
    study: &Study,
    kept: KnownRows<'t>,
) -> Result<Option<TableAnswer<'t>>, AnswerError> {
    let KnownRows { table, rows, usual } = kept;
    complete(format, &mut selection, study);
    let is_listed = study.is_listed() || args.shard.is_some();
    if let ([], true, Some(usual)) = (&selection.columns[..], is_listed, usual) {
        selection.columns = usual.to_vec();
    }
    if selection.columns.is_empty() && is_listed || !selection.is_in_table(study, rows) {
        return Ok(None);
    }
    let source = RowSource::Table(rows);
    let chosen = match chosen(args, format, &mut selection, study, source)? {
        Some(ChosenRows::Read) => {
            // What was written to a pipe cannot be taken back.
            let unreadable = |error: std::io::Error| AnswerError::Records(error.into());
            table.verify(&selection.mentioned_columns(study)).map_err(unreadable)?;
            ChosenRows::Read
        }
        Some(rows) => rows,
        None => ChosenRows::Gathered {
            table: selection.of_table(study, rows)?,
            accounts: table.accounts(),
        },
    };
    Ok(Some(TableAnswer { rows: chosen, source, selection }))
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
    let is_whole = args.shard.is_none();
    let is_enumerated = is_whole && !study.is_listed();
    if is_enumerated && study.is_one_run() && selection.columns.is_empty() && !args.steps {
        selection.columns = Selection::usual_columns(study);
    }
    let gathered = |selection: &Selection, most| -> Result<Option<ChosenRows>, AnswerError> {
        let gathered = selection.gathered(study, source, most)?;
        Ok(gathered.map(|(table, accounts)| ChosenRows::Gathered { table, accounts }))
    };
    let is_long = is_long(args, study);
    let is_file = matches!(format, TableFormat::Parquet | TableFormat::Csv);
    if (is_file || is_long) && !selection.columns.is_empty() && selection.is_separable(study) {
        selection.check(study)?;
        // Few rows need not be visited twice.
        let most = match (format, source) {
            _ if !is_long => 0,
            // They pass by once, and are packed.
            (TableFormat::Table, RowSource::Records { .. }) => 0,
            (TableFormat::Table, _) => CELLS_IN_MEMORY / selection.columns.len(),
            (_, RowSource::Table(_)) if selection.filter.is_some() => POINTS_IN_MEMORY,
            _ => 0,
        };
        let few = if most > 0 { gathered(selection, most)? } else { None };
        return Ok(Some(few.unwrap_or(ChosenRows::Read)));
    }
    if is_enumerated {
        let rows = match study.is_one_run() && selection.has_own_rows(study) {
            true => gathered(selection, MOST_POINTS)?,
            false => None,
        };
        return Ok(Some(rows.unwrap_or(ChosenRows::TooMany)));
    }
    let is_known = !selection.columns.is_empty();
    if study.point_count() > POINTS_IN_MEMORY && is_known && selection.has_own_rows(study) {
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
    let path = args.output.as_deref();
    let count = match format {
        TableFormat::Table => write_table(&rows, path)?,
        TableFormat::Json => write_json(&rows, path)?,
        TableFormat::Csv => write_csv(&rows, path)?,
        TableFormat::Parquet => {
            let path = path.context("--format parquet needs --output")?;
            write_parquet(&rows, selection.typed_columns(study)?, path)?
        }
    };
    if args.filter.is_some() && count == 0 {
        output::say("no row matches");
    }
    match path {
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
