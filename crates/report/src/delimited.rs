//! Comma-separated values.

use crate::table::{Cell, Table};

/// A number with the fewest digits that read back as the same number.
pub(crate) fn exact(x: f64) -> String {
    if x.is_nan() {
        "NaN".to_owned()
    } else if x.is_infinite() {
        if x > 0.0 { "inf" } else { "-inf" }.to_owned()
    } else {
        format!("{x:?}")
    }
}

/// Records as CSV with the quoting of RFC 4180; see [`Table::csv`] for the dialect.
pub(crate) fn write<R, S>(records: R) -> String
where
    R: IntoIterator<Item = Vec<S>>,
    S: AsRef<str>,
{
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    for record in records {
        // Writing to memory does not fail, and `flexible` allows records of any length.
        let _ = writer.write_record(record.iter().map(AsRef::as_ref));
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

impl Table {
    /// The table as CSV: a header with the column names as they are, then one record per row.
    ///
    /// Quoting is that of RFC 4180; lines end in a line feed alone, which every reader of CSV takes
    /// and which `awk` and `cut` need. Numbers have the fewest digits that read back as the same
    /// number; `NaN`, `inf` and `-inf` are spelled so. A missing value is an empty field.
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
