//! Matrices and lists of heights as text.

use super::header::{Fact, HeaderFacts};
use super::heights::{HeightMatrix, MAX_HEIGHTS};
use super::missing::{Marks, is_mark, is_second_word};
use super::titles::list_titles;
use crate::file_fault::{FileFaults, FilePlace};
use crate::file_text::{NumberReader, numbered_lines};
use crate::units::LengthUnit;

/// The number of lines by which the separators of a file are told.
const SAMPLE: usize = 200;

/// The units of a list: those of its coordinates and of its heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ListUnits {
    pub(super) lateral: LengthUnit,
    pub(super) heights: LengthUnit,
    /// Nobody names the unit of coordinates.
    pub(super) is_free: bool,
}

/// The lines of a text, sorted into a header and numbers.
pub(super) struct MatrixText<'a> {
    lines: Vec<NumberLine<'a>>,
    format: NumberFormat,
    pub(super) facts: HeaderFacts,
    /// The titles of the columns are those of a list, with the units that they name.
    pub(super) titles: Option<[Option<LengthUnit>; 3]>,
}

/// A line with numbers.
#[derive(Clone, Copy)]
struct NumberLine<'a> {
    number: usize,
    content: &'a str,
}

/// The way in which the numbers of a file are separated.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NumberFormat {
    /// The sign between numbers; blanks if there is none.
    separator: Option<char>,
    has_decimal_comma: bool,
    /// Every line ends with a separator.
    has_trailing_separator: bool,
    /// The number of values on the shortest of the first lines.
    least: usize,
}

impl<'a> MatrixText<'a> {
    /// Sorts the lines of a text.
    pub(super) fn new(text: &'a str, faults: &mut FileFaults) -> Self {
        let mut lines = Vec::new();
        let mut facts = HeaderFacts::default();
        let mut titles = None;
        for (number, line) in numbered_lines(text) {
            let line = line.trim_matches([' ', '\u{a0}', '\u{0c}', '\u{0b}']);
            if line.trim().is_empty() {
                continue;
            }
            if let Some(comment) = comment(line) {
                facts.note(number, comment, faults);
                if lines.is_empty() {
                    facts.note_title(number, comment, faults);
                    titles = titles.or_else(|| list_titles(number, comment, faults));
                }
                continue;
            }
            let content = without_remark(line);
            let is_above = lines.is_empty();
            let is_word = content.trim_start().starts_with(char::is_alphabetic);
            if is_above && is_word && facts.note_title(number, content, faults) {
                continue;
            }
            if is_above && is_word && facts.note(number, content, faults) {
                continue;
            }
            if begins_with_a_number(content) {
                lines.push(NumberLine { number, content });
            } else if let Some(units) =
                is_above.then(|| list_titles(number, content, faults)).flatten()
            {
                titles = Some(units);
            } else {
                faults.add(Some(FilePlace::line(number)), content, || {
                    "is neither a number nor a comment, and no known line of a header".to_owned()
                });
            }
        }
        let format = NumberFormat::of(&lines, faults);
        Self { lines, format, facts, titles }
    }

    /// Returns the number of values on the first line.
    pub(super) fn columns(&self) -> usize {
        let first = self.lines.first();
        first.map_or(0, |line| self.format.fields(line.content).count())
    }

    /// Reads the numbers as the heights of a matrix.
    pub(super) fn heights(
        &self,
        unit: LengthUnit,
        marks: &mut Marks,
        faults: &mut FileFaults,
    ) -> HeightMatrix {
        self.read(&mut [NumberReader::new(unit, self.format.has_decimal_comma)], marks, faults)
    }

    /// Reads the numbers as a list of x, y and z.
    pub(super) fn points(
        &self,
        units: ListUnits,
        marks: &mut Marks,
        faults: &mut FileFaults,
    ) -> HeightMatrix {
        let reader = |unit| NumberReader::new(unit, self.format.has_decimal_comma);
        let mut readers = [reader(units.lateral), reader(units.lateral), reader(units.heights)];
        self.read(&mut readers, marks, faults)
    }

    /// Reads the numbers; each column has its reader, the later ones the last.
    fn read(
        &self,
        readers: &mut [NumberReader],
        marks: &mut Marks,
        faults: &mut FileFaults,
    ) -> HeightMatrix {
        let (mut columns, mut heights) = (0, Vec::new());
        let last_reader = readers.len() - 1;
        let mut ragged = FileFaults::default();
        for (row, line) in self.lines.iter().enumerate() {
            let before = heights.len();
            for (index, field) in self.format.fields(line.content).enumerate() {
                // Some lines may end with a separator, others not.
                if index >= self.format.least && field.is_empty() {
                    continue;
                }
                if heights.len() > MAX_HEIGHTS {
                    break;
                }
                let reader = &mut readers[index.min(last_reader)];
                heights.push(match reader.read(field) {
                    Some(height) => height,
                    None if is_mark(field) => marks.count(field),
                    None => {
                        let place = FilePlace { line: line.number, value: index + 1 };
                        faults.add(Some(place), field, || not_a_number(field, self.format));
                        f64::NAN
                    }
                });
            }
            let found = heights.len() - before;
            if row == 0 {
                columns = found;
            } else if found != columns {
                ragged.add(Some(FilePlace::line(line.number)), "", || {
                    format!("not as long as those before it: {found} against {columns} numbers")
                });
            }
            if heights.len() > MAX_HEIGHTS {
                faults.add(Some(FilePlace::line(line.number)), "", || {
                    format!("there are more than {MAX_HEIGHTS} heights")
                });
                break;
            }
        }
        let mut rows = heights.len().checked_div(columns).unwrap_or(0);
        if let (true, [Some(nx), Some(ny)]) = (self.facts.is_grid, self.facts.counts)
            && nx.value.checked_mul(ny.value) == Some(heights.len())
        {
            // The lines of an ASCII grid may be broken anywhere.
            (rows, columns) = (ny.value, nx.value);
        } else {
            faults.append(ragged);
        }
        if heights.is_empty() && faults.is_empty() {
            faults.add(None, "", || "there are no heights in it".to_owned());
        }
        if self.facts.is_north_first && rows * columns == heights.len() {
            heights = heights.chunks(columns.max(1)).rev().flatten().copied().collect();
        }
        HeightMatrix { rows, columns, heights }
    }
}

impl NumberFormat {
    /// Tells the format by the first lines.
    fn of(lines: &[NumberLine<'_>], faults: &mut FileFaults) -> Self {
        let sample = &lines[..lines.len().min(SAMPLE)];
        let any = |of: &dyn Fn(&str) -> bool| sample.iter().find(|line| of(line.content));
        let place = |line: &NumberLine<'_>| Some(FilePlace::line(line.number));
        let has_inner_blank =
            |line: &str| line.split('\t').any(|field| field.trim().contains(char::is_whitespace));
        let separator = if any(&|line| line.contains(';')).is_some() {
            Some(';')
        } else if any(&|line| line.contains('\t')).is_some() && any(&has_inner_blank).is_none() {
            Some('\t')
        } else if any(&|line| line.split_whitespace().any(is_decimal_comma)).is_some()
            && any(&is_separated_by_commas).is_none()
        {
            None
        } else if any(&|line| line.contains(',')).is_some() {
            Some(',')
        } else {
            None
        };
        let mut format = NumberFormat {
            separator,
            has_decimal_comma: false,
            has_trailing_separator: false,
            least: 0,
        };
        if separator == Some(',') {
            let is_fraction = |field: &str| {
                field.len() > 1
                    && field.starts_with('0')
                    && field.bytes().all(|b| b.is_ascii_digit())
            };
            if let Some(line) = any(&|line| line.split(',').skip(1).map(str::trim).any(is_fraction))
            {
                faults.add(place(line), line.content, || {
                    "can be read with commas between numbers or in them; separate the numbers by \
                     semicolons or blanks"
                        .to_owned()
                });
            }
        } else if let Some(comma) = any(&|line| line.contains(',')) {
            format.has_decimal_comma = true;
            let has_point = |line: &str| line.contains('.');
            if let Some(line) = any(&has_point) {
                faults.add(place(line), line.content, || {
                    format!(
                        "has a decimal point where line {} has a comma; write all numbers alike",
                        comma.number
                    )
                });
            }
        }
        let ends = |line: &NumberLine<'_>| {
            separator
                .is_some_and(|separator| line.content.trim_end_matches(' ').ends_with(separator))
        };
        format.has_trailing_separator = !lines.is_empty() && lines.iter().all(ends);
        let counts = sample.iter().map(|line| format.fields(line.content).count());
        format.least = counts.min().unwrap_or(0);
        format
    }

    /// Returns the fields of a line.
    fn fields<'l>(self, line: &'l str) -> Box<dyn Iterator<Item = &'l str> + 'l> {
        let unquoted = |field: &'l str| {
            let is_bare = |byte: Option<&u8>| {
                byte.is_some_and(|byte| byte.is_ascii_graphic() && *byte != b'"')
            };
            let bytes = field.as_bytes();
            match is_bare(bytes.first()) && is_bare(bytes.last()) {
                true => field,
                false => field.trim().trim_matches('"').trim(),
            }
        };
        match self.separator {
            None => {
                let mut before = "";
                let words = line.split_whitespace().filter(move |word| {
                    let is_second = is_second_word(before, word);
                    before = word;
                    !is_second
                });
                Box::new(words.map(unquoted))
            }
            Some(separator) => {
                let line = line.trim_matches(' ');
                let line = match self.has_trailing_separator {
                    true => line.strip_suffix(separator).unwrap_or(line),
                    false => line,
                };
                Box::new(line.split(separator).map(unquoted))
            }
        }
    }
}

/// Returns whether a word is a number with a decimal comma: `0,5`.
fn is_decimal_comma(word: &str) -> bool {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let word = word.trim_start_matches(['+', '-', '\u{2212}']);
    word.split_once(',').is_some_and(|(whole, fraction)| {
        let figures = digits(fraction);
        let exponent = &fraction[figures..];
        digits(whole) == whole.len()
            && figures > 0
            && (exponent.is_empty() || exponent.starts_with(['e', 'E', 'd', 'D']))
    })
}

/// Returns whether commas stand between the numbers of a line.
fn is_separated_by_commas(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let (first, second) = (words.next().unwrap_or_default(), words.next());
    if second.is_none() {
        return first.contains(',');
    }
    line.split_whitespace()
        .any(|word| word.starts_with(',') || word.ends_with(',') || word.matches(',').count() > 1)
}

/// Returns the text of a line that is a comment as a whole.
fn comment(line: &str) -> Option<&str> {
    let line = line.trim();
    let is_ruler = |c: char| matches!(c, '-' | '=' | '*' | '_' | '~' | '+');
    if line.chars().count() > 3 && line.chars().all(is_ruler) {
        return Some("");
    }
    // Most lines are numbers, and a file may have millions of them.
    if !line.starts_with(['#', '%', '!', '*', ';', '"', '\'', '/']) {
        return None;
    }
    let mut words = line.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty()).peekable();
    if words.peek().is_some() && words.all(begins_with_a_number) {
        return None;
    }
    if let Some(rest) = line.strip_prefix("//") {
        return Some(rest.trim_start_matches('/'));
    }
    if let Some(rest) = line.strip_prefix(['#', '%', '!', '*']) {
        return Some(rest.trim_start_matches(['#', '%', '!', '*']));
    }
    // Before a number, a semicolon separates it from an empty field.
    if let Some(rest) = line.strip_prefix(';') {
        return (!begins_with_a_number(rest.trim_start_matches([';', ' ']))).then_some(rest);
    }
    let rest = line.strip_prefix(['"', '\''])?;
    let is_text = !begins_with_a_number(rest.trim_start());
    is_text.then(|| rest.trim_end_matches(['"', '\'', ',', ';']))
}

/// Returns a line up to the comment behind its numbers. A sign within a word begins none: `1.#QNAN`
/// is a mark, and `5%` no number.
fn without_remark(line: &str) -> &str {
    if !['#', '%', '!', '/'].iter().any(|sign| line.contains(*sign)) {
        return line.trim_end_matches(' ');
    }
    let follows_a_gap = |index: usize| {
        line[..index].chars().next_back().is_none_or(|c| c.is_whitespace() || c == ',' || c == ';')
    };
    let end = line
        .char_indices()
        .filter(|(_, c)| matches!(c, '#' | '%' | '!' | '/'))
        .filter(|(index, _)| follows_a_gap(*index))
        .find(|(index, c)| match c {
            '#' => !["N/A", "NUM!", "VALUE!", "DIV/0!", "REF!"]
                .iter()
                .any(|word| line[index + 1..].starts_with(word)),
            '%' | '!' => true,
            '/' => line[index + 1..].starts_with('/'),
            _ => false,
        })
        .map_or(line.len(), |(index, _)| index);
    line[..end].trim_end_matches(' ')
}

/// Returns whether a line begins with a number, an empty field or the mark of a missing value.
fn begins_with_a_number(line: &str) -> bool {
    let first = line.trim_start_matches([' ', '"']);
    let word = first.split([' ', '\t', ',', ';', '"']).next().unwrap_or_default();
    let digits = word.trim_start_matches(['+', '-', '\u{2212}', '.', ',']);
    digits.starts_with(|c: char| c.is_ascii_digit()) || is_mark(word)
}

fn not_a_number(field: &str, format: NumberFormat) -> String {
    if field.contains([',', '.']) && format.has_decimal_comma {
        "is not a finite number with a decimal comma".to_owned()
    } else if format.separator == Some(',') && field.contains(char::is_whitespace) {
        "is not a finite number; is a comma missing?".to_owned()
    } else {
        "is not a finite number".to_owned()
    }
}

/// Notes where the header and what stands below it differ.
pub(super) fn compare_counts(
    facts: &HeaderFacts,
    HeightMatrix { rows, columns, .. }: &HeightMatrix,
    faults: &mut FileFaults,
) {
    for (fact, found, what) in
        [(facts.counts[0], *columns, "columns"), (facts.counts[1], *rows, "rows")]
    {
        if let Some(Fact { value, line }) = fact.filter(|fact| fact.value != found) {
            faults.add(Some(FilePlace::line(line)), "", || {
                format!("the header says {value} {what}, below it there are {found}")
            });
        }
    }
}
