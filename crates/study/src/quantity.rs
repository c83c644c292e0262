//! The values that may stand behind a key, and how messages describe them.

use contact::model::Effect;

use crate::units::Dimension;
use crate::value::ValueType;

/// The values that may stand behind a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// A number in SI units, or a text with a unit.
    Number(Dimension),
    /// A whole number, 0 or above.
    Count,
    /// A whole number of elements or a pair of them.
    Mesh,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// True or false.
    Flag,
    /// Any text.
    Text,
    /// A unit of length.
    LengthUnit,
    /// A list of names of effects; neither their order nor repetitions matter.
    Effects,
    /// A list of lengths.
    Lengths,
    /// A list of places, each of three lengths.
    Places,
    /// A list of tables like this one; its value is their number.
    List(&'static str),
}

impl Quantity {
    /// Describes the values for messages: `a pressure, for example "1 MPa", or a number in Pa`.
    pub(crate) fn expected(self) -> String {
        match self {
            Quantity::Number(Dimension::Pure) => "a number".to_owned(),
            Quantity::Number(dimension) => {
                let example = match dimension {
                    Dimension::Length => "0.5 mm",
                    Dimension::Angle => "5 deg",
                    Dimension::Pressure => "80 GPa",
                    Dimension::Force => "1 kN",
                    Dimension::Moment => "2 N m",
                    Dimension::AnglePerLength => "0.1 rad/m",
                    Dimension::PerPressure => "1e-8 1/MPa",
                    Dimension::Velocity => "20 m/s",
                    Dimension::AngularVelocity => "40 rad/s",
                    _ => return format!("a number in {}", dimension.unit()),
                };
                format!(
                    "{} like \"{example}\" or a number in {}",
                    dimension.noun(),
                    dimension.unit()
                )
            }
            Quantity::Count => "a whole number".to_owned(),
            Quantity::Mesh => {
                "a whole number of elements like 64, or a pair like [64, 32]".to_owned()
            }
            Quantity::Choice(words) => match words {
                [only] => format!("\"{only}\""),
                _ => one_of(words),
            },
            Quantity::Flag => "true or false".to_owned(),
            Quantity::Text => "a text".to_owned(),
            Quantity::LengthUnit => {
                format!(
                    "a unit of length: {}",
                    quoted(&Dimension::Length.units().collect::<Vec<_>>())
                )
            }
            Quantity::Effects => {
                format!(
                    "a list of effects like [\"coupling\", \"asymmetry-x\"], each {}",
                    one_of(&Effect::OPTIONAL.map(Effect::name))
                )
            }
            Quantity::Lengths => "a list of lengths like [\"0.1 mm\", \"0.3 mm\"]".to_owned(),
            Quantity::Places => "a list of points [x, y, z] like [[0, 0, \"0.1 mm\"]]".to_owned(),
            Quantity::List(example) => format!("a list of tables like [{example}]"),
        }
    }

    /// Describes the values in a few words with their article, without an example.
    pub(crate) fn noun(self) -> String {
        match self {
            Quantity::Number(Dimension::Pure) => "a number".to_owned(),
            Quantity::Number(dimension) => dimension.noun().to_owned(),
            Quantity::Mesh => "a whole number, or a pair like [64, 32], each".to_owned(),
            Quantity::LengthUnit => "a unit of length".to_owned(),
            Quantity::Effects => "a list of effects".to_owned(),
            Quantity::Lengths => "a list of lengths".to_owned(),
            Quantity::Places => "a list of points [x, y, z]".to_owned(),
            Quantity::List(_) => "a list of tables".to_owned(),
            Quantity::Count | Quantity::Choice(_) | Quantity::Flag | Quantity::Text => {
                self.expected()
            }
        }
    }

    /// Returns whether it is a list, so that its entries are counted.
    pub(crate) fn is_counted(self) -> bool {
        matches!(self, Quantity::Effects | Quantity::Lengths | Quantity::Places | Quantity::List(_))
    }

    /// Returns the kind of the values. A mesh that is a pair is a text in tables.
    pub(crate) fn values(self) -> ValueType {
        match self {
            Quantity::Number(_) => ValueType::Number,
            Quantity::Count | Quantity::Mesh | Quantity::List(_) => ValueType::Integer,
            Quantity::Flag => ValueType::Flag,
            Quantity::Choice(_)
            | Quantity::Text
            | Quantity::LengthUnit
            | Quantity::Lengths
            | Quantity::Places
            | Quantity::Effects => ValueType::Text,
        }
    }
}

/// Describes a choice of words for messages.
pub(crate) fn one_of(words: &[&str]) -> String {
    format!("one of {}", quoted(words))
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}
