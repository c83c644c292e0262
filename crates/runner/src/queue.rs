//! The jobs that wait, in the order in which they should be handed out.
//!
//! Jobs of one group share an operator, so they go to one worker one after another, long ones
//! first. Groups are taken in order of falling total cost. Only when no unclaimed group is left
//! does a worker join the group of another.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// The index of a group in the queue; not the number that the caller gave it.
pub(crate) type GroupIndex = usize;

/// Costs are positive and finite, so their bits order as they do.
type CostBits = Reverse<u64>;

#[derive(Debug, Default)]
struct JobGroup {
    waiting: BTreeSet<(CostBits, usize)>,
    rank: CostBits,
    /// Live workers whose operator this is.
    holders: usize,
}

/// Jobs that wait, by group.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    groups: Vec<JobGroup>,
    /// Every group that has a waiting job, most expensive first.
    open: BTreeSet<(CostBits, GroupIndex)>,
    /// Per job: its group and its cost.
    jobs: Vec<(GroupIndex, CostBits)>,
    len: usize,
}

impl Queue {
    /// A queue of all jobs, given as (group number, predicted seconds).
    pub(crate) fn new(jobs: impl IntoIterator<Item = (u64, f64)>) -> Queue {
        let mut queue = Queue::default();
        let mut index = BTreeMap::new();
        let mut totals: Vec<f64> = Vec::new();
        for (number, cost) in jobs {
            let group = *index.entry(number).or_insert_with(|| {
                queue.groups.push(JobGroup::default());
                totals.push(0.0);
                queue.groups.len() - 1
            });
            totals[group] += cost;
            queue.jobs.push((group, Reverse(cost.to_bits())));
        }
        for (group, total) in queue.groups.iter_mut().zip(&totals) {
            group.rank = Reverse(total.to_bits());
        }
        for job in 0..queue.jobs.len() {
            queue.put(job);
        }
        queue
    }

    /// How many jobs wait.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Whether this job waits.
    #[cfg(any(test, debug_assertions))] // asked by the invariants
    pub(crate) fn contains(&self, job: usize) -> bool {
        let (group, cost) = self.jobs[job];
        self.groups[group].waiting.contains(&(cost, job))
    }

    /// Puts a job back, in its place in the order.
    pub(crate) fn put(&mut self, job: usize) {
        let (group, cost) = self.jobs[job];
        if self.groups[group].waiting.insert((cost, job)) {
            self.len += 1;
        }
        self.open.insert((self.groups[group].rank, group));
    }

    /// Takes this very job out, if it waits.
    pub(crate) fn take_this(&mut self, job: usize) -> bool {
        let (group, cost) = self.jobs[job];
        let taken = self.groups[group].waiting.remove(&(cost, job));
        self.len -= usize::from(taken);
        if self.groups[group].waiting.is_empty() {
            self.open.remove(&(self.groups[group].rank, group));
        }
        taken
    }

    /// A worker now holds the operator of `new` instead of that of `old`.
    pub(crate) fn hold(&mut self, old: Option<GroupIndex>, new: Option<GroupIndex>) {
        if let Some(old) = old {
            self.groups[old].holders -= 1;
        }
        if let Some(new) = new {
            self.groups[new].holders += 1;
        }
    }

    /// How many workers hold the operator of each group.
    #[cfg(any(test, debug_assertions))]
    pub(crate) fn holders(&self) -> Vec<usize> {
        self.groups.iter().map(|group| group.holders).collect()
    }

    /// Takes the next job that `fits` for a worker that holds the operator of group `held`.
    pub(crate) fn take(
        &mut self,
        held: Option<GroupIndex>,
        fits: impl Fn(usize) -> bool,
    ) -> Option<(usize, GroupIndex)> {
        let first = |group: GroupIndex| {
            self.groups[group].waiting.iter().copied().find(|&(_, job)| fits(job))
        };
        let held = held.and_then(|group| Some((group, first(group)?)));
        let unclaimed = || {
            let mut free = self.open.iter().filter(|(_, group)| self.groups[*group].holders == 0);
            free.find_map(|&(_, group)| Some((group, first(group)?)))
        };
        let shared = || {
            let mut claimed: Vec<_> =
                self.open.iter().filter(|(_, group)| self.groups[*group].holders > 0).collect();
            claimed.sort_by_key(|(rank, group)| {
                (Reverse(self.groups[*group].waiting.len()), *rank, *group)
            });
            claimed.into_iter().find_map(|&(_, group)| Some((group, first(group)?)))
        };
        let (group, entry) = held.or_else(unclaimed).or_else(shared)?;
        self.take_this(entry.1);
        Some((entry.1, group))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_stays_with_its_group_and_takes_long_jobs_first() {
        let mut queue = Queue::new([(7, 1.0), (9, 5.0), (7, 3.0), (9, 1.0), (7, 2.0), (7, 1.5)]);
        // group 7 costs 7.5 s, group 9 costs 6 s
        let (job, a) = queue.take(None, |_| true).unwrap();
        assert_eq!(job, 2);
        queue.hold(None, Some(a));
        let (job, b) = queue.take(None, |_| true).unwrap();
        assert_eq!(job, 1, "the second worker opens the other group");
        queue.hold(None, Some(b));
        assert_eq!(queue.take(Some(a), |_| true).unwrap().0, 4);
        assert_eq!(queue.take(Some(b), |_| true).unwrap().0, 3);
        assert_eq!(
            queue.take(Some(b), |_| true).unwrap(),
            (5, a),
            "and joins the first when its own is empty"
        );
        assert_eq!(queue.len(), 1);
        queue.put(5);
        assert!(queue.contains(5));
        assert_eq!(
            queue.take(Some(a), |job| job != 5).unwrap().0,
            0,
            "what does not fit is passed over"
        );
    }
}
