//! From the text of an expression to a tree whose names are resolved and whose kinds of values fit.

use std::borrow::Cow;

use cel::common::ast::{CallExpr, Expr, LiteralValue, operators};

use super::error::{FilterError, LONGEST};
use super::syntax::syntax_error;
use super::tree::{
    Arithmetic, Expression, ExpressionNode, FilterValue, Relation, TextTest, ValueKind,
};
use crate::table::{Cell, DataTable};

type Compiled = Result<Expression, FilterError>;

/// The condition that an expression is of a table's rows.
pub(super) fn compile(expression: &str, table: &DataTable) -> Compiled {
    if expression.trim().is_empty() {
        return Err(FilterError::Empty);
    }
    if expression.len() > LONGEST {
        return Err(FilterError::TooLong { length: expression.len() });
    }
    let tree = cel::parser::Parser::new()
        .parse(expression)
        .map_err(|errors| syntax_error(expression, &errors))?;
    let condition = part(&tree.expr, table)?;
    expect(&condition, ValueKind::Truth, "a filter must be a condition such as `mu > 0.3`")?;
    Ok(condition)
}

/// The name that an expression spells: `mu`, `friction.mu`, `layers[0].poisson`.
fn spelled(expression: &Expr) -> Option<String> {
    match expression {
        Expr::Ident(name) => Some(name.clone()),
        Expr::Select(select) if !select.test => {
            Some(format!("{}.{}", spelled(&select.operand.expr)?, select.field))
        }
        Expr::Call(CallExpr { func_name, target: None, args }) if func_name == operators::INDEX => {
            match args.as_slice() {
                [operand, index] => match &index.expr {
                    Expr::Literal(LiteralValue::Int(i)) => {
                        Some(format!("{}[{}]", spelled(&operand.expr)?, i.inner()))
                    }
                    _ => None,
                },
                _ => None,
            }
        }
        _ => None,
    }
}

fn part(expression: &Expr, table: &DataTable) -> Compiled {
    if let Some(name) = spelled(expression) {
        let index = table.column(&name)?;
        return Ok(Expression {
            node: ExpressionNode::Column(index),
            kind: column_kind(table, index),
            label: format!("column `{name}`"),
        });
    }
    match expression {
        Expr::Literal(literal) => constant(literal),
        Expr::Call(call) => self::call(call, table),
        Expr::List(_) => Err(FilterError::Unsupported("a list other than after `in`".to_owned())),
        Expr::Map(_) | Expr::Struct(_) => Err(FilterError::Unsupported("`{…}`".to_owned())),
        Expr::Select(select) => {
            Err(FilterError::Unsupported(format!("`.{}` of a value", select.field)))
        }
        Expr::Comprehension(_) => {
            Err(FilterError::Unsupported("a macro such as all() or exists()".to_owned()))
        }
        Expr::Unspecified | Expr::Ident(_) => Err(FilterError::Empty),
    }
}

fn column_kind(table: &DataTable, index: usize) -> ValueKind {
    let mut kinds = table.cells(index).filter_map(|cell| match cell {
        Cell::Number(_) | Cell::Integer(_) => Some(ValueKind::Number),
        Cell::Text(_) => Some(ValueKind::Text),
        Cell::Missing => None,
    });
    match kinds.next() {
        Some(first) if kinds.all(|kind| kind == first) => first,
        _ => ValueKind::Unknown,
    }
}

fn constant(literal: &LiteralValue) -> Compiled {
    let (value, label) = match literal {
        LiteralValue::Boolean(b) => (FilterValue::Truth(*b.inner()), b.inner().to_string()),
        LiteralValue::Int(i) => (FilterValue::Integer(*i.inner()), i.inner().to_string()),
        LiteralValue::UInt(u) => match i64::try_from(*u.inner()) {
            Ok(i) => (FilterValue::Integer(i), i.to_string()),
            Err(_) => (FilterValue::Number(*u.inner() as f64), u.inner().to_string()),
        },
        LiteralValue::Double(x) => (FilterValue::Number(*x.inner()), x.inner().to_string()),
        LiteralValue::String(s) => {
            (FilterValue::Text(Cow::Owned(s.inner().to_owned())), format!("{:?}", s.inner()))
        }
        LiteralValue::Null => (FilterValue::Missing, "null".to_owned()),
        LiteralValue::Bytes(_) => return Err(FilterError::Unsupported("b\"…\"".to_owned())),
    };
    Ok(Expression { kind: value.kind(), node: ExpressionNode::Constant(value), label })
}

fn call(call: &CallExpr, table: &DataTable) -> Compiled {
    let argument = |i: usize| -> Result<Box<Expression>, FilterError> {
        match call.args.get(i) {
            Some(argument) => Ok(Box::new(part(&argument.expr, table)?)),
            None => Err(FilterError::Mismatch(format!("`{}` lacks an argument", call.func_name))),
        }
    };
    let condition =
        |node| Ok(Expression { node, kind: ValueKind::Truth, label: "a comparison".to_owned() });
    let number = |node| {
        Ok(Expression {
            node,
            kind: ValueKind::Number,
            label: "the result of a calculation".to_owned(),
        })
    };

    if let Some(target) = &call.target {
        let test = match call.func_name.as_str() {
            "contains" => TextTest::Contains,
            "startsWith" => TextTest::StartsWith,
            "endsWith" => TextTest::EndsWith,
            other => return Err(FilterError::Unsupported(format!("`.{other}()`"))),
        };
        if call.args.len() != 1 {
            return Err(FilterError::Mismatch(format!("`.{}` takes one text", call.func_name)));
        }
        let (text, pattern) = (Box::new(part(&target.expr, table)?), argument(0)?);
        let needs = format!("`.{}` needs text", call.func_name);
        expect(&text, ValueKind::Text, &needs)?;
        expect(&pattern, ValueKind::Text, &needs)?;
        return condition(ExpressionNode::Text(test, text, pattern));
    }

    let compare = |relation| {
        let (a, b) = (argument(0)?, argument(1)?);
        let is_null =
            |p: &Expression| matches!(p.node, ExpressionNode::Constant(FilterValue::Missing));
        let node = match (relation, is_null(&a), is_null(&b)) {
            (Relation::Equal, _, true) => ExpressionNode::IsMissing(a),
            (Relation::Equal, true, _) => ExpressionNode::IsMissing(b),
            (Relation::NotEqual, true, _) | (Relation::NotEqual, _, true) => {
                let operand = if is_null(&b) { a } else { b };
                ExpressionNode::Not(Box::new(condition(ExpressionNode::IsMissing(operand))?))
            }
            (_, false, false) => {
                comparable(relation, &a, &b).map_err(FilterError::Mismatch)?;
                ExpressionNode::Compare(relation, a, b)
            }
            _ => {
                return Err(FilterError::Mismatch(
                    "null can only be compared by == and !=".to_owned(),
                ));
            }
        };
        condition(node)
    };
    let calculate = |operation| {
        let (a, b) = (argument(0)?, argument(1)?);
        for operand in [&a, &b] {
            expect(operand, ValueKind::Number, "arithmetic needs numbers")?;
        }
        number(ExpressionNode::Arithmetic(operation, a, b))
    };
    let logical = |join: fn(Box<Expression>, Box<Expression>) -> ExpressionNode, symbol: &str| {
        let (a, b) = (argument(0)?, argument(1)?);
        for operand in [&a, &b] {
            expect(operand, ValueKind::Truth, &format!("{symbol} joins conditions"))?;
        }
        condition(join(a, b))
    };
    match call.func_name.as_str() {
        operators::LOGICAL_AND => logical(ExpressionNode::And, "&&"),
        operators::LOGICAL_OR => logical(ExpressionNode::Or, "||"),
        operators::LOGICAL_NOT => {
            let operand = argument(0)?;
            expect(&operand, ValueKind::Truth, "! needs a condition")?;
            condition(ExpressionNode::Not(operand))
        }
        operators::EQUALS => compare(Relation::Equal),
        operators::NOT_EQUALS => compare(Relation::NotEqual),
        operators::LESS => compare(Relation::Less),
        operators::LESS_EQUALS => compare(Relation::LessOrEqual),
        operators::GREATER => compare(Relation::Greater),
        operators::GREATER_EQUALS => compare(Relation::GreaterOrEqual),
        operators::ADD => calculate(Arithmetic::Plus),
        operators::SUBSTRACT => calculate(Arithmetic::Minus),
        operators::MULTIPLY => calculate(Arithmetic::Times),
        operators::DIVIDE => calculate(Arithmetic::Over),
        operators::MODULO => calculate(Arithmetic::Modulo),
        operators::NEGATE => {
            let operand = argument(0)?;
            expect(&operand, ValueKind::Number, "- needs a number")?;
            let zero = Expression {
                node: ExpressionNode::Constant(FilterValue::Integer(0)),
                kind: ValueKind::Number,
                label: "0".to_owned(),
            };
            number(ExpressionNode::Arithmetic(Arithmetic::Minus, Box::new(zero), operand))
        }
        "abs" if call.args.len() != 1 => {
            Err(FilterError::Mismatch("`abs` takes one number".to_owned()))
        }
        "abs" => {
            let operand = argument(0)?;
            expect(&operand, ValueKind::Number, "abs() needs a number")?;
            number(ExpressionNode::Absolute(operand))
        }
        operators::CONDITIONAL => {
            let (condition, yes, no) = (argument(0)?, argument(1)?, argument(2)?);
            expect(&condition, ValueKind::Truth, "?: needs a condition")?;
            let kind = match (yes.kind, no.kind) {
                (a, b) if a == b => a,
                (ValueKind::Unknown, other) | (other, ValueKind::Unknown) => other,
                _ => {
                    let message = format!(
                        "both sides of `:` must be alike: {}, {}",
                        yes.described(),
                        no.described()
                    );
                    return Err(FilterError::Mismatch(message));
                }
            };
            Ok(Expression {
                node: ExpressionNode::Choose(condition, yes, no),
                kind,
                label: "the result of ?:".to_owned(),
            })
        }
        operators::IN => {
            let value = argument(0)?;
            let Some(Expr::List(list)) = call.args.get(1).map(|a| &a.expr) else {
                return Err(FilterError::Mismatch(
                    "`in` needs a list such as `mesh in [32, 64]`".to_owned(),
                ));
            };
            let mut members = Vec::new();
            for element in &list.elements {
                let member = part(&element.expr, table)?;
                comparable(Relation::Equal, &value, &member).map_err(FilterError::Mismatch)?;
                members.push(member);
            }
            condition(ExpressionNode::In(value, members))
        }
        operators::INDEX => {
            Err(FilterError::Unsupported("`[…]` with anything but a number of an entry".to_owned()))
        }
        other => Err(FilterError::Unsupported(format!("`{other}()`"))),
    }
}

fn expect(part: &Expression, kind: ValueKind, need: &str) -> Result<(), FilterError> {
    if part.kind == kind || part.kind == ValueKind::Unknown {
        Ok(())
    } else {
        Err(FilterError::Mismatch(format!("{need}, but {}", part.described())))
    }
}

/// Whether two kinds can be compared at all.
fn comparable(relation: Relation, a: &Expression, b: &Expression) -> Result<(), String> {
    let ordered = !matches!(relation, Relation::Equal | Relation::NotEqual);
    match (a.kind, b.kind) {
        (ValueKind::Truth, _) | (_, ValueKind::Truth) if ordered => {
            Err("a condition cannot be ordered; `a < x < b` is written `a < x && x < b`".to_owned())
        }
        (ValueKind::Unknown, _) | (_, ValueKind::Unknown) => Ok(()),
        (a, b) if a == b => Ok(()),
        _ => Err(format!("{} and {}; they cannot be compared", a.described(), b.described())),
    }
}
