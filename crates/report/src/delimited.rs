//! Comma-separated values.

/// Writes records as CSV with the quoting of RFC 4180.
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
