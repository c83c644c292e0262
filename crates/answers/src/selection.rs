//! A table of a study's results: which rows and columns of it, and in which order.

use identity::JobKey;
use report::{
    CellType, DataTable, FilterError, FilteredColumn, TableColumn, TableError, TypedColumn,
    sought_texts,
};
use study::columns::{along_path, nearest_name};
use study::{Column, Study, ValueType};

use crate::accounts::Accounts;
use crate::block::{self, POINTS_AT_ONCE};
use crate::error::AnswerError;
use crate::records::Records;
use crate::results::Results;
use crate::rows::{heads, increments};
use crate::survey::Surveyor;
use crate::tabled::{RowKeeper, TabledRows, rows_of_table, tabled_columns};

/// The cells from which on a block is complete.
const CELLS_OF_A_BLOCK: usize = 1 << 20;

/// The source of the rows of a study.
#[derive(Clone, Copy)]
pub enum RowSource<'r> {
    /// The records of its jobs.
    Records {
        /// The records.
        records: &'r dyn Records,
        /// The place that keeps all rows as they are made.
        keeper: Option<&'r dyn RowKeeper>,
    },
    /// A table that was made of them.
    Table(&'r dyn TabledRows),
}

/// A choice of rows and columns.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// The condition that the rows meet; none keeps all.
    pub filter: Option<String>,
    /// The columns to sort by, of which the first decides; `-name` sorts downwards.
    pub sort: Vec<String>,
    /// The columns, by name.
    pub columns: Vec<String>,
    /// The rows are the increments of loading paths in place of their ends.
    pub steps: bool,
}

impl Selection {
    /// Returns the rows and columns that are chosen of some results.
    ///
    /// # Errors
    /// There is no such column, the condition cannot be evaluated, or the fields of a record that
    /// is compared cannot be read.
    pub fn of(&self, results: &Results<'_>) -> Result<DataTable, AnswerError> {
        let table = if self.steps {
            results.increments()?
        } else {
            let mentions = self.columns.iter().chain(&self.sort).chain(&self.filter);
            results.table(&mentions.collect::<Vec<_>>())?
        };
        self.chosen(table).map_err(|error| suggested(error, results.study()))
    }

    /// Returns the rows and columns that are chosen of a table like those that are chosen [of
    /// results](Selection::of) from which it was made.
    ///
    /// # Errors
    /// There is no such column, the condition cannot be evaluated, or the table cannot be read.
    pub fn of_table(
        &self,
        study: &Study,
        table: &dyn TabledRows,
    ) -> Result<DataTable, AnswerError> {
        self.check(study)?;
        let columns = self.mentioned_columns(study);
        let rows = match self.rows_sought(table)? {
            Some(rows) => rows,
            None => (0..table.row_count()).collect(),
        };
        let table = rows_of_table(table, &columns, &rows)?;
        self.chosen(table).map_err(|error| suggested(error, study))
    }

    /// Returns whether a table has everything that the choice is about.
    pub fn is_in_table(&self, study: &Study, table: &dyn TabledRows) -> bool {
        let has = |column: &Column| table.columns().iter().any(|has| has.name == column.name);
        !self.steps && self.mentioned_columns(study).iter().all(has)
    }

    /// Returns the columns that occur in the choice, and maybe others.
    pub fn mentioned_columns(&self, study: &Study) -> Vec<Column> {
        let mut columns = self.all_columns(study);
        columns.retain(|column| self.mentions(column));
        columns
    }

    /// Returns the only rows of a table that can meet the condition, if it names the jobs.
    fn rows_sought(&self, table: &dyn TabledRows) -> Result<Option<Vec<usize>>, AnswerError> {
        let typed = table.columns().iter();
        let typed: Vec<FilteredColumn<'_>> =
            typed.map(|c| FilteredColumn { name: &c.name, cells: c.cells }).collect();
        let texts = self.filter.as_ref().and_then(|filter| sought_texts(filter, &typed, "key"));
        let Some(texts) = texts else { return Ok(None) };
        let mut rows = Vec::new();
        // A text that is spelled otherwise is no job's key.
        for key in texts.iter().filter_map(|text| text.parse::<JobKey>().ok()) {
            rows.extend(table.rows_of(&key).map_err(AnswerError::Records)?);
        }
        rows.sort_unstable();
        rows.dedup();
        Ok(Some(rows))
    }

    fn chosen(&self, mut table: DataTable) -> Result<DataTable, AnswerError> {
        if let Some(expression) = &self.filter {
            table = table.filter(expression)?;
        }
        if !self.sort.is_empty() {
            table = table.sort(&self.sort)?;
        }
        Ok(table.select(&self.columns)?)
    }

    /// Checks the names of columns and the form of the condition, before anything is read.
    ///
    /// # Errors
    /// There is no such column, or the condition has no meaning.
    pub fn check(&self, study: &Study) -> Result<(), AnswerError> {
        let empty = DataTable::new(heads(&self.all_columns(study)), Vec::new())?;
        self.chosen(empty).map(|_| ()).map_err(|error| suggested(error, study))
    }

    /// Returns whether the rows of a study can be made a few at a time: none depends on another,
    /// and they stay in their order.
    pub fn is_separable(&self, study: &Study) -> bool {
        self.sort.is_empty() && self.has_own_rows(study)
    }

    /// Returns whether no row of a study depends on another.
    pub fn has_own_rows(&self, study: &Study) -> bool {
        let compares =
            study.columns().iter().any(|column| column.is_compared() && self.mentions(column));
        study.adaptive().is_none() && !compares
    }

    /// Returns the columns that are shown of the points of a study that is too large for figures:
    /// its axes, and the usual results.
    pub fn usual_columns(study: &Study) -> Vec<String> {
        let axes = study.axes().map(|axis| axis.column().into_owned());
        let usual = study.kind().usual_columns().iter().map(|name| (*name).to_owned());
        axes.chain(usual).collect()
    }

    /// Returns whether the name of a column occurs in the choice, be it as a part of another name.
    fn mentions(&self, column: &Column) -> bool {
        let mut mentions = self.columns.iter().chain(&self.sort).chain(&self.filter);
        mentions.any(|mention| mention.contains(column.name.as_ref()))
    }

    /// Gathers the rows that are chosen of a study whose rows do not depend on each other, block by
    /// block, and sorts them. Only these rows are in memory. Returns `None` if there are more than
    /// `most`.
    ///
    /// # Errors
    /// There is no such column, the condition cannot be evaluated, or a record cannot be read.
    pub fn gathered(
        &self,
        study: &Study,
        source: RowSource<'_>,
        most: usize,
    ) -> Result<Option<(DataTable, Accounts)>, AnswerError> {
        self.check(study)?;
        let mut columns = self.columns.clone();
        for key in &self.sort {
            let names = |name: &str| self.all_columns(study).iter().any(|c| c.name == name);
            let name = key.strip_prefix('-').filter(|_| !names(key)).unwrap_or(key);
            if !columns.iter().any(|column| column == name) {
                columns.push(name.to_owned());
            }
        }
        let unsorted = Selection { sort: Vec::new(), columns, ..self.clone() };
        let mut table: Option<DataTable> = None;
        let mut is_full = false;
        let accounts = unsorted.visit_while(study, source, &mut |block: &DataTable| {
            let so_far =
                table.take().map_or_else(|| block.clone(), |t| t.followed_by(block.clone()));
            is_full = so_far.rows().len() > most;
            table = Some(so_far);
            Ok::<bool, AnswerError>(!is_full)
        })?;
        if is_full {
            return Ok(None);
        }
        let table = table.unwrap_or(DataTable::new(Vec::new(), Vec::new())?);
        let sorted = if self.sort.is_empty() { table } else { table.sort(&self.sort)? };
        Ok(Some((sorted.select(&self.columns)?, accounts)))
    }

    /// Visits the rows that are chosen of a study in blocks, of which one at a time is in memory,
    /// and returns the accounts of the runs that computed its results.
    ///
    /// # Errors
    /// There is no such column, the condition cannot be evaluated, a record cannot be read, or the
    /// visitor fails.
    pub fn visit<E: From<AnswerError>>(
        &self,
        study: &Study,
        source: RowSource<'_>,
        mut visitor: impl FnMut(&DataTable) -> Result<(), E>,
    ) -> Result<Accounts, E> {
        self.visit_while(study, source, &mut |block| visitor(block).map(|()| true))
    }

    /// Visits the rows like [`visit`](Selection::visit), until the visitor returns false.
    fn visit_while<E: From<AnswerError>>(
        &self,
        study: &Study,
        source: RowSource<'_>,
        visitor: &mut dyn FnMut(&DataTable) -> Result<bool, E>,
    ) -> Result<Accounts, E> {
        self.check(study)?;
        // Each of some hundred columns takes 32 bytes of a row.
        let columns = self.mentioned_columns(study);
        let mut chosen =
            self.chosen(DataTable::new(heads(&columns), Vec::new()).map_err(AnswerError::from)?)?;
        let mut goes_on = true;
        let mut add = |table: DataTable| {
            let more = self.chosen(table).map_err(|error| suggested(error, study))?;
            chosen = std::mem::replace(&mut chosen, more.without_rows()).followed_by(more);
            if chosen.rows().len() * chosen.columns().len() >= CELLS_OF_A_BLOCK {
                goes_on = visitor(&chosen)?;
                chosen = chosen.without_rows();
            }
            Ok::<bool, E>(goes_on)
        };
        let accounts = match source {
            RowSource::Records { records, keeper } => {
                let tabled = tabled_columns(study);
                keeper.into_iter().for_each(|keeper| keeper.begin(&tabled));
                let mut surveyor = keeper.and_then(|_| Surveyor::of(study));
                let accounts = block::visit(study, records, POINTS_AT_ONCE, &mut |block| {
                    keeper.into_iter().for_each(|keeper| block.keep(&tabled, keeper));
                    if let Some(surveyor) = &mut surveyor {
                        surveyor.add(&block)?;
                    }
                    add(match self.steps {
                        true => increments(&columns, block.accounts, block.computed())?,
                        false => DataTable::new(heads(&columns), block.rows(&columns))
                            .map_err(AnswerError::from)?,
                    })
                })?;
                if let Some(keeper) = keeper.filter(|_| goes_on) {
                    let notes = surveyor.map(Surveyor::notes).transpose()?;
                    keeper.end(&accounts, notes.as_ref());
                }
                accounts
            }
            RowSource::Table(table) => {
                let rows = self.rows_sought(table)?;
                let count = rows.as_ref().map_or(table.row_count(), Vec::len);
                for start in (0..count).step_by(POINTS_AT_ONCE) {
                    let end = count.min(start + POINTS_AT_ONCE);
                    let numbers = match &rows {
                        Some(rows) => rows[start..end].to_vec(),
                        None => (start..end).collect(),
                    };
                    if !add(rows_of_table(table, &columns, &numbers)?)? {
                        break;
                    }
                }
                table.accounts()
            }
        };
        if goes_on {
            visitor(&chosen)?;
        }
        Ok(accounts)
    }

    /// Returns every column that there is to choose from.
    pub fn all_columns(&self, study: &Study) -> Vec<Column> {
        if self.steps { along_path(study.columns()) } else { study.columns() }
    }

    /// Returns the columns that are chosen with the types of their cells.
    ///
    /// # Errors
    /// There is no such column.
    pub fn typed_columns(&self, study: &Study) -> Result<Vec<TypedColumn>, AnswerError> {
        let all = self.all_columns(study);
        let heads = DataTable::new(heads(&all), Vec::new())?;
        let typed = |name: &String| {
            let column = &all[heads.column(name).map_err(TableError::from)?];
            Ok(TypedColumn {
                head: TableColumn::new(column.name.as_ref(), column.unit()),
                meaning: column.meaning.to_owned(),
                cells: match column.values() {
                    ValueType::Integer => CellType::Integer,
                    ValueType::Number => CellType::Number,
                    ValueType::Flag => CellType::Flag,
                    ValueType::Text => CellType::Text,
                },
            })
        };
        let columns: Result<Vec<_>, AnswerError> = self.columns.iter().map(typed).collect();
        columns.map_err(|error| suggested(error, study))
    }
}

/// Returns the error about a column that is not there with the column that others call so, unless
/// it names one that is spelled like it.
fn suggested(error: AnswerError, study: &Study) -> AnswerError {
    let unknown = match &error {
        AnswerError::Table(TableError::UnknownColumn(unknown))
        | AnswerError::Filter(FilterError::UnknownColumn(unknown)) => unknown,
        _ => return error,
    };
    match nearest_name(&study.columns(), &unknown.name) {
        Some(meant) if unknown.close.is_empty() => {
            AnswerError::OtherName { name: unknown.name.clone(), meant: meant.to_owned() }
        }
        _ => error,
    }
}
