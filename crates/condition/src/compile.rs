//! The way from the text of an expression to a tree whose names are resolved and whose kinds of
//! values fit.

use std::borrow::Cow;

use cel::common::ast::{CallExpr, Expr, LiteralValue, operators};

use crate::error::{FilterError, LONGEST, UnknownColumn};
use crate::syntax::syntax_error;
use crate::tree::{
    Arithmetic, Expression, ExpressionNode, FilterValue, Relation, TextTest, ValueKind,
};

type Compiled = Result<Expression, FilterError>;
/// An operand of a node that is not yet built.
type CompiledOperand = Result<Box<Expression>, FilterError>;

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
    let tree =
        cel::parser::Parser::new().parse(text).map_err(|errors| syntax_error(text, &errors))?;
    let condition = expression(&tree.expr, names)?;
    expect(&condition, ValueKind::Truth, "a filter must be a condition such as `mu > 0.3`")?;
    Ok(condition)
}

/// Returns the name that an expression spells: `mu`, `friction.mu`, `layers[0].poisson`.
fn spelled(tree: &Expr) -> Option<String> {
    match tree {
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

/// Compiles an expression or one of its operands.
fn expression(tree: &Expr, names: &dyn ConditionNames) -> Compiled {
    if let Some(name) = spelled(tree) {
        let index = names.find(&name)?;
        return Ok(Expression {
            node: ExpressionNode::Column(index),
            kind: names.kind(index),
            label: format!("column `{name}`"),
        });
    }
    match tree {
        Expr::Literal(literal) => constant(literal),
        Expr::Call(call) => Call { call, names }.compiled(),
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

/// Completes a node that is a condition.
fn condition(node: ExpressionNode) -> Expression {
    Expression { node, kind: ValueKind::Truth, label: "a comparison".to_owned() }
}

/// Completes a node that is a number.
fn number(node: ExpressionNode) -> Expression {
    Expression { node, kind: ValueKind::Number, label: "the result of a calculation".to_owned() }
}

/// An operator or a function with its arguments, which are compiled one after the other: the first
/// that is wrong is the one that the message names.
struct Call<'a> {
    call: &'a CallExpr,
    names: &'a dyn ConditionNames,
}

impl Call<'_> {
    fn compiled(&self) -> Compiled {
        if let Some(target) = &self.call.target {
            return self.text_test(&target.expr);
        }
        match self.call.func_name.as_str() {
            operators::LOGICAL_AND => self.logical(ExpressionNode::And, "&&"),
            operators::LOGICAL_OR => self.logical(ExpressionNode::Or, "||"),
            operators::LOGICAL_NOT => {
                let operand = self.argument_of_kind(0, ValueKind::Truth, "! needs a condition")?;
                Ok(condition(ExpressionNode::Not(operand)))
            }
            operators::EQUALS => self.comparison(Relation::Equal),
            operators::NOT_EQUALS => self.comparison(Relation::NotEqual),
            operators::LESS => self.comparison(Relation::Less),
            operators::LESS_EQUALS => self.comparison(Relation::LessOrEqual),
            operators::GREATER => self.comparison(Relation::Greater),
            operators::GREATER_EQUALS => self.comparison(Relation::GreaterOrEqual),
            operators::ADD => self.calculation(Arithmetic::Plus),
            operators::SUBSTRACT => self.calculation(Arithmetic::Minus),
            operators::MULTIPLY => self.calculation(Arithmetic::Times),
            operators::DIVIDE => self.calculation(Arithmetic::Over),
            operators::MODULO => self.calculation(Arithmetic::Modulo),
            operators::NEGATE => self.negation(),
            "abs" => self.absolute(),
            operators::CONDITIONAL => self.choice(),
            operators::IN => self.membership(),
            operators::INDEX => Err(FilterError::Unsupported(
                "`[…]` with anything but a number of an entry".to_owned(),
            )),
            other => Err(FilterError::Unsupported(format!("`{other}()`"))),
        }
    }

    fn argument(&self, index: usize) -> CompiledOperand {
        match self.call.args.get(index) {
            Some(argument) => Ok(Box::new(expression(&argument.expr, self.names)?)),
            None => {
                Err(FilterError::Mismatch(format!("`{}` lacks an argument", self.call.func_name)))
            }
        }
    }

    /// Compiles an argument that must be of a kind; `need` begins the message if it is not.
    fn argument_of_kind(&self, index: usize, kind: ValueKind, need: &str) -> CompiledOperand {
        let argument = self.argument(index)?;
        expect(&argument, kind, need)?;
        Ok(argument)
    }

    /// Compiles `text.contains("…")` and the like, where `target` is the text.
    fn text_test(&self, target: &Expr) -> Compiled {
        let test = match self.call.func_name.as_str() {
            "contains" => TextTest::Contains,
            "startsWith" => TextTest::StartsWith,
            "endsWith" => TextTest::EndsWith,
            other => return Err(FilterError::Unsupported(format!("`.{other}()`"))),
        };
        if self.call.args.len() != 1 {
            let message = format!("`.{}` takes one text", self.call.func_name);
            return Err(FilterError::Mismatch(message));
        }
        let text = Box::new(expression(target, self.names)?);
        let pattern = self.argument(0)?;
        let need = format!("`.{}` needs text", self.call.func_name);
        expect(&text, ValueKind::Text, &need)?;
        expect(&pattern, ValueKind::Text, &need)?;
        Ok(condition(ExpressionNode::Text(test, text, pattern)))
    }

    /// Compiles a comparison; one with `null` asks for missing values.
    fn comparison(&self, relation: Relation) -> Compiled {
        let (a, b) = (self.argument(0)?, self.argument(1)?);
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
                return Err(FilterError::Mismatch(
                    "null can only be compared by == and !=".to_owned(),
                ));
            }
        };
        Ok(condition(node))
    }

    fn calculation(&self, operation: Arithmetic) -> Compiled {
        let (a, b) = (self.argument(0)?, self.argument(1)?);
        for operand in [&a, &b] {
            expect(operand, ValueKind::Number, "arithmetic needs numbers")?;
        }
        Ok(number(ExpressionNode::Arithmetic(operation, a, b)))
    }

    fn logical(
        &self,
        join: fn(Box<Expression>, Box<Expression>) -> ExpressionNode,
        symbol: &str,
    ) -> Compiled {
        let (a, b) = (self.argument(0)?, self.argument(1)?);
        for operand in [&a, &b] {
            expect(operand, ValueKind::Truth, &format!("{symbol} joins conditions"))?;
        }
        Ok(condition(join(a, b)))
    }

    /// Compiles `-x` as `0 - x`.
    fn negation(&self) -> Compiled {
        let operand = self.argument_of_kind(0, ValueKind::Number, "- needs a number")?;
        let zero = Expression {
            node: ExpressionNode::Constant(FilterValue::Integer(0)),
            kind: ValueKind::Number,
            label: "0".to_owned(),
        };
        Ok(number(ExpressionNode::Arithmetic(Arithmetic::Minus, Box::new(zero), operand)))
    }

    fn absolute(&self) -> Compiled {
        if self.call.args.len() != 1 {
            return Err(FilterError::Mismatch("`abs` takes one number".to_owned()));
        }
        let operand = self.argument_of_kind(0, ValueKind::Number, "abs() needs a number")?;
        Ok(number(ExpressionNode::Absolute(operand)))
    }

    /// Compiles `condition ? yes : no`.
    fn choice(&self) -> Compiled {
        let (condition, yes, no) = (self.argument(0)?, self.argument(1)?, self.argument(2)?);
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

    /// Compiles `value in [a, b]`.
    fn membership(&self) -> Compiled {
        let value = self.argument(0)?;
        let Some(Expr::List(list)) = self.call.args.get(1).map(|argument| &argument.expr) else {
            return Err(FilterError::Mismatch(
                "`in` needs a list such as `mesh in [32, 64]`".to_owned(),
            ));
        };
        let mut members = Vec::new();
        for element in &list.elements {
            let member = expression(&element.expr, self.names)?;
            check_comparable(Relation::Equal, &value, &member)?;
            members.push(member);
        }
        Ok(condition(ExpressionNode::In(value, members)))
    }
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
