//! Numbers with a bound of their error, for determinants whose sign is to be certain.
//!
//! A ball is a computed number and a radius, and holds the number of exact arithmetic. Every
//! operation adds to the radius what its operands' radii and its own rounding can do; the radius
//! is rounded too, and is lengthened by more than that. The narrow kind computes in double
//! precision. The wide kind computes in pairs of doubles, whose operations have a relative error
//! below 15u² with u = 2⁻⁵³ (M. Joldes, J.-M. Muller, V. Popescu, ACM Trans. Math. Softw. 44
//! (2017) 15res, <https://doi.org/10.1145/3121432>).

/// The sign of a number of exact arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// The number is above 0.
    Positive,
    /// The number is below 0.
    Negative,
    /// The ball holds 0, or is no number.
    Unclear,
}

/// Arithmetic with a bound of the error.
pub(super) trait Ball: Copy + Send + Sync {
    /// Creates the ball of a number that is exact.
    fn exact(value: f64) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn sign(self) -> Sign;
}

/// The factor that makes up for the rounding of a radius, which takes a few operations.
const LONGER: f64 = 1.0 + 16.0 * f64::EPSILON;

/// Returns the sign of all numbers that are at most the radius away.
fn sign(middle: f64, radius: f64) -> Sign {
    if middle > radius {
        Sign::Positive
    } else if middle < -radius {
        Sign::Negative
    } else {
        Sign::Unclear
    }
}

/// A ball in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Narrow {
    middle: f64,
    radius: f64,
}

impl Narrow {
    /// The largest relative rounding of an operation.
    const ROUNDING: f64 = 0.5 * f64::EPSILON;
    /// The largest absolute rounding of an operation whose result is tiny.
    const TINY: f64 = f64::MIN_POSITIVE;

    fn rounded(middle: f64, radius: f64) -> Self {
        Self { middle, radius: (radius + Self::ROUNDING * middle.abs() + Self::TINY) * LONGER }
    }
}

impl Ball for Narrow {
    fn exact(value: f64) -> Self {
        Self { middle: value, radius: 0.0 }
    }

    fn plus(self, other: Self) -> Self {
        Self::rounded(self.middle + other.middle, self.radius + other.radius)
    }

    fn minus(self, other: Self) -> Self {
        Self::rounded(self.middle - other.middle, self.radius + other.radius)
    }

    fn times(self, other: Self) -> Self {
        let radius =
            self.middle.abs() * other.radius + self.radius * (other.middle.abs() + other.radius);
        Self::rounded(self.middle * other.middle, radius)
    }

    fn over(self, other: Self) -> Self {
        let middle = self.middle / other.middle;
        let least = (other.middle.abs() * (1.0 - f64::EPSILON) - other.radius).max(0.0);
        Self::rounded(middle, (self.radius + middle.abs() * LONGER * other.radius) / least)
    }

    fn sign(self) -> Sign {
        sign(self.middle, self.radius)
    }
}

/// A ball in pairs of doubles, high + low.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide {
    high: f64,
    low: f64,
    radius: f64,
}

impl Wide {
    /// The largest relative rounding of an operation, twice the bound that is proved.
    const ROUNDING: f64 = 30.0 * Narrow::ROUNDING * Narrow::ROUNDING;
    /// The largest absolute rounding of an operation whose result is tiny: a product of two doubles
    /// is the sum of two unless the smaller one underflows.
    const TINY: f64 = 1e-280;

    fn rounded([high, low]: [f64; 2], radius: f64) -> Self {
        Self { high, low, radius: (radius + Self::ROUNDING * high.abs() + Self::TINY) * LONGER }
    }

    /// Returns a bound of the absolute value of its middle.
    fn size(self) -> f64 {
        self.high.abs() * LONGER
    }
}

/// Returns a + b as a rounded sum and its error, if |a| ≥ |b|.
fn sum_ordered(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    [sum, b - (sum - a)]
}

/// Returns a + b as a rounded sum and its error.
fn sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let of_b = sum - a;
    [sum, (a - (sum - of_b)) + (b - of_b)]
}

/// Returns a·b as a rounded product and its error, after Dekker and Veltkamp.
fn product(a: f64, b: f64) -> [f64; 2] {
    let split = |x: f64| {
        let scaled = 134_217_729.0 * x;
        let high = scaled - (scaled - x);
        [high, x - high]
    };
    let ([a_high, a_low], [b_high, b_low]) = (split(a), split(b));
    let rounded = a * b;
    let error = ((a_high * b_high - rounded) + a_high * b_low + a_low * b_high) + a_low * b_low;
    [rounded, error]
}

/// Returns the sum of two pairs.
fn pair_sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let ([high, high_error], [low, low_error]) = (sum(a[0], b[0]), sum(a[1], b[1]));
    let [high, rest] = sum_ordered(high, high_error + low);
    sum_ordered(high, low_error + rest)
}

/// Returns the product of a pair and a double.
fn pair_times(a: [f64; 2], b: f64) -> [f64; 2] {
    let [high, error] = product(a[0], b);
    let [high, rest] = sum_ordered(high, a[1] * b);
    sum_ordered(high, rest + error)
}

impl Ball for Wide {
    fn exact(value: f64) -> Self {
        Self { high: value, low: 0.0, radius: 0.0 }
    }

    fn plus(self, other: Self) -> Self {
        let middle = pair_sum([self.high, self.low], [other.high, other.low]);
        Self::rounded(middle, self.radius + other.radius)
    }

    fn minus(self, other: Self) -> Self {
        let middle = pair_sum([self.high, self.low], [-other.high, -other.low]);
        Self::rounded(middle, self.radius + other.radius)
    }

    fn times(self, other: Self) -> Self {
        let [high, error] = product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let radius = self.size() * other.radius + self.radius * (other.size() + other.radius);
        Self::rounded(sum_ordered(high, error + cross), radius)
    }

    fn over(self, other: Self) -> Self {
        let by = [other.high, other.low];
        let first = self.high / other.high;
        let [high, low] = pair_times(by, first);
        let rest = pair_sum([self.high, self.low], [-high, -low]);
        let middle = sum_ordered(first, rest[0] / other.high);
        let least = (other.high.abs() * (1.0 - f64::EPSILON) - other.radius).max(0.0);
        let size = middle[0].abs() * LONGER;
        Self::rounded(middle, (self.radius + size * other.radius) / least)
    }

    fn sign(self) -> Sign {
        // The pair is normalised, so its sign is that of the high part, which is at most one
        // rounding larger than the pair.
        sign(self.high * (1.0 - f64::EPSILON), self.radius)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Says if a ball holds a fraction of integers, which are exact doubles: that is, if the ball
    /// less the fraction may be 0.
    fn holds<B: Ball>(ball: B, numerator: f64, denominator: f64) -> bool {
        ball.times(B::exact(denominator)).minus(B::exact(numerator)).sign() == Sign::Unclear
    }

    fn length(ball: Wide) -> f64 {
        ball.radius
    }

    proptest! {
        /// Fractions of whole numbers are known exactly.
        #[test]
        fn balls_hold_the_exact_result(
            a in 1i32..1000, b in 1i32..1000, c in -1000i32..1000, d in 1i32..1000,
        ) {
            fn check<B: Ball>([a, b, c, d]: [f64; 4]) -> bool {
                let (x, y) = (
                    B::exact(a).over(B::exact(b)),
                    B::exact(c).over(B::exact(d)),
                );
                let zero = B::exact(0.0);
                let negative = zero.minus(x);
                holds(x.plus(y), a * d + c * b, b * d)
                    && holds(x.minus(y), a * d - c * b, b * d)
                    && holds(x.times(y), a * c, b * d)
                    && holds(y.over(x), c * b, a * d)
                    && x.sign() == Sign::Positive
                    && negative.sign() == Sign::Negative
                    && zero.sign() == Sign::Unclear
            }
            let numbers = [a, b, c, d].map(f64::from);
            prop_assert!(check::<Narrow>(numbers) && check::<Wide>(numbers));
        }

        /// A difference that double precision cannot tell from 0 has a sign in pairs.
        #[test]
        fn pairs_tell_small_differences(a in 1i32..1000, b in 1i32..1000, exponent in 70i32..80) {
            let small = 2_f64.powi(-exponent);
            fn difference<B: Ball>(a: f64, b: f64, small: f64) -> B {
                let x = B::exact(a).over(B::exact(b));
                x.plus(B::exact(small)).minus(x)
            }
            let [a, b] = [a, b].map(f64::from);
            let wide: Wide = difference(a, b, small);
            prop_assert_eq!(wide.sign(), Sign::Positive);
            prop_assert!(length(wide) < 1e-27 * (a / b).max(1.0));
            let narrow: Narrow = difference(a, b, small);
            prop_assert_eq!(narrow.sign(), Sign::Unclear);
        }
    }

    #[test]
    fn what_is_no_number_has_no_sign() {
        fn unclear<B: Ball>() -> bool {
            let [zero, one] = [0.0, 1.0].map(B::exact);
            let lost =
                [one.over(zero), zero.over(zero), B::exact(f64::NAN), one.over(zero).minus(one)];
            lost.into_iter().all(|ball| ball.sign() == Sign::Unclear)
        }
        assert!(unclear::<Narrow>() && unclear::<Wide>());
    }
}
