//! Units with the prefixes that a person reads.

/// The symbols that take a prefix. A unit that does not begin with one of them is left as it is:
/// `kg`, `1`, `%`, `°`.
const SYMBOLS: [&str; 9] = ["Pa", "Hz", "m", "N", "J", "W", "s", "V", "A"];
/// The prefixes from 10⁻¹⁵ to 10¹⁵.
const PREFIXES: [&str; 11] = ["f", "p", "n", "µ", "m", "", "k", "M", "G", "T", "P"];

/// A unit with its prefix, and the number by which SI values are divided to be read in it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PrefixedUnit {
    pub(crate) name: String,
    /// The power of ten that the prefix stands for, raised as the unit is.
    exponent: i32,
}

impl PrefixedUnit {
    /// Makes a unit as it is, without a prefix.
    pub(crate) fn plain(unit: &str) -> PrefixedUnit {
        PrefixedUnit { name: unit.to_owned(), exponent: 0 }
    }

    /// Makes the unit with the prefix that brings `magnitude` (SI) between 1 and 1000.
    pub(crate) fn fitting(unit: &str, magnitude: f64) -> PrefixedUnit {
        let plain = PrefixedUnit::plain(unit);
        let Some((symbol, power)) = leading_symbol(unit) else { return plain };
        if !(magnitude.is_finite() && magnitude > 0.0) {
            return plain;
        }
        // The rounding of log10 must not turn 1000 Pa into 1000 Pa.
        let step = ((magnitude.log10() + 1e-9) / f64::from(3 * power)).floor() as i32;
        let highest = match symbol {
            "s" => 0, // nobody reads kiloseconds
            "m" => 1,
            // Moduli are given in GPa.
            "Pa" => 3,
            _ => 5,
        };
        let step = step.clamp(-5, highest);
        let prefix = PREFIXES[(step + 5) as usize];
        PrefixedUnit { name: format!("{prefix}{unit}"), exponent: 3 * step * power }
    }

    /// Returns the power of ten by which SI values are divided.
    pub(crate) fn exponent(&self) -> i32 {
        self.exponent
    }

    /// Returns an SI value in this unit.
    pub(crate) fn of_si(&self, x: f64) -> f64 {
        // Powers of ten up to 10²² are exact, their inverses are not.
        if self.exponent < 0 {
            x * 10f64.powi(-self.exponent)
        } else {
            x / 10f64.powi(self.exponent)
        }
    }
}

/// Returns the symbol that a unit begins with and its power, if the symbol takes a prefix.
fn leading_symbol(unit: &str) -> Option<(&'static str, i32)> {
    let symbol = SYMBOLS
        .into_iter()
        .find(|s| unit.strip_prefix(s).is_some_and(|rest| !starts_with_letter(rest)))?;
    let rest = &unit[symbol.len()..];
    let power = |text: &str| match text.strip_prefix('^').unwrap_or(text).chars().next() {
        Some('2' | '²') => Some(2),
        Some('3' | '³') => Some(3),
        Some('-' | '⁻' | '0'..='9' | '⁰'..='⁹' | '¹') => None,
        _ => Some(1),
    };
    power(rest).map(|p| (symbol, p))
}

fn starts_with_letter(text: &str) -> bool {
    text.starts_with(char::is_alphabetic)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_bring_values_between_1_and_1000() {
        for (unit, value, name, read) in [
            ("Pa", 2.5e9, "GPa", 2.5),
            ("Pa", 1000.0, "kPa", 1.0),
            ("Pa", 999.0, "Pa", 999.0),
            ("m", 4e-6, "µm", 4.0),
            ("m", 2e7, "km", 2e4),
            ("m²", 4e-6, "mm²", 4.0),
            ("m^2", 4e-7, "µm^2", 4e5),
            ("N·m", 4e-3, "mN·m", 4.0),
            ("N/m", 4e6, "MN/m", 4.0),
            ("s", 4e6, "s", 4e6),
            ("s", 4e-2, "ms", 40.0),
            ("1", 4e-2, "1", 4e-2),
            ("", 4e-2, "", 4e-2),
            ("kg", 4e-2, "kg", 4e-2),
            ("mm", 4e-2, "mm", 4e-2),
            ("min", 4e-2, "min", 4e-2),
            ("m⁻¹", 4e4, "m⁻¹", 4e4),
            ("Pa", 0.0, "Pa", 0.0),
            ("Pa", 1e-300, "fPa", 1e-285),
        ] {
            let chosen = PrefixedUnit::fitting(unit, value);
            assert_eq!(chosen.name, name, "{value} {unit}");
            assert!(
                (chosen.of_si(value) - read).abs() <= 1e-15 * read,
                "{value} {unit}: {}",
                chosen.of_si(value)
            );
        }
    }
}
