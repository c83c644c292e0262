//! What an expression is for a row.

use std::borrow::Cow;
use std::cmp::Ordering;

use super::tree::{Arithmetic, Node, Part, Relation, TextTest, Value};
use crate::table::{Cell, compare_exactly};

/// The value of a part of the expression for a row; an error where kinds that only the row tells do
/// not fit.
pub(super) fn evaluate<'a>(part: &'a Part, row: &'a [Cell]) -> Result<Value<'a>, String> {
    let logical = |value: Option<bool>| Ok(value.map_or(Value::Missing, Value::Truth));
    match &part.node {
        Node::Constant(value) => Ok(match value {
            Value::Text(text) => Value::Text(Cow::Borrowed(text)),
            other => other.clone(),
        }),
        Node::Column(index) => Ok(match &row[*index] {
            Cell::Number(x) if x.is_nan() => Value::Missing,
            Cell::Number(x) => Value::Number(*x),
            Cell::Integer(i) => Value::Integer(*i),
            Cell::Text(text) => Value::Text(Cow::Borrowed(text)),
            Cell::Missing => Value::Missing,
        }),
        Node::Not(a) => logical(truth(a, &evaluate(a, row)?)?.map(|t| !t)),
        Node::And(a, b) => logical(match truth(a, &evaluate(a, row)?)? {
            Some(false) => Some(false),
            left => match truth(b, &evaluate(b, row)?)? {
                Some(true) => left,
                Some(false) => Some(false),
                None => None,
            },
        }),
        Node::Or(a, b) => logical(match truth(a, &evaluate(a, row)?)? {
            Some(true) => Some(true),
            left => match truth(b, &evaluate(b, row)?)? {
                Some(false) => left,
                Some(true) => Some(true),
                None => None,
            },
        }),
        Node::Compare(relation, a, b) => {
            logical(holds(*relation, a, &evaluate(a, row)?, b, &evaluate(b, row)?)?)
        }
        Node::IsMissing(a) => Ok(Value::Truth(evaluate(a, row)? == Value::Missing)),
        Node::Arithmetic(operation, a, b) => {
            let (Some(x), Some(y)) =
                (number(a, &evaluate(a, row)?)?, number(b, &evaluate(b, row)?)?)
            else {
                return Ok(Value::Missing);
            };
            let result = match operation {
                Arithmetic::Plus => x + y,
                Arithmetic::Minus => x - y,
                Arithmetic::Times => x * y,
                Arithmetic::Over => x / y,
                Arithmetic::Modulo => x % y,
            };
            Ok(if result.is_nan() { Value::Missing } else { Value::Number(result) })
        }
        Node::Absolute(a) => {
            Ok(number(a, &evaluate(a, row)?)?.map_or(Value::Missing, |x| Value::Number(x.abs())))
        }
        Node::In(a, members) => {
            let value = evaluate(a, row)?;
            let mut found = Some(false);
            for member in members {
                match holds(Relation::Equal, a, &value, member, &evaluate(member, row)?)? {
                    Some(true) => return Ok(Value::Truth(true)),
                    Some(false) => {}
                    None => found = None,
                }
            }
            logical(found)
        }
        Node::Choose(condition, yes, no) => match truth(condition, &evaluate(condition, row)?)? {
            Some(true) => evaluate(yes, row),
            Some(false) => evaluate(no, row),
            None => Ok(Value::Missing),
        },
        Node::Text(test, text, pattern) => match (evaluate(text, row)?, evaluate(pattern, row)?) {
            (Value::Missing, _) | (_, Value::Missing) => Ok(Value::Missing),
            (Value::Text(text), Value::Text(pattern)) => Ok(Value::Truth(match test {
                TextTest::Contains => text.contains(&*pattern),
                TextTest::StartsWith => text.starts_with(&*pattern),
                TextTest::EndsWith => text.ends_with(&*pattern),
            })),
            (a, b) => Err(format!(
                "text was needed, but there are {} and {}",
                a.kind().name(),
                b.kind().name()
            )),
        },
    }
}

/// A condition, `None` where it is unknown.
pub(super) fn truth(part: &Part, value: &Value<'_>) -> Result<Option<bool>, String> {
    match value {
        Value::Truth(t) => Ok(Some(*t)),
        Value::Missing => Ok(None),
        other => {
            Err(format!("a condition was needed, but {} is {}", part.label, other.kind().name()))
        }
    }
}

fn number(part: &Part, value: &Value<'_>) -> Result<Option<f64>, String> {
    match value {
        Value::Integer(i) => Ok(Some(*i as f64)),
        Value::Number(x) => Ok(Some(*x)),
        Value::Missing => Ok(None),
        other => Err(format!("a number was needed, but {} is {}", part.label, other.kind().name())),
    }
}

fn holds(
    relation: Relation,
    a: &Part,
    x: &Value<'_>,
    b: &Part,
    y: &Value<'_>,
) -> Result<Option<bool>, String> {
    let order = match (x, y) {
        (Value::Missing, _) | (_, Value::Missing) => return Ok(None),
        (Value::Integer(x), Value::Integer(y)) => x.cmp(y),
        (Value::Integer(x), Value::Number(y)) => compare_exactly(*x, *y),
        (Value::Number(x), Value::Integer(y)) => compare_exactly(*y, *x).reverse(),
        (Value::Number(x), Value::Number(y)) => match x.partial_cmp(y) {
            Some(order) => order,
            None => return Ok(None),
        },
        (Value::Text(x), Value::Text(y)) => x.cmp(y),
        (Value::Truth(x), Value::Truth(y)) => x.cmp(y),
        (x, y) => {
            let (x, y) = (x.kind().name(), y.kind().name());
            return Err(format!(
                "{} is {x} and {} is {y}; they cannot be compared",
                a.label, b.label
            ));
        }
    };
    Ok(Some(match relation {
        Relation::Equal => order == Ordering::Equal,
        Relation::NotEqual => order != Ordering::Equal,
        Relation::Less => order == Ordering::Less,
        Relation::LessOrEqual => order != Ordering::Greater,
        Relation::Greater => order == Ordering::Greater,
        Relation::GreaterOrEqual => order != Ordering::Less,
    }))
}
