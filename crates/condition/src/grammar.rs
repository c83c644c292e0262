//! The grammar: from the text of an expression to a tree of its operators, names and values.
//!
//! It is that of CEL, <https://github.com/google/cel-spec/blob/master/doc/langdef.md>, as far as a
//! condition can have a meaning; what CEL has besides is refused by its name.

use crate::error::FilterError;
use crate::syntax::syntax_error;
use crate::token::{PlacedToken, Token, token_at};
use crate::tree::{Arithmetic, FilterValue, Relation};

#[cfg(test)]
mod tests;

/// The number of expressions inside each other that are read.
const DEEPEST: usize = 96;
/// The number of operators and methods of an expression that are read. Each may stand on top of all
/// those before, and what goes through the tree needs a piece of the stack for each.
const MOST_OPERATORS: usize = 512;
/// The names that CEL keeps for other languages.
const RESERVED: [&str; 17] = [
    "as",
    "break",
    "const",
    "continue",
    "else",
    "for",
    "function",
    "if",
    "import",
    "let",
    "loop",
    "package",
    "namespace",
    "return",
    "var",
    "void",
    "while",
];
/// The functions that stand for loops over lists.
const MACROS: [&str; 5] = ["all", "exists", "exists_one", "map", "filter"];

/// An operator between two operands.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InfixOperator {
    Or,
    And,
    Compare(Relation),
    In,
    Calculate(Arithmetic),
}

impl InfixOperator {
    /// Returns the operator that a sign stands for, with how tightly it binds.
    fn of(sign: &str) -> Option<(InfixOperator, u8)> {
        let compare = |relation| (InfixOperator::Compare(relation), 3);
        let add = |operation| (InfixOperator::Calculate(operation), 4);
        let multiply = |operation| (InfixOperator::Calculate(operation), 5);
        Some(match sign {
            "||" => (InfixOperator::Or, 1),
            "&&" => (InfixOperator::And, 2),
            "==" => compare(Relation::Equal),
            "!=" => compare(Relation::NotEqual),
            "<" => compare(Relation::Less),
            "<=" => compare(Relation::LessOrEqual),
            ">" => compare(Relation::Greater),
            ">=" => compare(Relation::GreaterOrEqual),
            "in" => (InfixOperator::In, 3),
            "+" => add(Arithmetic::Plus),
            "-" => add(Arithmetic::Minus),
            "*" => multiply(Arithmetic::Times),
            "/" => multiply(Arithmetic::Over),
            "%" => multiply(Arithmetic::Modulo),
            _ => return None,
        })
    }
}

/// An expression as it is written, whose names are not yet known.
#[derive(Clone, Debug)]
pub(crate) enum Written {
    Constant(FilterValue<'static>),
    /// A name with its dots and indices: `mu`, `friction.mu`, `layers[0].poisson`.
    Name(String),
    Not(Box<Written>),
    Negated(Box<Written>),
    Infix(InfixOperator, Box<Written>, Box<Written>),
    /// The condition, the value if it holds, and the value if it does not.
    Choice(Box<[Written; 3]>),
    List(Vec<Written>),
    /// A function with its arguments.
    Call(String, Vec<Written>),
    /// A function behind the value that it is called on, which comes first, with its arguments.
    Method(Box<Written>, String, Vec<Written>),
    /// A construct that CEL has and conditions do not, in the words of the message.
    Foreign(String),
}

/// Reads an expression.
///
/// # Errors
/// [`FilterError::Syntax`], if the text does not follow the grammar.
pub(crate) fn read(text: &str) -> Result<Written, FilterError> {
    let mut reader = GrammarReader { text, next: token_at(text, 0)?, depth: 0, operators: 0 };
    let whole = reader.expression()?;
    match reader.next.token {
        Token::End => Ok(whole),
        _ => Err(reader.unexpected()),
    }
}

/// An expression as far as it is read.
struct GrammarReader<'t> {
    text: &'t str,
    /// The word or sign that comes next.
    next: PlacedToken<'t>,
    depth: usize,
    /// The number of operators and methods so far.
    operators: usize,
}

impl<'t> GrammarReader<'t> {
    /// Takes the word or sign that comes next.
    fn take(&mut self) -> Result<Token<'t>, FilterError> {
        let behind = token_at(self.text, self.next.end)?;
        Ok(std::mem::replace(&mut self.next, behind).token)
    }

    /// Takes a sign if it comes next.
    fn takes(&mut self, sign: &str) -> Result<bool, FilterError> {
        let is_next = self.is_next(sign);
        if is_next {
            self.take()?;
        }
        Ok(is_next)
    }

    /// Says whether a sign comes next.
    fn is_next(&self, sign: &str) -> bool {
        matches!(self.next.token, Token::Sign(next) if next == sign)
    }

    /// Takes a sign that must come next.
    fn needs(&mut self, sign: &str) -> Result<(), FilterError> {
        if self.takes(sign)? {
            return Ok(());
        }
        Err(match self.next.token {
            Token::End => self.fault(&format!("missing '{sign}' at end of the expression")),
            _ => self.unexpected(),
        })
    }

    /// Makes the fault of what comes next.
    fn fault(&self, message: &str) -> FilterError {
        syntax_error(self.text, self.next.start, message)
    }

    fn unexpected(&self) -> FilterError {
        match &self.text[self.next.start..self.next.end] {
            "" => self.fault("unexpected end of the expression"),
            next => self.fault(&format!("unexpected '{next}'")),
        }
    }

    fn expression(&mut self) -> Result<Written, FilterError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.fault("too many brackets inside each other"));
        }
        let mut read = self.infix(1)?;
        if self.takes("?")? {
            let yes = self.infix(1)?;
            self.needs(":")?;
            let no = self.expression()?;
            read = Written::Choice(Box::new([read, yes, no]));
        }
        self.depth -= 1;
        Ok(read)
    }

    /// Counts an operator or a method that comes next.
    fn count_operator(&mut self) -> Result<(), FilterError> {
        self.operators += 1;
        if self.operators > MOST_OPERATORS {
            return Err(self.fault(&format!(
                "more than {MOST_OPERATORS} operators (`mesh in [16, 32]` stands for many `==`)"
            )));
        }
        Ok(())
    }

    /// Reads operands that operators join which bind at least so tightly. Operators that bind alike
    /// are taken from the left.
    fn infix(&mut self, least: u8) -> Result<Written, FilterError> {
        let mut left = self.prefixed()?;
        while let Token::Sign(sign) = self.next.token
            && let Some((operator, binding)) = InfixOperator::of(sign)
            && binding >= least
        {
            self.count_operator()?;
            self.take()?;
            let right = self.infix(binding + 1)?;
            left = Written::Infix(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    /// Reads a value with the signs in front of it. Two of one sign cancel, and `!` and `-` do not
    /// mix.
    fn prefixed(&mut self) -> Result<Written, FilterError> {
        let nots = self.count("!")?;
        let minuses = if nots == 0 { self.count("-")? } else { 0 };
        // One sign in front of a number belongs to the number.
        let is_signed =
            minuses == 1 && matches!(self.next.token, Token::Whole(_) | Token::Fraction(_));
        let first = if is_signed { self.constant("-")? } else { self.primary()? };
        let value = self.member(first)?;
        Ok(match (nots % 2, minuses % 2) {
            (1, _) => Written::Not(Box::new(value)),
            (_, 1) if !is_signed => Written::Negated(Box::new(value)),
            _ => value,
        })
    }

    /// Takes all of a sign that come next, and returns how many there were.
    fn count(&mut self, sign: &str) -> Result<usize, FilterError> {
        let mut count = 0;
        while self.takes(sign)? {
            count += 1;
        }
        Ok(count)
    }

    /// Reads the parts, entries and functions behind a value.
    fn member(&mut self, mut value: Written) -> Result<Written, FilterError> {
        loop {
            value = if self.takes(".")? {
                let name = self.name()?;
                if self.is_next("(") {
                    self.count_operator()?;
                    self.take()?;
                    let arguments = self.list(")", false)?;
                    match MACROS.contains(&name) {
                        true => Written::Foreign("a macro such as all() or exists()".to_owned()),
                        false => Written::Method(Box::new(value), name.to_owned(), arguments),
                    }
                } else if let Written::Name(whole) = value {
                    Written::Name(format!("{whole}.{name}"))
                } else {
                    Written::Foreign(format!("`.{name}` of a value"))
                }
            } else if self.takes("[")? {
                let index = self.expression()?;
                self.needs("]")?;
                match (value, index) {
                    (Written::Name(name), Written::Constant(FilterValue::Integer(i))) => {
                        Written::Name(format!("{name}[{i}]"))
                    }
                    _ => {
                        Written::Foreign("`[…]` with anything but a number of an entry".to_owned())
                    }
                }
            } else {
                return Ok(value);
            };
        }
    }

    /// Takes a name that must come next.
    fn name(&mut self) -> Result<&'t str, FilterError> {
        let Token::Name(name) = self.next.token else { return Err(self.unexpected()) };
        self.take()?;
        Ok(name)
    }

    /// Reads expressions up to a bracket, with commas between them; `may_trail` says whether one
    /// may stand behind the last.
    fn list(&mut self, close: &str, may_trail: bool) -> Result<Vec<Written>, FilterError> {
        let mut elements = Vec::new();
        while elements.is_empty() && !self.is_next(close) || self.takes(",")? {
            if may_trail && !elements.is_empty() && self.is_next(close) {
                break;
            }
            elements.push(self.expression()?);
        }
        self.needs(close)?;
        Ok(elements)
    }

    fn primary(&mut self) -> Result<Written, FilterError> {
        if self.takes("(")? {
            let inner = self.expression()?;
            self.needs(")")?;
            return Ok(inner);
        }
        if self.takes("[")? {
            return Ok(Written::List(self.list("]", true)?));
        }
        if self.is_next("{") {
            return Err(FilterError::Unsupported("`{…}`".to_owned()));
        }
        if self.takes(".")? {
            return self.named(".");
        }
        match self.next.token {
            Token::Name(_) => self.named(""),
            _ => self.constant(""),
        }
    }

    /// Reads a name, which may be that of a function; `dot` stands in front of it.
    fn named(&mut self, dot: &str) -> Result<Written, FilterError> {
        if let Token::Name(name) = self.next.token
            && RESERVED.contains(&name)
        {
            return Err(self.fault(&format!("reserved identifier: {dot}{name}")));
        }
        let name = format!("{dot}{}", self.name()?);
        if self.is_next("{") {
            return Err(FilterError::Unsupported("`{…}`".to_owned()));
        }
        if self.takes("(")? {
            return Ok(Written::Call(name, self.list(")", false)?));
        }
        Ok(Written::Name(name))
    }

    /// Reads a value that stands for itself; `sign` stood in front of it.
    fn constant(&mut self, sign: &str) -> Result<Written, FilterError> {
        let value = match &self.next.token {
            Token::Whole(digits) => whole(sign, digits),
            Token::Unsigned(digits) => unsigned(digits),
            Token::Fraction(digits) => fraction(sign, digits),
            Token::Text(text) => Some(FilterValue::Text(text.clone().into())),
            Token::Sign("true") => Some(FilterValue::Truth(true)),
            Token::Sign("false") => Some(FilterValue::Truth(false)),
            Token::Sign("null") => Some(FilterValue::Missing),
            Token::Bytes => {
                self.take()?;
                return Ok(Written::Foreign("b\"…\"".to_owned()));
            }
            Token::End | Token::Sign(_) | Token::Name(_) => return Err(self.unexpected()),
        };
        let value = value.ok_or_else(|| self.fault("a number that is too large"))?;
        self.take()?;
        Ok(Written::Constant(value))
    }
}

/// Returns the digits of a whole number without their prefix, and the radix that it says.
fn radix(digits: &str) -> (&str, u32) {
    digits.strip_prefix("0x").map_or((digits, 10), |hexadecimal| (hexadecimal, 16))
}

/// Returns a whole number with its sign, unless it is too large.
fn whole(sign: &str, digits: &str) -> Option<FilterValue<'static>> {
    let (digits, radix) = radix(digits);
    i64::from_str_radix(&format!("{sign}{digits}"), radix).ok().map(FilterValue::Integer)
}

/// Returns a whole number that was marked as unsigned, unless it is too large.
fn unsigned(digits: &str) -> Option<FilterValue<'static>> {
    let (digits, radix) = radix(digits);
    let number = u64::from_str_radix(digits, radix).ok()?;
    Some(match i64::try_from(number) {
        Ok(i) => FilterValue::Integer(i),
        Err(_) => FilterValue::Number(number as f64),
    })
}

/// Returns a number with its sign, unless it is too large.
fn fraction(sign: &str, digits: &str) -> Option<FilterValue<'static>> {
    let number: f64 = format!("{sign}{digits}").parse().ok()?;
    number.is_finite().then_some(FilterValue::Number(number))
}
