//! A compiled expression.

use std::borrow::Cow;

/// What kind of value a part of the expression has; `Unknown` for a column that mixes kinds or has
/// no values at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ValueKind {
    Number,
    Text,
    Truth,
    Unknown,
}

impl ValueKind {
    pub(super) fn name(self) -> &'static str {
        match self {
            ValueKind::Number => "a number",
            ValueKind::Text => "text",
            ValueKind::Truth => "a condition",
            ValueKind::Unknown => "nothing known",
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum FilterValue<'a> {
    Integer(i64),
    Number(f64),
    Text(Cow<'a, str>),
    Truth(bool),
    Missing,
}

impl FilterValue<'_> {
    pub(super) fn kind(&self) -> ValueKind {
        match self {
            FilterValue::Integer(_) | FilterValue::Number(_) => ValueKind::Number,
            FilterValue::Text(_) => ValueKind::Text,
            FilterValue::Truth(_) => ValueKind::Truth,
            FilterValue::Missing => ValueKind::Unknown,
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
pub(super) enum ExpressionNode {
    Constant(FilterValue<'static>),
    Column(usize),
    Not(Box<Expression>),
    And(Box<Expression>, Box<Expression>),
    Or(Box<Expression>, Box<Expression>),
    Compare(Relation, Box<Expression>, Box<Expression>),
    IsMissing(Box<Expression>),
    Arithmetic(Arithmetic, Box<Expression>, Box<Expression>),
    Absolute(Box<Expression>),
    In(Box<Expression>, Vec<Expression>),
    Choose(Box<Expression>, Box<Expression>, Box<Expression>),
    Text(TextTest, Box<Expression>, Box<Expression>),
}

#[derive(Debug)]
pub(super) struct Expression {
    pub(super) node: ExpressionNode,
    pub(super) kind: ValueKind,
    /// How a message calls it: `column `mu`` or `"text"`.
    pub(super) label: String,
}

impl Expression {
    pub(super) fn described(&self) -> String {
        format!("{} is {}", self.label, self.kind.name())
    }
}
