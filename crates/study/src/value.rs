//! The value of a table's cell.

use std::fmt;

use crate::units::Compact;

/// The value of a table's cell, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Integer(u64),
    /// True or false.
    Flag(bool),
    /// A text.
    Text(String),
    /// Nothing: the job has no such key, or it left no such figure.
    Missing,
}

/// The kind of the values of a column, apart from missing ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueType {
    /// Numbers.
    Number,
    /// Whole numbers.
    Integer,
    /// True or false.
    Flag,
    /// Texts.
    Text,
}

impl Value {
    /// Returns the number, whole or not; `None` for others.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Value::Number(x) => Some(*x),
            Value::Integer(n) => Some(*n as f64),
            Value::Flag(_) | Value::Text(_) | Value::Missing => None,
        }
    }

    /// Returns `a`/`b` if `b` is positive.
    pub(crate) fn ratio(a: f64, b: f64) -> Value {
        // The sum turns −0 into 0.
        if b > 0.0 { Value::Number(a / b + 0.0) } else { Value::Missing }
    }
}

/// Numbers are displayed in their shortest exact form, missing values as nothing.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(x) => write!(f, "{}", Compact(*x)),
            Value::Integer(n) => write!(f, "{n}"),
            Value::Flag(yes) => write!(f, "{yes}"),
            Value::Text(text) => f.write_str(text),
            Value::Missing => Ok(()),
        }
    }
}
