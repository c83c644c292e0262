//! Random bits, permutations and fractions that follow from numbers alone.

use contact::SplitMix64;

/// The number of binary digits of a coordinate. A half of the last digit is added to each, so that
/// none is 0 or 1, and that takes one more digit of the 53 that a double has.
pub(super) const DIGITS: u32 = 52;

/// Returns 64 bits that follow from some numbers and look random.
pub(super) fn hashed(numbers: &[u64]) -> u64 {
    numbers.iter().fold(0, |state, number| SplitMix64(state ^ number).next())
}

/// Returns the number above 0 and below 1 of which the upper of some bits are the digits.
pub(super) fn inside(bits: u64) -> f64 {
    fraction(bits >> (64 - DIGITS), 1 << DIGITS)
}

/// Returns the middle of the interval with an index among `count` equal ones of the unit interval.
/// Below 2⁵² of them, it is correctly rounded, and neither 0 nor 1.
pub(super) fn fraction(index: u64, count: u64) -> f64 {
    (index as f64 + 0.5) / count as f64
}

/// Returns the place of a number below `length` in a permutation that the key chooses.
///
/// A Feistel network permutes the numbers below a power of 4, and is repeated until the number is
/// below `length` again (Black and Rogaway 2002, doi:10.1007/3-540-45760-7_9). So a permutation of
/// any length takes no memory.
pub(super) fn permuted(number: u64, length: u64, key: u64) -> u64 {
    const ROUNDS: u64 = 8;
    if length <= 1 {
        return number;
    }
    let half = (64 - (length - 1).leading_zeros()).div_ceil(2);
    let mask = (1 << half) - 1;
    let mut permuted = number;
    loop {
        let (mut left, mut right) = (permuted >> half, permuted & mask);
        for round in 0..ROUNDS {
            // The bits on top are those that a multiplication mixes best.
            let mixed = hashed(&[key, round << 32 | right]) >> (64 - half);
            (left, right) = (right, left ^ mixed);
        }
        permuted = left << half | right;
        if permuted < length {
            return permuted;
        }
    }
}
