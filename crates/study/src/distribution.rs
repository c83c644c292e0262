//! Distributions of a number: what a sample draws from, as functions of a uniform one.
//!
//! A coordinate of a [design](crate::design) becomes a value by the inverse of the cumulative
//! distribution function. Logarithms and exponentials come from `libm`, which is computed in the
//! same way everywhere; those of the system differ from machine to machine in their last digits.

use std::f64::consts::SQRT_2;

/// A distribution of the values of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    /// Equally likely between two numbers.
    Uniform {
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
    },
    /// A logarithm that is equally likely between those of two positive numbers.
    LogUniform {
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
    },
    /// A normal distribution, or what of it lies between two bounds.
    Normal(BoundedNormal),
    /// A logarithm that is distributed normally, in units of 1, or what of it lies between two
    /// bounds.
    LogNormal {
        /// The distribution of the logarithm.
        logarithm: BoundedNormal,
        /// The lower bound as it was given, or 0.
        from: f64,
        /// The upper bound as it was given, or infinity.
        to: f64,
    },
    /// A density that rises in a straight line from 0 to the mode and falls to 0 again.
    Triangular {
        /// The lower end.
        from: f64,
        /// The most likely value, which may be one of the ends.
        mode: f64,
        /// The upper end.
        to: f64,
    },
    /// Some values that the axis lists, each with a weight.
    Discrete(CumulativeWeights),
}

/// A normal distribution between two bounds, which may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedNormal {
    /// The mean of the distribution without bounds.
    pub mean: f64,
    /// The standard deviation of the distribution without bounds.
    pub deviation: f64,
    /// The lower bound.
    pub from: f64,
    /// The upper bound.
    pub to: f64,
}

/// The sums of the weights of the values up to each one, over the sum of all.
#[derive(Clone, Debug, PartialEq)]
pub struct CumulativeWeights(Vec<f64>);

impl Distribution {
    /// Returns the name by which a study file calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Distribution::Uniform { .. } => "uniform",
            Distribution::LogUniform { .. } => "log-uniform",
            Distribution::Normal(_) => "normal",
            Distribution::LogNormal { .. } => "log-normal",
            Distribution::Triangular { .. } => "triangular",
            Distribution::Discrete(_) => "discrete",
        }
    }

    /// Returns the value below which a part of the distribution lies; for a discrete one the index
    /// of the value. The part is above 0 and below 1.
    pub fn quantile(&self, part: f64) -> f64 {
        match self {
            Distribution::Uniform { from, to } => between(*from, *to, part),
            Distribution::LogUniform { from, to } => {
                let logarithm = between(libm::log(*from), libm::log(*to), part);
                libm::exp(logarithm).clamp(*from, *to)
            }
            Distribution::Normal(normal) => normal.quantile(part),
            // The exponential of a bound's logarithm may lie beyond the bound.
            Distribution::LogNormal { logarithm, from, to } => {
                libm::exp(logarithm.quantile(part)).clamp(*from, *to)
            }
            Distribution::Triangular { from, mode, to } => {
                let (rise, fall, width) = (mode - from, to - mode, to - from);
                // Halves of the range and no squares, so that nothing overflows.
                match part * width < rise {
                    true => from + rise * (part * (width / rise)).sqrt(),
                    false => to - fall * ((1.0 - part) * (width / fall)).sqrt(),
                }
                .clamp(*from, *to)
            }
            Distribution::Discrete(weights) => weights.index(part) as f64,
        }
    }

    /// Returns whether its values are drawn by their logarithms.
    pub fn is_log(&self) -> bool {
        matches!(self, Distribution::LogUniform { .. } | Distribution::LogNormal { .. })
    }
}

/// Returns the number that is a part of the way from one number to another.
fn between(from: f64, to: f64, part: f64) -> f64 {
    (from * (1.0 - part) + to * part).clamp(from, to)
}

impl BoundedNormal {
    /// Returns the probability of the distribution without bounds to lie between them.
    pub fn share(&self) -> f64 {
        let [low, high] = self.standard_bounds();
        below(high) - below(low)
    }

    /// Returns the bounds in standard deviations from the mean, so that most of what lies between
    /// them is below 0: the tail there keeps its digits, and the one above does not. Mirroring an
    /// upper part makes it a lower one.
    fn standard_bounds(&self) -> [f64; 2] {
        let [low, high] = [self.from, self.to].map(|bound| (bound - self.mean) / self.deviation);
        if low + high > 0.0 { [-high, -low] } else { [low, high] }
    }

    fn quantile(&self, part: f64) -> f64 {
        let [low, high] = self.standard_bounds();
        let is_mirrored = low != (self.from - self.mean) / self.deviation;
        let part = if is_mirrored { 1.0 - part } else { part };
        let [before, after] = [low, high].map(below);
        let standard = standard_quantile(between(before, after, part)).clamp(low, high);
        let signed = if is_mirrored { -standard } else { standard };
        (self.mean + self.deviation * signed).clamp(self.from, self.to)
    }
}

impl CumulativeWeights {
    /// Makes the weights of some values, of which none is negative and some are not 0.
    pub fn new(weights: &[f64]) -> CumulativeWeights {
        // The largest is taken out first, so that no sum overflows.
        let largest = weights.iter().fold(0.0, |largest: f64, weight| largest.max(*weight));
        let sums: Vec<f64> = weights
            .iter()
            .scan(0.0, |sum, weight| {
                *sum += weight / largest;
                Some(*sum)
            })
            .collect();
        let all = sums.last().copied().unwrap_or(1.0);
        CumulativeWeights(sums.into_iter().map(|sum| sum / all).collect())
    }

    /// Returns the index of the value that a part of all weights falls upon.
    pub fn index(&self, part: f64) -> usize {
        self.0.partition_point(|sum| *sum <= part).min(self.0.len().saturating_sub(1))
    }
}

/// Returns the probability of a standard normal number to be below `x`.
fn below(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

/// Returns the number below which a part of the standard normal distribution lies, to about 1 part
/// in 10¹⁶: algorithm AS 241, PPND16 (Wichura 1988, doi:10.2307/2347330).
fn standard_quantile(part: f64) -> f64 {
    let centred = part - 0.5;
    if centred.abs() <= 0.425 {
        let r = 0.180_625 - centred * centred;
        return centred * ratio(r, &CENTRE);
    }
    let tail = if centred < 0.0 { part } else { 1.0 - part };
    if tail <= 0.0 {
        return if centred < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let r = (-libm::log(tail)).sqrt();
    let distance = if r <= 5.0 { ratio(r - 1.6, &NEAR) } else { ratio(r - 5.0, &FAR) };
    if centred < 0.0 { -distance } else { distance }
}

/// The coefficients of a quotient of two polynomials, those of the lowest powers first.
struct Quotient {
    above: [f64; 8],
    below: [f64; 8],
}

fn ratio(x: f64, Quotient { above, below }: &Quotient) -> f64 {
    let value = |polynomial: &[f64; 8]| polynomial.iter().rev().fold(0.0, |sum, c| sum * x + c);
    value(above) / value(below)
}

/// The quotient for parts from 0.075 to 0.925, in 0.425² − (part − ½)².
#[expect(clippy::excessive_precision, reason = "these are the digits of the source")]
const CENTRE: Quotient = Quotient {
    above: [
        3.387_132_872_796_366_608_0,
        1.331_416_678_917_843_774_5e2,
        1.971_590_950_306_551_442_7e3,
        1.373_169_376_550_946_112_5e4,
        4.592_195_393_154_987_145_7e4,
        6.726_577_092_700_870_085_3e4,
        3.343_057_558_358_812_810_5e4,
        2.509_080_928_730_122_672_7e3,
    ],
    below: [
        1.0,
        4.231_333_070_160_091_125_2e1,
        6.871_870_074_920_579_082_9e2,
        5.394_196_021_424_751_107_7e3,
        2.121_379_430_158_659_586_7e4,
        3.930_789_580_009_271_061_0e4,
        2.872_908_573_572_194_267_4e4,
        5.226_495_278_852_854_561_0e3,
    ],
};

/// The quotient for tails down to e⁻²⁵, in √(−ln tail) − 1.6.
#[expect(clippy::excessive_precision, reason = "these are the digits of the source")]
const NEAR: Quotient = Quotient {
    above: [
        1.423_437_110_749_683_577_34,
        4.630_337_846_156_545_295_90,
        5.769_497_221_460_691_405_50,
        3.647_848_324_763_204_605_04,
        1.270_458_252_452_368_382_58,
        2.417_807_251_774_506_117_70e-1,
        2.272_384_498_926_918_458_33e-2,
        7.745_450_142_783_414_076_40e-4,
    ],
    below: [
        1.0,
        2.053_191_626_637_758_821_87,
        1.676_384_830_183_803_849_40,
        6.897_673_349_851_000_045_50e-1,
        1.481_039_764_274_800_745_90e-1,
        1.519_866_656_361_645_719_66e-2,
        5.475_938_084_995_344_946_00e-4,
        1.050_750_071_644_416_843_24e-9,
    ],
};

/// The quotient for tails below e⁻²⁵, in √(−ln tail) − 5.
#[expect(clippy::excessive_precision, reason = "these are the digits of the source")]
const FAR: Quotient = Quotient {
    above: [
        6.657_904_643_501_103_777_20,
        5.463_784_911_164_114_369_90,
        1.784_826_539_917_291_335_80,
        2.965_605_718_285_048_912_30e-1,
        2.653_218_952_657_612_309_30e-2,
        1.242_660_947_388_078_438_60e-3,
        2.711_555_568_743_487_578_15e-5,
        2.010_334_399_292_288_132_65e-7,
    ],
    below: [
        1.0,
        5.998_322_065_558_879_376_90e-1,
        1.369_298_809_227_358_053_10e-1,
        1.487_536_129_085_061_485_25e-2,
        7.868_691_311_456_132_591_00e-4,
        1.846_318_317_510_054_681_80e-5,
        1.421_511_758_316_445_888_70e-7,
        2.044_263_103_389_939_785_64e-15,
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: BoundedNormal =
        BoundedNormal { mean: 0.0, deviation: 1.0, from: f64::NEG_INFINITY, to: f64::INFINITY };

    fn log_normal(logarithm: BoundedNormal) -> Distribution {
        let [from, to] = [logarithm.from, logarithm.to].map(libm::exp);
        Distribution::LogNormal { logarithm, from, to }
    }

    fn is_near(found: f64, expected: f64) -> bool {
        (found - expected).abs() <= 4e-15 * expected.abs()
    }

    /// The expected values were computed with 50 digits (mpmath).
    #[test]
    fn quantiles_of_the_normal_distribution_are_known() {
        for (part, expected) in [
            (0.5, 0.0),
            (0.75, 0.674_489_750_196_081_7),
            (0.95, 1.644_853_626_951_472_7),
            (0.975, 1.959_963_984_540_054),
            (0.999, 3.090_232_306_167_813_5),
            (1e-10, -6.361_340_902_404_056),
            (1e-20, -9.262_340_089_798_408),
            (1e-300, -37.047_096_299_361_2),
        ] {
            let found = standard_quantile(part);
            assert!((found - expected).abs() <= 4e-15 * expected.abs(), "{part}: {found}");
            assert!((below(found) - part).abs() < 1e-12 * part.max(1e-3), "{part}");
        }
    }

    #[test]
    fn quantiles_rise_within_the_bounds() {
        let bounded = |from: f64, to: f64| BoundedNormal { mean: 3.0, deviation: 2.0, from, to };
        let distributions = [
            Distribution::Uniform { from: -2.0, to: 5.0 },
            Distribution::LogUniform { from: 1e-6, to: 1e9 },
            Distribution::Normal(FREE),
            Distribution::Normal(bounded(0.0, f64::INFINITY)),
            Distribution::Normal(bounded(23.0, 25.0)),
            Distribution::Normal(bounded(-27.0, -20.0)),
            log_normal(bounded(1.0, 2.0)),
            Distribution::Triangular { from: -1.0, mode: -1.0, to: 4.0 },
            Distribution::Triangular { from: 0.0, mode: 4.0, to: 4.0 },
            Distribution::Triangular { from: -1e308, mode: 0.0, to: 0.7e308 },
            Distribution::Discrete(CumulativeWeights::new(&[1.0, 0.0, 3.0, 1e-9])),
        ];
        let tiny = 1.0 / (1_u64 << 53) as f64;
        for distribution in distributions {
            let parts = (1..1000).map(|n| f64::from(n) / 1000.0);
            let parts = std::iter::once(tiny).chain(parts).chain([1.0 - tiny]);
            let values: Vec<f64> = parts.map(|part| distribution.quantile(part)).collect();
            assert!(values.is_sorted(), "{distribution:?}");
            assert!(values.iter().all(|x| x.is_finite()), "{distribution:?}");
            let ends = match &distribution {
                Distribution::Uniform { from, to }
                | Distribution::LogUniform { from, to }
                | Distribution::Triangular { from, to, .. } => [*from, *to],
                Distribution::Normal(normal) => [normal.from, normal.to],
                Distribution::LogNormal { from, to, .. } => [*from, *to],
                Distribution::Discrete(_) => [0.0, 3.0],
            };
            assert!(values[0] >= ends[0] && values[1000] <= ends[1], "{distribution:?}");
        }
    }

    /// Each part of the distribution is as large as it should be: the density that differences of
    /// quantiles give is that of the definition.
    #[test]
    fn quantiles_have_the_density_of_the_definition() {
        let bounded = BoundedNormal { mean: 1.0, deviation: 0.5, from: 0.3, to: 1.2 };
        let normal = |x: f64| (-0.5 * ((x - 1.0) / 0.5_f64).powi(2)).exp();
        let triangle = |x: f64| if x < 1.0 { x / 1.0 } else { (4.0 - x) / 3.0 };
        let cases: [(Distribution, &dyn Fn(f64) -> f64); 5] = [
            (Distribution::Normal(bounded), &normal),
            (log_normal(bounded), &|x| normal(x.ln()) / x),
            (Distribution::LogUniform { from: 0.1, to: 30.0 }, &|x| 1.0 / x),
            (Distribution::Triangular { from: 0.0, mode: 1.0, to: 4.0 }, &triangle),
            (Distribution::Uniform { from: 2.0, to: 3.0 }, &|_| 1.0),
        ];
        for (distribution, density) in cases {
            let step = 1e-4;
            let slopes = (1..20).map(|n| {
                let part = f64::from(n) / 20.0;
                let [low, x, high] =
                    [part - step, part, part + step].map(|part| distribution.quantile(part));
                2.0 * step / (high - low) / density(x)
            });
            let slopes: Vec<f64> = slopes.collect();
            let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
            // The mode of the triangle lies at a part of 1/4, where the density has a bend.
            let is_flat = |slope: &f64| (slope / mean - 1.0).abs() < 1e-3;
            assert!(slopes.iter().all(is_flat), "{distribution:?}: {slopes:?}");
        }
    }

    /// exp(ln 0.3) is 0.30000000000000004, and exp(ln 7) is 6.999999999999999.
    #[test]
    fn bounds_hold_to_the_last_bit() {
        let tiny = 1.0 / (1_u64 << 53) as f64;
        for n in 1..300 {
            let (from, to) = (f64::from(n) / 10.0, f64::from(n) / 10.0 + 0.1);
            let [least, most] = [from, to].map(libm::log);
            let logarithm = BoundedNormal { mean: 0.5, deviation: 9.0, from: least, to: most };
            let distribution = Distribution::LogNormal { logarithm, from, to };
            for part in [tiny, 0.5, 1.0 - tiny] {
                let value = distribution.quantile(part);
                assert!((from..=to).contains(&value), "{from} to {to}: {value}");
            }
        }
    }

    #[test]
    fn a_far_tail_keeps_its_digits() {
        // 1 part in e of what lies beyond 20 deviations lies beyond 20.0498 (mpmath).
        for sign in [1.0, -1.0_f64] {
            let bounds = [sign * 20.0, sign * 1e6];
            let (from, to) = (bounds[0].min(bounds[1]), bounds[0].max(bounds[1]));
            let tail = Distribution::Normal(BoundedNormal { from, to, ..FREE });
            let part = (-1.0_f64).exp();
            let beyond = tail.quantile(if sign > 0.0 { 1.0 - part } else { part });
            assert!((beyond.abs() - 20.049_814_195_8).abs() < 1e-9, "{beyond}");
            let ratio = below(-beyond.abs()) / below(-20.0);
            assert!((ratio / part - 1.0).abs() < 1e-11, "{beyond}: {ratio}");
        }
        assert!(BoundedNormal { from: 20.0, to: 21.0, ..FREE }.share() > 1e-90);
    }

    #[test]
    fn weights_choose_their_values() {
        let weights = CumulativeWeights::new(&[1.0, 0.0, 3.0]);
        let chosen = [0.01, 0.249, 0.251, 0.999].map(|part| weights.index(part));
        assert_eq!(chosen, [0, 0, 2, 2]);
        assert_eq!(CumulativeWeights::new(&[1e308, 1e308]).index(0.6), 1);
        assert!(is_near(Distribution::Uniform { from: 1.0, to: 3.0 }.quantile(0.25), 1.5));
    }
}
