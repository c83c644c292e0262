//! Latin hypercubes (McKay, Beckman and Conover 1979, doi:10.1080/00401706.1979.10489755): of `n`
//! points, each dimension has one in each of `n` equal intervals.
//!
//! A hypercube of twice as many points keeps those of the smaller one. Of the halves of an interval
//! its point is in one, and one of the new points is put into the other, which one is a random
//! permutation of each dimension. So hypercubes of n, 2n, 4n … points are the beginnings of each
//! other where n is the odd part of their numbers. No point can be added one by one.

use super::bits::{DIGITS, fraction, hashed, permuted};

/// The hypercubes of the doublings of an odd number of points.
#[derive(Debug)]
pub(super) struct LatinHypercube {
    key: u64,
    odd: u64,
    /// The digits of coordinates tell as many equal parts of the unit interval apart as the odd
    /// number times this power of 2.
    finest: u32,
}

/// Returns whether a hypercube of `count` points is the beginning of one of `other` points.
pub(super) fn is_nested(count: u32, other: u32) -> bool {
    let odd = |count: u32| count >> count.trailing_zeros().min(31);
    count <= other && odd(count) == odd(other)
}

impl LatinHypercube {
    pub(super) fn new(key: u64, count: u32) -> LatinHypercube {
        let odd = u64::from(count >> count.trailing_zeros().min(31)).max(1);
        LatinHypercube { key, odd, finest: DIGITS - (64 - odd.leading_zeros()) }
    }

    pub(super) fn coordinate(&self, index: u32, dimension: usize) -> f64 {
        let key = hashed(&[self.key, dimension as u64]);
        fraction(self.interval(index.into(), key, self.finest), self.odd << self.finest)
    }

    /// Returns the interval in which a point is, of those that `level` doublings make.
    fn interval(&self, index: u64, key: u64, level: u32) -> u64 {
        // The number of doublings after which the point is there.
        let born = (0..).find(|born| index < self.odd << born).unwrap_or(0);
        let interval = match born {
            0 => permuted(index, self.odd, hashed(&[key, 0])),
            _ => {
                let before = self.odd << (born - 1);
                let partner = permuted(index - before, before, hashed(&[key, u64::from(born)]));
                self.interval(partner, key, born) ^ 1
            }
        };
        // Inside its interval the place is random, the first digits of it on top.
        let deeper = level - born;
        let random = hashed(&[key, u64::from(born), index]);
        interval << deeper | random.checked_shr(64 - deeper).unwrap_or(0)
    }
}
