//! Numbers as text that a person or a program reads.

/// Writes a number with the fewest digits that read back as the same number.
pub(crate) fn exact(x: f64) -> String {
    if x.is_nan() {
        "NaN".to_owned()
    } else if x.is_infinite() {
        if x > 0.0 { "inf" } else { "-inf" }.to_owned()
    } else {
        format!("{x:?}")
    }
}

/// Returns the exponent of the leading decimal digit of a number, after rounding to `digits`. The
/// number must be neither 0 nor infinite.
pub(crate) fn decade(x: f64, digits: usize) -> i32 {
    let scientific = format!("{x:.*e}", digits.saturating_sub(1));
    scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// Rounds a number to so many significant digits, without trailing zeros: `0.333333`, `1.5e-07`.
pub(crate) fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".to_owned() } else { exact(x) };
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

/// Writes a power of ten as `e+06` or `e-12`, always with a sign and at least two digits, so that
/// columns line up.
pub(crate) fn exponent(power: i32) -> String {
    format!("e{}{:02}", if power < 0 { '-' } else { '+' }, power.abs())
}

/// Removes the zeros after the last decimal that is not zero.
pub(crate) fn trim_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// Writes a power of ten with a superscript: `10⁻³`.
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
