//! Files with columns of measured values, from which a sample draws.
//!
//! The file is a [table](crate::table_text). A head may end with the unit of its column,
//! `thickness [um]` or `thickness (um)`; without, each value has a unit of its own or is in SI
//! units. Empty cells are no values.

use crate::file_fault::{FileFaults, FilePlace};
use crate::file_text::{decode_text, known_format};
use crate::table_text::{TextRow, read_rows};
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
    let mut rows = read_rows(&text);
    let not_read = |error: csv::Error| FileFaults::whole(error.to_string());
    let heads = rows.next().ok_or_else(|| FileFaults::whole("it is empty"))?.map_err(not_read)?;
    let index = column_index(&heads, column)?;
    let heads = heads.cells;
    let unit = split_head(&heads[index]).1;
    let mut values = Vec::new();
    let mut faults = FileFaults::default();
    for row in rows {
        let TextRow { line, cells } = row.map_err(not_read)?;
        if cells.len() != heads.len() {
            let (found, all) = (cells.len(), heads.len());
            faults.add(Some(FilePlace::line(line)), "", || {
                format!("{found} values, but {all} heads")
            });
            continue;
        }
        let cell = cells.get(index).unwrap_or_default();
        if cell.is_empty() {
            continue;
        }
        match value(cell, unit, dimension) {
            Some(value) => values.push(value),
            None => {
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

/// Returns the index of the column that a name means: with its unit or without.
fn column_index(heads: &TextRow, column: &str) -> Result<usize, FileFaults> {
    let TextRow { line, cells } = heads;
    let with = |is_meant: &dyn Fn(&str) -> bool| {
        let found = cells.iter().enumerate().filter(|(_, head)| is_meant(head));
        found.map(|(index, _)| index).collect::<Vec<_>>()
    };
    let whole = with(&|head| head == column);
    let found = if whole.is_empty() { with(&|head| split_head(head).0 == column) } else { whole };
    let mut faults = FileFaults::default();
    match found[..] {
        [index] => return Ok(index),
        [] => {
            let all = cells.iter().collect::<Vec<_>>().join(", ");
            faults.add(Some(FilePlace::line(*line)), &all, || {
                format!("are its heads, and `{column}` is none of them")
            });
        }
        [_, second, ..] => {
            let place = FilePlace { line: *line, value: second + 1 };
            faults.add(Some(place), &cells[second], || {
                format!("is the head of another column as well, and `{column}` may mean either")
            });
        }
    }
    Err(faults)
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
            "n     d\n  7     0.001\n  8     0.002\n",
            "n d [mm]\n7 1\n8   2\n",
            "d [mm],d\n7,0.001\n8,0.002\n",
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
                refused("d,n\n\n# measured\n1,2\n3\n4,5,6\nx,7\n"),
                refused("d [mm],d [um]\n1,1000\n"),
            ]
            .join("\n")
        );
        assert!(read(b"PK\x03\x04\0\0", "d", Dimension::Pure).is_err());
    }
}
