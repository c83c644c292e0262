//! Rows of points that tell how much each dimension moves an output.

use super::bits::{hashed, permuted};

/// The arrangement of the points of a design.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrangement {
    /// Each point stands for itself.
    #[default]
    Plain,
    /// Rows of Saltelli et al. (2010, doi:10.1016/j.cpc.2009.09.018): a point A, the points AB_i,
    /// which are A but for the i-th coordinate, which is that of B, and the point B. A and B are
    /// the two halves of a point of twice as many dimensions.
    Saltelli,
    /// Trajectories of Morris (1991, doi:10.1080/00401706.1991.10484804): each point differs from
    /// the one before in one coordinate, by `levels`/2 steps on the grid 0, 1/(`levels` − 1) … 1.
    Trajectories {
        /// The number of values of each coordinate, which is even.
        levels: u32,
    },
}

impl Arrangement {
    /// Returns what a sample has so many of as its `count` says.
    pub fn noun(self) -> &'static str {
        match self {
            Arrangement::Plain => "points",
            _ => "rows",
        }
    }

    /// Returns the number of dimensions of the sequence for each dimension of the design.
    pub(super) fn coordinates_of_input(self) -> usize {
        if self == Arrangement::Saltelli { 2 } else { 1 }
    }

    /// Returns the number of points of a row in so many dimensions.
    pub(super) fn row_length(self, dimensions: usize) -> usize {
        match self {
            Arrangement::Plain => 1,
            Arrangement::Saltelli => dimensions + 2,
            Arrangement::Trajectories { .. } => dimensions + 1,
        }
    }
}

/// Returns whether a coordinate of a member of Saltelli's row is that of B.
pub(super) fn takes_second(member: usize, dimension: usize, dimensions: usize) -> bool {
    member == dimension + 1 || member == dimensions + 1
}

/// Returns a coordinate of a member of the trajectory that a key chooses: from where each dimension
/// begins, in which direction it moves, and in which order they do.
pub(super) fn trajectory(
    key: u64,
    member: usize,
    dimension: usize,
    dimensions: usize,
    levels: u32,
) -> f64 {
    let random = hashed(&[key, dimension as u64]);
    let half = u64::from(levels / 2);
    let low = ((u128::from(random) * u128::from(half)) >> 64) as u64;
    // The last digit says nothing of the first ones, which chose the level.
    let is_downwards = random & 1 == 1;
    let turn = permuted(dimension as u64, dimensions as u64, hashed(&[key, u64::MAX]));
    let has_moved = member as u64 > turn;
    let level = low + if has_moved == is_downwards { 0 } else { half };
    level as f64 / f64::from(levels - 1)
}
