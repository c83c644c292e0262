//! The value of an expression for a row.

use std::borrow::Cow;
use std::cmp::Ordering;

use super::tree::{Arithmetic, Expression, ExpressionNode, FilterValue, Relation, TextTest};
use crate::table::{Cell, compare_exactly};

/// Returns the value of an expression for a row.
///
/// # Errors
/// A message if the expression meets values of kinds that do not fit, which only the row tells: a
/// column may mix kinds.
fn evaluate<'a>(expression: &'a Expression, row: &'a [Cell]) -> Result<FilterValue<'a>, String> {
    let logical = |value: Option<bool>| Ok(value.map_or(FilterValue::Missing, FilterValue::Truth));
    match &expression.node {
        ExpressionNode::Constant(value) => Ok(match value {
            FilterValue::Text(text) => FilterValue::Text(Cow::Borrowed(text)),
            other => other.clone(),
        }),
        ExpressionNode::Column(index) => Ok(cell_value(&row[*index])),
        ExpressionNode::Not(a) => logical(Operand::new(a, row)?.truth()?.map(|t| !t)),
        ExpressionNode::And(a, b) => logical(match Operand::new(a, row)?.truth()? {
            Some(false) => Some(false),
            left => match Operand::new(b, row)?.truth()? {
                Some(true) => left,
                Some(false) => Some(false),
                None => None,
            },
        }),
        ExpressionNode::Or(a, b) => logical(match Operand::new(a, row)?.truth()? {
            Some(true) => Some(true),
            left => match Operand::new(b, row)?.truth()? {
                Some(false) => left,
                Some(true) => Some(true),
                None => None,
            },
        }),
        ExpressionNode::Compare(relation, a, b) => {
            logical(holds(*relation, &Operand::new(a, row)?, &Operand::new(b, row)?)?)
        }
        ExpressionNode::IsMissing(a) => {
            Ok(FilterValue::Truth(evaluate(a, row)? == FilterValue::Missing))
        }
        ExpressionNode::Arithmetic(operation, a, b) => {
            let (Some(x), Some(y)) =
                (Operand::new(a, row)?.number()?, Operand::new(b, row)?.number()?)
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
        ExpressionNode::Absolute(a) => Ok(Operand::new(a, row)?
            .number()?
            .map_or(FilterValue::Missing, |x| FilterValue::Number(x.abs()))),
        ExpressionNode::In(a, members) => {
            let value = Operand::new(a, row)?;
            let mut found = Some(false);
            for member in members {
                match holds(Relation::Equal, &value, &Operand::new(member, row)?)? {
                    Some(true) => return Ok(FilterValue::Truth(true)),
                    Some(false) => {}
                    None => found = None,
                }
            }
            logical(found)
        }
        ExpressionNode::Choose(condition, yes, no) => {
            match Operand::new(condition, row)?.truth()? {
                Some(true) => evaluate(yes, row),
                Some(false) => evaluate(no, row),
                None => Ok(FilterValue::Missing),
            }
        }
        ExpressionNode::Text(test, text, pattern) => {
            text_test(*test, evaluate(text, row)?, evaluate(pattern, row)?)
        }
    }
}

/// Returns the truth of a condition for a row, or `None` if it is unknown.
///
/// # Errors
/// A message if the expression meets values of kinds that do not fit.
pub(super) fn truth(condition: &Expression, row: &[Cell]) -> Result<Option<bool>, String> {
    Operand::new(condition, row)?.truth()
}

fn cell_value(cell: &Cell) -> FilterValue<'_> {
    match cell {
        Cell::Number(x) if x.is_nan() => FilterValue::Missing,
        Cell::Number(x) => FilterValue::Number(*x),
        Cell::Integer(i) => FilterValue::Integer(*i),
        Cell::Text(text) => FilterValue::Text(Cow::Borrowed(text)),
        Cell::Missing => FilterValue::Missing,
    }
}

fn text_test<'a>(
    test: TextTest,
    text: FilterValue<'_>,
    pattern: FilterValue<'_>,
) -> Result<FilterValue<'a>, String> {
    match (text, pattern) {
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

/// An expression with its value for a row.
struct Operand<'a> {
    expression: &'a Expression,
    value: FilterValue<'a>,
}

impl<'a> Operand<'a> {
    fn new(expression: &'a Expression, row: &'a [Cell]) -> Result<Operand<'a>, String> {
        Ok(Operand { expression, value: evaluate(expression, row)? })
    }

    /// Returns the truth of a condition, or `None` if it is unknown.
    fn truth(&self) -> Result<Option<bool>, String> {
        match &self.value {
            FilterValue::Truth(t) => Ok(Some(*t)),
            FilterValue::Missing => Ok(None),
            other => Err(format!(
                "a condition was needed, but {} is {}",
                self.expression.label,
                other.kind().name()
            )),
        }
    }

    /// Returns the number, or `None` if it is missing.
    fn number(&self) -> Result<Option<f64>, String> {
        match &self.value {
            FilterValue::Integer(i) => Ok(Some(*i as f64)),
            FilterValue::Number(x) => Ok(Some(*x)),
            FilterValue::Missing => Ok(None),
            other => Err(format!(
                "a number was needed, but {} is {}",
                self.expression.label,
                other.kind().name()
            )),
        }
    }
}

/// Says whether a relation holds between two values, or `None` if one of them is missing.
fn holds(relation: Relation, a: &Operand<'_>, b: &Operand<'_>) -> Result<Option<bool>, String> {
    let order = match (&a.value, &b.value) {
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
                a.expression.label, b.expression.label
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
