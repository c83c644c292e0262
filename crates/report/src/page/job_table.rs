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

impl JobTable {
    /// Makes a table of some columns, which fits into a number of bytes. Columns without any value
    /// are left out. If the others do not fit, those that are not shown from the start go first,
    /// from the last one on, then rows, from the last one on.
    ///
    /// # Errors
    /// [`TableError`], if the table lacks a column or the column `key`.
    pub fn new(table: &DataTable, columns: &[JobColumn], room: usize) -> Result<Self, TableError> {
        let key = table.column("key")?;
        let keys: Vec<String> = table
            .cells(key)
            .map(|cell| if let Cell::Text(key) = cell { key.clone() } else { String::new() })
            .collect();
        let mut kept = Vec::new();
        for column in columns {
            let index = table.column(&column.name)?;
            if table.cells(index).any(|cell| !cell.is_missing()) {
                kept.push((column.clone(), size(table, index)));
            }
        }
        let mut used: usize = keys.len() * 68 + kept.iter().map(|(_, size)| size).sum::<usize>();
        while used > room
            && let Some(last) = kept.iter().rposition(|(column, _)| !column.is_shown)
        {
            used -= kept.remove(last).1;
        }
        let rows = match used > room {
            true => keys.len() * room / used,
            false => keys.len(),
        };
        let columns: Vec<JobColumn> = kept.into_iter().map(|(column, _)| column).collect();
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        let keep: Vec<bool> = (0..keys.len()).map(|row| row < rows).collect();
        Ok(Self {
            table: table.select(&names)?.keep(&keep),
            columns,
            keys: keys.into_iter().take(rows).collect(),
            fieldless: Vec::new(),
        })
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

/// Returns about as many bytes as a column takes.
fn size(table: &DataTable, column: usize) -> usize {
    let mut cells = table.cells(column);
    let first = cells.next();
    if cells.all(|cell| Some(cell) == first) {
        return 200;
    }
    200 + table.cells(column).map(|cell| value(cell).to_string().len() + 1).sum::<usize>()
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
