//! The queue holds the jobs that wait, in the order in which they should be handed out.
//!
//! Jobs of one group share something costly, so they go to one worker one after another: those of
//! the lowest rank first, and of these the long ones first. Groups are taken in the order of their
//! lowest rank, then of falling total cost. A worker joins the group of another only when no
//! unclaimed group is left.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound::{Excluded, Unbounded};

/// The index of a group in the queue, which is not the number that the caller gave it.
pub(crate) type GroupIndex = usize;

/// The bits of a cost. Costs are positive and finite, so their bits have the same order.
type CostBits = Reverse<u64>;

/// A job as the queue knows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueuedJob {
    /// The number of its group.
    pub(crate) group: u64,
    /// The jobs of a lower rank go first.
    pub(crate) rank: u32,
    /// The predicted time, positive and finite \[s\].
    pub(crate) cost: f64,
}

/// The place of a waiting job in its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Turn {
    rank: u32,
    cost: CostBits,
    job: usize,
}

/// The place of a group in the queue: the lowest rank of its jobs, and the cost of all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct GroupTurn {
    rank: u32,
    total: CostBits,
}

#[derive(Debug)]
struct JobGroup {
    waiting: BTreeSet<Turn>,
    turn: GroupTurn,
    /// The number of live workers that hold this group.
    holders: usize,
}

/// The jobs that wait, by group.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    groups: Vec<JobGroup>,
    /// Every group that has a waiting job, in the order in which they are taken.
    open: BTreeSet<(GroupTurn, GroupIndex)>,
    /// Every waiting job, the cheapest first.
    by_cost: BTreeSet<(u64, usize)>,
    /// The sum of the costs of all waiting jobs, in whole nanoseconds, so that what is added and
    /// taken away leaves no rest.
    nanoseconds: u128,
    /// The group and the turn of each job.
    jobs: Vec<(GroupIndex, Turn)>,
}

impl Queue {
    /// Makes a queue of all jobs.
    pub(crate) fn new(jobs: impl IntoIterator<Item = QueuedJob>) -> Queue {
        let mut queue = Queue::default();
        let mut index = BTreeMap::new();
        let mut totals: Vec<f64> = Vec::new();
        for (job, QueuedJob { group, rank, cost }) in jobs.into_iter().enumerate() {
            let group = *index.entry(group).or_insert_with(|| {
                let turn = GroupTurn { rank, total: Reverse(0) };
                queue.groups.push(JobGroup { waiting: BTreeSet::new(), turn, holders: 0 });
                totals.push(0.0);
                queue.groups.len() - 1
            });
            totals[group] += cost;
            let turn = &mut queue.groups[group].turn;
            turn.rank = turn.rank.min(rank);
            queue.jobs.push((group, Turn { rank, cost: Reverse(cost.to_bits()), job }));
        }
        for (group, total) in queue.groups.iter_mut().zip(&totals) {
            group.turn.total = Reverse(total.to_bits());
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

    /// Returns the predicted time of all waiting jobs together \[s\].
    pub(crate) fn seconds(&self) -> f64 {
        self.nanoseconds as f64 * 1e-9
    }

    /// Returns the waiting job with the longest predicted time.
    pub(crate) fn longest(&self) -> Option<usize> {
        self.by_cost.last().map(|&(_, job)| job)
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
        let (group, turn) = self.jobs[job];
        self.groups[group].waiting.contains(&turn)
    }

    /// Puts a job back into its place in the order.
    pub(crate) fn put(&mut self, job: usize) {
        let (group, turn) = self.jobs[job];
        self.groups[group].waiting.insert(turn);
        if self.by_cost.insert((turn.cost.0, job)) {
            self.nanoseconds += nanoseconds(turn.cost);
        }
        self.open.insert((self.groups[group].turn, group));
    }

    /// Takes this very job out if it waits, and returns true if it did.
    pub(crate) fn take_this(&mut self, job: usize) -> bool {
        let (group, turn) = self.jobs[job];
        let taken = self.groups[group].waiting.remove(&turn);
        if self.by_cost.remove(&(turn.cost.0, job)) {
            self.nanoseconds -= nanoseconds(turn.cost);
        }
        if self.groups[group].waiting.is_empty() {
            self.open.remove(&(self.groups[group].turn, group));
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
            let waiting = &self.groups[group].waiting;
            // Of each rank those that are too long are passed over at once.
            let mut from = waiting.first().copied();
            while let Some(Turn { rank, .. }) = from {
                let first = Turn { rank, cost: Reverse(longest), job: 0 };
                let last = Turn { rank, cost: Reverse(0), job: usize::MAX };
                let found = waiting.range(first..=last).find(|turn| fits(turn.job));
                if let Some(turn) = found {
                    return Some(turn.job);
                }
                from = waiting.range((Excluded(last), Unbounded)).next().copied();
            }
            None
        };
        let held = held.and_then(|group| Some((group, first(group)?)));
        let unclaimed = || {
            let mut free = self.open.iter().filter(|(_, group)| self.groups[*group].holders == 0);
            free.find_map(|&(_, group)| Some((group, first(group)?)))
        };
        let shared = || {
            let mut claimed: Vec<_> =
                self.open.iter().filter(|(_, group)| self.groups[*group].holders > 0).collect();
            claimed.sort_by_key(|(turn, group)| {
                (Reverse(self.groups[*group].waiting.len()), *turn, *group)
            });
            claimed.into_iter().find_map(|&(_, group)| Some((group, first(group)?)))
        };
        let (group, job) = held.or_else(unclaimed).or_else(shared)?;
        self.take_this(job);
        Some((job, group))
    }
}

/// Returns a cost in whole nanoseconds.
fn nanoseconds(Reverse(cost): CostBits) -> u128 {
    (f64::from_bits(cost) * 1e9) as u128
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a queue of jobs given as their groups and costs.
    fn queue<const N: usize>(jobs: [(u64, f64); N]) -> Queue {
        Queue::new(jobs.map(|(group, cost)| QueuedJob { group, rank: 0, cost }))
    }

    #[test]
    fn ranks_go_before_costs_and_groups_before_ranks() {
        let jobs = [[7, 2, 9], [7, 0, 1], [9, 1, 1], [8, 0, 1], [8, 3, 1], [7, 0, 2]];
        let queued = |[group, rank, cost]: [u64; 3]| QueuedJob {
            group,
            rank: rank as u32,
            cost: cost as f64,
        };
        let mut queue = Queue::new(jobs.map(queued));
        let mut order = Vec::new();
        let mut held = None;
        while let Some((job, group)) = queue.take(held, f64::INFINITY, |_| true) {
            queue.hold(held, Some(group));
            held = Some(group);
            order.push(job);
        }
        assert_eq!(order, [5, 1, 0, 3, 4, 2]);

        // What is too long or does not fit is passed over in every rank.
        let mut queue = Queue::new(jobs.map(queued));
        assert_eq!(queue.take(None, 8.0, |job| job != 5 && job != 1).unwrap().0, 3);
        assert_eq!(queue.take(None, 9.0, |job| job == 0).unwrap().0, 0);
        assert_eq!(queue.take(None, 0.5, |_| true), None);
    }

    #[test]
    fn a_worker_stays_with_its_group_and_takes_long_jobs_first() {
        let mut queue = queue([(7, 1.0), (9, 5.0), (7, 3.0), (9, 1.0), (7, 2.0), (7, 1.5)]);
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
        let mut queue = queue([(7, 1.0), (9, 5.0), (7, 3.0), (9, 2.0)]);
        assert_eq!(queue.shortest(), Some(0));
        assert_eq!(queue.take(None, 0.5, |_| true), None);
        assert_eq!(queue.take(None, 2.0, |_| true), Some((3, queue.group(3))));
        assert_eq!(queue.take(Some(queue.group(2)), 2.5, |_| true).unwrap().0, 0);
        assert_eq!(queue.take(None, 2.5, |_| true), None);
        assert_eq!((queue.shortest(), queue.longest(), queue.len()), (Some(2), Some(1), 2));
        assert_eq!(queue.seconds(), 8.0);
        assert_eq!(queue.take(None, f64::INFINITY, |_| true).unwrap().0, 1);
        queue.put(1);
        queue.put(1);
        assert_eq!(queue.seconds(), 8.0, "a job waits once");
    }
}
