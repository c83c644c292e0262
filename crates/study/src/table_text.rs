//! Tables that are texts: heads on the first line, and a row of cells on each other one.
//!
//! The cells are separated by tabs, semicolons or commas, whichever the line of heads has most of.
//! Where it has none, they are separated by blanks, of which any number counts as one. Empty lines
//! and comments (`#`) are no rows, and a cell in quotes may hold anything.

use csv::StringRecord;

/// A row of a table.
#[derive(Clone, Debug)]
pub(crate) struct TextRow {
    /// The line on which it begins, counted from 1.
    pub(crate) line: usize,
    /// The cells without the blanks around them.
    pub(crate) cells: StringRecord,
}

/// Returns the sign between the cells.
fn separator(text: &str) -> u8 {
    let mut lines = text.lines().filter(|line| is_row(line));
    let heads = lines.next().unwrap_or_default();
    let count = |sign: &u8| outside_quotes(heads).filter(|byte| byte == sign).count();
    // Of equal counts the last one counts.
    let sign = [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',');
    // A blank may stand within the only head, as before its unit.
    let has_blank = |line: &str| outside_quotes(line.trim()).any(|byte| byte == b' ');
    let is_by_blanks = count(&sign) == 0
        && has_blank(heads)
        && (lines.next().is_none_or(has_blank) || !heads.trim().ends_with([']', ')']));
    if is_by_blanks { b' ' } else { sign }
}

/// Returns the rows of a table, of which the first one has the heads.
pub(crate) fn read_rows(text: &str) -> impl Iterator<Item = Result<TextRow, csv::Error>> {
    let separator = separator(text);
    let is_by_blanks = separator == b' ';
    let reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    let row = move |record: StringRecord| {
        let line = record.position().map_or(0, |place| line_of(place, text));
        let cells = match is_by_blanks {
            true => record.iter().filter(|cell| !cell.is_empty()).collect(),
            false => record,
        };
        TextRow { line, cells }
    };
    let rows = reader.into_records().map(move |record| record.map(row));
    let rows = rows.filter(|row| !row.as_ref().is_ok_and(|row| is_blank(&row.cells)));
    rows.enumerate().map(move |(index, row)| {
        let is_heads = index == 0 && is_by_blanks;
        row.map(|row| if is_heads { TextRow { cells: joined(&row.cells), ..row } } else { row })
    })
}

fn is_row(line: &str) -> bool {
    !line.trim().is_empty() && !line.starts_with('#')
}

fn is_blank(cells: &StringRecord) -> bool {
    cells.len() < 2 && cells.iter().all(str::is_empty)
}

fn outside_quotes(line: &str) -> impl Iterator<Item = u8> {
    line.split('"').step_by(2).flat_map(str::bytes)
}

/// Joins the heads of a table to their units, which stand behind blanks.
fn joined(heads: &StringRecord) -> StringRecord {
    let mut joined: Vec<String> = Vec::new();
    for head in heads {
        match joined.last_mut() {
            Some(last) if head.starts_with(['[', '(']) => *last = format!("{last} {head}"),
            _ => joined.push(head.to_owned()),
        }
    }
    StringRecord::from(joined)
}

/// Returns the line of a record, counted from 1. The place of a record is that of the empty lines
/// and comments before it.
fn line_of(place: &csv::Position, text: &str) -> usize {
    let rest = text.get(place.byte() as usize..).unwrap_or_default();
    let is_skipped = |line: &&str| line.trim_matches('\r').is_empty() || line.starts_with('#');
    place.line() as usize + rest.split('\n').take_while(is_skipped).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<(usize, Vec<String>)> {
        let row = |row: Result<TextRow, csv::Error>| {
            let row = row.unwrap();
            (row.line, row.cells.iter().map(str::to_owned).collect())
        };
        read_rows(text).map(row).collect()
    }

    #[test]
    fn cells_are_told_apart_by_the_line_of_heads() {
        for text in [
            "a [mm],b\n1,2\n",
            "a [mm];b\n1;2\n",
            "a [mm]\tb\n1\t 2\n",
            "a [mm] b\n1 2\n",
            "a   [mm]     b\n  1       2\n",
            "\n# x, y\na [mm] , b\n\n# 3\n1,2\n",
        ] {
            let cells: Vec<Vec<String>> = rows(text).into_iter().map(|(_, cells)| cells).collect();
            assert_eq!(cells, [["a [mm]", "b"], ["1", "2"]], "{text}");
        }
        assert_eq!(rows("wear depth [mm]\n1\n")[0].1, ["wear depth [mm]"]);
        assert_eq!(rows("\"a, outer\" b\n1 2\n")[0].1, ["a, outer", "b"]);
    }

    #[test]
    fn rows_know_their_lines() {
        let lines = |text: &str| rows(text).iter().map(|(line, _)| *line).collect::<Vec<_>>();
        for separator in [",", ";", " ", "   "] {
            let text = "# one\na,b\n\n# two\n# three\n1,2\r\n3,4\n".replace(',', separator);
            assert_eq!(lines(&text), [2, 6, 7], "{text}");
        }
    }
}
