//! The values that are marked and written along an axis.

use super::scale::AxisScale;
use crate::number::{power_of_ten, trim_zeros};

/// The ticks of an axis and their labels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ticks {
    /// Positions with their labels.
    pub(crate) major: Vec<(f64, String)>,
    /// Positions without labels.
    pub(crate) minor: Vec<f64>,
    /// The power of ten by which the labels are to be multiplied.
    pub(crate) exponent: i32,
}

impl AxisScale {
    /// Chooses about `target` labelled positions.
    pub(crate) fn ticks(&self, target: usize) -> Ticks {
        if self.log { self.log_ticks(target) } else { self.linear_ticks(target, true) }
    }

    /// Chooses positions at equal distances; `factor_out` says whether a power of ten may be left
    /// out of the labels.
    fn linear_ticks(&self, target: usize, factor_out: bool) -> Ticks {
        let step = RoundNumber::nearest((self.high - self.low) / target.max(1) as f64);
        let largest = self.low.abs().max(self.high.abs());
        let leading = largest.log10().floor() as i32;
        let exponent = if factor_out && !(-3..5).contains(&leading) { leading } else { 0 };
        let decimals = usize::try_from(exponent - step.power).unwrap_or(0);
        let multiples = |step: f64| {
            // The range is a hair wider, so that its ends are not lost to rounding.
            let first = (self.low / step - 1e-6).ceil();
            let count = ((self.high / step + 1e-6).floor() - first).clamp(-1.0, 200.0);
            (0..=count as i64).filter(move |_| count >= 0.0).map(move |i| first + i as f64)
        };
        let digit = f64::from(step.digit);
        let major: Vec<(f64, String)> = multiples(step.value)
            .map(|i| {
                let label = format!("{:.decimals$}", i * digit * 10f64.powi(step.power - exponent));
                let zero = label.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
                (i * step.value, if zero { "0".to_owned() } else { label.replace('-', "−") })
            })
            .collect();
        if major.len() < 2 && target < 12 {
            // One number alone gives no scale.
            return self.linear_ticks(target + 1, factor_out);
        }
        // Steps of 1 and 5 are divided into five, steps of 2 into four.
        let divisions = if step.digit == 2 { 4.0 } else { 5.0 };
        let minor = multiples(step.value / divisions)
            .filter(|i| i.rem_euclid(divisions) != 0.0)
            .map(|i| i * step.value / divisions)
            .collect();
        Ticks { major, minor, exponent }
    }

    /// Chooses round numbers on a logarithmic axis.
    fn log_ticks(&self, target: usize) -> Ticks {
        let (decades, thirds) = (self.round_numbers(&[1]), self.round_numbers(&[1, 2, 5]));
        let labelled = match (decades.len(), thirds.len()) {
            (3.., _) => decades,
            (_, count) if (3..=target.max(4) + 2).contains(&count) => thirds,
            (2, _) => decades,
            _ => return self.narrow_log_ticks(target),
        };
        let skip = if labelled.iter().all(|tick| tick.digit == 1) {
            labelled.len().div_ceil(target.max(2)) as i32
        } else {
            1
        };
        let labelled: Vec<RoundNumber> = labelled
            .into_iter()
            .filter(|tick| skip == 1 || tick.power.rem_euclid(skip) == 0)
            .collect();
        let plain = labelled.iter().all(|tick| (-3..4).contains(&tick.power));
        let major: Vec<(f64, String)> =
            labelled.iter().map(|tick| (tick.value, tick.label(plain))).collect();
        let minor = if self.high.log10() - self.low.log10() > 12.0 {
            Vec::new()
        } else {
            let is_major = |x: f64| major.iter().any(|(m, _)| (x / m - 1.0).abs() < 1e-9);
            let all = self.round_numbers(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
            all.into_iter().map(|tick| tick.value).filter(|&x| !is_major(x)).collect()
        };
        Ticks { major, minor, exponent: 0 }
    }

    /// Chooses positions within less than about half a decade: as on a linear axis, only that they
    /// are unevenly spaced.
    fn narrow_log_ticks(&self, target: usize) -> Ticks {
        let mut ticks = self.linear_ticks(target.min(5), false);
        if ticks.major.iter().any(|(_, label)| label.chars().count() > 7) {
            for (x, label) in &mut ticks.major {
                *label = scientific(*x);
            }
        }
        ticks
    }

    /// Lists the numbers in the range that are one of some digits times a power of ten.
    fn round_numbers(&self, digits: &[u8]) -> Vec<RoundNumber> {
        let inside = |x: f64| x >= self.low * (1.0 - 1e-9) && x <= self.high * (1.0 + 1e-9);
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        (first..=last)
            .flat_map(|power| digits.iter().map(move |&digit| RoundNumber::new(digit, power)))
            .filter(|number| inside(number.value))
            .collect()
    }
}

/// A digit times a power of ten.
struct RoundNumber {
    digit: u8,
    power: i32,
    value: f64,
}

impl RoundNumber {
    fn new(digit: u8, power: i32) -> RoundNumber {
        RoundNumber { digit, power, value: f64::from(digit) * 10f64.powi(power) }
    }

    /// Returns the number among 1, 2, 5 times a power of ten that is nearest to `raw`.
    fn nearest(raw: f64) -> RoundNumber {
        let power = raw.log10().floor() as i32;
        match raw / 10f64.powi(power) {
            // The limits are geometric means: the nearest on a logarithmic ruler.
            r if r <= 2f64.sqrt() => RoundNumber::new(1, power),
            r if r <= 10f64.sqrt() => RoundNumber::new(2, power),
            r if r <= 50f64.sqrt() => RoundNumber::new(5, power),
            _ => RoundNumber::new(1, power + 1),
        }
    }

    /// Writes the number, with all its zeros if it is to be `plain`.
    fn label(&self, plain: bool) -> String {
        if plain {
            trim_zeros(&format!("{:.3}", self.value)).to_owned()
        } else if self.digit == 1 {
            power_of_ten(self.power)
        } else {
            format!("{}·{}", self.digit, power_of_ten(self.power))
        }
    }
}

/// Writes a number with two decimals and its power of ten.
fn scientific(x: f64) -> String {
    let text = format!("{x:.2e}");
    match text.split_once('e').map(|(m, p)| (m, p.parse::<i32>())) {
        Some((mantissa, Ok(power))) => format!("{}·{}", trim_zeros(mantissa), power_of_ten(power)),
        _ => text,
    }
    .replace('-', "−")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::scale::drawable;
    use super::*;

    fn labels(low: f64, high: f64, log: bool) -> Vec<String> {
        AxisScale { low, high, log }.ticks(7).major.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(0.0, 1.0, false), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(-0.3, 0.31, false), ["−0.3", "−0.2", "−0.1", "0", "0.1", "0.2", "0.3"]);
        assert_eq!(
            labels(0.001, 1000.0, true),
            ["0.001", "0.01", "0.1", "1", "10", "100", "1000"][..].to_vec()
        );
        assert_eq!(labels(1e-9, 1e-6, true), ["10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶"]);
        assert_eq!(labels(4.0, 60.0, true), ["5", "10", "20", "50"]);
        assert_eq!(
            labels(1.1, 1.4, true),
            ["1.10", "1.15", "1.20", "1.25", "1.30", "1.35", "1.40"]
        );
    }

    #[test]
    fn large_and_small_numbers_leave_their_power_to_the_label() {
        let ticks = AxisScale { low: 0.0, high: 3e7, log: false }.ticks(4);
        assert_eq!((ticks.exponent, ticks.major[1].1.as_str()), (7, "1"));
        let ticks = AxisScale { low: 0.0, high: 3e-7, log: false }.ticks(4);
        assert_eq!((ticks.exponent, ticks.major[1].1.as_str()), (-7, "1"));
    }

    proptest! {
        #[test]
        fn any_values_have_a_range_with_ticks(values: Vec<f64>, log: bool, target in 1usize..12) {
            let scale = AxisScale::around(values.iter().copied(), log);
            prop_assert!(scale.low < scale.high && (scale.high - scale.low).is_finite(), "{scale:?}");
            let ticks = scale.ticks(target);
            prop_assert!((1..60).contains(&ticks.major.len()), "{ticks:?}");
            for (x, _) in &ticks.major {
                prop_assert!((-1e-5..=1.0 + 1e-5).contains(&scale.fraction(*x)), "{scale:?} {x}");
            }
            for x in values.into_iter().filter(|x| drawable(*x, log)) {
                prop_assert!((0.0..=1.0).contains(&scale.fraction(x)), "{scale:?} {x}");
            }
        }
    }
}
