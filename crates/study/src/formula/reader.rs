//! The reader of formulas, which checks their units.

use std::f64::consts::PI;

use super::node::{FormulaNode, FormulaOperator, MathFunction, is_small_whole};
use super::unit_powers::UnitPowers;
use crate::key::Key;
use crate::quantity::Quantity;
use crate::sheet::Sheet;
use crate::units::{leading_number, unit_value};

/// The number of parentheses, signs and powers inside each other that a formula may have.
pub(super) const DEEPEST: usize = 64;

/// The reason why a text is no formula.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FormulaFault {
    pub(crate) message: String,
    /// The remedy.
    pub(crate) expected: String,
}

impl FormulaFault {
    pub(super) fn new(message: impl Into<String>, expected: impl Into<String>) -> FormulaFault {
        FormulaFault { message: message.into(), expected: expected.into() }
    }
}

/// A part of a formula, and what it measures.
pub(super) struct Measured {
    pub(super) node: FormulaNode,
    pub(super) dimension: UnitPowers,
}

impl Measured {
    fn times(self, other: Measured) -> Measured {
        let dimension = self.dimension.times(other.dimension, 1.0);
        let operands = (Box::new(self.node), Box::new(other.node));
        let node = FormulaNode::Operation(FormulaOperator::Times, operands.0, operands.1);
        Measured { node, dimension }
    }
}

/// A formula as far as it is read.
pub(super) struct FormulaReader<'t> {
    text: &'t str,
    position: usize,
    depth: usize,
    find: &'t dyn Fn(&str) -> Result<Key, FormulaFault>,
    /// The keys that were read.
    pub(super) keys: Vec<Key>,
    /// True if a function is used whose last digits are not exact.
    pub(super) is_inexact: bool,
}

impl<'t> FormulaReader<'t> {
    /// Begins with a text. `find` returns the key that a name means, or says why there is none.
    pub(super) fn new(text: &'t str, find: &'t dyn Fn(&str) -> Result<Key, FormulaFault>) -> Self {
        Self { text, position: 0, depth: 0, find, keys: Vec::new(), is_inexact: false }
    }

    /// Reads all of the text.
    pub(super) fn whole(&mut self) -> Result<Measured, FormulaFault> {
        let sum = self.sum()?;
        if self.rest().is_empty() { Ok(sum) } else { Err(self.unexpected()) }
    }

    /// Returns the text that is left, without blanks in front.
    fn rest(&mut self) -> &str {
        let rest = &self.text[self.position..];
        self.position += rest.len() - rest.trim_start().len();
        &self.text[self.position..]
    }

    /// Takes a sign if it comes next.
    fn takes(&mut self, sign: char) -> bool {
        let is_next = self.rest().starts_with(sign);
        self.position += if is_next { sign.len_utf8() } else { 0 };
        is_next
    }

    /// Makes the fault of what cannot come next.
    fn unexpected(&mut self) -> FormulaFault {
        let rest: String = self.rest().chars().take(20).collect();
        let place = self.text[..self.position].chars().count() + 1;
        match rest.as_str() {
            "" => FormulaFault::new("the formula ends too early", "needs a number or a key here"),
            rest => FormulaFault::new(
                format!("unexpected `{rest}` at character {place}"),
                "needs numbers, keys, + - * / ^ and parentheses",
            ),
        }
    }

    fn sum(&mut self) -> Result<Measured, FormulaFault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(FormulaFault::new("too much inside each other", "must be simpler"));
        }
        let mut sum = self.product()?;
        loop {
            let operator = if self.takes('+') {
                FormulaOperator::Plus
            } else if self.takes('-') {
                FormulaOperator::Minus
            } else {
                self.depth -= 1;
                return Ok(sum);
            };
            let other = self.product()?;
            same(&sum, &other, "added or subtracted")?;
            let node = FormulaNode::Operation(operator, Box::new(sum.node), Box::new(other.node));
            sum = Measured { node, dimension: sum.dimension };
        }
    }

    fn product(&mut self) -> Result<Measured, FormulaFault> {
        let mut product = self.signed()?;
        loop {
            let (operator, count) = if self.takes('*') {
                (FormulaOperator::Times, 1.0)
            } else if self.takes('/') {
                (FormulaOperator::Over, -1.0)
            } else {
                return Ok(product);
            };
            let other = self.signed()?;
            let dimension = product.dimension.times(other.dimension, count);
            let node =
                FormulaNode::Operation(operator, Box::new(product.node), Box::new(other.node));
            product = Measured { node, dimension };
        }
    }

    fn signed(&mut self) -> Result<Measured, FormulaFault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(FormulaFault::new("too much inside each other", "must be simpler"));
        }
        let signed = if self.takes('-') {
            let Measured { node, dimension } = self.signed()?;
            Measured { node: FormulaNode::Negated(Box::new(node)), dimension }
        } else if self.takes('+') {
            self.signed()?
        } else {
            self.raised()?
        };
        self.depth -= 1;
        Ok(signed)
    }

    fn raised(&mut self) -> Result<Measured, FormulaFault> {
        let base = self.primary()?;
        self.power_of(base)
    }

    /// Reads the exponent of a base, if one comes next.
    fn power_of(&mut self, base: Measured) -> Result<Measured, FormulaFault> {
        if !self.takes('^') {
            return Ok(base);
        }
        let used = self.keys.len();
        let exponent = self.signed()?;
        if !exponent.dimension.is_pure() {
            let message = format!("an exponent is {}", exponent.dimension.noun());
            return Err(FormulaFault::new(message, "must be a pure number"));
        }
        let constant = match self.keys.len() == used {
            true => exponent.node.value(&Sheet::default()).ok(),
            false => None,
        };
        self.is_inexact |= !constant.is_some_and(is_small_whole);
        let dimension = match constant {
            _ if base.dimension.is_pure() => UnitPowers::PURE,
            Some(count) => UnitPowers::PURE.times(base.dimension, count),
            None => {
                let message = format!("a power of {} that changes", base.dimension.noun());
                return Err(FormulaFault::new(message, "needs an exponent without keys"));
            }
        };
        let operands = (Box::new(base.node), Box::new(exponent.node));
        let node = FormulaNode::Operation(FormulaOperator::Power, operands.0, operands.1);
        Ok(Measured { node, dimension })
    }

    fn primary(&mut self) -> Result<Measured, FormulaFault> {
        if self.takes('(') {
            let inner = self.sum()?;
            return if self.takes(')') { Ok(inner) } else { Err(self.unclosed()) };
        }
        if self.rest().starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return self.number();
        }
        match self.word().to_owned() {
            word if word.is_empty() => Err(self.unexpected()),
            word => {
                self.position += word.len();
                self.named(&word)
            }
        }
    }

    fn unclosed(&mut self) -> FormulaFault {
        match self.rest() {
            "" => FormulaFault::new("a parenthesis is not closed", "needs `)`"),
            _ => self.unexpected(),
        }
    }

    /// Returns the name that comes next: letters, digits, `_`, dots and indices.
    fn word(&mut self) -> &str {
        let rest = self.rest();
        let is_first = |c: char| c.is_alphabetic() || c == '_' || c == '°';
        if !rest.starts_with(is_first) {
            return "";
        }
        let is_part = |c: char| is_first(c) || c.is_ascii_digit() || matches!(c, '.' | '[' | ']');
        &rest[..rest.find(|c: char| !is_part(c)).unwrap_or(rest.len())]
    }

    fn number(&mut self) -> Result<Measured, FormulaFault> {
        let rest = self.rest();
        let Some(number) = leading_number(rest).map(str::to_owned) else {
            return Err(self.unexpected());
        };
        self.position += number.len();
        let word = self.word().to_owned();
        if word.is_empty() {
            let value = number.parse().unwrap_or(f64::NAN);
            return Ok(Measured { node: FormulaNode::Number(value), dimension: UnitPowers::PURE });
        }
        let Some((value, dimension)) = unit_value(&number, &word) else {
            let message = format!("`{word}` after {number} is no unit");
            let expected = match (self.find)(&word) {
                Ok(_) => format!("write {number} * {word} for a product"),
                Err(_) => "must be a unit like mm, GPa, kN or deg".to_owned(),
            };
            return Err(FormulaFault::new(message, expected));
        };
        self.position += word.len();
        let dimension = UnitPowers::of(dimension);
        if !self.rest().starts_with('^') {
            return self.units_after(Measured { node: FormulaNode::Number(value), dimension });
        }
        let value = number.parse().unwrap_or(f64::NAN);
        let count = Measured { node: FormulaNode::Number(value), dimension: UnitPowers::PURE };
        let unit = self.raised_unit(&word)?;
        self.units_after(count.times(unit))
    }

    /// Returns one of a unit whose symbol has been read, to the power that comes next.
    fn raised_unit(&mut self, symbol: &str) -> Result<Measured, FormulaFault> {
        let Some((value, dimension)) = unit_value("1", symbol) else {
            return Err(self.unexpected());
        };
        let unit =
            Measured { node: FormulaNode::Number(value), dimension: UnitPowers::of(dimension) };
        // A unit behind the exponent is a factor: `mm^2 N` is no power of 2 N.
        let behind = self.rest().strip_prefix('^').map(str::trim_start);
        let Some(exponent) = behind.and_then(leading_number).map(str::to_owned) else {
            return self.power_of(unit);
        };
        self.takes('^');
        self.rest();
        self.position += exponent.len();
        let count = exponent.parse().unwrap_or(f64::NAN);
        self.is_inexact |= !is_small_whole(count);
        let operands = (Box::new(unit.node), Box::new(FormulaNode::Number(count)));
        let node = FormulaNode::Operation(FormulaOperator::Power, operands.0, operands.1);
        Ok(Measured { node, dimension: UnitPowers::PURE.times(unit.dimension, count) })
    }

    /// Returns the product with the units that come next, such as the `m` of `N m`.
    fn units_after(&mut self, mut product: Measured) -> Result<Measured, FormulaFault> {
        loop {
            let word = self.word().to_owned();
            if unit_value("1", &word).is_none() {
                return Ok(product);
            }
            self.position += word.len();
            product = product.times(self.raised_unit(&word)?);
        }
    }

    fn named(&mut self, word: &str) -> Result<Measured, FormulaFault> {
        if self.takes('(') {
            return self.call(word);
        }
        if word == "pi" {
            return Ok(Measured { node: FormulaNode::Number(PI), dimension: UnitPowers::PURE });
        }
        // No key and no column is called like a unit.
        if unit_value("1", word).is_some() {
            let unit = self.raised_unit(word)?;
            return self.units_after(unit);
        }
        let key = (self.find)(word)?;
        let dimension = match key.quantity() {
            Quantity::Number(dimension) => UnitPowers::of(dimension),
            Quantity::Count | Quantity::Mesh | Quantity::List(_) => UnitPowers::PURE,
            _ => {
                let message = format!("`{word}` is a text");
                return Err(FormulaFault::new(message, "must be a key whose values are numbers"));
            }
        };
        self.keys.push(key);
        Ok(Measured { node: FormulaNode::Key(key), dimension })
    }

    fn call(&mut self, word: &str) -> Result<Measured, FormulaFault> {
        let Some(function) = MathFunction::find(word) else {
            let message = format!("there is no function `{word}`");
            let known = MathFunction::NAMES.join(", ");
            return Err(FormulaFault::new(message, format!("the functions are {known}")));
        };
        let mut arguments = vec![self.sum()?];
        while self.takes(',') {
            arguments.push(self.sum()?);
        }
        if !self.takes(')') {
            return Err(self.unclosed());
        }
        if !function.takes(arguments.len()) {
            let message = format!("`{word}` does not take {} values", arguments.len());
            return Err(FormulaFault::new(message, "takes one value; min and max take several"));
        }
        let first = arguments[0].dimension;
        let dimension = match function {
            MathFunction::Root => UnitPowers::PURE.times(first, 0.5),
            MathFunction::Absolute => first,
            MathFunction::Least | MathFunction::Greatest => {
                for other in &arguments[1..] {
                    same(&arguments[0], other, "compared")?;
                }
                first
            }
            _ if first.is_pure() => UnitPowers::PURE,
            _ => {
                let message = format!("`{word}` of {}", first.noun());
                return Err(FormulaFault::new(message, "must be of a pure number"));
            }
        };
        self.is_inexact |= matches!(
            function,
            MathFunction::Exponential
                | MathFunction::Logarithm
                | MathFunction::Sine
                | MathFunction::Cosine
                | MathFunction::Tangent
                | MathFunction::ArcTangent
        );
        let arguments = arguments.into_iter().map(|argument| argument.node).collect();
        Ok(Measured { node: FormulaNode::Call(function, arguments), dimension })
    }
}

/// Refuses two parts of different dimensions; `done` says what cannot be done with them.
fn same(a: &Measured, b: &Measured, done: &str) -> Result<(), FormulaFault> {
    if a.dimension.fits(b.dimension) {
        return Ok(());
    }
    let (a, b) = (a.dimension.noun(), b.dimension.noun());
    let message = format!("{a} and {b} cannot be {done}");
    Err(FormulaFault::new(message, "needs the same dimension on both sides"))
}
