//! Formulas over keys, with units: `0.1 * punch.radius`, `2 mm + sqrt(radius * approach)`.
//!
//! A formula has numbers, with a unit or without, keys by their paths or the names of their
//! columns, `+ - * / ^`, parentheses, `pi`, and the functions below. A unit by itself is one of it,
//! and units that follow each other are their product, as in `1e-5 mm^3/(N m)`. A power after a
//! unit is one of the unit: `2 mm^2` are two square millimetres.
//! Dimensions are checked when the formula is read: a length and a force cannot be added, and the
//! root of a pressure times an area is that of a force. An angle counts as a pure number, as the
//! radian does. The crates for units fix dimensions when Rust is compiled, and those that evaluate
//! texts know none, so the few lines of a reader are here.
//!
//! A value is rounded to 15 significant digits, and to 13 where a function is used whose last
//! digits are not exact: `0.1 * radius` with a radius of 3 mm is the job of 0.3 mm. The functions
//! are those of `libm`, which are the same on every machine. A formula that is a key alone has its
//! value, to the last bit.

use std::f64::consts::PI;

use contact::model::Mesh;

use crate::key::Key;
use crate::quantity::Quantity;
use crate::sheet::{Setting, Sheet};
use crate::units::{Dimension, leading_number, unit_value};

/// The number of parentheses, signs and powers inside each other that a formula may have.
const DEEPEST: usize = 64;

/// A formula whose keys are known and whose dimensions fit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Formula {
    node: FormulaNode,
    dimension: UnitPowers,
    keys: Vec<Key>,
    /// The number of significant digits of a value; `None` if it is not rounded.
    digits: Option<usize>,
}

#[derive(Clone, Debug, PartialEq)]
enum FormulaNode {
    Number(f64),
    Key(Key),
    Negated(Box<FormulaNode>),
    Operation(FormulaOperator, Box<FormulaNode>, Box<FormulaNode>),
    Call(MathFunction, Vec<FormulaNode>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum FormulaOperator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

/// The powers of a metre, a newton and a second in a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UnitPowers {
    metre: f64,
    newton: f64,
    second: f64,
}

/// The reason why a text is no formula.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FormulaFault {
    pub(crate) message: String,
    /// The remedy.
    pub(crate) expected: String,
}

macro_rules! functions {
    ($($name:ident $word:literal $least:literal..=$most:literal;)*) => {
        /// A function that a formula may use.
        #[derive(Clone, Copy, Debug, PartialEq)]
        enum MathFunction { $($name,)* }

        impl MathFunction {
            const NAMES: &'static [&'static str] = &[$($word,)*];

            fn find(word: &str) -> Option<MathFunction> {
                match word { $($word => Some(MathFunction::$name),)* _ => None }
            }

            /// Returns whether it takes so many arguments.
            fn takes(self, count: usize) -> bool {
                match self { $(MathFunction::$name => ($least..=$most).contains(&count),)* }
            }
        }
    };
}

functions! {
    Root "sqrt" 1..=1;
    Absolute "abs" 1..=1;
    Least "min" 2..=16;
    Greatest "max" 2..=16;
    Rounded "round" 1..=1;
    Below "floor" 1..=1;
    Above "ceil" 1..=1;
    Exponential "exp" 1..=1;
    Logarithm "ln" 1..=1;
    Sine "sin" 1..=1;
    Cosine "cos" 1..=1;
    Tangent "tan" 1..=1;
    ArcTangent "atan" 1..=1;
}

impl UnitPowers {
    const PURE: UnitPowers = UnitPowers { metre: 0.0, newton: 0.0, second: 0.0 };

    /// Returns the powers in the SI unit of a dimension.
    pub(crate) fn of(dimension: Dimension) -> UnitPowers {
        let [metre, newton, second] = match dimension {
            Dimension::Pure | Dimension::Angle => [0.0, 0.0, 0.0],
            Dimension::Length => [1.0, 0.0, 0.0],
            Dimension::Area => [2.0, 0.0, 0.0],
            Dimension::Volume => [3.0, 0.0, 0.0],
            Dimension::Pressure => [-2.0, 1.0, 0.0],
            Dimension::PerPressure => [2.0, -1.0, 0.0],
            Dimension::Force | Dimension::EnergyPerLength => [0.0, 1.0, 0.0],
            Dimension::AnglePerLength => [-1.0, 0.0, 0.0],
            Dimension::Moment | Dimension::Energy => [1.0, 1.0, 0.0],
            Dimension::Time => [0.0, 0.0, 1.0],
            Dimension::Velocity => [1.0, 0.0, -1.0],
            Dimension::AngularVelocity => [0.0, 0.0, -1.0],
        };
        UnitPowers { metre, newton, second }
    }

    /// Returns whether two units measure the same. Powers are quotients of small whole numbers.
    pub(crate) fn fits(self, other: UnitPowers) -> bool {
        let pairs =
            [(self.metre, other.metre), (self.newton, other.newton), (self.second, other.second)];
        pairs.iter().all(|(power, other)| (power - other).abs() < 1e-9)
    }

    fn is_pure(self) -> bool {
        self.fits(Self::PURE)
    }

    /// Returns the powers of a product with the `count`-th power of another unit.
    fn times(self, other: UnitPowers, count: f64) -> UnitPowers {
        UnitPowers {
            metre: self.metre + count * other.metre,
            newton: self.newton + count * other.newton,
            second: self.second + count * other.second,
        }
    }

    /// Returns the name with its article, for messages.
    pub(crate) fn noun(self) -> String {
        let named = [
            Dimension::Pure,
            Dimension::Length,
            Dimension::Area,
            Dimension::Pressure,
            Dimension::Force,
            Dimension::Moment,
            Dimension::PerPressure,
            Dimension::Velocity,
            Dimension::AngularVelocity,
            Dimension::Time,
        ];
        if let Some(dimension) = named.into_iter().find(|known| self.fits(Self::of(*known))) {
            return dimension.noun().to_owned();
        }
        let power = |(symbol, count): (&str, f64)| {
            let count = (count * 1e6).round() / 1e6;
            match count {
                0.0 => None,
                1.0 => Some(symbol.to_owned()),
                count => Some(format!("{symbol}^{count}")),
            }
        };
        let powers = [("N", self.newton), ("m", self.metre), ("s", self.second)]
            .into_iter()
            .filter_map(power);
        format!("a quantity in {}", powers.collect::<Vec<_>>().join(" "))
    }
}

impl FormulaFault {
    fn new(message: impl Into<String>, expected: impl Into<String>) -> FormulaFault {
        FormulaFault { message: message.into(), expected: expected.into() }
    }
}

impl Formula {
    /// Reads a formula. `find` returns the key that a name means, or says why there is none.
    pub(crate) fn read(
        text: &str,
        find: &dyn Fn(&str) -> Result<Key, FormulaFault>,
    ) -> Result<Formula, FormulaFault> {
        if text.trim().is_empty() {
            return Err(FormulaFault::new("the formula is empty", "needs \"0.1 * punch.radius\""));
        }
        let mut reader = FormulaReader {
            text,
            position: 0,
            depth: 0,
            find,
            keys: Vec::new(),
            is_inexact: false,
        };
        let Measured { node, dimension } = reader.sum()?;
        if !reader.rest().is_empty() {
            return Err(reader.unexpected());
        }
        let digits = match (&node, reader.is_inexact) {
            (FormulaNode::Key(_), _) => None,
            (_, true) => Some(13),
            (_, false) => Some(15),
        };
        Ok(Formula { node, dimension, keys: reader.keys, digits })
    }

    /// Returns the dimension of its values.
    pub(crate) fn dimension(&self) -> UnitPowers {
        self.dimension
    }

    /// Returns the keys that it uses.
    pub(crate) fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Returns the value for the keys of a sheet, in SI units.
    ///
    /// # Errors
    ///
    /// Returns a key that the sheet does not have, or has as something else than a number.
    pub(crate) fn value(&self, sheet: &Sheet<'_>) -> Result<f64, Key> {
        let value = self.node.value(sheet)?;
        Ok(match self.digits {
            Some(digits) => format!("{value:.*e}", digits - 1).parse().unwrap_or(value),
            None => value,
        })
    }
}

impl FormulaNode {
    fn value(&self, sheet: &Sheet<'_>) -> Result<f64, Key> {
        Ok(match self {
            FormulaNode::Number(x) => *x,
            FormulaNode::Key(key) => match sheet.get(*key).map(|given| &given.setting) {
                Some(Setting::Number(x)) => *x,
                Some(Setting::Count(n) | Setting::Mesh(Mesh::Across(n))) => f64::from(*n),
                _ => return Err(*key),
            },
            FormulaNode::Negated(a) => -a.value(sheet)?,
            FormulaNode::Operation(operator, a, b) => {
                let (a, b) = (a.value(sheet)?, b.value(sheet)?);
                match operator {
                    FormulaOperator::Plus => a + b,
                    FormulaOperator::Minus => a - b,
                    FormulaOperator::Times => a * b,
                    FormulaOperator::Over => a / b,
                    FormulaOperator::Power => power(a, b),
                }
            }
            FormulaNode::Call(function, arguments) => {
                let values =
                    arguments.iter().map(|a| a.value(sheet)).collect::<Result<Vec<f64>, Key>>()?;
                let x = values.first().copied().unwrap_or(f64::NAN);
                match function {
                    MathFunction::Root => x.sqrt(),
                    MathFunction::Absolute => x.abs(),
                    MathFunction::Least => values.into_iter().fold(x, f64::min),
                    MathFunction::Greatest => values.into_iter().fold(x, f64::max),
                    MathFunction::Rounded => x.round(),
                    MathFunction::Below => x.floor(),
                    MathFunction::Above => x.ceil(),
                    MathFunction::Exponential => libm::exp(x),
                    MathFunction::Logarithm => libm::log(x),
                    MathFunction::Sine => libm::sin(x),
                    MathFunction::Cosine => libm::cos(x),
                    MathFunction::Tangent => libm::tan(x),
                    MathFunction::ArcTangent => libm::atan(x),
                }
            }
        })
    }
}

/// Returns a power; one with a small whole exponent is a product, which is the same everywhere.
fn power(base: f64, exponent: f64) -> f64 {
    if !is_small_whole(exponent) {
        return libm::pow(base, exponent);
    }
    let product = (0..exponent.abs() as u32).fold(1.0, |product, _| product * base);
    if exponent < 0.0 { 1.0 / product } else { product }
}

fn is_small_whole(exponent: f64) -> bool {
    exponent.fract() == 0.0 && exponent.abs() <= 64.0
}

/// A part of a formula, and what it measures.
struct Measured {
    node: FormulaNode,
    dimension: UnitPowers,
}

impl Measured {
    fn times(self, other: Measured) -> Measured {
        let dimension = self.dimension.times(other.dimension, 1.0);
        let operands = (Box::new(self.node), Box::new(other.node));
        let node = FormulaNode::Operation(FormulaOperator::Times, operands.0, operands.1);
        Measured { node, dimension }
    }
}

struct FormulaReader<'t> {
    text: &'t str,
    position: usize,
    depth: usize,
    find: &'t dyn Fn(&str) -> Result<Key, FormulaFault>,
    keys: Vec<Key>,
    /// True if a function is used whose last digits are not exact.
    is_inexact: bool,
}

impl FormulaReader<'_> {
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
        let dimension = UnitPowers::of(dimension);
        self.power_of(Measured { node: FormulaNode::Number(value), dimension })
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::sheet::Given;

    fn find(name: &str) -> Result<Key, FormulaFault> {
        Key::find(name).or_else(|| Key::of_column(name)).ok_or_else(|| FormulaFault::new("", ""))
    }

    /// Returns the value of a formula where the radius is 3 mm, μ = 0.25 and the mesh has 48.
    fn value(text: &str) -> Result<f64, FormulaFault> {
        let given = |setting| Given { setting, span: 0..0, nth: None };
        let given = [
            (Key::Radius, given(Setting::Number(3e-3))),
            (Key::Mu, given(Setting::Number(0.25))),
            (Key::ShearModulus, given(Setting::Number(8e10))),
            (Key::Mesh, given(Setting::Mesh(Mesh::Across(48)))),
        ];
        let sheet = Sheet::new(given.iter().map(|(key, given)| (*key, given)));
        Formula::read(text, &find).map(|formula| formula.value(&sheet).unwrap_or(f64::NAN))
    }

    #[test]
    fn formulas_have_the_values_of_arithmetic() {
        for (text, expected) in [
            ("0.1 * punch.radius", 3e-4),
            ("2 mm + 0.1 * radius", 2.3e-3),
            ("-radius^2 * 4 / radius", -1.2e-2),
            ("2^3^2", 512.0),
            ("(1 + 2) * 3 - 4 / 2 - 1", 6.0),
            ("2 - 3 - 4", -5.0),
            ("8 / 4 / 2", 1.0),
            ("sqrt(radius * 27 mm)", 9e-3),
            ("min(radius, 1 mm, 2 mm) + max(0 m, 1 um)", 1.001e-3),
            ("abs(-mu)", 0.25),
            ("round(mesh * 0.26)", 12.0),
            ("radius / mm", 3.0),
            ("210 N/mm^2", 210e6),
            ("(radius^3)^(1/3)", 3e-3),
            ("1.5e-3 m", 1.5e-3),
            ("10 µm", 1e-5),
            ("90 deg / pi", 0.5),
            ("tan(45 deg)", 1.0),
            ("scene.foundation.base.shear_modulus * radius ^ 2 / kN", 720.0),
            ("radius", 3e-3),
            ("20 m/s", 20.0),
            ("72 km/h", 20.0),
            ("90 km / 1.25 h", 20.0),
            ("40 rad/s", 40.0),
            ("30 rpm / pi", 1.0),
            ("2 min - 60 s", 60.0),
            ("radius / (2 s)", 1.5e-3),
            ("2 N m", 2.0),
            ("3 kN mm / radius", 1e3),
            ("2 mm^2", 2e-6),
            ("(2 mm)^2", 4e-6),
            ("2 mm^2 m", 2e-6),
            ("1e-5 mm^3/(N m)", 1e-14),
            ("1e-5 mm^3/N m", 1e-14),
            ("1e-5 mm^3 / J", 1e-14),
            ("mu * mm^3/(N m)", 2.5e-10),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    /// The last digits of the functions of a platform are its own, and a key must not be.
    #[test]
    fn functions_are_those_of_one_library() {
        type Function = fn(f64) -> f64;
        let functions: [(&str, Function); 7] = [
            ("exp(mu)", libm::exp),
            ("ln(mu)", libm::log),
            ("sin(mu)", libm::sin),
            ("cos(mu)", libm::cos),
            ("tan(mu)", libm::tan),
            ("atan(mu)", libm::atan),
            ("mu^2.3", |x| libm::pow(x, 2.3)),
        ];
        for (text, function) in functions {
            let formula = Formula::read(text, &find).unwrap();
            for n in 1..2000 {
                let x = f64::from(n) * 0.007_3;
                let given = Given { setting: Setting::Number(x), span: 0..0, nth: None };
                let sheet = Sheet::new([(Key::Mu, &given)]);
                assert_eq!(formula.node.value(&sheet), Ok(function(x)), "{text} at {x}");
            }
        }
    }

    #[test]
    fn dimensions_are_known_before_values_are() {
        let noun = |text: &str| Formula::read(text, &find).map(|f| f.dimension().noun());
        for (text, expected) in [
            ("radius * radius", "an area"),
            ("shear_modulus * radius^2", "a force"),
            ("sqrt(shear_modulus / shear_modulus)", "a pure number"),
            ("radius / radius", "a pure number"),
            ("sqrt(radius)", "a quantity in m^0.5"),
            ("1 kN * radius", "a moment"),
            ("1 / radius", "a quantity in m^-1"),
            ("radius / s", "a velocity"),
            ("72 km/h", "a velocity"),
            ("40 rad/s", "an angular velocity"),
            ("3 h", "a time"),
            ("1e-5 mm^3/(N m)", "one over a pressure"),
            ("2 N m", "a moment"),
        ] {
            assert_eq!(noun(text).as_deref(), Ok(expected), "{text}");
        }
        for (text, words) in [
            ("radius + mu", "a length and a pure number cannot be added or subtracted"),
            ("max(radius, 1 kN)", "a length and a force cannot be compared"),
            ("2^radius", "an exponent is a length"),
            ("radius^mu", "a power of a length that changes"),
            ("sin(radius)", "`sin` of a length"),
            ("shape * 2", "`shape` is a text"),
            ("20 m/s + 3 s", "a velocity and a time cannot be added or subtracted"),
            ("1 mm^radius", "an exponent is a length"),
            ("(N radius)", "unexpected `radius)` at character 4"),
            ("3 hours", "`hours` after 3 is no unit"),
        ] {
            assert_eq!(noun(text).map_err(|fault| fault.message), Err(words.to_owned()), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_formula_or_a_fault(text in "[-+*/^().,0-9a-z \\[\\]µ]{0,40}") {
            let _ = value(&text);
        }

        #[test]
        fn nesting_ends(depth in 0usize..2000) {
            let text = format!("{}1{}", "(".repeat(depth), ")".repeat(depth));
            prop_assert_eq!(value(&text).is_ok(), depth < DEEPEST / 2);
        }
    }
}
