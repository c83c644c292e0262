//! The queue holds the jobs that wait, in the order in which they should be handed out.
//!
//! Jobs of one group share something costly, so they go to one worker one after another, long ones
//! first. Groups are taken in the order of falling total cost. A worker joins the group of another
//! only when no unclaimed group is left.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// The index of a group in the queue, which is not the number that the caller gave it.
pub(crate) type GroupIndex = usize;

/// The bits of a cost. Costs are positive and finite, so their bits have the same order.
type CostBits = Reverse<u64>;

#[derive(Debug, Default)]
struct JobGroup {
    waiting: BTreeSet<(CostBits, usize)>,
    rank: CostBits,
    /// The number of live workers that hold this group.
    holders: usize,
}

/// The jobs that wait, by group.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    groups: Vec<JobGroup>,
    /// Every group that has a waiting job, the most expensive first.
    open: BTreeSet<(CostBits, GroupIndex)>,
    /// Every waiting job, the cheapest first.
    by_cost: BTreeSet<(u64, usize)>,
    /// The group and the cost of each job.
    jobs: Vec<(GroupIndex, CostBits)>,
}

impl Queue {
    /// Makes a queue of all jobs, each given as its group number and its predicted time \[s\].
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

    /// Returns the number of waiting jobs.
    pub(crate) fn len(&self) -> usize {
        self.by_cost.len()
    }

    /// Returns the waiting job with the shortest predicted time.
    pub(crate) fn shortest(&self) -> Option<usize> {
        self.by_cost.first().map(|&(_, job)| job)
    }

    /// Returns the group of a job.
    pub(crate) fn group(&self, job: usize) -> GroupIndex {
        self.jobs[job].0
    }

    /// Returns true if this job waits.
    #[cfg(any(test, debug_assertions))] // The invariants ask for it.
    pub(crate) fn contains(&self, job: usize) -> bool {
        let (group, cost) = self.jobs[job];
        self.groups[group].waiting.contains(&(cost, job))
    }

    /// Puts a job back into its place in the order.
    pub(crate) fn put(&mut self, job: usize) {
        let (group, cost) = self.jobs[job];
        self.groups[group].waiting.insert((cost, job));
        self.by_cost.insert((cost.0, job));
        self.open.insert((self.groups[group].rank, group));
    }

    /// Takes this very job out if it waits, and returns true if it did.
    pub(crate) fn take_this(&mut self, job: usize) -> bool {
        let (group, cost) = self.jobs[job];
        let taken = self.groups[group].waiting.remove(&(cost, job));
        self.by_cost.remove(&(cost.0, job));
        if self.groups[group].waiting.is_empty() {
            self.open.remove(&(self.groups[group].rank, group));
        }
        taken
    }

    /// Notes that a worker now holds the group `new` instead of the group `old`.
    pub(crate) fn hold(&mut self, old: Option<GroupIndex>, new: Option<GroupIndex>) {
        if let Some(old) = old {
            self.groups[old].holders -= 1;
        }
        if let Some(new) = new {
            self.groups[new].holders += 1;
        }
    }

    /// Returns the number of workers that hold each group.
    #[cfg(any(test, debug_assertions))]
    pub(crate) fn holders(&self) -> Vec<usize> {
        self.groups.iter().map(|group| group.holders).collect()
    }

    /// Takes the next job that `fits`, and whose predicted time is at most `longest` \[s\], for a
    /// worker that holds the group `held`.
    pub(crate) fn take(
        &mut self,
        held: Option<GroupIndex>,
        longest: f64,
        fits: impl Fn(usize) -> bool,
    ) -> Option<(usize, GroupIndex)> {
        let longest = longest.max(0.0).to_bits();
        if self.by_cost.first().is_none_or(|&(cost, _)| cost > longest) {
            return None;
        }
        let first = |group: GroupIndex| {
            let mut short = self.groups[group].waiting.range((Reverse(longest), 0)..).copied();
            short.find(|&(_, job)| fits(job))
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
        // Group 7 costs 7.5 s, and group 9 costs 6 s.
        let (job, a) = queue.take(None, f64::INFINITY, |_| true).unwrap();
        assert_eq!(job, 2);
        queue.hold(None, Some(a));
        let (job, b) = queue.take(None, f64::INFINITY, |_| true).unwrap();
        assert_eq!(job, 1, "the second worker opens the other group");
        queue.hold(None, Some(b));
        assert_eq!(queue.take(Some(a), f64::INFINITY, |_| true).unwrap().0, 4);
        assert_eq!(queue.take(Some(b), f64::INFINITY, |_| true).unwrap().0, 3);
        assert_eq!(
            queue.take(Some(b), f64::INFINITY, |_| true).unwrap(),
            (5, a),
            "and joins the first when its own is empty"
        );
        assert_eq!(queue.len(), 1);
        queue.put(5);
        assert!(queue.contains(5));
        assert_eq!(
            queue.take(Some(a), f64::INFINITY, |job| job != 5).unwrap().0,
            0,
            "what does not fit is passed over"
        );
    }

    #[test]
    fn what_takes_longer_than_there_is_time_for_is_passed_over() {
        let mut queue = Queue::new([(7, 1.0), (9, 5.0), (7, 3.0), (9, 2.0)]);
        assert_eq!(queue.shortest(), Some(0));
        assert_eq!(queue.take(None, 0.5, |_| true), None);
        assert_eq!(queue.take(None, 2.0, |_| true), Some((3, queue.group(3))));
        assert_eq!(queue.take(Some(queue.group(2)), 2.5, |_| true).unwrap().0, 0);
        assert_eq!(queue.take(None, 2.5, |_| true), None);
        assert_eq!((queue.shortest(), queue.len()), (Some(2), 2));
        assert_eq!(queue.take(None, f64::INFINITY, |_| true).unwrap().0, 1);
    }
}
