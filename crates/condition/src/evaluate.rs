//! The value of an expression for a row.

use std::borrow::Cow;
use std::cmp::Ordering;

use crate::tree::{Arithmetic, Expression, ExpressionNode, FilterValue, Relation, TextTest};

/// Returns the value of an expression for the values of names.
///
/// # Errors
/// A message if the expression meets values of kinds that do not fit, which only the values tell: a
/// column may mix kinds.
fn evaluate<'a>(
    expression: &'a Expression,
    values: &dyn Fn(usize) -> FilterValue<'a>,
) -> Result<FilterValue<'a>, String> {
    let logical = |value: Option<bool>| Ok(value.map_or(FilterValue::Missing, FilterValue::Truth));
    match &expression.node {
        ExpressionNode::Constant(value) => Ok(match value {
            FilterValue::Text(text) => FilterValue::Text(Cow::Borrowed(text)),
            other => other.clone(),
        }),
        ExpressionNode::Column(index) => Ok(match values(*index) {
            FilterValue::Number(x) if x.is_nan() => FilterValue::Missing,
            value => value,
        }),
        ExpressionNode::Not(a) => logical(Operand::new(a, values)?.truth()?.map(|t| !t)),
        ExpressionNode::And(a, b) => logical(match Operand::new(a, values)?.truth()? {
            Some(false) => Some(false),
            left => match Operand::new(b, values)?.truth()? {
                Some(true) => left,
                Some(false) => Some(false),
                None => None,
            },
        }),
        ExpressionNode::Or(a, b) => logical(match Operand::new(a, values)?.truth()? {
            Some(true) => Some(true),
            left => match Operand::new(b, values)?.truth()? {
                Some(false) => left,
                Some(true) => Some(true),
                None => None,
            },
        }),
        ExpressionNode::Compare(relation, a, b) => {
            logical(holds(*relation, &Operand::new(a, values)?, &Operand::new(b, values)?)?)
        }
        ExpressionNode::IsMissing(a) => {
            Ok(FilterValue::Truth(evaluate(a, values)? == FilterValue::Missing))
        }
        ExpressionNode::Arithmetic(operation, a, b) => {
            let (Some(x), Some(y)) =
                (Operand::new(a, values)?.number()?, Operand::new(b, values)?.number()?)
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
        ExpressionNode::Absolute(a) => Ok(Operand::new(a, values)?
            .number()?
            .map_or(FilterValue::Missing, |x| FilterValue::Number(x.abs()))),
        ExpressionNode::In(a, members) => {
            let value = Operand::new(a, values)?;
            let mut found = Some(false);
            for member in members {
                match holds(Relation::Equal, &value, &Operand::new(member, values)?)? {
                    Some(true) => return Ok(FilterValue::Truth(true)),
                    Some(false) => {}
                    None => found = None,
                }
            }
            logical(found)
        }
        ExpressionNode::Choose(condition, yes, no) => {
            match Operand::new(condition, values)?.truth()? {
                Some(true) => evaluate(yes, values),
                Some(false) => evaluate(no, values),
                None => Ok(FilterValue::Missing),
            }
        }
        ExpressionNode::Text(test, text, pattern) => {
            text_test(*test, evaluate(text, values)?, evaluate(pattern, values)?)
        }
    }
}

/// Returns the truth of a condition for a row, or `None` if it is unknown.
///
/// # Errors
/// A message if the expression meets values of kinds that do not fit.
pub(crate) fn truth<'a>(
    condition: &'a Expression,
    values: &dyn Fn(usize) -> FilterValue<'a>,
) -> Result<Option<bool>, String> {
    Operand::new(condition, values)?.truth()
}

/// Returns the numerical order of an integer and a number that is not NaN, without rounding the
/// integer.
pub fn compare_exactly(i: i64, x: f64) -> Ordering {
    // 2⁶³ is a number, i64::MAX is not.
    if x >= 9_223_372_036_854_775_808.0 {
        Ordering::Less
    } else if x < -9_223_372_036_854_775_808.0 {
        Ordering::Greater
    } else {
        let whole = x.trunc();
        i.cmp(&(whole as i64)).then(whole.partial_cmp(&x).unwrap_or(Ordering::Equal))
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
    fn new(
        expression: &'a Expression,
        values: &dyn Fn(usize) -> FilterValue<'a>,
    ) -> Result<Operand<'a>, String> {
        Ok(Operand { expression, value: evaluate(expression, values)? })
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
