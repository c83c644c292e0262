//! A table that is written row by row, to a file or to standard output, so that its length takes no
//! memory.

use std::borrow::Cow;
use std::ffi::OsString;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use answers::{Accounts, AnswerError, Records, Selection};
use anyhow::{Context, Result};
use report::{DataTable, ParquetFault, ParquetFile, TypedColumn, WiderCell};
use study::Study;

use crate::account::account_json;
use crate::machine::this_program;

/// The source of the blocks of a table, all of which have the same columns.
pub(crate) enum TableRows<'r> {
    /// A table that is there.
    Whole {
        table: DataTable,
        /// The accounts of the runs that computed what is in it.
        accounts: &'r Accounts,
    },
    /// The rows that are chosen of a study, to be read as it is written.
    Selected { selection: &'r Selection, study: &'r Study, source: &'r dyn Records },
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
                Ok(Cow::Borrowed(accounts))
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

/// A file that takes its place when it is whole.
struct NewFile<'p> {
    path: &'p Path,
    partial: PathBuf,
}

impl<'p> NewFile<'p> {
    fn create(path: &'p Path) -> Result<(Self, File)> {
        let mut name = OsString::from(path);
        name.push(".part");
        let partial = PathBuf::from(name);
        let file = File::create(&partial)
            .with_context(|| format!("cannot write {}", partial.display()))?;
        Ok((NewFile { path, partial }, file))
    }

    /// Gives the file its name if it was written, and removes it otherwise.
    fn settle<T>(self, written: Result<T>) -> Result<T> {
        let settled = written.and_then(|written| {
            std::fs::rename(&self.partial, self.path)?;
            Ok(written)
        });
        if settled.is_err() {
            let _ = std::fs::remove_file(&self.partial);
        }
        settled.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

/// Writes a table as Parquet and returns the number of its rows.
pub(crate) fn write_parquet(
    rows: &TableRows<'_>,
    mut columns: Vec<TypedColumn>,
    path: &Path,
) -> Result<u64> {
    loop {
        let (place, file) = NewFile::create(path)?;
        let written = parquet(rows, &columns, file);
        let wider = match &written {
            Err(error) => match error.downcast_ref::<ParquetFault>() {
                Some(ParquetFault::Wider(wider)) => Some(wider.clone()),
                _ => None,
            },
            Ok(_) => None,
        };
        let settled = place.settle(written);
        // A mesh may be a pair at some point, which is a text. Types only widen, so this ends.
        let Some(WiderCell { name, cells }) = wider else { return settled };
        let column = columns.iter_mut().find(|column| column.head.name == name);
        column.context("a block has a column of its own")?.cells = cells;
    }
}

fn parquet(rows: &TableRows<'_>, columns: &[TypedColumn], file: File) -> Result<u64> {
    let mut parquet = ParquetFile::new(BufWriter::new(file), columns.to_vec())?;
    let accounts = rows.visit(|block| Ok(parquet.write(block)?))?;
    let runs = accounts.listed().into_iter().map(|(run, account)| account_json(run, account));
    let program = this_program();
    let origin = serde_json::json!({ "written_by": program, "runs": runs.collect::<Vec<_>>() });
    parquet.say("tribosweep.provenance", origin.to_string());
    Ok(parquet.close()?)
}

/// Writes a table as CSV to a file, or to standard output, and returns the number of its rows; the
/// largest number if the reader has gone away, who does not care.
pub(crate) fn write_csv(rows: &TableRows<'_>, path: Option<&Path>) -> Result<u64> {
    match path {
        Some(path) => {
            let (place, file) = NewFile::create(path)?;
            let mut file = BufWriter::new(file);
            let written = csv(rows, &mut file);
            place.settle(written)
        }
        None => {
            let written = csv(rows, &mut io::stdout().lock());
            // A reader that has gone away, as `head` does, is no error.
            let is_gone = |error: &anyhow::Error| {
                error
                    .downcast_ref::<io::Error>()
                    .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
            };
            match written {
                Err(error) if is_gone(&error) => Ok(u64::MAX),
                written => written.context("cannot write to standard output"),
            }
        }
    }
}

fn csv(rows: &TableRows<'_>, sink: &mut dyn Write) -> Result<u64> {
    let mut is_first = true;
    let mut count = 0;
    rows.visit(|block| {
        let text = if is_first { block.csv() } else { block.csv_rows() };
        is_first = false;
        count += block.rows().len() as u64;
        Ok(sink.write_all(text.as_bytes())?)
    })?;
    sink.flush()?;
    Ok(count)
}
