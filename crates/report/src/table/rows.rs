//! A table of named columns and rows.

use std::borrow::Cow;
use std::cmp::Ordering;

use condition::UnknownColumn;
use serde::{Deserialize, Serialize};

use super::cell::{Cell, compare};
use super::error::TableError;

/// The name of a column and the unit of its numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableColumn {
    /// The name, the same in the study file, in queries, exports and figures.
    pub name: String,
    /// The SI unit, `"1"` for a ratio, empty for text and counts.
    pub unit: String,
}

impl TableColumn {
    /// Makes a column with a name and a unit, which may be empty.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        TableColumn { name: name.into(), unit: unit.into() }
    }
}

/// Named columns, and rows with one cell per column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DataTable {
    columns: Vec<TableColumn>,
    rows: Vec<Vec<Cell>>,
}

impl DataTable {
    /// Makes a table, after checking that names are unique and that every row has one cell per
    /// column.
    ///
    /// # Errors
    /// [`TableError::Duplicate`] if two columns share a name, and [`TableError::RowLength`] if a
    /// row is too short or too long.
    pub fn new(columns: Vec<TableColumn>, rows: Vec<Vec<Cell>>) -> Result<DataTable, TableError> {
        for (i, column) in columns.iter().enumerate() {
            if columns[..i].iter().any(|earlier| earlier.name == column.name) {
                return Err(TableError::Duplicate(column.name.clone()));
            }
        }
        for (row, cells) in rows.iter().enumerate() {
            if cells.len() != columns.len() {
                return Err(TableError::RowLength {
                    row,
                    found: cells.len(),
                    expected: columns.len(),
                });
            }
        }
        Ok(DataTable { columns, rows })
    }

    /// Returns the columns, in order.
    pub fn columns(&self) -> &[TableColumn] {
        &self.columns
    }

    /// Returns the rows, each with one cell per column.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// Iterates over the cells of one column, from top to bottom.
    pub(crate) fn cells(&self, column: usize) -> impl Iterator<Item = &Cell> + Clone {
        self.rows.iter().map(move |row| &row[column])
    }

    /// Returns the index of a column.
    ///
    /// # Errors
    /// [`UnknownColumn`], with the names that come close, if no column has the name.
    pub fn column(&self, name: &str) -> Result<usize, UnknownColumn> {
        self.columns.iter().position(|c| c.name == name).ok_or_else(|| self.unknown(name))
    }

    /// Makes the error about a name that no column has.
    fn unknown(&self, name: &str) -> UnknownColumn {
        let wanted = name.to_lowercase();
        let mut close: Vec<(f64, &str)> = self
            .columns
            .iter()
            .filter_map(|column| {
                let candidate = column.name.to_lowercase();
                // The last part of a dotted name is what people remember.
                let tail = candidate.rsplit('.').next().unwrap_or_default();
                let likeness = strsim::jaro_winkler(&wanted, &candidate)
                    .max(strsim::jaro_winkler(&wanted, tail));
                let contained = wanted.chars().count() >= 3 && candidate.contains(&wanted);
                (likeness > 0.8 || contained).then_some((likeness, column.name.as_str()))
            })
            .collect();
        close.sort_by(|a, b| b.0.total_cmp(&a.0));
        UnknownColumn {
            name: name.to_owned(),
            close: close.into_iter().take(3).map(|(_, name)| name.to_owned()).collect(),
            columns: self.columns.iter().map(|c| c.name.clone()).collect(),
        }
    }

    /// Returns the table with these columns only, in this order.
    ///
    /// # Errors
    /// [`TableError::UnknownColumn`] if no column has a name, or [`TableError::Duplicate`] if a
    /// name is given twice.
    pub fn select<S: AsRef<str>>(&self, names: &[S]) -> Result<DataTable, TableError> {
        let picked =
            names.iter().map(|name| self.column(name.as_ref())).collect::<Result<Vec<_>, _>>()?;
        DataTable::new(
            picked.iter().map(|&i| self.columns[i].clone()).collect(),
            self.rows.iter().map(|row| picked.iter().map(|&i| row[i].clone()).collect()).collect(),
        )
    }

    /// Returns the table sorted by several columns, of which the first decides; `-name` sorts in
    /// descending order.
    ///
    /// Rows that are equal in every key keep their order. Numbers come before text, and missing
    /// values and NaN come last, whether ascending or descending.
    ///
    /// # Errors
    /// [`TableError::UnknownColumn`] if no column has a name.
    pub fn sort<S: AsRef<str>>(&self, keys: &[S]) -> Result<DataTable, TableError> {
        let keys = keys
            .iter()
            .map(|key| {
                let key = key.as_ref();
                match key.strip_prefix('-') {
                    Some(name) if self.columns.iter().all(|c| c.name != key) => {
                        Ok((self.column(name)?, true))
                    }
                    _ => Ok((self.column(key)?, false)),
                }
            })
            .collect::<Result<Vec<_>, UnknownColumn>>()?;
        let mut sorted = self.clone();
        sorted.rows.sort_by(|a, b| {
            let by_key = |&(column, descending): &(usize, bool)| {
                let (a, b) = (&a[column], &b[column]);
                match (a.is_missing(), b.is_missing()) {
                    (false, false) if descending => compare(b, a),
                    (false, false) => compare(a, b),
                    (a, b) => a.cmp(&b),
                }
            };
            keys.iter().map(by_key).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        });
        Ok(sorted)
    }

    /// Returns the table with the rows of another one after its own. Both have the same columns.
    pub fn followed_by(mut self, other: DataTable) -> DataTable {
        debug_assert_eq!(self.columns, other.columns, "tables of different columns");
        self.rows.extend(other.rows);
        self
    }

    /// Returns the table with at most so many of its rows, the first ones.
    pub fn first_rows(&self, most: usize) -> Cow<'_, DataTable> {
        match self.rows.get(..most) {
            Some(rows) => {
                Cow::Owned(DataTable { columns: self.columns.clone(), rows: rows.to_vec() })
            }
            None => Cow::Borrowed(self),
        }
    }

    /// Returns the columns without any row.
    pub fn without_rows(&self) -> DataTable {
        DataTable { columns: self.columns.clone(), rows: Vec::new() }
    }

    /// Returns the table with the rows for which `keep`, which has an element per row, is true.
    pub(crate) fn keep(&self, keep: &[bool]) -> DataTable {
        let rows = self
            .rows
            .iter()
            .zip(keep)
            .filter(|(_, keep)| **keep)
            .map(|(row, _)| row.clone())
            .collect();
        DataTable { columns: self.columns.clone(), rows }
    }
}
