//! Sobol's sequence.
//!
//! The direction numbers are those of Joe and Kuo (2008, doi:10.1137/070709359), of which the file
//! beside this one has the first 256 dimensions; it is theirs, and its licence stands with it. The
//! digits are scrambled by nested random permutations as Owen proposed (1995,
//! doi:10.1007/978-1-4612-2552-2_19): each of the first 32 binary digits is flipped or not, by a
//! random bit that depends on the digits before it. The digits after these are random. So every
//! point is uniform by itself, the intervals of halves, quarters … have their points as without,
//! and the first point is as good as the others (Owen 2022, doi:10.1007/978-3-030-98319-2_4).

use super::bits::{hashed, inside};

/// The direction numbers: a line of heads, then the dimension, the degree, the coefficients of the
/// polynomial and the first numbers. The first dimension needs none.
const JOE_KUO: &str = include_str!("new-joe-kuo-6.256.txt");

/// The number of binary digits of an index, and of those of a coordinate that it determines.
const BITS: usize = 32;

/// The direction numbers of each dimension, and the key of its scrambling.
#[derive(Debug)]
pub(super) struct Sobol {
    directions: Vec<[u32; BITS]>,
    keys: Vec<u64>,
}

impl Sobol {
    pub(super) fn new(key: u64, dimensions: usize) -> Sobol {
        let first = std::iter::once(std::array::from_fn(|bit| 1 << (BITS - 1 - bit)));
        let others = JOE_KUO.lines().skip(1).map(directions);
        Sobol {
            directions: first.chain(others).take(dimensions).collect(),
            keys: (0..dimensions as u64).map(|dimension| hashed(&[key, dimension])).collect(),
        }
    }

    pub(super) fn coordinate(&self, index: u32, dimension: usize) -> f64 {
        let plain = self.plain(index, dimension);
        let key = self.keys[dimension];
        let random = hashed(&[key, 1 << BITS | u64::from(plain)]);
        inside(u64::from(scrambled(plain, key)) << 32 | random >> 32)
    }

    /// Returns the digits of a coordinate of the sequence itself, the first one on top.
    fn plain(&self, index: u32, dimension: usize) -> u32 {
        let (mut rest, mut digits) = (index, 0);
        while rest != 0 {
            digits ^= self.directions[dimension][rest.trailing_zeros() as usize];
            rest &= rest - 1;
        }
        digits
    }
}

/// Computes the direction numbers of a line of the file, by the recurrence of Bratley and Fox
/// (1988, doi:10.1145/42288.214372).
fn directions(line: &str) -> [u32; BITS] {
    let numbers: Vec<u32> = line.split_whitespace().flat_map(str::parse).collect();
    let mut directions = [0; BITS];
    let [_, degree, coefficients, first @ ..] = &numbers[..] else { return directions };
    let degree = *degree as usize;
    for bit in 0..BITS {
        directions[bit] = match first.get(bit) {
            Some(number) => number << (BITS - 1 - bit),
            None => {
                let before = directions[bit - degree];
                let others = (1..degree)
                    .filter(|step| coefficients >> (degree - 1 - step) & 1 == 1)
                    .map(|step| directions[bit - step]);
                others.fold(before ^ before >> degree, |sum, direction| sum ^ direction)
            }
        };
    }
    directions
}

/// Flips each digit or not, by a random bit that depends on the digits before it.
fn scrambled(plain: u32, key: u64) -> u32 {
    let flips = (0..BITS).fold(0, |flips: u32, level| {
        // The digits before, with a 1 in front, number the nodes of the tree of all digits.
        let node = 1 << level | u64::from(plain) >> (BITS - level);
        flips << 1 | (hashed(&[key, node]) >> 63) as u32
    });
    plain ^ flips
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy 1.17 has point 540 as its 1000th without scrambling, since it counts in Gray's code.
    #[test]
    fn the_sequence_without_scrambling_is_the_published_one() {
        let sobol = Sobol::new(0, 256);
        assert_eq!(sobol.directions.len(), 256);
        let eighths = |dimension: usize| -> Vec<u32> {
            (0..8).map(|index| sobol.plain(index, dimension) >> (BITS - 3)).collect()
        };
        // These follow from the polynomials x + 1 and x² + x + 1 by hand.
        assert_eq!(eighths(0), [0, 4, 2, 6, 1, 5, 3, 7]);
        assert_eq!(eighths(1), [0, 4, 6, 2, 5, 1, 3, 7]);
        assert_eq!(eighths(2), [0, 4, 6, 2, 3, 7, 5, 1]);
        let of_scipy = [943_718_400, 415_236_096, 297_795_584, 801_112_064, 1_069_547_520];
        let dimensions = [0, 1, 9, 99, 255];
        assert_eq!(dimensions.map(|dimension| sobol.plain(540, dimension)), of_scipy);
        // No direction number is missing: each has its own last digit.
        for directions in &sobol.directions {
            for (bit, direction) in directions.iter().enumerate() {
                assert_eq!(direction.trailing_zeros() as usize, BITS - 1 - bit);
            }
        }
    }

    #[test]
    fn scrambling_keeps_the_intervals() {
        for key in 0..50 {
            let mut quarters: Vec<u32> =
                (0..4).map(|digits| scrambled(digits << 30, hashed(&[key])) >> 30).collect();
            assert_eq!(quarters[0] >> 1, quarters[1] >> 1, "halves stay halves");
            quarters.sort_unstable();
            assert_eq!(quarters, [0, 1, 2, 3]);
        }
    }
}
