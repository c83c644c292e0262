//! The partition of a study into shards: parts that machines compute without knowing of each other.
//!
//! A partition follows from the study and the number of shards alone, so every machine finds its
//! own part. Sequences stay whole: points of which one says whether there is another, or that are
//! compared with each other, and points that share a job. Sequences that share an operator lie side
//! by side, and the row of all sequences is cut where the forecasts say that the work is even.
//!
//! The files below hold the row and its cuts (`row`), the sequences of a study whose points can be
//! listed (`listed`), and those of one that is too large for that (`lattice`). They do not know
//! this face.

mod lattice;
mod listed;
mod row;

use std::collections::HashSet;
use std::fmt;
use std::str::FromStr;

use study::Study;
use thiserror::Error;

use crate::error::AnswerError;

use lattice::Lattice;
use row::{Piece, SequenceRow};

/// The largest number of shards of a study.
pub const MOST_SHARDS: u32 = 65_536;

/// One shard of so many, which is written 3/16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

/// Why a shard is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ShardError {
    /// The text is no index and count.
    #[error("a shard is written INDEX/COUNT, for example 3/16")]
    Form,
    /// The count is 0 or too large.
    #[error("there must be 1 to {MOST_SHARDS} shards, and not {0}")]
    Count(u64),
    /// The index is 0.
    #[error("the first shard is 1/{0}: shards are counted from 1")]
    Zero(u32),
    /// The index is larger than the count.
    #[error("there is no shard {index} of {count}; the last one is {count}/{count}")]
    Beyond {
        /// The index.
        index: u64,
        /// The count.
        count: u32,
    },
}

impl Shard {
    /// The whole study as one shard.
    pub const WHOLE: Shard = Shard { index: 1, count: 1 };

    /// Returns the shard with an index, counted from 1, of so many.
    ///
    /// # Errors
    /// There is no such shard.
    pub fn new(index: u64, count: u64) -> Result<Shard, ShardError> {
        let known = u32::try_from(count).ok().filter(|count| (1..=MOST_SHARDS).contains(count));
        let known = known.ok_or(ShardError::Count(count))?;
        match u32::try_from(index) {
            Ok(0) => Err(ShardError::Zero(known)),
            Ok(index) if index <= known => Ok(Shard { index, count: known }),
            _ => Err(ShardError::Beyond { index, count: known }),
        }
    }

    /// Returns the index, counted from 1.
    pub fn index(self) -> u32 {
        self.index
    }

    /// Returns the number of shards.
    pub fn count(self) -> u32 {
        self.count
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Shard, ShardError> {
        let (index, count) = text.split_once('/').ok_or(ShardError::Form)?;
        let number = |digits: &str| {
            let is_plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
            is_plain.then(|| digits.parse().unwrap_or(u64::MAX)).ok_or(ShardError::Form)
        };
        Shard::new(number(index)?, number(count)?)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

/// The work of one shard.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShardLoad {
    /// The number of points.
    pub points: u64,
    /// The number of sequences, which is that of the points unless some belong together.
    pub sequences: u64,
    /// The number of operators, as far as forecasts tell them apart.
    pub operators: usize,
    /// The forecast of the work \[s\].
    pub seconds: f64,
}

/// A study cut into shards.
pub struct Partition {
    row: SequenceRow,
    members: Members,
}

/// The points of the pieces of a row.
enum Members {
    /// The indices of the points of each piece, which is one sequence.
    Listed(Vec<Vec<usize>>),
    Lattice(Lattice),
}

impl Partition {
    /// Cuts a study into so many shards.
    ///
    /// # Errors
    /// A point makes no sense, or its job cannot be forecast.
    pub fn of(study: &Study, count: u32) -> Result<Partition, AnswerError> {
        if study.is_listed() {
            let listed::SequenceList { pieces, members } = listed::list(study)?;
            return Ok(Partition {
                row: SequenceRow::evened(pieces, count),
                members: Members::Listed(members),
            });
        }
        let (lattice, pieces) = Lattice::of(study)?;
        Ok(Partition { row: SequenceRow::new(pieces, count), members: Members::Lattice(lattice) })
    }

    /// Returns the number of shards.
    pub fn count(&self) -> u32 {
        self.row.count()
    }

    /// Returns the forecast of the longest sequence \[s\], which no partition makes shorter.
    pub fn longest(&self) -> f64 {
        self.row.longest() as f64 * 1e-9
    }

    /// Returns the work of a shard.
    pub fn load(&self, shard: Shard) -> ShardLoad {
        let mut load = ShardLoad::default();
        let mut operators = HashSet::new();
        for share in self.row.shares(shard.index - 1) {
            let Piece { cost, points, operator, .. } = self.row.piece(share.piece);
            let sequences = share.sequences.end - share.sequences.start;
            load.sequences += sequences;
            load.points += points * sequences;
            load.seconds += cost as f64 * 1e-9 * sequences as f64;
            operators.insert(operator);
        }
        load.operators = operators.len();
        load
    }

    /// Returns the indices of the points of a shard in ascending order.
    pub fn indices(&self, shard: Shard) -> Vec<usize> {
        let mut indices = Vec::new();
        for share in self.row.shares(shard.index - 1) {
            match &self.members {
                Members::Listed(members) => indices.extend_from_slice(&members[share.piece]),
                Members::Lattice(lattice) => {
                    for sequence in share.sequences {
                        lattice.extend(&mut indices, share.piece, sequence);
                    }
                }
            }
        }
        indices.sort_unstable();
        indices
    }
}

#[cfg(test)]
mod tests;
