//! A table as CSV.

use super::cell::Cell;
use super::rows::DataTable;
use crate::delimited::write;
use crate::number::exact;

impl DataTable {
    /// Writes the table as CSV: a header with the column names as they are, then one record per
    /// row.
    ///
    /// The quoting is that of RFC 4180. Lines end in a line feed alone, which every reader of CSV
    /// takes and which `awk` and `cut` need. Numbers have the fewest digits that read back as the
    /// same number; `NaN`, `inf` and `-inf` are spelled so. A missing value is an empty field.
    pub fn csv(&self) -> String {
        let header = self.columns().iter().map(|c| c.name.clone()).collect();
        let rows = self.rows().iter().map(|row| {
            row.iter()
                .map(|cell| match cell {
                    Cell::Number(x) => exact(*x),
                    Cell::Integer(i) => i.to_string(),
                    Cell::Text(text) => text.clone(),
                    Cell::Missing => String::new(),
                })
                .collect()
        });
        write(std::iter::once(header).chain(rows))
    }
}
