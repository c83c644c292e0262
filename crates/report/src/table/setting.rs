//! The setting of a column: how its cells are written follows from all of them, which may pass by
//! one after the other. First a [`ColumnSurvey`] sees every cell and says the form of the column,
//! then the form says the width of each text, and at last it writes them.

use unicode_width::UnicodeWidthStr;
use wording::one_line;

use super::cell::Cell;
use super::rows::TableColumn;
use crate::number::{decade, exact, exponent, significant, trim_zeros};
use crate::unit::PrefixedUnit;

/// The layout of a table in [`DataTable::terminal`](crate::DataTable::terminal).
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

/// The knowledge of the cells of a column that have passed by.
pub(super) struct ColumnSurvey {
    /// There were neither flags nor texts.
    numeric: bool,
    /// There were integers alone.
    whole: bool,
    /// The largest magnitude of a number.
    largest: f64,
    /// The smallest and the largest magnitude of the numbers that are neither 0 nor infinite.
    magnitudes: Option<[f64; 2]>,
}

impl ColumnSurvey {
    /// Returns the knowledge of a column of which no cell was seen.
    pub(super) fn new() -> Self {
        ColumnSurvey { numeric: true, whole: true, largest: 0.0, magnitudes: None }
    }

    /// Sees the next cell.
    pub(super) fn see(&mut self, cell: &Cell) {
        self.numeric &= !matches!(cell, Cell::Flag(_) | Cell::Text(_));
        self.whole &= matches!(cell, Cell::Integer(_) | Cell::Missing);
        let Some(magnitude) = cell.number().map(f64::abs) else { return };
        self.largest = self.largest.max(magnitude);
        if magnitude.is_finite() && magnitude != 0.0 {
            let [least, most] = self.magnitudes.unwrap_or([magnitude; 2]);
            self.magnitudes = Some([least.min(magnitude), most.max(magnitude)]);
        }
    }

    /// Returns the form of the column with a head.
    pub(super) fn form(&self, column: &TableColumn, layout: &TerminalLayout) -> ColumnForm {
        let plain_unit = PrefixedUnit::plain(&column.unit);
        let unit = match self.numeric && layout.prefixes {
            true => PrefixedUnit::fitting(&column.unit, self.largest),
            false => plain_unit.clone(),
        };
        let mut header = vec![one_line(&column.name).into_owned()];
        if !unit.name.is_empty() {
            header.push(format!("[{}]", one_line(&unit.name)));
        }
        let digits = layout.digits.clamp(1, 17);
        // Decades grow with magnitudes, so that the two ends tell of all between.
        let ends = self.magnitudes.map(|ends| ends.map(|x| unit.of_si(x)));
        let decades = ends.into_iter().flatten().filter(|x| x.is_finite() && *x != 0.0);
        let is_plain = |d: i32| (-5..digits.max(6) as i32).contains(&d);
        ColumnForm {
            header,
            numeric: self.numeric,
            is_aligned: self.numeric && !(self.whole && unit == plain_unit),
            plain: decades.map(|x| decade(x, digits)).all(is_plain),
            unit,
            digits,
            missing: if layout.unicode { "–" } else { "-" },
        }
    }
}

/// The form of the cells of a column.
pub(super) struct ColumnForm {
    /// The lines of the header: the name and, if there is one, the unit.
    pub(super) header: Vec<String>,
    /// All cells are numbers or missing.
    pub(super) numeric: bool,
    /// Numbers are aligned at the decimal point.
    is_aligned: bool,
    /// No number needs an exponent.
    plain: bool,
    unit: PrefixedUnit,
    digits: usize,
    /// The text of a missing value.
    missing: &'static str,
}

/// The widths of the texts of a column, in characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct TextWidths {
    /// The widest piece before the decimal point, or the widest text that is not aligned.
    before: usize,
    /// The widest decimals with their point.
    after: usize,
    /// The widest power of ten.
    power: usize,
}

impl TextWidths {
    /// Returns the widths that hold the texts of both.
    pub(super) fn or(self, other: TextWidths) -> TextWidths {
        TextWidths {
            before: self.before.max(other.before),
            after: self.after.max(other.after),
            power: self.power.max(other.power),
        }
    }

    /// Returns the width of the widest text.
    pub(super) fn content(self) -> usize {
        self.before + self.after + self.power
    }
}

impl ColumnForm {
    /// Returns the width of the widest line of the header.
    pub(super) fn header_width(&self) -> usize {
        self.header.iter().map(|line| line.width()).max().unwrap_or(0)
    }

    /// Returns the widths of the text of a cell.
    pub(super) fn widths(&self, cell: &Cell) -> TextWidths {
        if !self.is_aligned {
            return TextWidths { before: self.word(cell).width(), ..TextWidths::default() };
        }
        let NumberText { whole, fraction, exponent } = self.number(cell);
        TextWidths { before: whole.width(), after: fraction.width(), power: exponent.width() }
    }

    /// Writes a cell of a column whose texts have these widths at most. All that are aligned are
    /// equally wide.
    pub(super) fn text(&self, cell: &Cell, widths: TextWidths) -> String {
        if !self.is_aligned {
            return self.word(cell);
        }
        let NumberText { whole, fraction, exponent } = self.number(cell);
        let TextWidths { before, after, power } = widths;
        let blanks = " ".repeat(before.saturating_sub(whole.width()));
        if exponent.is_empty() {
            format!("{blanks}{whole}{fraction:<0$}", after + power)
        } else {
            // A blank before an exponent would tear the number apart.
            let point = if fraction.is_empty() && after > 0 { "." } else { &fraction };
            format!("{blanks}{whole}{point:0<after$}{exponent:<power$}")
        }
    }

    /// Writes a cell as a text that is not aligned.
    fn word(&self, cell: &Cell) -> String {
        match cell {
            Cell::Number(x) => significant(*x, self.digits),
            Cell::Integer(i) => i.to_string(),
            Cell::Flag(yes) => yes.to_string(),
            Cell::Text(text) => one_line(text).into_owned(),
            Cell::Missing => self.missing.to_owned(),
        }
    }

    fn number(&self, cell: &Cell) -> NumberText {
        let value = match cell {
            Cell::Number(x) => Some(self.unit.of_si(*x)),
            Cell::Integer(i) => Some(self.unit.of_si(*i as f64)),
            Cell::Flag(_) | Cell::Text(_) | Cell::Missing => None,
        };
        NumberText::new(value, self.digits, self.plain, self.missing)
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
