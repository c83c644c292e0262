//! A compiled expression: a tree whose column names are resolved.

use std::borrow::Cow;

/// The kind of value that an expression has. `Unknown` stands for a column that mixes kinds or has
/// no values at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueKind {
    Number,
    Text,
    Truth,
    Unknown,
}

impl ValueKind {
    /// Returns the kind as messages call it.
    pub(super) fn name(self) -> &'static str {
        match self {
            ValueKind::Number => "a number",
            ValueKind::Text => "text",
            ValueKind::Truth => "a condition",
            ValueKind::Unknown => "nothing known",
        }
    }
}

/// The value of an expression for one row. A missing cell, NaN and `null` are all `Missing`.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FilterValue<'a> {
    Integer(i64),
    Number(f64),
    Text(Cow<'a, str>),
    Truth(bool),
    Missing,
}

impl FilterValue<'_> {
    /// Returns the kind of the value; it is unknown for a missing one.
    pub(super) fn kind(&self) -> ValueKind {
        match self {
            FilterValue::Integer(_) | FilterValue::Number(_) => ValueKind::Number,
            FilterValue::Text(_) => ValueKind::Text,
            FilterValue::Truth(_) => ValueKind::Truth,
            FilterValue::Missing => ValueKind::Unknown,
        }
    }
}

/// A comparison of two values.
#[derive(Clone, Copy, Debug)]
pub(super) enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Arithmetic {
    Plus,
    Minus,
    Times,
    Over,
    Modulo,
}

/// A test of a text against a pattern.
#[derive(Clone, Copy, Debug)]
pub(super) enum TextTest {
    Contains,
    StartsWith,
    EndsWith,
}

/// The operation of an expression, with its operands.
#[derive(Debug)]
pub(super) enum ExpressionNode {
    Constant(FilterValue<'static>),
    /// The cell of a column, by the column's index in the table.
    Column(usize),
    Not(Box<Expression>),
    And(Box<Expression>, Box<Expression>),
    Or(Box<Expression>, Box<Expression>),
    Compare(Relation, Box<Expression>, Box<Expression>),
    IsMissing(Box<Expression>),
    Arithmetic(Arithmetic, Box<Expression>, Box<Expression>),
    Absolute(Box<Expression>),
    /// The value and the members of the list that it is looked up in.
    In(Box<Expression>, Vec<Expression>),
    /// The condition, the value if it holds, and the value if it does not.
    Choose(Box<Expression>, Box<Expression>, Box<Expression>),
    /// The text and the pattern.
    Text(TextTest, Box<Expression>, Box<Expression>),
}

/// A compiled expression.
#[derive(Debug)]
pub(super) struct Expression {
    pub(super) node: ExpressionNode,
    pub(super) kind: ValueKind,
    /// The name in messages: `column `mu`` or `"text"`.
    pub(super) label: String,
}

impl Expression {
    /// Returns a sentence that says of which kind the expression is.
    pub(super) fn described(&self) -> String {
        format!("{} is {}", self.label, self.kind.name())
    }
}
