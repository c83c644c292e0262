//! Rows by an expression: `mu > 0.3 && mesh == 64 && status == "certified"`.
//!
//! The grammar is that of the Common Expression Language (CEL, <https://cel.dev>), parsed by the `cel` crate. The
//! meaning is given here rather than by CEL's own interpreter, because a table of measurements needs it otherwise in
//! four places: integers and numbers mix in arithmetic, a column may have a dotted name (`friction.mu`), comparing a
//! number with text is refused instead of being false, and a missing value makes a comparison unknown.

use std::borrow::Cow;
use std::cmp::Ordering;

use cel::common::ast::{CallExpr, Expr, LiteralValue, operators};
use thiserror::Error;

use crate::table::{Cell, Table, UnknownColumn, compare_exactly};

/// Why a filter was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FilterError {
    /// There is no expression.
    #[error("the expression is empty; write a condition such as `mu > 0.3 && mesh == 64`")]
    Empty,
    /// The expression is longer than any that a person writes.
    #[error("the expression has {length} bytes; at most {} are allowed", LONGEST)]
    TooLong {
        /// Its length in bytes.
        length: usize,
    },
    /// The expression does not follow the grammar.
    #[error("{message} at character {position}\n  {expression}\n  {caret:>position$}{hint}", caret = '^')]
    Syntax {
        /// What was wrong.
        message: String,
        /// The whole expression, on one line.
        expression: String,
        /// Where, counted in characters from 1.
        position: usize,
        /// What would be right, if that can be guessed: empty, or a line that begins with a line end.
        hint: String,
    },
    /// A name is not that of a column.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
    /// Two values of different kinds meet, or a value of the wrong kind.
    #[error("{0}")]
    Mismatch(String),
    /// The grammar allows it, filters do not.
    #[error(
        "{0} cannot be used in a filter; there are == != < <= > >=, && || !, + - * / %, ?:, in [..], abs(), and contains, \
         startsWith, endsWith on text"
    )]
    Unsupported(String),
}

/// The longest expression, in bytes.
const LONGEST: usize = 4096;

/// What kind of value a part of the expression has; `Unknown` for a column that mixes kinds or has no values at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number,
    Text,
    Truth,
    Unknown,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Kind::Number => "a number",
            Kind::Text => "text",
            Kind::Truth => "a condition",
            Kind::Unknown => "nothing known",
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
enum Value<'a> {
    Integer(i64),
    Number(f64),
    Text(Cow<'a, str>),
    Truth(bool),
    Missing,
}

impl Value<'_> {
    fn kind(&self) -> Kind {
        match self {
            Value::Integer(_) | Value::Number(_) => Kind::Number,
            Value::Text(_) => Kind::Text,
            Value::Truth(_) => Kind::Truth,
            Value::Missing => Kind::Unknown,
        }
    }
}

#[derive(Debug, Clone, Copy)]
enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

#[derive(Debug, Clone, Copy)]
enum Arithmetic {
    Plus,
    Minus,
    Times,
    Over,
    Modulo,
}

#[derive(Debug, Clone, Copy)]
enum TextTest {
    Contains,
    StartsWith,
    EndsWith,
}

/// A compiled expression, with its column names resolved. `String`s are how the part was written, for messages.
#[derive(Debug)]
enum Node {
    Constant(Value<'static>),
    Column(usize),
    Not(Box<Part>),
    And(Box<Part>, Box<Part>),
    Or(Box<Part>, Box<Part>),
    Compare(Relation, Box<Part>, Box<Part>),
    IsMissing(Box<Part>),
    Arithmetic(Arithmetic, Box<Part>, Box<Part>),
    Absolute(Box<Part>),
    In(Box<Part>, Vec<Part>),
    Choose(Box<Part>, Box<Part>, Box<Part>),
    Text(TextTest, Box<Part>, Box<Part>),
}

#[derive(Debug)]
struct Part {
    node: Node,
    kind: Kind,
    /// How a message calls it: `column `mu`` or `"text"`.
    label: String,
}

impl Part {
    fn described(&self) -> String {
        format!("{} is {}", self.label, self.kind.name())
    }
}

type Compiled = Result<Part, FilterError>;

impl Table {
    /// The rows for which an expression holds, in their order.
    ///
    /// Columns are called by their names, values are SI. Integers and numbers compare and compute with each other; a
    /// quotient is never rounded. Text stands in `"…"` or `'…'` and is compared exactly. Conditions are joined by
    /// `&&`, `||`, `!` and parentheses; there are also `in [1, 2]`, `a ? b : c`, `abs(x)`, `+ - * / %`, and
    /// `text.contains("…")`, `.startsWith`, `.endsWith`.
    ///
    /// A missing value (or NaN) makes whatever is computed from it unknown, as in SQL: neither `x > 1` nor `!(x > 1)`
    /// nor `x != 1` selects a row without `x`, but `x > 1 || y > 1` does if `y > 1`. `x == null` and `x != null`
    /// ask for it.
    ///
    /// # Errors
    /// [`FilterError`]; also for a comparison of a number with text, which could never hold.
    ///
    /// ```
    /// use report::{Cell, Column, Table};
    /// let table = Table::new(
    ///     vec![Column::new("mu", "1"), Column::new("mesh", "")],
    ///     vec![vec![0.1.into(), 64.into()], vec![0.4.into(), 64.into()], vec![0.5.into(), Cell::Missing]],
    /// )?;
    /// assert_eq!(table.filter("mu > 0.3 && mesh == 64")?.rows(), &[vec![0.4.into(), 64.into()]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn filter(&self, expression: &str) -> Result<Table, FilterError> {
        let condition = compile(expression, self)?;
        let keep = self
            .rows()
            .iter()
            .enumerate()
            .map(|(i, row)| {
                match evaluate(&condition, row) {
                    Ok(value) => truth(&condition, &value).map(|t| t == Some(true)),
                    Err(error) => Err(error),
                }
                .map_err(|message| FilterError::Mismatch(format!("{message} (in row {})", i + 1)))
            })
            .collect::<Result<Vec<bool>, _>>()?;
        Ok(self.keep(&keep))
    }
}

fn compile(expression: &str, table: &Table) -> Compiled {
    if expression.trim().is_empty() {
        return Err(FilterError::Empty);
    }
    if expression.len() > LONGEST {
        return Err(FilterError::TooLong { length: expression.len() });
    }
    let tree = cel::parser::Parser::new().parse(expression).map_err(|errors| syntax_error(expression, &errors))?;
    let condition = part(&tree.expr, table)?;
    expect(&condition, Kind::Truth, "a filter must be a condition such as `mu > 0.3`")?;
    Ok(condition)
}

fn syntax_error(expression: &str, errors: &cel::ParseErrors) -> FilterError {
    let flat: String = expression.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let first = errors.errors.first();
    // CEL counts lines from 1 and columns from 0 or 1, in characters.
    let (line, column) = first.map_or((1, 1), |e| e.pos);
    let before: usize = expression.split('\n').take(usize::try_from(line - 1).unwrap_or(0)).map(|l| l.chars().count() + 1).sum();
    let position = (before + usize::try_from(column).unwrap_or(0)).clamp(1, flat.chars().count() + 1);
    let message = first.map_or("syntax error", |e| e.msg.as_str());
    let message = message.strip_prefix("Syntax error: ").unwrap_or(message);
    // The list of every token that could have stood there helps nobody, nor do the words of a parser.
    let mut message = message.split(" expecting ").next().unwrap_or(message).replace(['\n', '\r'], " ");
    for (theirs, ours) in [
        ("token recognition error at:", "unexpected"),
        ("mismatched input", "unexpected"),
        ("extraneous input", "unexpected"),
        ("no viable alternative at input", "unexpected"),
        ("'<EOF>'", "end of the expression"),
    ] {
        message = message.replace(theirs, ours);
    }
    FilterError::Syntax { message, position, hint: hint(&flat), expression: flat }
}

/// What people write who know another language.
fn hint(expression: &str) -> String {
    let padded = format!(" {} ", expression.to_lowercase());
    let single_equals = expression
        .char_indices()
        .any(|(i, c)| c == '=' && !expression[..i].ends_with(['=', '!', '<', '>']) && !expression[i + 1..].starts_with('='));
    let advice = if ["=>", "=<"].iter().any(|wrong| expression.contains(wrong)) {
        "at least, at most are written >=, <="
    } else if single_equals {
        "equality is written =="
    } else if [" and ", " or ", " not "].iter().any(|word| padded.contains(word)) {
        "and, or, not are written &&, ||, !"
    } else if expression.replace("&&", "").contains('&') || expression.replace("||", "").contains('|') {
        "and, or are written &&, ||"
    } else {
        return String::new();
    };
    format!("\n  {advice}")
}

/// The name that an expression spells: `mu`, `friction.mu`, `layers[0].poisson`.
fn spelled(expression: &Expr) -> Option<String> {
    match expression {
        Expr::Ident(name) => Some(name.clone()),
        Expr::Select(select) if !select.test => Some(format!("{}.{}", spelled(&select.operand.expr)?, select.field)),
        Expr::Call(CallExpr { func_name, target: None, args }) if func_name == operators::INDEX => match args.as_slice() {
            [operand, index] => match &index.expr {
                Expr::Literal(LiteralValue::Int(i)) => Some(format!("{}[{}]", spelled(&operand.expr)?, i.inner())),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

fn part(expression: &Expr, table: &Table) -> Compiled {
    if let Some(name) = spelled(expression) {
        let index = table.column(&name)?;
        return Ok(Part { node: Node::Column(index), kind: column_kind(table, index), label: format!("column `{name}`") });
    }
    match expression {
        Expr::Literal(literal) => constant(literal),
        Expr::Call(call) => self::call(call, table),
        Expr::List(_) => Err(FilterError::Unsupported("a list other than after `in`".to_owned())),
        Expr::Map(_) | Expr::Struct(_) => Err(FilterError::Unsupported("`{…}`".to_owned())),
        Expr::Select(select) => Err(FilterError::Unsupported(format!("`.{}` of a value", select.field))),
        Expr::Comprehension(_) => Err(FilterError::Unsupported("a macro such as all() or exists()".to_owned())),
        Expr::Unspecified | Expr::Ident(_) => Err(FilterError::Empty),
    }
}

fn column_kind(table: &Table, index: usize) -> Kind {
    let mut kinds = table.cells(index).filter_map(|cell| match cell {
        Cell::Number(_) | Cell::Integer(_) => Some(Kind::Number),
        Cell::Text(_) => Some(Kind::Text),
        Cell::Missing => None,
    });
    match kinds.next() {
        Some(first) if kinds.all(|kind| kind == first) => first,
        _ => Kind::Unknown,
    }
}

fn constant(literal: &LiteralValue) -> Compiled {
    let (value, label) = match literal {
        LiteralValue::Boolean(b) => (Value::Truth(*b.inner()), b.inner().to_string()),
        LiteralValue::Int(i) => (Value::Integer(*i.inner()), i.inner().to_string()),
        LiteralValue::UInt(u) => match i64::try_from(*u.inner()) {
            Ok(i) => (Value::Integer(i), i.to_string()),
            Err(_) => (Value::Number(*u.inner() as f64), u.inner().to_string()),
        },
        LiteralValue::Double(x) => (Value::Number(*x.inner()), x.inner().to_string()),
        LiteralValue::String(s) => (Value::Text(Cow::Owned(s.inner().to_owned())), format!("{:?}", s.inner())),
        LiteralValue::Null => (Value::Missing, "null".to_owned()),
        LiteralValue::Bytes(_) => return Err(FilterError::Unsupported("b\"…\"".to_owned())),
    };
    Ok(Part { kind: value.kind(), node: Node::Constant(value), label })
}

fn call(call: &CallExpr, table: &Table) -> Compiled {
    let argument = |i: usize| -> Result<Box<Part>, FilterError> {
        match call.args.get(i) {
            Some(argument) => Ok(Box::new(part(&argument.expr, table)?)),
            None => Err(FilterError::Mismatch(format!("`{}` lacks an argument", call.func_name))),
        }
    };
    let condition = |node| Ok(Part { node, kind: Kind::Truth, label: "a comparison".to_owned() });
    let number = |node| Ok(Part { node, kind: Kind::Number, label: "the result of a calculation".to_owned() });

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
        expect(&text, Kind::Text, &needs)?;
        expect(&pattern, Kind::Text, &needs)?;
        return condition(Node::Text(test, text, pattern));
    }

    let compare = |relation| {
        let (a, b) = (argument(0)?, argument(1)?);
        let is_null = |p: &Part| matches!(p.node, Node::Constant(Value::Missing));
        let node = match (relation, is_null(&a), is_null(&b)) {
            (Relation::Equal, _, true) => Node::IsMissing(a),
            (Relation::Equal, true, _) => Node::IsMissing(b),
            (Relation::NotEqual, true, _) | (Relation::NotEqual, _, true) => {
                let operand = if is_null(&b) { a } else { b };
                Node::Not(Box::new(condition(Node::IsMissing(operand))?))
            }
            (_, false, false) => {
                comparable(relation, &a, &b).map_err(FilterError::Mismatch)?;
                Node::Compare(relation, a, b)
            }
            _ => return Err(FilterError::Mismatch("null can only be compared by == and !=".to_owned())),
        };
        condition(node)
    };
    let calculate = |operation| {
        let (a, b) = (argument(0)?, argument(1)?);
        for operand in [&a, &b] {
            expect(operand, Kind::Number, "arithmetic needs numbers")?;
        }
        number(Node::Arithmetic(operation, a, b))
    };
    let logical = |join: fn(Box<Part>, Box<Part>) -> Node, symbol: &str| {
        let (a, b) = (argument(0)?, argument(1)?);
        for operand in [&a, &b] {
            expect(operand, Kind::Truth, &format!("{symbol} joins conditions"))?;
        }
        condition(join(a, b))
    };
    match call.func_name.as_str() {
        operators::LOGICAL_AND => logical(Node::And, "&&"),
        operators::LOGICAL_OR => logical(Node::Or, "||"),
        operators::LOGICAL_NOT => {
            let operand = argument(0)?;
            expect(&operand, Kind::Truth, "! needs a condition")?;
            condition(Node::Not(operand))
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
            expect(&operand, Kind::Number, "- needs a number")?;
            let zero = Part { node: Node::Constant(Value::Integer(0)), kind: Kind::Number, label: "0".to_owned() };
            number(Node::Arithmetic(Arithmetic::Minus, Box::new(zero), operand))
        }
        "abs" if call.args.len() == 1 => {
            let operand = argument(0)?;
            expect(&operand, Kind::Number, "abs() needs a number")?;
            number(Node::Absolute(operand))
        }
        operators::CONDITIONAL => {
            let (condition, yes, no) = (argument(0)?, argument(1)?, argument(2)?);
            expect(&condition, Kind::Truth, "?: needs a condition")?;
            let kind = match (yes.kind, no.kind) {
                (a, b) if a == b => a,
                (Kind::Unknown, other) | (other, Kind::Unknown) => other,
                _ => {
                    let message = format!("both sides of `:` must be alike: {}, {}", yes.described(), no.described());
                    return Err(FilterError::Mismatch(message));
                }
            };
            Ok(Part { node: Node::Choose(condition, yes, no), kind, label: "the result of ?:".to_owned() })
        }
        operators::IN => {
            let value = argument(0)?;
            let Some(Expr::List(list)) = call.args.get(1).map(|a| &a.expr) else {
                return Err(FilterError::Mismatch("`in` needs a list such as `mesh in [32, 64]`".to_owned()));
            };
            let mut members = Vec::new();
            for element in &list.elements {
                let member = part(&element.expr, table)?;
                comparable(Relation::Equal, &value, &member).map_err(FilterError::Mismatch)?;
                members.push(member);
            }
            condition(Node::In(value, members))
        }
        other => Err(FilterError::Unsupported(format!("`{other}()`"))),
    }
}

fn expect(part: &Part, kind: Kind, need: &str) -> Result<(), FilterError> {
    if part.kind == kind || part.kind == Kind::Unknown {
        Ok(())
    } else {
        Err(FilterError::Mismatch(format!("{need}, but {}", part.described())))
    }
}

/// Whether two kinds can be compared at all.
fn comparable(relation: Relation, a: &Part, b: &Part) -> Result<(), String> {
    let ordered = !matches!(relation, Relation::Equal | Relation::NotEqual);
    match (a.kind, b.kind) {
        (Kind::Truth, _) | (_, Kind::Truth) if ordered => {
            Err("a condition cannot be ordered; `a < x < b` is written `a < x && x < b`".to_owned())
        }
        (Kind::Unknown, _) | (_, Kind::Unknown) => Ok(()),
        (a, b) if a == b => Ok(()),
        _ => Err(format!("{} and {}; they cannot be compared", a.described(), b.described())),
    }
}

fn evaluate<'a>(part: &'a Part, row: &'a [Cell]) -> Result<Value<'a>, String> {
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
        Node::Compare(relation, a, b) => logical(holds(*relation, a, &evaluate(a, row)?, b, &evaluate(b, row)?)?),
        Node::IsMissing(a) => Ok(Value::Truth(evaluate(a, row)? == Value::Missing)),
        Node::Arithmetic(operation, a, b) => {
            let (Some(x), Some(y)) = (number(a, &evaluate(a, row)?)?, number(b, &evaluate(b, row)?)?) else {
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
        Node::Absolute(a) => Ok(number(a, &evaluate(a, row)?)?.map_or(Value::Missing, |x| Value::Number(x.abs()))),
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
            (a, b) => Err(format!("text was needed, but there are {} and {}", a.kind().name(), b.kind().name())),
        },
    }
}

fn truth(part: &Part, value: &Value<'_>) -> Result<Option<bool>, String> {
    match value {
        Value::Truth(t) => Ok(Some(*t)),
        Value::Missing => Ok(None),
        other => Err(format!("a condition was needed, but {} is {}", part.label, other.kind().name())),
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

fn holds(relation: Relation, a: &Part, x: &Value<'_>, b: &Part, y: &Value<'_>) -> Result<Option<bool>, String> {
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
            return Err(format!("{} is {x} and {} is {y}; they cannot be compared", a.label, b.label));
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
