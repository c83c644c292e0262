//! The parts of a formula, and their values.

use contact::model::Mesh;

use crate::key::Key;
use crate::sheet::{Setting, Sheet};

/// A part of a formula that has a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum FormulaNode {
    Number(f64),
    Key(Key),
    Negated(Box<FormulaNode>),
    Operation(FormulaOperator, Box<FormulaNode>, Box<FormulaNode>),
    Call(MathFunction, Vec<FormulaNode>),
}

/// An operation of two values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FormulaOperator {
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

macro_rules! functions {
    ($($name:ident $word:literal $least:literal..=$most:literal;)*) => {
        /// A function that a formula may use.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) enum MathFunction { $($name,)* }

        impl MathFunction {
            pub(super) const NAMES: &'static [&'static str] = &[$($word,)*];

            /// Returns the function of this name.
            pub(super) fn find(word: &str) -> Option<MathFunction> {
                match word { $($word => Some(MathFunction::$name),)* _ => None }
            }

            /// Returns whether it takes so many arguments.
            pub(super) fn takes(self, count: usize) -> bool {
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

impl FormulaNode {
    /// Returns the value for the keys of a sheet.
    pub(super) fn value(&self, sheet: &Sheet<'_>) -> Result<f64, Key> {
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

/// Returns whether a power is a product of a few factors.
pub(super) fn is_small_whole(exponent: f64) -> bool {
    exponent.fract() == 0.0 && exponent.abs() <= 64.0
}
