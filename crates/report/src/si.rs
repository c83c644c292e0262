//! Numbers and units as a person reads them.

/// Symbols that take a prefix. A unit that does not begin with one of them is left as it is: `kg`,
/// `1`, `%`, `°`.
const SYMBOLS: [&str; 9] = ["Pa", "Hz", "m", "N", "J", "W", "s", "V", "A"];
const PREFIXES: [&str; 11] = ["f", "p", "n", "µ", "m", "", "k", "M", "G", "T", "P"];

/// A unit with its prefix, and the number by which SI values are divided to be read in it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unit {
    pub(crate) name: String,
    /// Power of ten that the prefix stands for.
    exponent: i32,
}

impl Unit {
    /// A unit as it is, without a prefix.
    pub(crate) fn plain(unit: &str) -> Unit {
        Unit { name: unit.to_owned(), exponent: 0 }
    }

    /// The unit with the prefix that brings `magnitude` (SI) between 1 and 1000.
    pub(crate) fn fitting(unit: &str, magnitude: f64) -> Unit {
        let plain = Unit::plain(unit);
        let Some((symbol, power)) = leading_symbol(unit) else { return plain };
        if !(magnitude.is_finite() && magnitude > 0.0) {
            return plain;
        }
        // The rounding of log10 must not turn 1000 Pa into 1000 Pa.
        let step = ((magnitude.log10() + 1e-9) / f64::from(3 * power)).floor() as i32;
        let highest = match symbol {
            "s" => 0, // nobody reads kiloseconds
            "m" => 1,
            // moduli are given in GPa
            "Pa" => 3,
            _ => 5,
        };
        let step = step.clamp(-5, highest);
        let prefix = PREFIXES[(step + 5) as usize];
        Unit { name: format!("{prefix}{unit}"), exponent: 3 * step * power }
    }

    /// An SI value in this unit.
    pub(crate) fn of_si(&self, x: f64) -> f64 {
        // Powers of ten up to 10²² are exact, their inverses are not.
        if self.exponent < 0 {
            x * 10f64.powi(-self.exponent)
        } else {
            x / 10f64.powi(self.exponent)
        }
    }
}

/// The symbol that a unit begins with, if it takes a prefix, and the power it has.
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

/// The exponent of the leading decimal digit of a number that is neither 0 nor infinite, after
/// rounding to `digits`.
pub(crate) fn decade(x: f64, digits: usize) -> i32 {
    let scientific = format!("{x:.*e}", digits.saturating_sub(1));
    scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// A number rounded to so many significant digits, without trailing zeros: `0.333333`, `1.5e-07`.
pub(crate) fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".to_owned() } else { crate::delimited::exact(x) };
    }
    let leading = decade(x, digits);
    if (-5..digits.max(1) as i32).contains(&leading) {
        let decimals = (digits as i32 - 1 - leading).max(0) as usize;
        trim_zeros(&format!("{x:.decimals$}")).to_owned()
    } else {
        let text = format!("{x:.*e}", digits.saturating_sub(1));
        let (mantissa, _) = text.split_once('e').unwrap_or((&text, ""));
        format!("{}{}", trim_zeros(mantissa), exponent(leading))
    }
}

/// `e+06`, `e-12`: at least two digits, always a sign, so that columns line up.
pub(crate) fn exponent(power: i32) -> String {
    format!("e{}{:02}", if power < 0 { '-' } else { '+' }, power.abs())
}

/// The number without zeros after its last decimal that is not zero.
pub(crate) fn trim_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// A power of ten with a superscript: `10⁻³`.
pub(crate) fn power_of_ten(power: i32) -> String {
    let superscript = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    format!("10{}", power.to_string().chars().map(superscript).collect::<String>())
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
            let chosen = Unit::fitting(unit, value);
            assert_eq!(chosen.name, name, "{value} {unit}");
            assert!(
                (chosen.of_si(value) - read).abs() <= 1e-15 * read,
                "{value} {unit}: {}",
                chosen.of_si(value)
            );
        }
    }

    #[test]
    fn significant_digits() {
        for (x, text) in [
            (1.0 / 3.0, "0.333333"),
            (999_999.7, "1e+06"),
            (123_456.0, "123456"),
            (0.1 + 0.2, "0.3"),
            (-1.5e-7, "-1.5e-07"),
            (1e-5, "0.00001"),
            (0.0, "0"),
            (-0.0, "0"),
            (f64::INFINITY, "inf"),
            (f64::MIN_POSITIVE, "2.22507e-308"),
        ] {
            assert_eq!(significant(x, 6), text);
        }
        assert_eq!(power_of_ten(-12), "10⁻¹²");
        assert_eq!(power_of_ten(340), "10³⁴⁰");
    }
}
