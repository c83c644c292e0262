//! A compiled expression: a tree whose column names are resolved.

use std::borrow::Cow;

/// The kind of value that an expression has. `Unknown` stands for a column that mixes kinds or has
/// no values at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// Numbers, whole or not.
    Number,
    /// Texts.
    Text,
    /// True or false.
    Truth,
    /// Values of several kinds, or none.
    Unknown,
}

impl ValueKind {
    /// Returns the kind as messages call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            ValueKind::Number => "a number",
            ValueKind::Text => "text",
            ValueKind::Truth => "a condition",
            ValueKind::Unknown => "nothing known",
        }
    }
}

/// The value of an expression for the values of names. A missing value, NaN and `null` are all
/// `Missing`.
#[derive(Clone, Debug, PartialEq)]
pub enum FilterValue<'a> {
    /// A whole number.
    Integer(i64),
    /// A number; NaN counts as missing.
    Number(f64),
    /// A text.
    Text(Cow<'a, str>),
    /// True or false.
    Truth(bool),
    /// Nothing.
    Missing,
}

impl FilterValue<'_> {
    /// Returns the kind of the value; it is unknown for a missing one.
    pub(crate) fn kind(&self) -> ValueKind {
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
pub(crate) enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Arithmetic {
    Plus,
    Minus,
    Times,
    Over,
    Modulo,
}

/// A test of a text against a pattern.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TextTest {
    Contains,
    StartsWith,
    EndsWith,
}

/// The operation of an expression, with its operands.
#[derive(Clone, Debug)]
pub(crate) enum ExpressionNode {
    Constant(FilterValue<'static>),
    /// The value of a name, by its index.
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
#[derive(Clone, Debug)]
pub(crate) struct Expression {
    pub(crate) node: ExpressionNode,
    pub(crate) kind: ValueKind,
    /// The name in messages: `column `mu`` or `"text"`.
    pub(crate) label: String,
}

impl Expression {
    /// Returns a sentence that says of which kind the expression is.
    pub(crate) fn described(&self) -> String {
        format!("{} is {}", self.label, self.kind.name())
    }

    /// Returns the texts of which the name with an index has one wherever the expression is true;
    /// `None` if it may be true for other values as well.
    pub(crate) fn texts_of(&self, index: usize) -> Option<Vec<&str>> {
        let is_name = |a: &Expression| matches!(a.node, ExpressionNode::Column(i) if i == index);
        match &self.node {
            ExpressionNode::Compare(Relation::Equal, a, b) if is_name(a) => Some(vec![b.text()?]),
            ExpressionNode::Compare(Relation::Equal, a, b) if is_name(b) => Some(vec![a.text()?]),
            ExpressionNode::In(a, members) if is_name(a) => {
                members.iter().map(Expression::text).collect()
            }
            ExpressionNode::And(a, b) => a.texts_of(index).or_else(|| b.texts_of(index)),
            ExpressionNode::Or(a, b) => {
                let mut texts = a.texts_of(index)?;
                texts.extend(b.texts_of(index)?);
                Some(texts)
            }
            _ => None,
        }
    }

    /// Returns the text that the expression is.
    fn text(&self) -> Option<&str> {
        match &self.node {
            ExpressionNode::Constant(FilterValue::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// Returns whether the expression uses the name with an index.
    pub(crate) fn uses(&self, index: usize) -> bool {
        match &self.node {
            ExpressionNode::Constant(_) => false,
            ExpressionNode::Column(used) => *used == index,
            ExpressionNode::Not(a) | ExpressionNode::IsMissing(a) | ExpressionNode::Absolute(a) => {
                a.uses(index)
            }
            ExpressionNode::And(a, b)
            | ExpressionNode::Or(a, b)
            | ExpressionNode::Compare(_, a, b)
            | ExpressionNode::Arithmetic(_, a, b)
            | ExpressionNode::Text(_, a, b) => a.uses(index) || b.uses(index),
            ExpressionNode::In(a, members) => {
                a.uses(index) || members.iter().any(|member| member.uses(index))
            }
            ExpressionNode::Choose(condition, yes, no) => {
                condition.uses(index) || yes.uses(index) || no.uses(index)
            }
        }
    }
}
