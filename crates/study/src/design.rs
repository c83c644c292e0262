//! Designs of samples: the points of the unit cube that a sample takes.
//!
//! A coordinate of a point follows at once from the method, the seed, the index of the point and
//! the dimension. So a design of any length takes no memory, and a point is the same on every
//! machine and in every order of work: there are only whole numbers and one division.
//!
//! The files below make the coordinates by one method each: `sobol`, `halton`, `latin_hypercube`.
//! `arrangement` puts rows of points in place of single ones. They know `bits`, from which all of
//! them draw what is random, and not this face.

use std::sync::Arc;

pub mod arrangement;
mod bits;
mod halton;
mod latin_hypercube;
mod sobol;

use arrangement::Arrangement;
use bits::{hashed, inside};
use halton::Halton;
use latin_hypercube::LatinHypercube;
use sobol::Sobol;

/// The largest number of dimensions of a design, which is that of the direction numbers here.
pub const MOST_DIMENSIONS: usize = 256;

/// A way to choose the points of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplingMethod {
    /// Sobol's sequence, scrambled as Owen proposed.
    Sobol,
    /// Halton's sequence with digits permuted at random.
    Halton,
    /// A Latin hypercube: each dimension has a point in each of as many equal intervals.
    LatinHypercube,
    /// Points that know nothing of each other.
    Random,
}

impl SamplingMethod {
    /// Every method.
    pub const ALL: [SamplingMethod; 4] = [
        SamplingMethod::Sobol,
        SamplingMethod::Halton,
        SamplingMethod::LatinHypercube,
        SamplingMethod::Random,
    ];

    /// The names by which a study file calls them.
    pub(crate) const NAMES: [&'static str; 4] =
        [Self::ALL[0].name(), Self::ALL[1].name(), Self::ALL[2].name(), Self::ALL[3].name()];

    /// Returns the name by which a study file calls it.
    pub const fn name(self) -> &'static str {
        match self {
            SamplingMethod::Sobol => "sobol",
            SamplingMethod::Halton => "halton",
            SamplingMethod::LatinHypercube => "latin-hypercube",
            SamplingMethod::Random => "random",
        }
    }

    /// Returns what a sample by this method is, as a noun with its article.
    pub fn noun(self) -> &'static str {
        match self {
            SamplingMethod::Sobol => "a sample of Sobol' points",
            SamplingMethod::Halton => "a sample of Halton points",
            SamplingMethod::LatinHypercube => "a Latin hypercube",
            SamplingMethod::Random => "a random sample",
        }
    }
}

/// The points of the unit cube that a sample takes.
#[derive(Clone, Debug)]
pub struct Design {
    method: SamplingMethod,
    count: u32,
    seed: u32,
    dimensions: usize,
    arrangement: Arrangement,
    generator: Arc<Generator>,
}

/// The preparations of a method for all coordinates.
#[derive(Debug)]
enum Generator {
    Sobol(Sobol),
    Halton(Halton),
    LatinHypercube(LatinHypercube),
    Random(u64),
}

/// Designs are equal if they have the same points.
impl PartialEq for Design {
    fn eq(&self, other: &Design) -> bool {
        let text = |design: &Design| {
            let Design { method, count, seed, dimensions, arrangement, .. } = design;
            (*method, *count, *seed, *dimensions, *arrangement)
        };
        text(self) == text(other)
    }
}

impl Design {
    /// Makes the design of `count` points; there are at most [`MOST_DIMENSIONS`] dimensions.
    pub fn new(method: SamplingMethod, count: u32, seed: u32, dimensions: usize) -> Design {
        Design::of_rows(method, count, seed, dimensions, Arrangement::Plain)
    }

    /// Makes the design of `count` rows of points. There are at most
    /// [`most_dimensions`](Design::most_dimensions).
    pub fn of_rows(
        method: SamplingMethod,
        count: u32,
        seed: u32,
        dimensions: usize,
        arrangement: Arrangement,
    ) -> Design {
        let inputs = dimensions.min(Design::most_dimensions(arrangement));
        let dimensions = inputs * arrangement.coordinates_of_input();
        let key = hashed(&[u64::from(seed)]);
        let generator = match method {
            SamplingMethod::Sobol => Generator::Sobol(Sobol::new(key, dimensions)),
            SamplingMethod::Halton => Generator::Halton(Halton::new(key, dimensions)),
            SamplingMethod::LatinHypercube => {
                Generator::LatinHypercube(LatinHypercube::new(key, count))
            }
            SamplingMethod::Random => Generator::Random(key),
        };
        let generator = Arc::new(generator);
        Design { method, count, seed, dimensions: inputs, arrangement, generator }
    }

    /// Returns the largest number of dimensions of a design in some arrangement.
    pub fn most_dimensions(arrangement: Arrangement) -> usize {
        MOST_DIMENSIONS / arrangement.coordinates_of_input()
    }

    /// Returns the method.
    pub fn method(&self) -> SamplingMethod {
        self.method
    }

    /// Returns the number of rows, which are the points if the design is plain.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the arrangement of the points in rows.
    pub fn arrangement(&self) -> Arrangement {
        self.arrangement
    }

    /// Returns the design with as many rows in another arrangement.
    pub fn arranged(&self, arrangement: Arrangement) -> Design {
        Design::of_rows(self.method, self.count, self.seed, self.dimensions, arrangement)
    }

    /// Returns the number of points of each row.
    pub fn row_length(&self) -> usize {
        self.arrangement.row_length(self.dimensions)
    }

    /// Returns the number of points; `None` if there are more than an index counts.
    pub fn points(&self) -> Option<u32> {
        u32::try_from(self.row_length()).ok()?.checked_mul(self.count)
    }

    /// Returns the seed.
    pub fn seed(&self) -> u32 {
        self.seed
    }

    /// Returns the number of dimensions.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Returns whether every point of this design is also a point of another one with the same
    /// index.
    pub fn is_kept_by(&self, other: &Design) -> bool {
        let is_alike = (self.method, self.seed) == (other.method, other.seed)
            && self.arrangement == other.arrangement
            && match self.arrangement {
                Arrangement::Plain => self.dimensions <= other.dimensions,
                _ => self.dimensions == other.dimensions,
            }
            && self.count <= other.count;
        let is_nested = match self.method {
            SamplingMethod::LatinHypercube => latin_hypercube::is_nested(self.count, other.count),
            _ => true,
        };
        is_alike && is_nested
    }

    /// Returns a coordinate of a point: a number above 0 and below 1, or of a trajectory from 0 to
    /// 1.
    ///
    /// The index must be below the number of points of a Latin hypercube; other sequences go on.
    ///
    /// # Panics
    /// The dimension is none of the design's.
    pub fn coordinate(&self, index: u32, dimension: usize) -> f64 {
        assert!(dimension < self.dimensions, "a design has no dimension {dimension}");
        let row_length = self.row_length() as u32;
        let (row, member) = (index / row_length, (index % row_length) as usize);
        match self.arrangement {
            Arrangement::Plain => self.drawn(index, dimension),
            Arrangement::Saltelli => {
                let takes_second = arrangement::takes_second(member, dimension, self.dimensions);
                self.drawn(row, dimension + usize::from(takes_second) * self.dimensions)
            }
            Arrangement::Trajectories { levels } => {
                let key = hashed(&[u64::from(self.seed), row.into()]);
                arrangement::trajectory(key, member, dimension, self.dimensions, levels)
            }
        }
    }

    /// Returns a coordinate of the sequence.
    fn drawn(&self, index: u32, dimension: usize) -> f64 {
        match &*self.generator {
            Generator::Sobol(sobol) => sobol.coordinate(index, dimension),
            Generator::Halton(halton) => halton.coordinate(index, dimension),
            Generator::LatinHypercube(hypercube) => hypercube.coordinate(index, dimension),
            Generator::Random(key) => inside(hashed(&[*key, dimension as u64, index.into()])),
        }
    }
}

#[cfg(test)]
mod tests;
