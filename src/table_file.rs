//! A table that is written row by row, to a file or to standard output, so that its length takes no
//! memory.

use std::borrow::Cow;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use answers::{Accounts, AnswerError, RowSource, Selection};
use anyhow::{Context, Result};
use report::{
    DataTable, ParquetFault, ParquetFile, TerminalLayout, TypedColumn, WiderCell, packed_cells,
    set_in_blocks, unpacked_cells,
};
use study::{MOST_POINTS, Study};
use wording::{escaped_json, visible};

use crate::account::account_json;
use crate::machine::this_program;
use crate::output::layout;
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

/// The most bytes of packed blocks that are in memory.
const MOST_PACKED: usize = 32 << 20;

/// The blocks of a table that was made of records, packed, so that they need not be made again.
#[derive(Default)]
struct PackedBlocks {
    heads: Option<DataTable>,
    /// The number of rows of each block, and its columns.
    blocks: Vec<(usize, Vec<Vec<u8>>)>,
    bytes: usize,
    /// There was no room for a block.
    is_full: bool,
}

impl PackedBlocks {
    fn add(&mut self, block: &DataTable) {
        if self.is_full {
            return;
        }
        let columns = 0..block.columns().len();
        let pack = |column: usize| packed_cells(block.rows().iter().map(|row| &row[column]));
        let columns: Option<Vec<Vec<u8>>> = columns.map(pack).collect();
        self.bytes += columns.iter().flatten().map(Vec::len).sum::<usize>();
        self.is_full = columns.is_none() || self.bytes > MOST_PACKED;
        if self.is_full {
            self.blocks = Vec::new();
            return;
        }
        self.heads.get_or_insert_with(|| block.without_rows());
        self.blocks.extend(columns.map(|columns| (block.rows().len(), columns)));
    }

    fn visit(&self, visitor: &mut dyn FnMut(&DataTable) -> Result<()>) -> Result<()> {
        let Some(heads) = &self.heads else { return Ok(()) };
        for (count, columns) in &self.blocks {
            let unpacked = columns.iter().map(|column| unpacked_cells(column, *count));
            let mut columns: Vec<_> = unpacked
                .map(|column| Some(column?.into_iter()))
                .collect::<Option<_>>()
                .context("packed cells are not what they were")?;
            let rows = (0..*count).map(|_| columns.iter_mut().filter_map(Iterator::next).collect());
            visitor(&DataTable::new(heads.columns().to_vec(), rows.collect())?)?;
        }
        Ok(())
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
    let mut is_first = true;
    let mut count = 0;
    written(path, |write| {
        rows.visit(|block| {
            let text = if is_first { block.csv() } else { block.csv_rows() };
            is_first = false;
            count += block.rows().len() as u64;
            write(&text)
        })
        .map(|_| true)
    })
    .map(|is_read| if is_read { count } else { u64::MAX })
}

/// Writes a table as JSON like [`write_csv`].
pub(crate) fn write_json(rows: &TableRows<'_>, path: Option<&Path>) -> Result<u64> {
    let mut is_first = true;
    let mut count = 0;
    written(path, |write| {
        rows.visit(|block| {
            if is_first {
                write(&escaped_json(&block.json_head()))?;
            }
            is_first = false;
            let text = block.json_rows(count == 0);
            count += block.rows().len() as u64;
            write(&escaped_json(&text))
        })?;
        write(DataTable::json_end(count > 0)).map(|()| true)
    })
    .map(|is_read| if is_read { count } else { u64::MAX })
}

/// Writes a table to be read like [`write_csv`]. Its rows are visited three times, since the width
/// of a column follows from all of them; where a text is wrapped, they are in memory, and of too
/// many rows none is wrapped.
pub(crate) fn write_table(rows: &TableRows<'_>, path: Option<&Path>) -> Result<u64> {
    let layout = layout_for(path, layout());
    if let Some(count) = write_lines(rows, path, &layout)? {
        return Ok(count);
    }
    let mut whole: Option<DataTable> = None;
    let mut are_few = true;
    rows.visit(|block| {
        are_few &= whole.as_ref().map_or(0, |table| table.rows().len()) <= MOST_POINTS;
        if are_few {
            let before = whole.take().unwrap_or_else(|| block.without_rows());
            whole = Some(before.followed_by(block.clone()));
        }
        Ok(())
    })?;
    let Some(table) = whole.filter(|_| are_few) else {
        let layout = TerminalLayout { width: None, ..layout };
        return Ok(write_lines(rows, path, &layout)?.unwrap_or(0));
    };
    let text = table.terminal(&layout);
    let is_read = written(path, |write| write(&visible(&text)).map(|()| true))?;
    Ok(if is_read { table.rows().len() as u64 } else { u64::MAX })
}

/// Returns the layout of a table to be read. A file has the one of a pipe, which does not depend on
/// the terminal from which it was written.
fn layout_for(path: Option<&Path>, layout: TerminalLayout) -> TerminalLayout {
    TerminalLayout { width: layout.width.filter(|_| path.is_none()), ..layout }
}

/// Writes a table to be read; `None` if nothing was written, since a text would be wrapped.
fn write_lines(
    rows: &TableRows<'_>,
    path: Option<&Path>,
    layout: &TerminalLayout,
) -> Result<Option<u64>> {
    let are_packed = matches!(rows, TableRows::Selected { source: RowSource::Records { .. }, .. });
    let mut packed = PackedBlocks::default();
    let mut is_set = true;
    let mut visits = 0;
    let mut count = 0;
    let is_read = written(path, |write| {
        let visit = |visitor: &mut dyn FnMut(&DataTable) -> Result<()>| {
            visits += 1;
            if visits > 1 && are_packed && !packed.is_full {
                return packed.visit(visitor);
            }
            rows.visit(|block| {
                if visits == 1 {
                    count += block.rows().len() as u64;
                    if are_packed {
                        packed.add(block);
                    }
                }
                visitor(block)
            })
            .map(drop)
        };
        is_set = set_in_blocks(layout, visit, |text| write(&visible(text)))?;
        Ok(is_set)
    })?;
    Ok(is_set.then_some(if is_read { count } else { u64::MAX }))
}

/// Writes text as it is made, to a file or to standard output; the file stays as it was if `fill`
/// says that there is none. Returns false if the reader of standard output has gone away, as `head`
/// does, which is no error.
fn written(
    path: Option<&Path>,
    fill: impl FnOnce(&mut dyn FnMut(&str) -> Result<()>) -> Result<bool>,
) -> Result<bool> {
    let into = |sink: &mut dyn Write, failure: &str| {
        let write =
            &mut |text: &str| sink.write_all(text.as_bytes()).with_context(|| failure.to_owned());
        let is_filled = fill(write)?;
        sink.flush().with_context(|| failure.to_owned())?;
        Ok(is_filled)
    };
    if let Some(path) = path {
        let file = WrittenFile::create(path)?;
        if into(&mut BufWriter::new(file.sink()), &failure(path))? {
            file.settle()?;
        }
        return Ok(true);
    }
    match into(&mut io::stdout().lock(), "cannot write to standard output") {
        Err(error) if is_gone(&error) => Ok(false),
        outcome => outcome.map(|_| true),
    }
}

/// Returns whether something was not written since its reader has gone away.
fn is_gone(error: &anyhow::Error) -> bool {
    let source = error.downcast_ref::<io::Error>();
    source.is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_blocks_are_those_that_were_packed() {
        let heads = vec![report::TableColumn::new("mu", "1"), report::TableColumn::new("why", "")];
        let block = |rows: &[(f64, &str)]| {
            let rows = rows.iter().map(|(mu, why)| vec![(*mu).into(), (*why).into()]).collect();
            DataTable::new(heads.clone(), rows).unwrap()
        };
        let blocks = [block(&[(0.1, "a"), (0.2, "")]), block(&[]), block(&[(0.3, "a")])];
        let mut packed = PackedBlocks::default();
        blocks.iter().for_each(|block| packed.add(block));
        let mut visited = Vec::new();
        packed
            .visit(&mut |block| {
                visited.push(block.clone());
                Ok(())
            })
            .unwrap();
        assert_eq!(visited, blocks);
        let long = "x".repeat(MOST_PACKED);
        packed.add(&block(&[(0.4, &long)]));
        assert!(packed.is_full && packed.blocks.is_empty());
    }

    #[test]
    fn a_file_has_the_layout_of_a_pipe() {
        let of_terminal = TerminalLayout { width: Some(40), ..TerminalLayout::default() };
        assert_eq!(layout_for(None, of_terminal).width, Some(40));
        assert_eq!(layout_for(Some(Path::new("rows.txt")), of_terminal).width, None);
    }
}
