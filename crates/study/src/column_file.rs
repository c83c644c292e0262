//! Files with columns of measured values, from which a sample draws.
//!
//! The file is a text of lines; the first line that is no comment (`#`) has the heads, and the
//! values are separated as those are: by tabs, semicolons, commas or blanks. A head may end with
//! the unit of its column, `thickness [um]` or `thickness (um)`; without, each value has a unit of
//! its own or is in SI units. Empty cells are no values.

use crate::file_fault::{FileFaults, FilePlace};
use crate::file_text::{decode_text, known_format};
use crate::units::{Dimension, quantity};

/// The largest number of values of a column.
pub(crate) const MOST_VALUES: usize = 1_000_000;

/// Reads the values of a column, in the order of the file.
///
/// # Errors
/// The file is no text, has no such column, or has something else than values in it.
pub(crate) fn read(
    bytes: &[u8],
    column: &str,
    dimension: Dimension,
) -> Result<Vec<f64>, FileFaults> {
    if let Some(format) = known_format(bytes) {
        return Err(FileFaults::whole(format!("it is {format} and no text")));
    }
    let text = decode_text(bytes).ok_or_else(|| FileFaults::whole("it is no text"))?;
    let head = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let head = head.ok_or_else(|| FileFaults::whole("it is empty"))?;
    let separator = [b'\t', b';', b',', b' '];
    let is_in_head = |byte: &u8| head.as_bytes().contains(byte);
    // A blank may stand before a unit, so that only tables without other separators have it.
    let separator = separator.into_iter().find(is_in_head);
    let is_single = separator == Some(b' ') && split_head(head).1.is_some();
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator.filter(|_| !is_single).unwrap_or(b','))
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let heads = reader.headers().map_err(|error| FileFaults::whole(error.to_string()))?.clone();
    let is_meant = |head: &str| head == column || split_head(head).0 == column;
    let Some(index) = heads.iter().position(is_meant) else {
        let mut faults = FileFaults::default();
        let found = heads.iter().collect::<Vec<_>>().join(", ");
        let place = heads.position().map(|place| FilePlace::line(place.line() as usize));
        faults.add(place, &found, || format!("are its heads, and `{column}` is none of them"));
        return Err(faults);
    };
    let unit = split_head(&heads[index]).1;
    let mut values = Vec::new();
    let mut faults = FileFaults::default();
    for record in reader.records() {
        let record = record.map_err(|error| FileFaults::whole(error.to_string()))?;
        let cell = record.get(index).unwrap_or_default();
        if cell.is_empty() {
            continue;
        }
        match value(cell, unit, dimension) {
            Some(value) => values.push(value),
            None => {
                let line = record.position().map_or(0, |place| place.line() as usize);
                let place = FilePlace { line, value: index + 1 };
                let unit = unit.map_or(String::new(), |unit| format!(" in {unit}"));
                faults.add(Some(place), cell, || format!("is not {}{unit}", dimension.noun()));
            }
        }
        if values.len() > MOST_VALUES {
            return Err(FileFaults::whole(format!("it has more than {MOST_VALUES} values")));
        }
    }
    match (faults.is_empty(), values.is_empty()) {
        (false, _) => Err(faults),
        (true, true) => Err(FileFaults::whole(format!("it has no value below `{column}`"))),
        (true, false) => Ok(values),
    }
}

/// Splits a head into its name and the unit in brackets behind it.
fn split_head(head: &str) -> (&str, Option<&str>) {
    let head = head.trim();
    let split = |open: char, close: char| {
        let (name, unit) = head.strip_suffix(close)?.rsplit_once(open)?;
        Some((name.trim(), Some(unit.trim())))
    };
    split('[', ']').or_else(|| split('(', ')')).unwrap_or((head, None))
}

/// Returns the SI value of a cell.
fn value(cell: &str, unit: Option<&str>, dimension: Dimension) -> Option<f64> {
    let bare = cell.parse::<f64>().ok();
    let value = match (unit, bare) {
        (Some("1" | "-" | "") | None, Some(number)) => Some(number),
        (Some(unit), _) => quantity(&format!("{cell} {unit}"), dimension).ok(),
        (None, None) => quantity(cell, dimension).ok(),
    };
    // −0 becomes 0.
    value.filter(|value| value.is_finite()).map(|value| value + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(text: &str, column: &str) -> Result<Vec<f64>, String> {
        read(text.as_bytes(), column, Dimension::Length).map_err(|faults| faults.words(true))
    }

    #[test]
    fn values_have_the_unit_of_their_head_or_their_own() {
        for text in [
            "n,d\n1,0.001\n2,0.002\n",
            "n,d [mm]\n1,1\n2,2\n",
            "# measured\n\nd (mm)\n1\n2\n",
            "d [mm] ; n\n1 ; 7\n ; 8\n2 ; 9\n",
            "d\tn\n1 mm\t7\n2000 um\t8\n",
            "\"d, outer\",d\n7,1e-3\n8,0.002\r\n",
            "d n\n0.001 3\n0.002 4\n",
        ] {
            assert_eq!(lengths(text, "d").as_deref(), Ok(&[0.001, 0.002][..]), "{text}");
        }
        assert_eq!(read(b"mu\n0.25\n", "mu", Dimension::Pure), Ok(vec![0.25]));
    }

    #[test]
    fn what_is_no_value_is_refused_with_its_place() {
        let refused = |text: &str| lengths(text, "d").unwrap_err();
        insta::assert_snapshot!(
            [
                refused("n,m\n1,2\n"),
                refused("n,d [mm]\n1,x\n2,3\n3,NaN\n"),
                refused("d [GPa]\n3\n"),
                refused("d\n"),
                refused(""),
            ]
            .join("\n")
        );
        assert!(read(b"PK\x03\x04\0\0", "d", Dimension::Pure).is_err());
    }
}
