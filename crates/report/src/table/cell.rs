//! One value of a table, and the order of values.

use std::borrow::Cow;
use std::cmp::Ordering;

use condition::compare_exactly;
use serde::{Deserialize, Serialize};

use crate::number::exact;

/// One value of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// A measured or computed quantity, in the unit of its column. NaN counts as missing when rows
    /// are sorted, filtered or drawn; exports keep it.
    Number(f64),
    /// A count or an identifier.
    Integer(i64),
    /// True or false.
    Flag(bool),
    /// A text.
    Text(String),
    /// No value, e.g. because the job failed.
    Missing,
}

impl Cell {
    /// Returns the cell as a number, if it is one. NaN is none.
    pub fn number(&self) -> Option<f64> {
        match self {
            Cell::Number(x) if !x.is_nan() => Some(*x),
            Cell::Integer(i) => Some(*i as f64),
            _ => None,
        }
    }

    /// Returns the text of the cell, as CSV and Parquet have it in a column of texts: a number has
    /// the fewest digits that read back as the same number. Where it is missing there is none.
    pub fn exact(&self) -> Option<Cow<'_, str>> {
        match self {
            Cell::Number(x) => Some(exact(*x).into()),
            Cell::Integer(i) => Some(i.to_string().into()),
            Cell::Flag(yes) => Some(yes.to_string().into()),
            Cell::Text(text) => Some(text.into()),
            Cell::Missing => None,
        }
    }

    /// Says whether there is no value to compare: [`Cell::Missing`] or NaN.
    pub fn is_missing(&self) -> bool {
        match self {
            Cell::Missing => true,
            Cell::Number(x) => x.is_nan(),
            Cell::Integer(_) | Cell::Flag(_) | Cell::Text(_) => false,
        }
    }
}

impl From<f64> for Cell {
    fn from(x: f64) -> Self {
        Cell::Number(x)
    }
}

impl From<i64> for Cell {
    fn from(i: i64) -> Self {
        Cell::Integer(i)
    }
}

impl From<bool> for Cell {
    fn from(yes: bool) -> Self {
        Cell::Flag(yes)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

/// Returns the ascending order of two cells that are not missing: numbers by value, then false
/// and true, then text.
pub(super) fn compare(a: &Cell, b: &Cell) -> Ordering {
    match (a, b) {
        (Cell::Integer(a), Cell::Integer(b)) => a.cmp(b),
        (Cell::Number(a), Cell::Number(b)) => a.partial_cmp(b).unwrap_or(Ordering::Equal),
        (Cell::Integer(a), Cell::Number(b)) => compare_exactly(*a, *b),
        (Cell::Number(a), Cell::Integer(b)) => compare_exactly(*b, *a).reverse(),
        (Cell::Text(a), Cell::Text(b)) => a.cmp(b),
        (Cell::Text(_), _) => Ordering::Greater,
        (_, Cell::Text(_)) => Ordering::Less,
        (Cell::Flag(a), Cell::Flag(b)) => a.cmp(b),
        (Cell::Flag(_), Cell::Number(_) | Cell::Integer(_)) => Ordering::Greater,
        (Cell::Number(_) | Cell::Integer(_), Cell::Flag(_)) => Ordering::Less,
        (Cell::Missing, _) | (_, Cell::Missing) => Ordering::Equal,
    }
}
