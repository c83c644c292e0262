//! A table that is written row by row, to a file or to standard output, so that its length takes no
//! memory.

use std::borrow::Cow;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use answers::{Accounts, AnswerError, RowSource, Selection};
use anyhow::{Context, Result};
use report::{DataTable, ParquetFault, ParquetFile, TypedColumn, WiderCell};
use study::Study;

use crate::account::account_json;
use crate::machine::this_program;
use crate::written_file::{WrittenFile, failure};

/// The source of the blocks of a table, all of which have the same columns.
pub(crate) enum TableRows<'r> {
    /// A table that is there.
    Whole {
        table: DataTable,
        /// The accounts of the runs that computed what is in it.
        accounts: Cow<'r, Accounts>,
    },
    /// The rows that are chosen of a study, to be read as it is written.
    Selected { selection: &'r Selection, study: &'r Study, source: RowSource<'r> },
}

impl TableRows<'_> {
    /// Visits the blocks, and returns the accounts of the runs that computed what is in them.
    fn visit(
        &self,
        mut visitor: impl FnMut(&DataTable) -> Result<()>,
    ) -> Result<Cow<'_, Accounts>> {
        match self {
            TableRows::Whole { table, accounts } => {
                visitor(table)?;
                Ok(Cow::Borrowed(accounts.as_ref()))
            }
            TableRows::Selected { selection, study, source } => {
                let visited = selection
                    .visit(study, *source, |block| visitor(block).map_err(VisitError::Visitor));
                visited.map(Cow::Owned).map_err(|error| match error {
                    VisitError::Answer(error) => error.into(),
                    VisitError::Visitor(error) => error,
                })
            }
        }
    }
}

/// Why the blocks of a table were not all visited.
enum VisitError {
    Answer(AnswerError),
    Visitor(anyhow::Error),
}

impl From<AnswerError> for VisitError {
    fn from(error: AnswerError) -> Self {
        VisitError::Answer(error)
    }
}

/// Writes a table as Parquet and returns the number of its rows.
pub(crate) fn write_parquet(
    rows: &TableRows<'_>,
    mut columns: Vec<TypedColumn>,
    path: &Path,
) -> Result<u64> {
    loop {
        let file = WrittenFile::create(path)?;
        let written = parquet(rows, &columns, &file, path);
        let wider = match &written {
            Err(error) => match error.downcast_ref::<ParquetFault>() {
                Some(ParquetFault::Wider(wider)) => Some(wider.clone()),
                _ => None,
            },
            Ok(_) => None,
        };
        // A mesh may be a pair at some point, which is a text. Types only widen, so this ends.
        let Some(WiderCell { name, cells }) = wider else {
            let count = written?;
            file.settle()?;
            return Ok(count);
        };
        let column = columns.iter_mut().find(|column| column.head.name == name);
        column.context("a block has a column of its own")?.cells = cells;
    }
}

fn parquet(
    rows: &TableRows<'_>,
    columns: &[TypedColumn],
    file: &WrittenFile<'_>,
    path: &Path,
) -> Result<u64> {
    let sink = BufWriter::new(file.sink());
    let mut parquet = ParquetFile::new(sink, columns.to_vec()).with_context(|| failure(path))?;
    let accounts = rows.visit(|block| parquet.write(block).with_context(|| failure(path)))?;
    let runs = accounts.listed().into_iter().map(|(run, account)| account_json(run, account));
    let program = this_program();
    let origin = serde_json::json!({ "written_by": program, "runs": runs.collect::<Vec<_>>() });
    parquet.say("tribosweep.provenance", origin.to_string());
    parquet.close().with_context(|| failure(path))
}

/// Writes a table as CSV to a file, or to standard output, and returns the number of its rows; the
/// largest number if the reader has gone away, who does not care.
pub(crate) fn write_csv(rows: &TableRows<'_>, path: Option<&Path>) -> Result<u64> {
    match path {
        Some(path) => {
            let file = WrittenFile::create(path)?;
            let count = csv(rows, &mut BufWriter::new(file.sink()), &failure(path))?;
            file.settle()?;
            Ok(count)
        }
        None => {
            let output = &mut io::stdout().lock();
            let written = csv(rows, output, "cannot write to standard output");
            // A reader that has gone away, as `head` does, is no error.
            let is_gone = |error: &anyhow::Error| {
                error
                    .downcast_ref::<io::Error>()
                    .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
            };
            match written {
                Err(error) if is_gone(&error) => Ok(u64::MAX),
                written => written,
            }
        }
    }
}

/// Writes a table as CSV; `failure` is said if the bytes cannot be written.
fn csv(rows: &TableRows<'_>, sink: &mut dyn Write, failure: &str) -> Result<u64> {
    let mut is_first = true;
    let mut count = 0;
    rows.visit(|block| {
        let text = if is_first { block.csv() } else { block.csv_rows() };
        is_first = false;
        count += block.rows().len() as u64;
        sink.write_all(text.as_bytes()).with_context(|| failure.to_owned())
    })?;
    sink.flush().with_context(|| failure.to_owned())?;
    Ok(count)
}
