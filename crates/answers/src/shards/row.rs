//! The row of all sequences of a study, cut into shards.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

/// The load of the fullest shard, relative to the mean, up to which a row is simply cut.
const EVEN: (u128, u128) = (11, 10);

/// Sequences that follow each other and are forecast to take as long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// The forecast of one sequence \[ns\], at least 1. Whole numbers make the same sums
    /// everywhere.
    pub(super) cost: u128,
    /// The part of the row that one sequence takes: its cost, unless there is a reason to take
    /// more.
    pub(super) weight: u128,
    /// The number of sequences.
    pub(super) count: u64,
    /// The number of points of each sequence.
    pub(super) points: u64,
    /// The operator that they share.
    pub(super) operator: u64,
}

impl Piece {
    /// Returns the number of points of all its sequences.
    fn all_points(&self) -> u128 {
        u128::from(self.points) * u128::from(self.count)
    }
}

/// The sequences of a piece that one shard has.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Share {
    /// The index of the piece.
    pub(super) piece: usize,
    /// The sequences, counted within the piece.
    pub(super) sequences: Range<u64>,
}

/// Pieces in a row, cut into shards.
pub(super) struct SequenceRow {
    pieces: Vec<Piece>,
    /// The weight of everything before each piece, and of everything.
    starts: Vec<u128>,
    count: u32,
    /// The pieces of each shard, where they are dealt one by one instead of cut.
    dealt: Option<Vec<Vec<usize>>>,
}

impl SequenceRow {
    /// Cuts a row into so many shards: a sequence belongs to the shard in whose equal part of the
    /// whole cost its middle lies. So no shard has more than the mean and one sequence.
    pub(super) fn new(pieces: Vec<Piece>, count: u32) -> SequenceRow {
        let mut starts = vec![0];
        for piece in &pieces {
            starts.push(starts[starts.len() - 1] + piece.weight * u128::from(piece.count));
        }
        SequenceRow { pieces, starts, count, dealt: None }
    }

    /// Cuts a row so that no shard has more than `most` points, if that can be. Where the cheap
    /// sequences are very many, every sequence counts as if it took some more time, the same for
    /// each point, and no more of it than is needed.
    pub(super) fn bounded(pieces: Vec<Piece>, count: u32, most: u64) -> SequenceRow {
        let points: u128 = pieces.iter().map(Piece::all_points).sum();
        let row = SequenceRow::new(pieces.clone(), count);
        let mean = (row.total() / points.max(1)).max(1);
        let with_more = |sixteenths: u128| {
            let raised = pieces.iter().map(|piece| {
                let more = (mean * sixteenths / 16).max(1) * u128::from(piece.points);
                Piece { weight: piece.cost + more, ..*piece }
            });
            SequenceRow::new(raised.collect(), count)
        };
        let is_bounded = |row: &SequenceRow| (0..count).all(|shard| row.points(shard) <= most);
        if is_bounded(&row) {
            return row;
        }
        let steps = (0..12).map(|power| 1 << power);
        steps.map(with_more).find(is_bounded).unwrap_or(row)
    }

    /// Returns the number of points of a shard.
    fn points(&self, shard: u32) -> u64 {
        let of = |share: &Share| {
            self.pieces[share.piece].points * (share.sequences.end - share.sequences.start)
        };
        self.shares(shard).iter().map(of).sum()
    }

    /// Cuts a row of single sequences, or deals them where cutting leaves a shard too full: the
    /// longest first, each to the shard that has least (Graham, doi:10.1137/0117039).
    pub(super) fn evened(pieces: Vec<Piece>, count: u32) -> SequenceRow {
        let mut row = SequenceRow::new(pieces, count);
        let fullest = |row: &SequenceRow| {
            let load = |shard| row.shares(shard).iter().map(|share| row.cost(share)).sum::<u128>();
            (0..count).map(load).max().unwrap_or(0)
        };
        let cut = fullest(&row);
        if cut * u128::from(count) * EVEN.1 <= row.total() * EVEN.0 {
            return row;
        }
        let mut by_cost: Vec<usize> = (0..row.pieces.len()).collect();
        by_cost.sort_by_key(|piece| Reverse(row.pieces[*piece].cost));
        let mut loads: BinaryHeap<_> =
            (0..count as usize).map(|shard| Reverse((0, shard))).collect();
        let mut dealt = vec![Vec::new(); count as usize];
        for piece in by_cost {
            if let Some(Reverse((load, shard))) = loads.pop() {
                dealt[shard].push(piece);
                loads.push(Reverse((load + row.pieces[piece].cost, shard)));
            }
        }
        row.dealt = Some(dealt);
        if fullest(&row) > cut {
            row.dealt = None;
        }
        row
    }

    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// Returns bytes that two rows share only if they are cut in the same way.
    pub(super) fn identity(&self) -> Vec<u8> {
        let mut bytes = self.count.to_le_bytes().to_vec();
        for Piece { weight, count, points, .. } in &self.pieces {
            bytes.extend_from_slice(&weight.to_le_bytes());
            bytes.extend_from_slice(&count.to_le_bytes());
            bytes.extend_from_slice(&points.to_le_bytes());
        }
        bytes
    }

    pub(super) fn piece(&self, piece: usize) -> Piece {
        self.pieces[piece]
    }

    /// Returns the forecast of the longest sequence \[ns\].
    pub(super) fn longest(&self) -> u128 {
        self.pieces.iter().map(|piece| piece.cost).max().unwrap_or(0)
    }

    fn total(&self) -> u128 {
        self.starts[self.pieces.len()]
    }

    fn cost(&self, share: &Share) -> u128 {
        let sequences = share.sequences.end - share.sequences.start;
        self.pieces[share.piece].cost * u128::from(sequences)
    }

    /// Returns what the `shard`-th shard has, counted from 0.
    pub(super) fn shares(&self, shard: u32) -> Vec<Share> {
        if let Some(dealt) = &self.dealt {
            let share = |piece: &usize| Share { piece: *piece, sequences: 0..1 };
            return dealt[shard as usize].iter().map(share).collect();
        }
        // A sequence whose middle lies in this shard begins before the end of the shard, and its
        // piece ends after the beginning.
        let parts = u128::from(self.count);
        let first =
            self.starts[1..].partition_point(|end| end * parts <= u128::from(shard) * self.total());
        let mut shares = Vec::new();
        for piece in first..self.pieces.len() {
            if self.starts[piece] * parts >= u128::from(shard + 1) * self.total() {
                break;
            }
            let sequences = self.before(piece, shard)..self.before(piece, shard + 1);
            if !sequences.is_empty() {
                shares.push(Share { piece, sequences });
            }
        }
        shares
    }

    /// Returns the number of sequences of a piece that belong to shards before the `shard`-th:
    /// those with (start + (k + ½)·weight)·parts < shard·total.
    fn before(&self, piece: usize, shard: u32) -> u64 {
        let Piece { weight, count, .. } = self.pieces[piece];
        let parts = u128::from(self.count);
        let limit = 2 * u128::from(shard) * self.total();
        let first_middle = (2 * self.starts[piece] + weight) * parts;
        if limit <= first_middle {
            return 0;
        }
        let number = (limit - first_middle).div_ceil(2 * weight * parts);
        number.min(u128::from(count)) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(cost: u128, count: u64) -> Piece {
        Piece { cost, weight: cost, count, points: 1, operator: 0 }
    }

    /// Returns the number of the shard of every sequence, and the load of every shard.
    fn shards(row: &SequenceRow) -> (Vec<Vec<u32>>, Vec<u128>) {
        let mut found: Vec<Vec<u32>> =
            row.pieces.iter().map(|piece| vec![u32::MAX; piece.count as usize]).collect();
        let mut loads = vec![0; row.count as usize];
        for shard in 0..row.count {
            for share in row.shares(shard) {
                loads[shard as usize] += row.cost(&share);
                for sequence in share.sequences {
                    let entry = &mut found[share.piece][sequence as usize];
                    assert_eq!(*entry, u32::MAX, "a sequence is in two shards");
                    *entry = shard;
                }
            }
        }
        (found, loads)
    }

    #[test]
    fn every_sequence_is_in_one_shard_and_none_has_more_than_the_mean_and_one_sequence() {
        // A linear congruential generator makes costs of three orders of magnitude.
        let mut state = 7u64;
        let mut random = |most: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            1 + (state >> 33) % most
        };
        for count in [1, 2, 3, 7, 16, 100, 1000] {
            for _ in 0..20 {
                let pieces: Vec<Piece> =
                    (0..random(40)).map(|_| piece(u128::from(random(1000)), random(60))).collect();
                let longest = pieces.iter().map(|piece| piece.cost).max().unwrap();
                let row = SequenceRow::new(pieces, count);
                let (found, loads) = shards(&row);
                let order: Vec<u32> = found.into_iter().flatten().collect();
                assert!(order.is_sorted() && order.iter().all(|shard| *shard < count));
                let mean = row.total() / u128::from(count);
                assert!(loads.iter().all(|load| *load <= mean + longest + 1), "{loads:?}");
            }
        }
    }

    #[test]
    fn what_cannot_be_cut_evenly_is_dealt() {
        // In this order each cut would leave a shard with 8 or more, where 6 is the mean.
        let costs = [5, 3, 5, 3, 4, 2, 2];
        let row = SequenceRow::evened(costs.map(|cost| piece(cost, 1)).to_vec(), 4);
        let (found, loads) = shards(&row);
        assert!(found.iter().flatten().all(|shard| *shard < 4));
        assert_eq!(loads.iter().max(), Some(&7), "{loads:?}");
        // One that is longer than the mean sets the pace, and nothing else is in its shard.
        let row = SequenceRow::evened([1, 1, 1, 90, 1].map(|cost| piece(cost, 1)).to_vec(), 3);
        assert_eq!(shards(&row).1, [90, 2, 2]);
    }

    #[test]
    fn cheap_sequences_are_not_more_than_a_shard_may_have() {
        let pieces = vec![piece(1000, 1_000_000), piece(1_000_000, 1_000_000)];
        let cut = SequenceRow::new(pieces.clone(), 100);
        let bounded = SequenceRow::bounded(pieces, 100, 30_000);
        let most = |row: &SequenceRow| (0..100).map(|shard| row.points(shard)).max().unwrap();
        assert!(most(&cut) > 900_000 && most(&bounded) <= 30_000, "{}", most(&bounded));
        let (found, _) = shards(&bounded);
        assert!(found.into_iter().flatten().is_sorted());
    }

    #[test]
    fn a_thousand_millions_of_sequences_are_cut_without_listing_them() {
        let pieces = vec![piece(1_000_000_000, 400_000_000), piece(3_000_000_000, 600_000_000)];
        let row = SequenceRow::new(pieces, 10_000);
        let sequences: u64 = (0..10_000)
            .flat_map(|shard| row.shares(shard))
            .map(|share| share.sequences.end - share.sequences.start)
            .sum();
        assert_eq!(sequences, 1_000_000_000);
        // 2.2·10⁹ s of work are 2.2·10⁵ s for each shard.
        let middle = row.shares(5000);
        assert_eq!(middle.iter().map(|share| row.cost(share)).sum::<u128>() / 10u128.pow(14), 2);
    }
}
