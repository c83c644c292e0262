//! Arrays of shards.

use std::fmt::Write;

/// An array whose elements are shards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Array {
    /// The shard of the element with index 0.
    pub(crate) first: u32,
    /// The indices of the elements, in rising order.
    pub(crate) indices: Vec<u32>,
}

impl Array {
    /// Returns the numbers of the shards.
    pub(crate) fn shards(&self) -> impl Iterator<Item = u32> {
        self.indices.iter().map(|index| self.first + index)
    }

    /// Returns the value of `--array`: ranges of indices, and the number of elements that may run
    /// at a time, if there is a limit.
    pub(crate) fn option(&self, at_a_time: Option<u32>) -> String {
        let ranges = self.indices.chunk_by(|index, next| index + 1 == *next);
        let mut words = Vec::new();
        for range in ranges {
            words.push(match range {
                [index] => index.to_string(),
                range => format!("{}-{}", range[0], range[range.len() - 1]),
            });
        }
        let mut option = words.join(",");
        if let Some(limit) = at_a_time {
            // Writing to a string does not fail.
            let _ = write!(option, "%{limit}");
        }
        option
    }
}

/// Returns the arrays that have some shards as their elements, each with at most `size` indices.
/// The shards are in rising order, from 1 on.
pub(crate) fn arrays(shards: &[u32], size: u32) -> Vec<Array> {
    let size = size.max(1);
    shards
        .chunk_by(|shard, next| (shard - 1) / size == (next - 1) / size)
        .map(|chunk| {
            let first = (chunk[0] - 1) / size * size + 1;
            Array { first, indices: chunk.iter().map(|shard| shard - first).collect() }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shard_is_in_one_array_with_small_indices() {
        for size in 1..9 {
            for count in 1..40 {
                let shards: Vec<u32> = (1..=count).collect();
                let arrays = arrays(&shards, size);
                let listed: Vec<u32> = arrays.iter().flat_map(Array::shards).collect();
                assert_eq!(listed, shards);
                assert!(arrays.iter().all(|array| array.indices.iter().all(|index| *index < size)));
                assert_eq!(arrays.len() as u32, count.div_ceil(size));
            }
        }
    }

    #[test]
    fn indices_are_written_as_ranges() {
        let option = |shards: &[u32], limit| -> Vec<String> {
            arrays(shards, 8).iter().map(|array| array.option(limit)).collect()
        };
        assert_eq!(option(&[1, 2, 3, 4, 5, 6, 7, 8, 9], None), ["0-7", "0"]);
        assert_eq!(option(&[2, 4, 5, 20], Some(3)), ["1,3-4%3", "3%3"]);
        assert_eq!(arrays(&[20], 8), [Array { first: 17, indices: vec![3] }]);
    }
}
