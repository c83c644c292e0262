//! A table as JSON.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::cell::Cell;
use super::rows::{DataTable, TableColumn};

/// A row as an object whose keys keep the order of the columns.
struct JsonRow<'a>(&'a [TableColumn], &'a [Cell]);

impl Serialize for JsonRow<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_map(Some(self.1.len()))?;
        for (column, cell) in self.0.iter().zip(self.1) {
            match cell {
                // JSON has no NaN and no infinity.
                Cell::Number(x) if x.is_finite() => object.serialize_entry(&column.name, x)?,
                Cell::Number(_) | Cell::Missing => object.serialize_entry(&column.name, &())?,
                Cell::Integer(i) => object.serialize_entry(&column.name, i)?,
                Cell::Flag(yes) => object.serialize_entry(&column.name, yes)?,
                Cell::Text(text) => object.serialize_entry(&column.name, text)?,
            }
        }
        object.end()
    }
}

/// The units of the columns as an object whose keys keep their order.
struct JsonUnits<'a>(&'a [TableColumn]);

impl Serialize for JsonUnits<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|column| (&column.name, &column.unit)))
    }
}

/// Writes a value as JSON, which cannot fail: keys are strings, and nothing but memory is written.
fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

impl DataTable {
    /// Writes the table as JSON: `{"units": {name: unit, …}, "rows": [{name: value, …}, …]}`, with
    /// one line per row.
    ///
    /// Units stand beside the rows so that numbers stay numbers and never travel without their
    /// unit; the keys of both keep the order of the columns. Missing values, NaN and infinities are
    /// `null`.
    pub fn json(&self) -> String {
        let mut out = self.json_head() + &self.json_rows(true);
        out += DataTable::json_end(!self.rows().is_empty());
        out
    }

    /// Writes the beginning of the table as [JSON](DataTable::json), which rows follow.
    pub fn json_head(&self) -> String {
        format!("{{\"units\": {},\n\"rows\": [", text(&JsonUnits(self.columns())))
    }

    /// Writes the rows as [JSON](DataTable::json), to follow the head if they are the first, or
    /// those of another table.
    pub fn json_rows(&self, are_first: bool) -> String {
        let mut out = String::new();
        for (i, row) in self.rows().iter().enumerate() {
            out += if are_first && i == 0 { "\n" } else { ",\n" };
            out += &text(&JsonRow(self.columns(), row));
        }
        out
    }

    /// Returns the end of a table as [JSON](DataTable::json) that has rows or none.
    pub fn json_end(has_rows: bool) -> &'static str {
        if has_rows { "\n]}\n" } else { "]}\n" }
    }
}
