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

impl DataTable {
    /// Writes the table as JSON: `{"units": {name: unit, …}, "rows": [{name: value, …}, …]}`, with
    /// one line per row.
    ///
    /// Units stand beside the rows so that numbers stay numbers and never travel without their
    /// unit; the keys of both keep the order of the columns. Missing values, NaN and infinities are
    /// `null`.
    pub fn json(&self) -> String {
        // Neither serialisation can fail: keys are strings, and nothing but memory is written.
        let text = |value: Result<String, serde_json::Error>| value.unwrap_or_default();
        let mut out = String::from("{\"units\": ");
        out += &text(serde_json::to_string(&JsonUnits(self.columns())));
        out += ",\n\"rows\": [";
        for (i, row) in self.rows().iter().enumerate() {
            out += if i == 0 { "\n" } else { ",\n" };
            out += &text(serde_json::to_string(&JsonRow(self.columns(), row)));
        }
        out += if self.rows().is_empty() { "]}\n" } else { "\n]}\n" };
        out
    }
}
