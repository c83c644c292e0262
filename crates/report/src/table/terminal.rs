//! A table as text for a terminal.

use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, TableStyle, Width,
};
use unicode_width::UnicodeWidthStr;
use wording::one_line;

use super::cell::Cell;
use super::rows::DataTable;
use crate::number::{decade, exact, exponent, significant, trim_zeros};
use crate::unit::PrefixedUnit;

/// The layout of a table in [`DataTable::terminal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TerminalLayout {
    /// The number of characters per line. Text is wrapped and the columns are set in several blocks
    /// to keep within it. `None` sets every row on one line.
    pub width: Option<usize>,
    /// The number of significant digits of numbers, at least 1.
    pub digits: usize,
    /// True if a column with a unit is shown with an SI prefix, one for the whole column:
    /// `peak_pressure [GPa]`.
    pub prefixes: bool,
    /// True if lines and the dash for a missing value may be other than ASCII.
    pub unicode: bool,
}

impl Default for TerminalLayout {
    fn default() -> Self {
        TerminalLayout { width: None, digits: 6, prefixes: false, unicode: true }
    }
}

/// The number of blanks on both sides of a cell together.
const PADDING: usize = 2;
/// The number of blanks between two columns.
const SEPARATOR: usize = 1;
/// The least width to which a column of text is wrapped.
const NARROWEST_TEXT: usize = 20;

/// A column that is ready to be set.
pub(crate) struct TypesetColumn {
    /// The lines of the header: the name and, if there is one, the unit.
    header: Vec<String>,
    cells: Vec<String>,
    numeric: bool,
    /// The width below which the column is not squeezed, in characters.
    least: usize,
}

impl TypesetColumn {
    /// Returns the name and, if there is one, the unit in brackets.
    pub(crate) fn head(&self) -> (&str, Option<&str>) {
        (self.header.first().map_or("", String::as_str), self.header.get(1).map(String::as_str))
    }

    /// Returns whether its cells are numbers.
    pub(crate) fn is_number(&self) -> bool {
        self.numeric
    }

    /// Returns the text of the cell in a row.
    pub(crate) fn cell(&self, row: usize) -> &str {
        self.cells.get(row).map_or("", String::as_str)
    }
}

impl DataTable {
    /// Sets every column.
    pub(crate) fn typeset(&self, layout: &TerminalLayout) -> Vec<TypesetColumn> {
        (0..self.columns().len()).map(|i| self.set(i, layout)).collect()
    }

    /// Writes the table as text: a header with units, numbers aligned at the decimal point, a
    /// newline at the end.
    ///
    /// When the columns do not fit into the width, they are set in several blocks, each of which
    /// begins with the first column. Characters that a terminal would obey are shown escaped.
    pub fn terminal(&self, layout: &TerminalLayout) -> String {
        let columns = self.typeset(layout);
        let mut out = String::new();
        for block in blocks(&columns, layout.width) {
            if !out.is_empty() {
                out.push('\n');
            }
            out += &draw(&columns, &block, self.rows().len(), layout);
        }
        out
    }

    /// Sets the header and the cells of the column with an index.
    fn set(&self, index: usize, layout: &TerminalLayout) -> TypesetColumn {
        let column = &self.columns()[index];
        let numeric = self.cells(index).all(|cell| !matches!(cell, Cell::Flag(_) | Cell::Text(_)));
        let largest = self.cells(index).filter_map(Cell::number).map(f64::abs).fold(0.0, f64::max);
        let unit = if numeric && layout.prefixes {
            PrefixedUnit::fitting(&column.unit, largest)
        } else {
            PrefixedUnit::plain(&column.unit)
        };
        let mut header = vec![one_line(&column.name).into_owned()];
        if !unit.name.is_empty() {
            header.push(format!("[{}]", one_line(&unit.name)));
        }
        let missing = if layout.unicode { "–" } else { "-" };
        let whole = self.cells(index).all(|cell| matches!(cell, Cell::Integer(_) | Cell::Missing));
        let cells = if numeric && !(whole && unit == PrefixedUnit::plain(&column.unit)) {
            let values: Vec<Option<f64>> = self
                .cells(index)
                .map(|cell| match cell {
                    Cell::Number(x) => Some(unit.of_si(*x)),
                    Cell::Integer(i) => Some(unit.of_si(*i as f64)),
                    Cell::Flag(_) | Cell::Text(_) | Cell::Missing => None,
                })
                .collect();
            align(&values, layout.digits.clamp(1, 17), missing)
        } else {
            let text = |cell: &Cell| match cell {
                Cell::Number(x) => significant(*x, layout.digits.clamp(1, 17)),
                Cell::Integer(i) => i.to_string(),
                Cell::Flag(yes) => yes.to_string(),
                Cell::Text(text) => one_line(text).into_owned(),
                Cell::Missing => missing.to_owned(),
            };
            self.cells(index).map(text).collect()
        };
        let widest = |texts: &[String]| texts.iter().map(|t| t.width()).max().unwrap_or(0);
        let content = widest(&cells);
        let least =
            widest(&header).max(if numeric { content } else { content.min(NARROWEST_TEXT) });
        TypesetColumn { header, cells, numeric, least }
    }
}

/// A number as text in the pieces that are aligned: the piece before the point is set flush right,
/// the rest flush left.
#[derive(Default)]
struct NumberText {
    whole: String,
    /// The point and the decimals; empty for an integer.
    fraction: String,
    /// The power of ten; empty for a plain number.
    exponent: String,
}

impl NumberText {
    /// Writes a value with so many significant digits.
    fn new(value: Option<f64>, digits: usize, plain: bool, missing: &str) -> NumberText {
        let word = |whole: String| NumberText { whole, ..NumberText::default() };
        let x = match value {
            None => return word(missing.to_owned()),
            Some(x) if !x.is_finite() => return word(exact(x)),
            Some(x) => x,
        };
        let (number, exponent) = if x == 0.0 {
            ("0".to_owned(), String::new())
        } else if plain {
            let decimals = (digits as i32 - 1 - decade(x, digits)).max(0) as usize;
            (format!("{x:.decimals$}"), String::new())
        } else {
            let text = format!("{x:.*e}", digits - 1);
            let mantissa = text.split_once('e').map_or(text.as_str(), |(mantissa, _)| mantissa);
            (mantissa.to_owned(), exponent(decade(x, digits)))
        };
        let number = trim_zeros(&number);
        let point = number.find('.').unwrap_or(number.len());
        let (whole, fraction) = number.split_at(point);
        NumberText { whole: whole.to_owned(), fraction: fraction.to_owned(), exponent }
    }
}

/// Writes numbers as text of equal width, aligned at the decimal point; with exponents if a plain
/// number of one of them would need more than six leading or trailing zeros.
fn align(values: &[Option<f64>], digits: usize, missing: &str) -> Vec<String> {
    let mut decades =
        values.iter().flatten().filter(|x| x.is_finite() && **x != 0.0).map(|x| decade(*x, digits));
    let plain = decades.all(|d| (-5..digits.max(6) as i32).contains(&d));
    let texts: Vec<NumberText> =
        values.iter().map(|value| NumberText::new(*value, digits, plain, missing)).collect();
    let widest = |piece: fn(&NumberText) -> &str| {
        texts.iter().map(|text| piece(text).width()).max().unwrap_or(0)
    };
    let before = widest(|text| &text.whole);
    let after = widest(|text| &text.fraction);
    let power = widest(|text| &text.exponent);
    texts
        .iter()
        .map(|NumberText { whole, fraction, exponent }| {
            let blanks = " ".repeat(before - whole.width());
            if exponent.is_empty() {
                format!("{blanks}{whole}{fraction:<0$}", after + power)
            } else {
                // A blank before an exponent would tear the number apart.
                let point = if fraction.is_empty() && after > 0 { "." } else { fraction };
                format!("{blanks}{whole}{point:0<after$}{exponent:<power$}")
            }
        })
        .collect()
}

/// Divides the columns into as few blocks as fit into the width, as indices of columns.
fn blocks(columns: &[TypesetColumn], width: Option<usize>) -> Vec<Vec<usize>> {
    let Some(width) = width else { return vec![(0..columns.len()).collect()] };
    let space = |i: usize| columns[i].least + PADDING;
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    let mut used = 0;
    for i in 0..columns.len() {
        match blocks.last_mut() {
            Some(block) if used + SEPARATOR + space(i) <= width => {
                block.push(i);
                used += SEPARATOR + space(i);
            }
            Some(block) if block.len() == 1 => {
                // Nothing fits beside the key column: the block overflows rather than repeat the
                // key column alone for ever.
                block.push(i);
                used = width;
            }
            Some(_) => {
                blocks.push(vec![0, i]);
                used = space(0) + SEPARATOR + space(i);
            }
            None => {
                blocks.push(vec![0]);
                used = space(0);
            }
        }
    }
    blocks
}

/// Writes one block of columns.
fn draw(
    columns: &[TypesetColumn],
    block: &[usize],
    rows: usize,
    layout: &TerminalLayout,
) -> String {
    let mut table = comfy_table::Table::new();
    // There are rules above, below the header and at the end, as in a printed table.
    let rule = if layout.unicode { '─' } else { '-' };
    let line = LineStyle::none().fill(rule).junction(rule);
    table.load_style(TableStyle::new().top_border(line).header_separator(line).bottom_border(line));
    let least = block
        .iter()
        .map(|&i| columns[i].least + PADDING + SEPARATOR)
        .sum::<usize>()
        .saturating_sub(SEPARATOR);
    if let Some(width) = layout.width {
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(u16::try_from(width.max(least)).unwrap_or(u16::MAX));
    }
    let tall = block.iter().map(|&i| columns[i].header.len()).max().unwrap_or(0);
    table.set_header(block.iter().map(|&i| {
        // Units stand on one line, also under names that have none.
        let mut lines = columns[i].header.clone();
        lines.resize(tall, String::new());
        lines.join("\n")
    }));
    for row in 0..rows {
        table.add_row(block.iter().map(|&i| columns[i].cells[row].as_str()));
    }
    for (position, &i) in block.iter().enumerate() {
        if let Some(column) = table.column_mut(position) {
            let alignment =
                if columns[i].numeric { CellAlignment::Right } else { CellAlignment::Left };
            column.set_cell_alignment(alignment);
            let least = u16::try_from(columns[i].least + PADDING).unwrap_or(u16::MAX);
            column.set_constraint(if columns[i].numeric {
                ColumnConstraint::Absolute(Width::Fixed(least))
            } else {
                ColumnConstraint::LowerBoundary(Width::Fixed(least))
            });
        }
    }
    let mut text = String::new();
    for line in table.lines() {
        text += line.trim_end();
        text.push('\n');
    }
    text
}
