//! A set of keys that takes little more memory than the keys do.

use std::collections::BTreeSet;
use std::ops::Bound;

use identity::JobKey;

/// The number of keys that are added before they join the others, and the part of those that they
/// are at least. So every key is moved a few times, which takes less time than making it durable.
const MOST_RECENT: usize = 4096;
const LEAST_PART: usize = 32;

/// Keys in ascending order. Those that were added last are in a tree, which takes half as much
/// memory again.
#[derive(Debug, Default)]
pub(crate) struct KeySet {
    sorted: Vec<JobKey>,
    recent: BTreeSet<JobKey>,
}

impl KeySet {
    /// Makes a set of keys in any order.
    pub(crate) fn new(mut keys: Vec<JobKey>) -> Self {
        keys.sort_unstable();
        keys.dedup();
        keys.shrink_to_fit();
        KeySet { sorted: keys, recent: BTreeSet::new() }
    }

    /// Returns the number of keys.
    pub(crate) fn len(&self) -> usize {
        self.sorted.len() + self.recent.len()
    }

    /// Returns true if the key is in the set.
    pub(crate) fn contains(&self, key: &JobKey) -> bool {
        self.recent.contains(key) || self.sorted.binary_search(key).is_ok()
    }

    /// Adds keys.
    pub(crate) fn extend(&mut self, keys: impl IntoIterator<Item = JobKey>) {
        for key in keys {
            if self.sorted.binary_search(&key).is_err() {
                self.recent.insert(key);
            }
        }
        if self.recent.len() >= MOST_RECENT.max(self.sorted.len() / LEAST_PART) {
            self.settle();
        }
    }

    /// Moves the recent keys to their places among the others, the last first.
    fn settle(&mut self) {
        let mut rest = self.sorted.len();
        let mut end = rest + self.recent.len();
        self.sorted.reserve_exact(self.recent.len());
        self.sorted.resize(end, JobKey([0; 32]));
        for key in std::mem::take(&mut self.recent).into_iter().rev() {
            let place = self.sorted[..rest].partition_point(|other| *other < key);
            end -= rest - place;
            self.sorted.copy_within(place..rest, end);
            end -= 1;
            self.sorted[end] = key;
            rest = place;
        }
    }

    /// Takes away the keys for which `stays` does not hold.
    pub(crate) fn retain(&mut self, mut stays: impl FnMut(&JobKey) -> bool) {
        self.sorted.retain(&mut stays);
        self.recent.retain(stays);
    }

    /// Iterates over the keys in ascending order: those above one, or all.
    pub(crate) fn above(&self, least: Option<&JobKey>) -> impl Iterator<Item = JobKey> + '_ {
        let is_above = |key: &JobKey| least.is_none_or(|least| key > least);
        let start = self.sorted.partition_point(|key| !is_above(key));
        let mut sorted = self.sorted[start..].iter().copied().peekable();
        let mut recent = match least {
            Some(least) => self.recent.range((Bound::Excluded(*least), Bound::Unbounded)),
            None => self.recent.range(..),
        }
        .copied()
        .peekable();
        std::iter::from_fn(move || match (sorted.peek(), recent.peek()) {
            (Some(next), Some(other)) if other < next => recent.next(),
            (Some(_), _) => sorted.next(),
            (None, _) => recent.next(),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn key(number: u16) -> JobKey {
        let mut key = JobKey([0; 32]);
        key.0[..2].copy_from_slice(&number.to_be_bytes());
        key
    }

    proptest! {
        #[test]
        fn it_is_the_set_of_what_was_added_and_not_taken_away(
            first in prop::collection::vec(any::<u16>(), 0..300),
            groups in prop::collection::vec(prop::collection::vec(any::<u16>(), 0..3000), 0..8),
            divisor in 2_u16..9,
            least in any::<u16>(),
        ) {
            let keys = |numbers: &[u16]| numbers.iter().map(|n| key(*n)).collect::<Vec<_>>();
            let mut set = KeySet::new(keys(&first));
            let mut expected: BTreeSet<JobKey> = keys(&first).into_iter().collect();
            for (turn, group) in groups.iter().enumerate() {
                set.extend(keys(group));
                expected.extend(keys(group));
                if turn % 3 == 2 {
                    let stays = |key: &JobKey| !u16::from(key.0[1]).is_multiple_of(divisor);
                    set.retain(stays);
                    expected.retain(stays);
                }
                prop_assert_eq!(set.len(), expected.len());
            }
            prop_assert!(set.above(None).eq(expected.iter().copied()));
            let least = key(least);
            let above = expected.iter().copied().filter(|key| *key > least);
            prop_assert!(set.above(Some(&least)).eq(above));
            prop_assert_eq!(set.contains(&least), expected.contains(&least));
            prop_assert!(expected.iter().all(|key| set.contains(key)));
        }
    }
}
