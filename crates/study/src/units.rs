//! The dimensions, and the units that a study file may write. Everything behind this file is in SI
//! units.
//!
//! A units library multiplies by 10⁻⁶ in floating point, which turns "10 um" into
//! 9.999999999999999e-6 m and so into another job than 1e-5. Here a decimal prefix moves the
//! decimal point of the text before it becomes a number, so that the two are the same bits.

use crate::scaling::{UnitScale, scaled, scaled_at_once_by};

/// The dimension of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// A pure number.
    Pure,
    /// A length \[m\].
    Length,
    /// An area \[m²\].
    Area,
    /// An angle \[rad\].
    Angle,
    /// A pressure or an elastic modulus \[Pa\].
    Pressure,
    /// A force \[N\].
    Force,
    /// The moment of a force [N m].
    Moment,
    /// An energy \[J\].
    Energy,
    /// A time \[s\].
    Time,
    /// An angle per length \[rad/m\].
    AnglePerLength,
    /// An energy per length \[J/m\].
    EnergyPerLength,
    /// One over a pressure \[1/Pa\].
    PerPressure,
    /// A volume \[m³\].
    Volume,
    /// A velocity \[m/s\].
    Velocity,
    /// An angular velocity \[rad/s\].
    AngularVelocity,
}

impl Dimension {
    /// Returns the symbol of the SI unit in which everything is computed, stored and shown; empty
    /// for a pure number.
    pub fn unit(self) -> &'static str {
        match self {
            Dimension::Pure => "",
            Dimension::Length => "m",
            Dimension::Area => "m²",
            Dimension::Angle => "rad",
            Dimension::Pressure => "Pa",
            Dimension::Force => "N",
            Dimension::Moment => "N m",
            Dimension::Energy => "J",
            Dimension::Time => "s",
            Dimension::AnglePerLength => "rad/m",
            Dimension::EnergyPerLength => "J/m",
            Dimension::PerPressure => "1/Pa",
            Dimension::Volume => "m³",
            Dimension::Velocity => "m/s",
            Dimension::AngularVelocity => "rad/s",
        }
    }

    /// Returns the name with its article, for messages.
    pub(crate) fn noun(self) -> &'static str {
        match self {
            Dimension::Pure => "a pure number",
            Dimension::Length => "a length",
            Dimension::Area => "an area",
            Dimension::Angle => "an angle",
            Dimension::Pressure => "a pressure",
            Dimension::Force => "a force",
            Dimension::Moment => "a moment",
            Dimension::Energy => "an energy",
            Dimension::Time => "a time",
            Dimension::AnglePerLength => "an angle per length",
            Dimension::EnergyPerLength => "an energy per length",
            Dimension::PerPressure => "one over a pressure",
            Dimension::Volume => "a volume",
            Dimension::Velocity => "a velocity",
            Dimension::AngularVelocity => "an angular velocity",
        }
    }

    /// Returns the units that a file may write for it, in the order of the table below.
    pub(crate) fn units(self) -> impl Iterator<Item = &'static str> {
        UNITS.iter().filter(move |unit| unit.dimension == self).map(|unit| unit.symbol)
    }
}

#[derive(Clone, Copy, Debug)]
struct Unit {
    symbol: &'static str,
    dimension: Dimension,
    scale: UnitScale,
}

const fn ten(symbol: &'static str, dimension: Dimension, exponent: i32) -> Unit {
    Unit { symbol, dimension, scale: UnitScale::Ten(exponent) }
}

const fn decimal(symbol: &'static str, dimension: Dimension, factor: u64, exponent: i32) -> Unit {
    Unit { symbol, dimension, scale: UnitScale::Decimal(factor, exponent) }
}

const fn times(symbol: &'static str, dimension: Dimension, factor: f64) -> Unit {
    Unit { symbol, dimension, scale: UnitScale::Times(factor) }
}

/// Every unit that a file may write, in one of its spellings. There is no millipascal: it
/// would be a misspelt MPa.
const UNITS: &[Unit] = &[
    ten("m", Dimension::Length, 0),
    ten("cm", Dimension::Length, -2),
    ten("mm", Dimension::Length, -3),
    ten("um", Dimension::Length, -6),
    ten("nm", Dimension::Length, -9),
    ten("pm", Dimension::Length, -12),
    ten("km", Dimension::Length, 3),
    decimal("in", Dimension::Length, 254, -4),
    ten("Pa", Dimension::Pressure, 0),
    ten("kPa", Dimension::Pressure, 3),
    ten("MPa", Dimension::Pressure, 6),
    ten("GPa", Dimension::Pressure, 9),
    ten("TPa", Dimension::Pressure, 12),
    ten("bar", Dimension::Pressure, 5),
    ten("N/m^2", Dimension::Pressure, 0),
    ten("kN/m^2", Dimension::Pressure, 3),
    ten("MN/m^2", Dimension::Pressure, 6),
    ten("N/cm^2", Dimension::Pressure, 4),
    ten("N/mm^2", Dimension::Pressure, 6),
    ten("kN/mm^2", Dimension::Pressure, 9),
    times("psi", Dimension::Pressure, 6894.757293168361),
    times("ksi", Dimension::Pressure, 6894757.293168361),
    ten("rad", Dimension::Angle, 0),
    ten("mrad", Dimension::Angle, -3),
    ten("urad", Dimension::Angle, -6),
    times("deg", Dimension::Angle, std::f64::consts::PI / 180.0),
    times("°", Dimension::Angle, std::f64::consts::PI / 180.0),
    ten("N", Dimension::Force, 0),
    ten("nN", Dimension::Force, -9),
    ten("uN", Dimension::Force, -6),
    ten("mN", Dimension::Force, -3),
    ten("kN", Dimension::Force, 3),
    ten("MN", Dimension::Force, 6),
    decimal("lbf", Dimension::Force, 44_482_216_152_605, -13),
    ten("N m", Dimension::Moment, 0),
    ten("mN m", Dimension::Moment, -3),
    ten("uN m", Dimension::Moment, -6),
    ten("N mm", Dimension::Moment, -3),
    ten("kN m", Dimension::Moment, 3),
    ten("rad/m", Dimension::AnglePerLength, 0),
    ten("rad/mm", Dimension::AnglePerLength, 3),
    ten("mrad/m", Dimension::AnglePerLength, -3),
    ten("mrad/mm", Dimension::AnglePerLength, 0),
    ten("1/m", Dimension::AnglePerLength, 0),
    ten("1/mm", Dimension::AnglePerLength, 3),
    ten("1/km", Dimension::AnglePerLength, -3),
    ten("1/Pa", Dimension::PerPressure, 0),
    ten("1/kPa", Dimension::PerPressure, -3),
    ten("1/MPa", Dimension::PerPressure, -6),
    ten("1/GPa", Dimension::PerPressure, -9),
    ten("m^2/N", Dimension::PerPressure, 0),
    ten("mm^2/N", Dimension::PerPressure, -6),
    ten("m^3/(N m)", Dimension::PerPressure, 0),
    ten("mm^3/(N m)", Dimension::PerPressure, -9),
    ten("mm^3/(N mm)", Dimension::PerPressure, -6),
    ten("um^3/(N m)", Dimension::PerPressure, -18),
    ten("um^3/(N mm)", Dimension::PerPressure, -15),
    ten("m^3/J", Dimension::PerPressure, 0),
    ten("mm^3/J", Dimension::PerPressure, -9),
    ten("J", Dimension::Energy, 0),
    ten("mJ", Dimension::Energy, -3),
    ten("kJ", Dimension::Energy, 3),
    ten("s", Dimension::Time, 0),
    ten("ms", Dimension::Time, -3),
    decimal("min", Dimension::Time, 60, 0),
    decimal("h", Dimension::Time, 3600, 0),
    ten("m/s", Dimension::Velocity, 0),
    ten("cm/s", Dimension::Velocity, -2),
    ten("mm/s", Dimension::Velocity, -3),
    times("km/h", Dimension::Velocity, 1.0 / 3.6),
    ten("rad/s", Dimension::AngularVelocity, 0),
    ten("mrad/s", Dimension::AngularVelocity, -3),
    times("deg/s", Dimension::AngularVelocity, std::f64::consts::PI / 180.0),
    times("rpm", Dimension::AngularVelocity, std::f64::consts::PI / 30.0),
    ten("1/s", Dimension::AngularVelocity, 0),
];

/// Words that people write who mean a unit, each with the unit.
const MEANT: &[(&str, &str)] = &[
    ("micron", "um"),
    ("microns", "um"),
    ("micrometer", "um"),
    ("micrometers", "um"),
    ("micrometre", "um"),
    ("meter", "m"),
    ("metre", "m"),
    ("millimeter", "mm"),
    ("millimetre", "mm"),
    ("inch", "in"),
    ("inches", "in"),
    ("\"", "in"),
    ("pascal", "Pa"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("radian", "rad"),
    ("radians", "rad"),
    ("newton", "N"),
    ("newtons", "N"),
    ("lb", "lbf"),
    ("lbs", "lbf"),
    ("/m", "1/m"),
    ("m^-1", "1/m"),
    ("/mm", "1/mm"),
    ("pa^-1", "1/Pa"),
    ("/pa", "1/Pa"),
    ("mpa^-1", "1/MPa"),
    ("/mpa", "1/MPa"),
    ("kmh", "km/h"),
    ("kph", "km/h"),
    ("mps", "m/s"),
    ("/s", "1/s"),
    ("s^-1", "1/s"),
    ("1/min", "rpm"),
];

/// Returns the unit that a symbol stands for, however it is spelled.
fn find(symbol: &str) -> Option<&'static Unit> {
    // No unit is as long as this.
    if symbol.len() > 32 {
        return None;
    }
    let plain = plain(symbol);
    let is_meant = |unit: &&Unit| {
        let known = self::plain(unit.symbol);
        known == plain || known.replace(' ', "") == plain
    };
    UNITS.iter().find(is_meant)
}

/// Returns the spelling of a symbol by which units are told apart: with u for µ, with plain digits,
/// without signs of powers, and with a blank for each sign of multiplication. Capitals count: "Nm"
/// is a moment, "nm" a length. So do blanks: "m m" is no millimetre.
fn plain(symbol: &str) -> String {
    let letter = |c: char| match c {
        'µ' | 'μ' => 'u',
        '²' => '2',
        '³' => '3',
        '*' | '·' | '⋅' | '.' => ' ',
        c => c,
    };
    // A denominator may stand in parentheses.
    let opened = symbol
        .split_once("/(")
        .and_then(|(above, below)| Some(format!("{above}/{}", below.strip_suffix(')')?)));
    let symbol = opened.as_deref().unwrap_or(symbol);
    let letters: String = symbol.chars().filter(|c| *c != '^').map(letter).collect();
    let words = |part: &str| part.split_whitespace().collect::<Vec<_>>().join(" ");
    letters.split('/').map(words).collect::<Vec<_>>().join("/")
}

/// Returns the unit of a dimension that was probably meant by a symbol that is none.
fn nearest(symbol: &str, wanted: Dimension) -> Option<&'static str> {
    let lower = symbol.to_lowercase();
    let meant = MEANT.iter().find(|(others, _)| *others == lower).map(|(_, unit)| *unit);
    let is_wanted = |unit: &&str| find(unit).is_some_and(|unit| unit.dimension == wanted);
    wanted
        .units()
        .find(|known| plain(known).eq_ignore_ascii_case(&plain(symbol)))
        .or(meant.filter(is_wanted))
}

/// The reason why a text is not a quantity of the dimension that its key needs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum QuantityError {
    /// The text does not begin with a number.
    #[error("`{text}` does not begin with a number")]
    NoNumber {
        /// The text.
        text: String,
    },
    /// The number does not fit a double.
    #[error("`{text}` is too large a number")]
    TooLarge {
        /// The text.
        text: String,
    },
    /// The number has no unit.
    #[error("`{text}` has no unit")]
    NoUnit {
        /// The text.
        text: String,
    },
    /// The number has a comma in place of a point, or in thousands.
    #[error("`{text}` has a comma in its number")]
    Comma {
        /// The text.
        text: String,
    },
    /// The unit is not in the table.
    #[error("`{unit}` is not a unit known here")]
    UnknownUnit {
        /// The unit as written.
        unit: String,
        /// The known unit that is most like it, of the wanted dimension.
        nearest: Option<&'static str>,
    },
    /// The unit measures something else.
    #[error("`{text}` is {}, not {}", .found.noun(), .wanted.noun())]
    WrongDimension {
        /// The text.
        text: String,
        /// The dimension that it has.
        found: Dimension,
        /// The dimension that it should have.
        wanted: Dimension,
    },
}

/// Returns the SI value of a text such as `80 GPa`, `0.5mm` or `10 µm`, correctly rounded if the
/// unit is a decimal number of SI units.
///
/// # Errors
///
/// Returns an error if the text is not a number with a unit of the dimension `wanted`.
pub fn quantity(text: &str, wanted: Dimension) -> Result<f64, QuantityError> {
    let whole = text.trim();
    let (number, symbol) =
        split_number(whole).ok_or_else(|| QuantityError::NoNumber { text: text.to_owned() })?;
    if symbol.is_empty() {
        return Err(QuantityError::NoUnit { text: whole.to_owned() });
    }
    if symbol.starts_with(',') {
        return Err(QuantityError::Comma { text: whole.to_owned() });
    }
    let unit = find(symbol).ok_or_else(|| QuantityError::UnknownUnit {
        unit: symbol.to_owned(),
        nearest: nearest(symbol, wanted),
    })?;
    if unit.dimension != wanted {
        return Err(QuantityError::WrongDimension {
            text: whole.to_owned(),
            found: unit.dimension,
            wanted,
        });
    }
    scaled(number, unit.scale)
        .filter(|x| x.is_finite())
        .ok_or_else(|| QuantityError::TooLarge { text: whole.to_owned() })
}

/// Returns the SI value of a number with a unit, given as texts, and what it measures; `None` if
/// the unit is not known.
pub(crate) fn unit_value(number: &str, symbol: &str) -> Option<(f64, Dimension)> {
    let unit = find(symbol)?;
    Some((scaled(number, unit.scale)?, unit.dimension))
}

/// Returns the number with which a text begins.
pub(crate) fn leading_number(text: &str) -> Option<&str> {
    split_number(text).map(|(number, _)| number)
}

/// A unit of length, in which the heights of a file are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LengthUnit {
    symbol: &'static str,
    scale: UnitScale,
}

impl LengthUnit {
    /// The metre.
    pub(crate) const METRE: LengthUnit = LengthUnit { symbol: "m", scale: UnitScale::Ten(0) };

    /// Returns the unit of length with this symbol.
    pub(crate) fn find(symbol: &str) -> Option<Self> {
        let unit = find(symbol).filter(|unit| unit.dimension == Dimension::Length)?;
        Some(LengthUnit { symbol: unit.symbol, scale: unit.scale })
    }

    /// Returns the symbol.
    pub(crate) fn symbol(self) -> &'static str {
        self.symbol
    }

    /// Returns the ratios that two units of length may have, 1 before the others.
    pub(crate) fn ratios() -> impl Iterator<Item = f64> {
        let powers = (1..=12).flat_map(|n| [10f64.powi(n), 1.0 / 10f64.powi(n)]);
        std::iter::once(1.0).chain(powers)
    }

    /// Returns the metres of a decimal number of units, correctly rounded; `None` if the text is
    /// no number.
    pub(crate) fn metres(self, number: &str) -> Option<f64> {
        scaled(number, self.scale)
    }

    /// Returns the metres of a decimal number of units, correctly rounded; `None` if the text is no
    /// number, or one that takes longer to read.
    pub(crate) fn metres_at_once(self, number: &str) -> Option<f64> {
        scaled_at_once_by(number, self.scale)
    }

    /// Returns the metres of a double's number of units, rounded once where the unit is a power of
    /// ten: the doubles 10⁰ … 10²² are exact.
    pub(crate) fn metres_of(self, number: f64) -> f64 {
        match self.scale {
            UnitScale::Ten(exponent) if exponent < 0 => number / 10f64.powi(-exponent),
            UnitScale::Ten(exponent) => number * 10f64.powi(exponent),
            UnitScale::Decimal(factor, exponent) => number * factor as f64 / 10f64.powi(-exponent),
            UnitScale::Times(factor) => number * factor,
        }
    }
}

/// Splits `1.5e3 um` into `1.5e3` and `um`; `None` if there is no number in front.
fn split_number(text: &str) -> Option<(&str, &str)> {
    let bytes = text.as_bytes();
    let digits =
        |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mut end = digits(sign);
    let mut figures = end - sign;
    if bytes.get(end) == Some(&b'.') {
        let fraction = digits(end + 1);
        figures += fraction - (end + 1);
        end = fraction;
    }
    if figures == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let start = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(start.min(bytes.len()));
        if exponent > start {
            end = exponent;
        }
    }
    Some((&text[..end], text[end..].trim_start()))
}

/// A number that is displayed in its shortest exact form, with an exponent if it is far from 1.
pub(crate) struct Compact(pub(crate) f64);

impl std::fmt::Display for Compact {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-4..1e6).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// Returns lengths \[m\] in words, with four digits, in the unit that fits the largest of them.
pub(crate) fn lengths(metres: &[f64]) -> Vec<String> {
    let largest = metres.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let units = [(1.0, "m"), (1e-3, "mm"), (1e-6, "um")];
    let fits = |(unit, _): &(f64, &str)| largest >= *unit;
    let (unit, symbol) = units.into_iter().find(fits).unwrap_or((1e-9, "nm"));
    let digits = |x: f64| {
        let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
        format!("{}", Compact(rounded))
    };
    metres.iter().map(|x| format!("{} {symbol}", digits(x / unit))).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::scaling::scaled_by_text;

    #[test]
    fn decimal_units_are_exact() {
        for (text, dimension, value) in [
            ("10 um", Dimension::Length, 1e-5),
            ("10 µm", Dimension::Length, 1e-5),
            ("10 μm", Dimension::Length, 1e-5),
            ("0.5mm", Dimension::Length, 0.0005),
            ("80 GPa", Dimension::Pressure, 80e9),
            ("1.5e3 um", Dimension::Length, 1.5e-3),
            ("-.7E+1 nm", Dimension::Length, -7e-9),
            ("210 N/mm^2", Dimension::Pressure, 210e6),
            ("210 N/mm2", Dimension::Pressure, 210e6),
            ("210 N/mm²", Dimension::Pressure, 210e6),
            ("210 kN/mm^2", Dimension::Pressure, 210e9),
            ("210 kN / mm2", Dimension::Pressure, 210e9),
            ("3 MN/m²", Dimension::Pressure, 3e6),
            ("2 µN", Dimension::Force, 2e-6),
            ("2 Nm", Dimension::Moment, 2.0),
            ("2 N·m", Dimension::Moment, 2.0),
            ("2 N*mm", Dimension::Moment, 2e-3),
            ("2 nm", Dimension::Length, 2e-9),
            ("2\u{a0}mm", Dimension::Length, 2e-3),
            ("1 kN", Dimension::Force, 1000.0),
            ("90 deg", Dimension::Angle, std::f64::consts::FRAC_PI_2),
            ("180°", Dimension::Angle, std::f64::consts::PI),
            ("1 in", Dimension::Length, 0.0254),
            ("0.2 rad/mm", Dimension::AnglePerLength, 200.0),
            ("0.2 1/m", Dimension::AnglePerLength, 0.2),
            ("2e-8 1/MPa", Dimension::PerPressure, 2e-14),
            ("1e-5 mm³/(N·m)", Dimension::PerPressure, 1e-14),
            ("1e-5 mm^3/Nm", Dimension::PerPressure, 1e-14),
            ("1e-5mm3/N m", Dimension::PerPressure, 1e-14),
            ("3e-8 mm2/N", Dimension::PerPressure, 3e-14),
            ("4 um^3/(N*mm)", Dimension::PerPressure, 4e-15),
            ("72 km/h", Dimension::Velocity, 20.0),
            ("3 mm/s", Dimension::Velocity, 0.003),
            ("30 rpm", Dimension::AngularVelocity, std::f64::consts::PI),
            ("4.5 1/s", Dimension::AngularVelocity, 4.5),
            ("1.5 h", Dimension::Time, 5400.0),
            ("0.1 min", Dimension::Time, 6.0),
            ("2 kJ", Dimension::Energy, 2000.0),
        ] {
            assert_eq!(quantity(text, dimension), Ok(value), "{text}");
        }
    }

    #[test]
    fn what_is_not_a_quantity_says_why() {
        let refused = |text: &str, wanted| quantity(text, wanted).unwrap_err().to_string();
        assert_eq!(refused("5 mm", Dimension::Pressure), "`5 mm` is a length, not a pressure");
        assert_eq!(refused("0.3 mm", Dimension::Pure), "`0.3 mm` is a length, not a pure number");
        assert_eq!(refused("80", Dimension::Pressure), "`80` has no unit");
        assert_eq!(refused("GPa", Dimension::Pressure), "`GPa` does not begin with a number");
        assert_eq!(refused("0,5 mm", Dimension::Length), "`0,5 mm` has a comma in its number");
        assert_eq!(refused("", Dimension::Pressure), "`` does not begin with a number");
        assert_eq!(refused("1e999 m", Dimension::Length), "`1e999 m` is too large a number");
        assert_eq!(
            refused("1e99999999999 m", Dimension::Length),
            "`1e99999999999 m` is too large a number"
        );
        let suggested = |text: &str, wanted| match quantity(text, wanted) {
            Err(QuantityError::UnknownUnit { nearest, .. }) => nearest,
            other => panic!("{other:?}"),
        };
        assert_eq!(suggested("80 mpa", Dimension::Pressure), Some("MPa"));
        assert_eq!(suggested("80 n/mm2", Dimension::Pressure), Some("N/mm^2"));
        assert_eq!(suggested("3 microns", Dimension::Length), Some("um"));
        assert_eq!(suggested("3 microns", Dimension::Pressure), None);
        assert_eq!(suggested(&format!("3 {}", "m".repeat(100)), Dimension::Length), None);
    }

    #[test]
    fn lengths_read_well() {
        let shown = |metres: &[f64]| lengths(metres).join(", ");
        assert_eq!(shown(&[31.25e-6, 1e-3 / 3.0]), "31.25 um, 333.3 um");
        assert_eq!(shown(&[-28.127e-6, 0.375e-6]), "-28.13 um, 0.375 um");
        assert_eq!(shown(&[0.0]), "0 nm");
        assert_eq!(shown(&[-0.069612, 0.06]), "-69.61 mm, 60 mm");
    }

    proptest! {
        /// The short way and the way by text give the same bits, and refuse the same texts.
        #[test]
        fn numbers_are_scaled_at_once_as_by_text(
            number in "[+-]{0,2}[0-9]{0,20}[.]{0,2}[0-9]{0,12}([eE][+-]?[0-9]{0,4})?",
            unit in proptest::sample::select(UNITS),
        ) {
            let bits = |value: Option<f64>| value.map(f64::to_bits);
            prop_assert_eq!(
                bits(scaled(&number, unit.scale)),
                bits(scaled_by_text(&number, unit.scale)),
                "{} {}", number, unit.symbol
            );
        }

        #[test]
        fn any_text_is_a_quantity_or_an_error(text in "\\PC*") {
            for dimension in [Dimension::Pure, Dimension::Length, Dimension::Pressure] {
                if let Ok(x) = quantity(&text, dimension) {
                    prop_assert!(x.is_finite());
                }
            }
        }

        /// Every way to write a length gives the same bits.
        #[test]
        fn inches_are_millimetres_exactly(n in 0u64..1_000_000, digits in 0usize..6) {
            let inches = format!("{}.{:0digits$}", n / 7, n % 10u64.pow(digits as u32));
            let tenths: u128 = inches.replace('.', "").parse().unwrap();
            let written = if digits == 0 { 1 } else { digits };
            let millimetres = format!("{}e-{} mm", tenths * 254, written + 1);
            prop_assert_eq!(
                quantity(&format!("{inches} in"), Dimension::Length),
                quantity(&millimetres, Dimension::Length)
            );
        }

        #[test]
        fn millimetres_are_metres_with_the_point_moved(n in -1_000_000i64..1_000_000) {
            prop_assert_eq!(quantity(&format!("{n} mm"), Dimension::Length), Ok(n as f64 / 1000.0));
            let millimetre = LengthUnit::find("mm").unwrap();
            prop_assert_eq!(millimetre.metres_of(n as f64), n as f64 / 1000.0);
            prop_assert_eq!(millimetre.metres(&n.to_string()), Some(n as f64 / 1000.0));
        }
    }
}
