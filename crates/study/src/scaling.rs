//! Numbers as texts times the scale of a unit, correctly rounded.

/// The scale of a unit: what a number of it is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum UnitScale {
    /// A power of ten, which is applied to the decimal text.
    Ten(i32),
    /// A whole number times a power of ten below 1, which are applied to the decimal text.
    Decimal(u64, i32),
    /// A conventional factor.
    Times(f64),
}

/// The powers of ten that are doubles without rounding.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Returns a decimal number times `factor`·10^`shift`, correctly rounded; `None` if the number does
/// not look as most do. A whole number below 2⁵³ and a power of ten up to 10²² are exact, so that
/// their product or quotient is rounded once (Clinger 1990, doi:10.1145/93542.93557). Files hold
/// millions of numbers, and this needs no memory for any.
pub(crate) fn scaled_at_once(number: &str, factor: u64, shift: i32) -> Option<f64> {
    let (is_negative, digits) = match number.as_bytes() {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    let (mut whole, mut figures, mut decimals) = (0u64, 0, None);
    let mut rest = digits;
    while let [byte, behind @ ..] = rest {
        match byte {
            b'0'..=b'9' if figures < 19 => {
                whole = 10 * whole + u64::from(byte - b'0');
                figures += 1;
                decimals = decimals.map(|count: i32| count + 1);
            }
            b'.' if decimals.is_none() => decimals = Some(0),
            b'e' | b'E' => break,
            _ => return None,
        }
        rest = behind;
    }
    let exponent = match rest {
        [] => 0,
        [_, b'-', digits @ ..] => -small_number(digits)?,
        [_, b'+', digits @ ..] | [_, digits @ ..] => small_number(digits)?,
    };
    let whole = whole.checked_mul(factor).filter(|whole| figures > 0 && *whole < 1 << 53)?;
    let power = shift + exponent - decimals.unwrap_or(0);
    let exact = *EXACT_POWERS.get(power.unsigned_abs() as usize)?;
    let size = if power < 0 { whole as f64 / exact } else { whole as f64 * exact };
    Some(if is_negative { -size } else { size })
}

/// Returns the value of one to three digits.
fn small_number(digits: &[u8]) -> Option<i32> {
    let is_number = (1..=3).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit);
    is_number.then(|| digits.iter().fold(0, |sum, digit| 10 * sum + i32::from(digit - b'0')))
}

/// Returns a decimal number times the scale of its unit.
pub(crate) fn scaled(number: &str, scale: UnitScale) -> Option<f64> {
    scaled_at_once_by(number, scale).or_else(|| scaled_by_text(number, scale))
}

/// Returns a decimal number times the scale of its unit, if [`scaled_at_once`] can tell it.
pub(crate) fn scaled_at_once_by(number: &str, scale: UnitScale) -> Option<f64> {
    match scale {
        UnitScale::Ten(exponent) => scaled_at_once(number, 1, exponent),
        UnitScale::Decimal(factor, exponent) => scaled_at_once(number, factor, exponent),
        UnitScale::Times(_) => None,
    }
}

/// Returns a decimal number of any length times the scale of its unit.
pub(crate) fn scaled_by_text(number: &str, scale: UnitScale) -> Option<f64> {
    match scale {
        UnitScale::Ten(0) => number.parse().ok(),
        UnitScale::Ten(exponent) => shifted(number, exponent),
        UnitScale::Decimal(factor, exponent) => match multiplied(number, factor) {
            Some(product) => shifted(&product, exponent),
            None => number.parse::<f64>().ok().map(|x| x * factor as f64 / 10f64.powi(-exponent)),
        },
        UnitScale::Times(factor) => number.parse::<f64>().ok().map(|x| x * factor),
    }
}

/// Returns a decimal number times a whole one, exactly; `None` if it has too many digits or is no
/// number.
fn multiplied(number: &str, factor: u64) -> Option<String> {
    let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let (sign, digits) = match mantissa.strip_prefix(['+', '-']) {
        Some(digits) if mantissa.starts_with('-') => ("-", digits),
        Some(digits) => ("", digits),
        None => ("", mantissa),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    if digits.bytes().any(|byte| !(byte.is_ascii_digit() || byte == b'.')) {
        return None;
    }
    let product = format!("{whole}{fraction}").parse::<u128>().ok()?.checked_mul(factor.into())?;
    let exponent = exponent.parse::<i64>().ok()?.checked_sub(fraction.len() as i64)?;
    Some(format!("{sign}{product}e{exponent}"))
}

/// Returns `number`·10^`shift`, correctly rounded.
fn shifted(number: &str, shift: i32) -> Option<f64> {
    let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let exponent = exponent.parse::<i32>().ok()?.checked_add(shift)?;
    format!("{mantissa}e{exponent}").parse().ok()
}
