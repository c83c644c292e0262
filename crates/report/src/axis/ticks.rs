//! Which values are written beside an axis.

use super::scale::AxisScale;
use crate::number::{power_of_ten, trim_zeros};

/// What is written along an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    /// Positions with their labels.
    pub(crate) major: Vec<(f64, String)>,
    /// Positions without labels.
    pub(crate) minor: Vec<f64>,
    /// The labels are to be multiplied by ten to this power.
    pub(crate) exponent: i32,
}

impl AxisScale {
    /// About `target` labelled positions.
    pub(crate) fn ticks(&self, target: usize) -> Ticks {
        if self.log { self.log_ticks(target) } else { self.linear_ticks(target, true) }
    }

    fn linear_ticks(&self, target: usize, factor_out: bool) -> Ticks {
        let (step, mantissa, power) = nice_step((self.high - self.low) / target.max(1) as f64);
        let largest = self.low.abs().max(self.high.abs());
        let leading = largest.log10().floor() as i32;
        let exponent = if factor_out && !(-3..5).contains(&leading) { leading } else { 0 };
        let decimals = usize::try_from(exponent - power).unwrap_or(0);
        let multiples = |step: f64| {
            // A hair beyond the ends, so that the ends themselves are not lost to rounding.
            let first = (self.low / step - 1e-6).ceil();
            let count = ((self.high / step + 1e-6).floor() - first).clamp(-1.0, 200.0);
            (0..=count as i64).filter(move |_| count >= 0.0).map(move |i| first + i as f64)
        };
        let major: Vec<(f64, String)> = multiples(step)
            .map(|i| {
                let label = format!("{:.decimals$}", i * mantissa * 10f64.powi(power - exponent));
                let zero = label.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
                (i * step, if zero { "0".to_owned() } else { label.replace('-', "−") })
            })
            .collect();
        if major.len() < 2 && target < 12 {
            // One number alone gives no scale.
            return self.linear_ticks(target + 1, factor_out);
        }
        // 1 → 5 parts, 2 → 4 parts, 5 → 5 parts
        let parts = if mantissa == 2.0 { 4.0 } else { 5.0 };
        let minor = multiples(step / parts)
            .filter(|i| i.rem_euclid(parts) != 0.0)
            .map(|i| i * step / parts)
            .collect();
        Ticks { major, minor, exponent }
    }

    fn log_ticks(&self, target: usize) -> Ticks {
        let (low, high) = (self.low.log10(), self.high.log10());
        let inside = |x: f64| x >= self.low * (1.0 - 1e-9) && x <= self.high * (1.0 + 1e-9);
        let (first, last) = (low.floor() as i32, high.ceil() as i32);
        let multiples = |digits: &'static [u8]| {
            (first..=last).flat_map(move |p| {
                digits.iter().map(move |&d| (d, p, f64::from(d) * 10f64.powi(p)))
            })
        };
        let of = |digits: &'static [u8]| {
            multiples(digits).filter(|&(_, _, x)| inside(x)).collect::<Vec<_>>()
        };
        let (decades, thirds) = (of(&[1]), of(&[1, 2, 5]));
        let labelled = match (decades.len(), thirds.len()) {
            (3.., _) => decades,
            (_, thirds_in) if (3..=target.max(4) + 2).contains(&thirds_in) => thirds,
            (2, _) => decades,
            _ => {
                // Less than about half a decade: as on a linear axis, only unevenly spaced.
                let mut ticks = self.linear_ticks(target.min(5), false);
                if ticks.major.iter().any(|(_, label)| label.chars().count() > 7) {
                    for (x, label) in &mut ticks.major {
                        *label = scientific(*x);
                    }
                }
                return ticks;
            }
        };
        let skip = if labelled.iter().all(|&(d, ..)| d == 1) {
            labelled.len().div_ceil(target.max(2)) as i32
        } else {
            1
        };
        let every_decade = skip == 1;
        let labelled: Vec<_> = labelled
            .into_iter()
            .filter(|(_, p, _)| every_decade || p.rem_euclid(skip) == 0)
            .collect();
        let plain = labelled.iter().all(|&(_, p, _)| (-3..4).contains(&p));
        let major: Vec<(f64, String)> = labelled
            .iter()
            .map(|&(digit, power, x)| {
                let label = if plain {
                    trim_zeros(&format!("{x:.3}")).to_owned()
                } else if digit == 1 {
                    power_of_ten(power)
                } else {
                    format!("{digit}·{}", power_of_ten(power))
                };
                (x, label)
            })
            .collect();
        let minor = if high - low > 12.0 {
            Vec::new()
        } else {
            let is_major = |x: f64| major.iter().any(|(m, _)| (x / m - 1.0).abs() < 1e-9);
            of(&[1, 2, 3, 4, 5, 6, 7, 8, 9])
                .into_iter()
                .map(|(_, _, x)| x)
                .filter(|&x| !is_major(x))
                .collect()
        };
        Ticks { major, minor, exponent: 0 }
    }
}

fn scientific(x: f64) -> String {
    let text = format!("{x:.2e}");
    match text.split_once('e').map(|(m, p)| (m, p.parse::<i32>())) {
        Some((mantissa, Ok(power))) => format!("{}·{}", trim_zeros(mantissa), power_of_ten(power)),
        _ => text,
    }
    .replace('-', "−")
}

/// The number among 1, 2, 5 times a power of ten that is nearest to `raw`, with its digit and
/// power.
fn nice_step(raw: f64) -> (f64, f64, i32) {
    let power = raw.log10().floor() as i32;
    let unit = 10f64.powi(power);
    let (mantissa, power) = match raw / unit {
        // Geometric means of neighbours: the nearest on a logarithmic ruler.
        r if r <= 2f64.sqrt() => (1.0, power),
        r if r <= 10f64.sqrt() => (2.0, power),
        r if r <= 50f64.sqrt() => (5.0, power),
        _ => (1.0, power + 1),
    };
    (mantissa * 10f64.powi(power), mantissa, power)
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
                prop_assert!((-1e-5..=1.0 + 1e-5).contains(&scale.at(*x)), "{scale:?} {x}");
            }
            for x in values.into_iter().filter(|x| drawable(*x, log)) {
                prop_assert!((0.0..=1.0).contains(&scale.at(x)), "{scale:?} {x}");
            }
        }
    }
}
