//! Random numbers for searches that must take the same path for ever, which no library promises.

use crate::model::{SceneError, refuse};

/// The largest number of random starts that a search may have.
pub(crate) const MOST_STARTS: u32 = 10_000;

/// Refuses more random starts than [`MOST_STARTS`].
///
/// # Errors
/// A [`SceneError`] at `search.starts` if there are more.
pub(crate) fn validate_starts(starts: u32) -> Result<(), SceneError> {
    if starts <= MOST_STARTS {
        Ok(())
    } else {
        Err(refuse("search.starts", starts, &format!("must be at most {MOST_STARTS}")))
    }
}

/// The generator SplitMix64 (Steele, Lea and Flood 2014, doi:10.1145/2714064.2660195); the field is
/// its state.
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// Returns 64 random bits.
    #[inline]
    #[expect(clippy::should_implement_trait, reason = "the numbers have no end")]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number that is uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number that is uniform in [−1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected values are the first numbers of seed 0 as the authors' code gives them.
    #[test]
    fn is_the_published_generator() {
        let mut random = SplitMix64(0);
        assert_eq!([random.next(), random.next()], [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
        assert!(
            (0..1000)
                .all(|_| (0.0..1.0).contains(&random.unit())
                    && (-1.0..1.0).contains(&random.signed()))
        );
    }
}
