//! The way from the text of an expression to a tree whose names are resolved and whose kinds of
//! values fit.

use crate::error::{FilterError, LONGEST, UnknownColumn};
use crate::grammar::{self, InfixOperator, Written};
use crate::tree::{
    Arithmetic, Expression, ExpressionNode, FilterValue, Relation, TextTest, ValueKind,
};

type Compiled = Result<Expression, FilterError>;

/// The names that a condition may use.
pub trait ConditionNames {
    /// Returns the index of a name.
    ///
    /// # Errors
    /// There is no such name; the error says those that come close.
    fn find(&self, name: &str) -> Result<usize, UnknownColumn>;

    /// Returns the kind that all values of the name with an index have.
    fn kind(&self, index: usize) -> ValueKind;
}

/// Compiles the condition that a text states about names.
pub(crate) fn compile(text: &str, names: &dyn ConditionNames) -> Compiled {
    if text.trim().is_empty() {
        return Err(FilterError::Empty);
    }
    if text.len() > LONGEST {
        return Err(FilterError::TooLong { length: text.len() });
    }
    let condition = expression(&grammar::read(text)?, names)?;
    expect(&condition, ValueKind::Truth, "a filter must be a condition such as `mu > 0.3`")?;
    Ok(condition)
}

/// Compiles an expression or one of its operands. Operands are compiled one after the other: the
/// first that is wrong is the one that the message names.
fn expression(written: &Written, names: &dyn ConditionNames) -> Compiled {
    let operand = |written: &Written| expression(written, names).map(Box::new);
    match written {
        Written::Constant(value) => Ok(constant(value.clone())),
        Written::Name(name) => {
            let index = names.find(name)?;
            Ok(Expression {
                node: ExpressionNode::Column(index),
                kind: names.kind(index),
                label: format!("column `{name}`"),
            })
        }
        Written::Not(value) => {
            let value = operand(value)?;
            expect(&value, ValueKind::Truth, "! needs a condition")?;
            Ok(condition(ExpressionNode::Not(value)))
        }
        Written::Negated(value) => negation(operand(value)?),
        Written::Infix(operator, a, b) => infix(*operator, a, b, names),
        Written::Choice(parts) => {
            let [condition, yes, no] = parts.as_ref();
            choice(operand(condition)?, operand(yes)?, operand(no)?)
        }
        Written::List(_) => {
            Err(FilterError::Unsupported("a list other than after `in`".to_owned()))
        }
        Written::Call(name, arguments) if name == "abs" => match arguments.as_slice() {
            [argument] => absolute(operand(argument)?),
            _ => Err(FilterError::Mismatch("`abs` takes one number".to_owned())),
        },
        Written::Call(name, _) => Err(FilterError::Unsupported(format!("`{name}()`"))),
        Written::Method(text, name, arguments) => text_test(text, name, arguments, names),
        Written::Foreign(what) => Err(FilterError::Unsupported(what.clone())),
    }
}

fn constant(value: FilterValue<'static>) -> Expression {
    let label = match &value {
        FilterValue::Truth(b) => b.to_string(),
        FilterValue::Integer(i) => i.to_string(),
        FilterValue::Number(x) => x.to_string(),
        FilterValue::Text(text) => format!("{text:?}"),
        FilterValue::Missing => "null".to_owned(),
    };
    Expression { kind: value.kind(), node: ExpressionNode::Constant(value), label }
}

/// Completes a node that is a condition.
fn condition(node: ExpressionNode) -> Expression {
    Expression { node, kind: ValueKind::Truth, label: "a comparison".to_owned() }
}

/// Completes a node that is a number.
fn number(node: ExpressionNode) -> Expression {
    Expression { node, kind: ValueKind::Number, label: "the result of a calculation".to_owned() }
}

/// Compiles an operator between two operands.
fn infix(
    operator: InfixOperator,
    a: &Written,
    b: &Written,
    names: &dyn ConditionNames,
) -> Compiled {
    let operand = |written| expression(written, names).map(Box::new);
    let both = |kind, need: &str| {
        let (a, b) = (operand(a)?, operand(b)?);
        expect(&a, kind, need)?;
        expect(&b, kind, need)?;
        Ok::<_, FilterError>((a, b))
    };
    match operator {
        InfixOperator::And => {
            let (a, b) = both(ValueKind::Truth, "&& joins conditions")?;
            Ok(condition(ExpressionNode::And(a, b)))
        }
        InfixOperator::Or => {
            let (a, b) = both(ValueKind::Truth, "|| joins conditions")?;
            Ok(condition(ExpressionNode::Or(a, b)))
        }
        InfixOperator::Calculate(operation) => {
            let (a, b) = both(ValueKind::Number, "arithmetic needs numbers")?;
            Ok(number(ExpressionNode::Arithmetic(operation, a, b)))
        }
        InfixOperator::Compare(relation) => comparison(relation, operand(a)?, operand(b)?),
        InfixOperator::In => membership(operand(a)?, b, names),
    }
}

/// Compiles `text.contains("…")` and the like.
fn text_test(
    text: &Written,
    name: &str,
    arguments: &[Written],
    names: &dyn ConditionNames,
) -> Compiled {
    let test = match name {
        "contains" => TextTest::Contains,
        "startsWith" => TextTest::StartsWith,
        "endsWith" => TextTest::EndsWith,
        other => return Err(FilterError::Unsupported(format!("`.{other}()`"))),
    };
    let [pattern] = arguments else {
        return Err(FilterError::Mismatch(format!("`.{name}` takes one text")));
    };
    let text = Box::new(expression(text, names)?);
    let pattern = Box::new(expression(pattern, names)?);
    let need = format!("`.{name}` needs text");
    expect(&text, ValueKind::Text, &need)?;
    expect(&pattern, ValueKind::Text, &need)?;
    Ok(condition(ExpressionNode::Text(test, text, pattern)))
}

/// Compiles a comparison; one with `null` asks for missing values.
fn comparison(relation: Relation, a: Box<Expression>, b: Box<Expression>) -> Compiled {
    let is_null = |operand: &Expression| {
        matches!(operand.node, ExpressionNode::Constant(FilterValue::Missing))
    };
    let node = match (relation, is_null(&a), is_null(&b)) {
        (Relation::Equal, _, true) => ExpressionNode::IsMissing(a),
        (Relation::Equal, true, _) => ExpressionNode::IsMissing(b),
        (Relation::NotEqual, true, _) | (Relation::NotEqual, _, true) => {
            let operand = if is_null(&b) { a } else { b };
            ExpressionNode::Not(Box::new(condition(ExpressionNode::IsMissing(operand))))
        }
        (_, false, false) => {
            check_comparable(relation, &a, &b)?;
            ExpressionNode::Compare(relation, a, b)
        }
        _ => {
            return Err(FilterError::Mismatch("null can only be compared by == and !=".to_owned()));
        }
    };
    Ok(condition(node))
}

/// Compiles `-x` as `0 - x`.
fn negation(operand: Box<Expression>) -> Compiled {
    expect(&operand, ValueKind::Number, "- needs a number")?;
    let zero = Box::new(constant(FilterValue::Integer(0)));
    Ok(number(ExpressionNode::Arithmetic(Arithmetic::Minus, zero, operand)))
}

fn absolute(operand: Box<Expression>) -> Compiled {
    expect(&operand, ValueKind::Number, "abs() needs a number")?;
    Ok(number(ExpressionNode::Absolute(operand)))
}

/// Compiles `condition ? yes : no`.
fn choice(condition: Box<Expression>, yes: Box<Expression>, no: Box<Expression>) -> Compiled {
    expect(&condition, ValueKind::Truth, "?: needs a condition")?;
    let kind = match (yes.kind, no.kind) {
        (a, b) if a == b => a,
        (ValueKind::Unknown, other) | (other, ValueKind::Unknown) => other,
        _ => {
            let message =
                format!("both sides of `:` must be alike: {}, {}", yes.described(), no.described());
            return Err(FilterError::Mismatch(message));
        }
    };
    Ok(Expression {
        node: ExpressionNode::Choose(condition, yes, no),
        kind,
        label: "the result of ?:".to_owned(),
    })
}

/// Compiles `value in [a, b]`.
fn membership(value: Box<Expression>, list: &Written, names: &dyn ConditionNames) -> Compiled {
    let Written::List(list) = list else {
        return Err(FilterError::Mismatch(
            "`in` needs a list such as `mesh in [32, 64]`".to_owned(),
        ));
    };
    let mut members = Vec::new();
    for element in list {
        let member = expression(element, names)?;
        check_comparable(Relation::Equal, &value, &member)?;
        members.push(member);
    }
    Ok(condition(ExpressionNode::In(value, members)))
}

/// Checks that an expression is of a kind; `need` begins the message if it is not.
fn expect(expression: &Expression, kind: ValueKind, need: &str) -> Result<(), FilterError> {
    if expression.kind == kind || expression.kind == ValueKind::Unknown {
        Ok(())
    } else {
        Err(FilterError::Mismatch(format!("{need}, but {}", expression.described())))
    }
}

/// Checks that two expressions are of kinds that a relation can compare.
fn check_comparable(relation: Relation, a: &Expression, b: &Expression) -> Result<(), FilterError> {
    let ordered = !matches!(relation, Relation::Equal | Relation::NotEqual);
    let message = match (a.kind, b.kind) {
        (ValueKind::Truth, _) | (_, ValueKind::Truth) if ordered => {
            "a condition cannot be ordered; `a < x < b` is written `a < x && x < b`".to_owned()
        }
        (ValueKind::Unknown, _) | (_, ValueKind::Unknown) => return Ok(()),
        (a, b) if a == b => return Ok(()),
        _ => format!("{} and {}; they cannot be compared", a.described(), b.described()),
    };
    Err(FilterError::Mismatch(message))
}
