//! Lines, numbers and faults of a profile's text.

use std::fmt;

/// The number of faulty lines that are shown; the others are counted only.
const SHOWN: usize = 10;

/// The lines of a text that cannot be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineFaults {
    shown: Vec<LineFault>,
    count: usize,
}

/// A line that cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub struct LineFault {
    /// The number of the line, counted from 1.
    pub line: usize,
    /// The text of the line.
    pub found: String,
    /// The text that would be right.
    pub expected: String,
}

impl LineFaults {
    /// Adds a line.
    pub(super) fn add(&mut self, line: usize, found: &str, expected: &str) {
        if self.shown.len() < SHOWN {
            let found = found.chars().take(80).collect();
            self.shown.push(LineFault { line, found, expected: expected.to_owned() });
        }
        self.count += 1;
    }

    /// Returns whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the first lines.
    pub fn shown(&self) -> &[LineFault] {
        &self.shown
    }

    /// Returns the number of all lines.
    pub fn count(&self) -> usize {
        self.count
    }
}

impl fmt::Display for LineFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, LineFault { line, found, expected }) in self.shown.iter().enumerate() {
            let separator = if index > 0 { "; " } else { "" };
            write!(f, "{separator}line {line}: `{found}`: {expected}")?;
        }
        match self.count - self.shown.len() {
            0 => Ok(()),
            rest => write!(f, "; and {rest} more"),
        }
    }
}

/// Returns the lines of a text with their numbers, counted from 1, whatever ends them.
pub(super) fn numbered_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let lines = text.split(end).map(|line| line.trim_matches(['\r', '\u{1a}', '\u{feff}']));
    lines.enumerate().map(|(index, line)| (index + 1, line))
}

/// Reads a finite number; an exponent of Fortran's is accepted.
pub(super) fn finite(text: &str) -> Option<f64> {
    let is_number = text.bytes().all(|b| !b.is_ascii_alphabetic() || b"eEdD".contains(&b));
    let number = text.replace(['d', 'D'], "e").parse::<f64>().ok();
    number.filter(|v| is_number && v.is_finite())
}

/// Returns the units in a metre of a unit of length, by its name.
pub(super) fn per_metre(name: &str) -> Option<f64> {
    match name.trim().trim_matches(['\'', '"', '[', ']', '(', ')']).trim().to_lowercase().as_str() {
        "m" | "meter" | "metre" => Some(1.0),
        "cm" => Some(1e2),
        "mm" | "millimeter" | "millimetre" => Some(1e3),
        "um" | "µm" | "μm" => Some(1e6),
        "in" | "inch" => Some(1.0 / 0.0254),
        _ => None,
    }
}
