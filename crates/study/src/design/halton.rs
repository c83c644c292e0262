//! Halton's sequence (1960, doi:10.1007/BF01386213): the digits of the index in the base of the
//! dimension, a prime number, are those of the coordinate, the last one first. Each place of each
//! dimension has a random permutation of its digits, as Owen (2017, arXiv:1706.02808) recommends;
//! without, dimensions of large bases go together for many points.

use contact::SplitMix64;

use super::bits::{DIGITS, fraction, hashed};

/// The digits of each dimension.
#[derive(Debug)]
pub(super) struct Halton(Vec<Digits>);

/// The permutations of the digits of a dimension.
#[derive(Debug)]
struct Digits {
    base: u32,
    /// The permutation of each place, the first place after the point first.
    places: Vec<Vec<u32>>,
}

impl Halton {
    pub(super) fn new(key: u64, dimensions: usize) -> Halton {
        let digits = |(dimension, base): (usize, u32)| {
            // There are as many places as a coordinate can hold, which are more than any index has.
            let count = (1..).take_while(|places| u64::from(base).pow(*places) <= 1 << DIGITS);
            let place =
                |place: u32| permutation(base, hashed(&[key, dimension as u64, u64::from(place)]));
            Digits { base, places: count.map(place).collect() }
        };
        Halton(primes().take(dimensions).enumerate().map(digits).collect())
    }

    pub(super) fn coordinate(&self, index: u32, dimension: usize) -> f64 {
        let Digits { base, places } = &self.0[dimension];
        let (mut rest, mut digits, mut count) = (index, 0, 1);
        for permutation in places {
            digits = digits * u64::from(*base) + u64::from(permutation[(rest % base) as usize]);
            rest /= base;
            count *= u64::from(*base);
        }
        fraction(digits, count)
    }
}

/// Returns the prime numbers.
fn primes() -> impl Iterator<Item = u32> {
    (2..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0))
}

/// Returns a random permutation of the numbers below `length` (Fisher and Yates).
fn permutation(length: u32, seed: u64) -> Vec<u32> {
    let mut random = SplitMix64(seed);
    let mut numbers: Vec<u32> = (0..length).collect();
    for last in (1..numbers.len()).rev() {
        let other = (u128::from(random.next()) * (last as u128 + 1)) >> 64;
        numbers.swap(last, other as usize);
    }
    numbers
}
