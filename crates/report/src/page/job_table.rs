//! The table of a page that can be sorted and filtered.

use serde_json::{Value, json};
use wording::visible;

use crate::table::{Cell, DataTable, TableError};

/// The table of all jobs.
#[derive(Clone, Debug)]
pub struct JobTable {
    table: DataTable,
    columns: Vec<JobColumn>,
    keys: Vec<String>,
    /// The rows whose jobs have no fields.
    fieldless: Vec<usize>,
}

/// The meaning of a column of a table of jobs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobColumn {
    /// The name.
    pub name: String,
    /// The kind of its values, by which columns are grouped; `axis` for what tells jobs apart.
    pub group: &'static str,
    /// The meaning in words.
    pub meaning: String,
    /// True if it is shown from the start.
    pub is_shown: bool,
}

/// The room that a column takes in the page, from cells that come one after the other.
#[derive(Clone, Debug)]
pub struct ColumnRoom {
    first: Option<Cell>,
    /// All cells are equal, so that the page has one of them.
    is_constant: bool,
    is_filled: bool,
    cells: usize,
    /// The bytes of the cells, unless all are equal.
    bytes: usize,
}

impl Default for ColumnRoom {
    fn default() -> Self {
        Self { first: None, is_constant: true, is_filled: false, cells: 0, bytes: 0 }
    }
}

impl ColumnRoom {
    /// Adds the next cell.
    pub fn add(&mut self, cell: &Cell) {
        self.is_filled |= !cell.is_missing();
        let bytes = |cell: &Cell| value(cell).to_string().len() + 1;
        match &self.first {
            None => self.first = Some(cell.clone()),
            Some(first) if self.is_constant && cell == first => {}
            Some(first) => {
                if self.is_constant {
                    self.is_constant = false;
                    self.bytes = self.cells * bytes(first);
                }
                self.bytes += bytes(cell);
            }
        }
        self.cells += 1;
    }

    /// Returns whether some cell has a value.
    pub fn is_filled(&self) -> bool {
        self.is_filled
    }

    /// Returns about as many bytes as the column takes.
    fn bytes(&self) -> usize {
        200 + self.bytes
    }
}

/// The columns and the number of rows of a table that fits into a page.
#[derive(Clone, Debug)]
pub struct FittedTable {
    /// The columns.
    pub columns: Vec<JobColumn>,
    /// The number of rows, from the first one on.
    pub rows: usize,
}

impl FittedTable {
    /// Returns whether nothing but the columns that are shown from the start fits into a number of
    /// bytes beside the keys of so many rows. It does not matter then how long the others are.
    pub fn is_full(rows: usize, room: usize) -> bool {
        rows * KEY > room
    }

    /// Returns what fits into a number of bytes. Columns without any value are left out. If the
    /// others do not fit, those that are not shown from the start go first, from the last one on,
    /// then rows, from the last one on.
    pub fn of(columns: Vec<(JobColumn, ColumnRoom)>, rows: usize, room: usize) -> Self {
        let mut kept = columns;
        kept.retain(|(_, column)| column.is_filled);
        let mut used = rows * KEY + kept.iter().map(|(_, column)| column.bytes()).sum::<usize>();
        while used > room
            && let Some(last) = kept.iter().rposition(|(column, _)| !column.is_shown)
        {
            used -= kept.remove(last).1.bytes();
        }
        let rows = if used > room { rows * room / used } else { rows };
        Self { columns: kept.into_iter().map(|(column, _)| column).collect(), rows }
    }
}

/// The bytes that the key of a row takes.
const KEY: usize = 68;

impl JobTable {
    /// Makes a table of some columns, [fitted](FittedTable::of) into a number of bytes.
    ///
    /// # Errors
    /// [`TableError`], if the table lacks a column or the column `key`.
    pub fn new(table: &DataTable, columns: &[JobColumn], room: usize) -> Result<Self, TableError> {
        let mut sized = Vec::new();
        for column in columns {
            let mut taken = ColumnRoom::default();
            table.cells(table.column(&column.name)?).for_each(|cell| taken.add(cell));
            sized.push((column.clone(), taken));
        }
        let FittedTable { columns, rows } = FittedTable::of(sized, table.rows().len(), room);
        let keep: Vec<bool> = (0..table.rows().len()).map(|row| row < rows).collect();
        Self::of_rows(&table.keep(&keep), columns)
    }

    /// Makes a table of some columns with all rows of another one.
    ///
    /// # Errors
    /// [`TableError`], if the table lacks a column or the column `key`.
    pub fn of_rows(table: &DataTable, columns: Vec<JobColumn>) -> Result<Self, TableError> {
        let key =
            |cell: &Cell| if let Cell::Text(key) = cell { key.clone() } else { String::new() };
        let keys = table.cells(table.column("key")?).map(key).collect();
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        Ok(Self { table: table.select(&names)?, columns, keys, fieldless: Vec::new() })
    }

    /// Returns the table with what is known of the job of each row, by its number: whether it has
    /// fields.
    pub fn with_fields(mut self, has_fields: impl Fn(usize) -> bool) -> Self {
        self.fieldless = (0..self.rows()).filter(|row| !has_fields(*row)).collect();
        self
    }

    /// Returns the names of its columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.keys.len()
    }

    /// Returns the keys of the rows.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// Returns the table for the script. A column whose cells are all equal holds its value once.
    pub(super) fn json(&self) -> Value {
        let mut slots = Vec::new();
        let mut columns = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            let unit = &self.table.columns()[index].unit;
            let mut cells = self.table.cells(index);
            let is_number =
                self.table.cells(index).all(|cell| !matches!(cell, Cell::Flag(_) | Cell::Text(_)));
            let mut said = json!({
                "name": visible(&column.name),
                "unit": visible(unit),
                "meaning": visible(&column.meaning),
                "group": column.group,
                "shown": column.is_shown,
                "number": is_number,
            });
            match cells.next().filter(|first| cells.all(|cell| cell == *first)) {
                Some(same) => said["same"] = value(same),
                None => {
                    said["slot"] = json!(slots.len());
                    slots.push(index);
                }
            }
            columns.push(said);
        }
        let rows: Vec<Vec<Value>> = self
            .table
            .rows()
            .iter()
            .map(|row| slots.iter().map(|slot| value(&row[*slot])).collect())
            .collect();
        let keys: Vec<_> = self.keys.iter().map(|key| visible(key)).collect();
        json!({ "columns": columns, "keys": keys, "rows": rows, "fieldless": self.fieldless })
    }
}

/// Returns a cell for the script. JSON has neither NaN nor infinities: an infinite number is a
/// text.
fn value(cell: &Cell) -> Value {
    match cell {
        Cell::Number(x) if x.is_infinite() => json!(if *x > 0.0 { "inf" } else { "-inf" }),
        Cell::Number(x) => json!(x),
        Cell::Integer(i) => json!(i),
        // The script compares words.
        Cell::Flag(yes) => json!(yes.to_string()),
        Cell::Text(text) => json!(visible(text)),
        Cell::Missing => Value::Null,
    }
}
