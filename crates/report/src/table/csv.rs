//! A table as CSV.

use super::cell::Cell;
use super::rows::DataTable;
use crate::delimited::write;

impl DataTable {
    /// Writes the table as CSV: a header with the column names as they are, then one record per
    /// row.
    ///
    /// The quoting is that of RFC 4180. Lines end in a line feed alone, which every reader of CSV
    /// takes and which `awk` and `cut` need. Numbers have the fewest digits that read back as the
    /// same number; `NaN`, `inf` and `-inf` are spelled so. A missing value is an empty field.
    ///
    /// A text that begins with `=`, `+`, `-`, `@`, a tab or a line end gets a `'` in front, because
    /// spreadsheets compute what begins so. Numbers never do.
    pub fn csv(&self) -> String {
        let header: Vec<String> = self.columns().iter().map(|c| inert(&c.name)).collect();
        write([header]) + &self.csv_rows()
    }

    /// Writes the rows as CSV without their header, to follow those of another table.
    pub fn csv_rows(&self) -> String {
        write(self.rows().iter().map(|row| {
            row.iter()
                .map(|cell| match cell {
                    Cell::Text(text) => inert(text),
                    other => other.exact().unwrap_or_default().into_owned(),
                })
                .collect::<Vec<String>>()
        }))
    }
}

/// Returns a text that no spreadsheet takes for a formula.
fn inert(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    if is_formula { format!("'{text}") } else { text.to_owned() }
}
