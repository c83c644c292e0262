//! A compiled expression.

use std::borrow::Cow;

/// What kind of value a part of the expression has; `Unknown` for a column that mixes kinds or has
/// no values at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Text,
    Truth,
    Unknown,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Kind::Number => "a number",
            Kind::Text => "text",
            Kind::Truth => "a condition",
            Kind::Unknown => "nothing known",
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value<'a> {
    Integer(i64),
    Number(f64),
    Text(Cow<'a, str>),
    Truth(bool),
    Missing,
}

impl Value<'_> {
    pub(super) fn kind(&self) -> Kind {
        match self {
            Value::Integer(_) | Value::Number(_) => Kind::Number,
            Value::Text(_) => Kind::Text,
            Value::Truth(_) => Kind::Truth,
            Value::Missing => Kind::Unknown,
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Arithmetic {
    Plus,
    Minus,
    Times,
    Over,
    Modulo,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum TextTest {
    Contains,
    StartsWith,
    EndsWith,
}

/// A compiled expression, with its column names resolved. `String`s are how the part was written,
/// for messages.
#[derive(Debug)]
pub(super) enum Node {
    Constant(Value<'static>),
    Column(usize),
    Not(Box<Part>),
    And(Box<Part>, Box<Part>),
    Or(Box<Part>, Box<Part>),
    Compare(Relation, Box<Part>, Box<Part>),
    IsMissing(Box<Part>),
    Arithmetic(Arithmetic, Box<Part>, Box<Part>),
    Absolute(Box<Part>),
    In(Box<Part>, Vec<Part>),
    Choose(Box<Part>, Box<Part>, Box<Part>),
    Text(TextTest, Box<Part>, Box<Part>),
}

#[derive(Debug)]
pub(super) struct Part {
    pub(super) node: Node,
    pub(super) kind: Kind,
    /// How a message calls it: `column `mu`` or `"text"`.
    pub(super) label: String,
}

impl Part {
    pub(super) fn described(&self) -> String {
        format!("{} is {}", self.label, self.kind.name())
    }
}
