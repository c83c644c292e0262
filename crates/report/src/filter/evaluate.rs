//! What an expression is for a row.

use std::borrow::Cow;
use std::cmp::Ordering;

use super::tree::{Arithmetic, Expression, ExpressionNode, FilterValue, Relation, TextTest};
use crate::table::{Cell, compare_exactly};

/// The value of a part of the expression for a row; an error where kinds that only the row tells do
/// not fit.
pub(super) fn evaluate<'a>(
    part: &'a Expression,
    row: &'a [Cell],
) -> Result<FilterValue<'a>, String> {
    let logical = |value: Option<bool>| Ok(value.map_or(FilterValue::Missing, FilterValue::Truth));
    match &part.node {
        ExpressionNode::Constant(value) => Ok(match value {
            FilterValue::Text(text) => FilterValue::Text(Cow::Borrowed(text)),
            other => other.clone(),
        }),
        ExpressionNode::Column(index) => Ok(match &row[*index] {
            Cell::Number(x) if x.is_nan() => FilterValue::Missing,
            Cell::Number(x) => FilterValue::Number(*x),
            Cell::Integer(i) => FilterValue::Integer(*i),
            Cell::Text(text) => FilterValue::Text(Cow::Borrowed(text)),
            Cell::Missing => FilterValue::Missing,
        }),
        ExpressionNode::Not(a) => logical(truth(a, &evaluate(a, row)?)?.map(|t| !t)),
        ExpressionNode::And(a, b) => logical(match truth(a, &evaluate(a, row)?)? {
            Some(false) => Some(false),
            left => match truth(b, &evaluate(b, row)?)? {
                Some(true) => left,
                Some(false) => Some(false),
                None => None,
            },
        }),
        ExpressionNode::Or(a, b) => logical(match truth(a, &evaluate(a, row)?)? {
            Some(true) => Some(true),
            left => match truth(b, &evaluate(b, row)?)? {
                Some(false) => left,
                Some(true) => Some(true),
                None => None,
            },
        }),
        ExpressionNode::Compare(relation, a, b) => {
            logical(holds(*relation, a, &evaluate(a, row)?, b, &evaluate(b, row)?)?)
        }
        ExpressionNode::IsMissing(a) => {
            Ok(FilterValue::Truth(evaluate(a, row)? == FilterValue::Missing))
        }
        ExpressionNode::Arithmetic(operation, a, b) => {
            let (Some(x), Some(y)) =
                (number(a, &evaluate(a, row)?)?, number(b, &evaluate(b, row)?)?)
            else {
                return Ok(FilterValue::Missing);
            };
            let result = match operation {
                Arithmetic::Plus => x + y,
                Arithmetic::Minus => x - y,
                Arithmetic::Times => x * y,
                Arithmetic::Over => x / y,
                Arithmetic::Modulo => x % y,
            };
            Ok(if result.is_nan() { FilterValue::Missing } else { FilterValue::Number(result) })
        }
        ExpressionNode::Absolute(a) => Ok(number(a, &evaluate(a, row)?)?
            .map_or(FilterValue::Missing, |x| FilterValue::Number(x.abs()))),
        ExpressionNode::In(a, members) => {
            let value = evaluate(a, row)?;
            let mut found = Some(false);
            for member in members {
                match holds(Relation::Equal, a, &value, member, &evaluate(member, row)?)? {
                    Some(true) => return Ok(FilterValue::Truth(true)),
                    Some(false) => {}
                    None => found = None,
                }
            }
            logical(found)
        }
        ExpressionNode::Choose(condition, yes, no) => {
            match truth(condition, &evaluate(condition, row)?)? {
                Some(true) => evaluate(yes, row),
                Some(false) => evaluate(no, row),
                None => Ok(FilterValue::Missing),
            }
        }
        ExpressionNode::Text(test, text, pattern) => {
            match (evaluate(text, row)?, evaluate(pattern, row)?) {
                (FilterValue::Missing, _) | (_, FilterValue::Missing) => Ok(FilterValue::Missing),
                (FilterValue::Text(text), FilterValue::Text(pattern)) => {
                    Ok(FilterValue::Truth(match test {
                        TextTest::Contains => text.contains(&*pattern),
                        TextTest::StartsWith => text.starts_with(&*pattern),
                        TextTest::EndsWith => text.ends_with(&*pattern),
                    }))
                }
                (a, b) => Err(format!(
                    "text was needed, but there are {} and {}",
                    a.kind().name(),
                    b.kind().name()
                )),
            }
        }
    }
}

/// A condition, `None` where it is unknown.
pub(super) fn truth(part: &Expression, value: &FilterValue<'_>) -> Result<Option<bool>, String> {
    match value {
        FilterValue::Truth(t) => Ok(Some(*t)),
        FilterValue::Missing => Ok(None),
        other => {
            Err(format!("a condition was needed, but {} is {}", part.label, other.kind().name()))
        }
    }
}

fn number(part: &Expression, value: &FilterValue<'_>) -> Result<Option<f64>, String> {
    match value {
        FilterValue::Integer(i) => Ok(Some(*i as f64)),
        FilterValue::Number(x) => Ok(Some(*x)),
        FilterValue::Missing => Ok(None),
        other => Err(format!("a number was needed, but {} is {}", part.label, other.kind().name())),
    }
}

fn holds(
    relation: Relation,
    a: &Expression,
    x: &FilterValue<'_>,
    b: &Expression,
    y: &FilterValue<'_>,
) -> Result<Option<bool>, String> {
    let order = match (x, y) {
        (FilterValue::Missing, _) | (_, FilterValue::Missing) => return Ok(None),
        (FilterValue::Integer(x), FilterValue::Integer(y)) => x.cmp(y),
        (FilterValue::Integer(x), FilterValue::Number(y)) => compare_exactly(*x, *y),
        (FilterValue::Number(x), FilterValue::Integer(y)) => compare_exactly(*y, *x).reverse(),
        (FilterValue::Number(x), FilterValue::Number(y)) => match x.partial_cmp(y) {
            Some(order) => order,
            None => return Ok(None),
        },
        (FilterValue::Text(x), FilterValue::Text(y)) => x.cmp(y),
        (FilterValue::Truth(x), FilterValue::Truth(y)) => x.cmp(y),
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
