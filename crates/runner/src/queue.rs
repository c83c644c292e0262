//! The queue holds the jobs that wait, in the order in which they should be handed out.
//!
//! Jobs of one group share something costly, so they go to one worker one after another: those of
//! the lowest rank first, and of these the long ones first. Groups are taken in the order of their
//! lowest rank, then of falling total cost. A worker joins the group of another only when no
//! unclaimed group is left.

use std::cmp::Reverse;
use std::collections::BTreeMap;

/// The index of a group in the queue, which is not the number that the caller gave it.
pub(crate) type GroupIndex = usize;

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

/// The numbers that decide on the turn of a job.
#[derive(Clone, Copy, Debug)]
struct Turn {
    group: u32,
    rank: u32,
    /// The bits of its cost, of four bytes. Costs are positive and finite, so their bits have the
    /// same order.
    cost: u32,
}

/// A group of jobs.
#[derive(Clone, Copy, Debug)]
struct JobGroup {
    /// The first of its places in the line of turns.
    start: u32,
    /// The place after its last.
    end: u32,
    /// The number of its jobs that wait.
    waiting: u32,
    /// The number of live workers that hold this group.
    holders: u32,
}

/// The sums over the jobs of a group.
#[derive(Clone, Copy, Debug)]
struct GroupSums {
    /// The lowest rank.
    rank: u32,
    /// The predicted time of all of them \[s\].
    cost: f64,
    jobs: u32,
}

/// The jobs that wait, by group. A waiting job takes some 21 bytes, for there may be a million.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    /// The groups in the order in which they are taken.
    groups: Vec<JobGroup>,
    /// The groups that have a waiting job.
    open: PlaceSet,
    jobs: Vec<Turn>,
    /// The jobs by group, and those of a group by their turns.
    by_turn: JobLine,
    /// The jobs by their costs, the cheapest first.
    by_cost: JobLine,
    /// The sum of the costs of all waiting jobs, in whole nanoseconds, so that what is added and
    /// taken away leaves no rest.
    nanoseconds: u128,
}

impl Queue {
    /// Makes a queue of all jobs.
    pub(crate) fn new(queued: impl IntoIterator<Item = QueuedJob>) -> Queue {
        let mut index = BTreeMap::new();
        let mut groups: Vec<GroupSums> = Vec::new();
        let queued = queued.into_iter();
        let mut jobs: Vec<Turn> = Vec::with_capacity(queued.size_hint().0);
        for QueuedJob { group, rank, cost } in queued {
            let group = *index.entry(group).or_insert_with(|| {
                groups.push(GroupSums { rank, cost: 0.0, jobs: 0 });
                groups.len() - 1
            });
            let sums = &mut groups[group];
            sums.rank = sums.rank.min(rank);
            sums.cost += cost;
            sums.jobs += 1;
            jobs.push(Turn { group: group as u32, rank, cost: (cost as f32).to_bits() });
        }
        drop(index);
        let mut turns: Vec<u32> = (0..groups.len() as u32).collect();
        turns.sort_by_key(|&group| {
            let GroupSums { rank, cost, .. } = groups[group as usize];
            (rank, Reverse(cost.to_bits()))
        });
        let mut numbers = vec![0; groups.len()];
        let mut queue = Queue { open: PlaceSet::new(groups.len()), ..Queue::default() };
        let mut start = 0;
        for (number, &group) in turns.iter().enumerate() {
            numbers[group as usize] = number as u32;
            let end = start + groups[group as usize].jobs;
            queue.groups.push(JobGroup { start, end, waiting: 0, holders: 0 });
            start = end;
        }
        jobs.iter_mut().for_each(|turn| turn.group = numbers[turn.group as usize]);
        queue.by_turn = JobLine::new(&jobs, Turn::place);
        queue.by_cost = JobLine::new(&jobs, Turn::price);
        queue.jobs = jobs;
        for job in 0..queue.jobs.len() {
            queue.put(job);
        }
        queue
    }

    /// Returns the number of waiting jobs.
    pub(crate) fn len(&self) -> usize {
        self.by_cost.waiting.count
    }

    /// Returns the predicted time of all waiting jobs together \[s\].
    pub(crate) fn seconds(&self) -> f64 {
        self.nanoseconds as f64 * 1e-9
    }

    /// Returns the waiting job with the longest predicted time.
    pub(crate) fn longest(&self) -> Option<usize> {
        Some(self.by_cost.job(self.by_cost.waiting.last()?))
    }

    /// Returns the waiting job with the shortest predicted time.
    pub(crate) fn shortest(&self) -> Option<usize> {
        Some(self.by_cost.job(self.by_cost.waiting.next(0)?))
    }

    /// Returns the predicted time of a job \[s\].
    pub(crate) fn cost(&self, job: usize) -> f64 {
        f32::from_bits(self.jobs[job].cost).into()
    }

    /// Returns the group of a job.
    pub(crate) fn group(&self, job: usize) -> GroupIndex {
        self.jobs[job].group as usize
    }

    /// Returns true if this job waits.
    #[cfg(any(test, debug_assertions))] // The invariants ask for it.
    pub(crate) fn contains(&self, job: usize) -> bool {
        let place = self.by_turn.place(&self.jobs, Turn::place, job);
        self.by_turn.waiting.contains(place)
    }

    /// Puts a job back into its place in the order.
    pub(crate) fn put(&mut self, job: usize) {
        let place = self.by_turn.place(&self.jobs, Turn::place, job);
        if self.by_turn.waiting.insert(place) {
            let price = self.by_cost.place(&self.jobs, Turn::price, job);
            self.by_cost.waiting.insert(price);
            let Turn { group, cost, .. } = self.jobs[job];
            self.nanoseconds += nanoseconds(cost);
            self.groups[group as usize].waiting += 1;
            self.open.insert(group as usize);
        }
    }

    /// Takes this very job out if it waits, and returns true if it did.
    pub(crate) fn take_this(&mut self, job: usize) -> bool {
        let place = self.by_turn.place(&self.jobs, Turn::place, job);
        let taken = self.by_turn.waiting.remove(place);
        if taken {
            let price = self.by_cost.place(&self.jobs, Turn::price, job);
            self.by_cost.waiting.remove(price);
            let Turn { group, cost, .. } = self.jobs[job];
            self.nanoseconds -= nanoseconds(cost);
            let waiting = &mut self.groups[group as usize].waiting;
            *waiting -= 1;
            if *waiting == 0 {
                self.open.remove(group as usize);
            }
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
        self.groups.iter().map(|group| group.holders as usize).collect()
    }

    /// Returns the next job that `fits`, and whose predicted time is at most `longest` \[s\], for a
    /// worker that holds the group `held`, and the group of that job.
    pub(crate) fn next(
        &self,
        held: Option<GroupIndex>,
        longest: f64,
        fits: impl Fn(usize) -> bool,
    ) -> Option<(usize, GroupIndex)> {
        if self.shortest().is_none_or(|job| self.cost(job) > longest) {
            return None;
        }
        let first = |group: GroupIndex| Some((group, self.first(group, longest, &fits)?));
        let unclaimed = || {
            let mut free = self.open.iter().filter(|&group| self.groups[group].holders == 0);
            free.find_map(first)
        };
        let shared = || {
            let mut claimed: Vec<GroupIndex> =
                self.open.iter().filter(|&group| self.groups[group].holders > 0).collect();
            claimed.sort_by_key(|&group| Reverse(self.groups[group].waiting));
            claimed.into_iter().find_map(first)
        };
        let (group, job) = held.and_then(first).or_else(unclaimed).or_else(shared)?;
        Some((job, group))
    }

    /// Returns the first waiting job of a group that fits and is not too long.
    fn first(
        &self,
        group: GroupIndex,
        longest: f64,
        fits: &impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let JobGroup { start, end, .. } = self.groups[group];
        let (mut from, end) = (start as usize, end as usize);
        loop {
            let place = self.by_turn.waiting.next(from).filter(|&place| place < end)?;
            let job = self.by_turn.job(place);
            let rank = self.jobs[job].rank;
            if self.cost(job) <= longest {
                if fits(job) {
                    return Some(job);
                }
                from = place + 1;
            } else {
                // Of each rank those that are too long are passed over at once.
                from = place
                    + self.by_turn.order[place..end].partition_point(|&job| {
                        let job = job as usize;
                        self.jobs[job].rank == rank && self.cost(job) > longest
                    });
            }
        }
    }
}

impl Turn {
    /// Returns what orders a job among all: its group, its rank, the long ones first.
    fn place(&self) -> impl Ord + use<> {
        (self.group, self.rank, Reverse(self.cost))
    }

    /// Returns what orders a job by its cost.
    fn price(&self) -> u32 {
        self.cost
    }
}

/// The jobs in a fixed order, of which some wait.
#[derive(Debug, Default)]
struct JobLine {
    order: Vec<u32>,
    /// The places of those that wait.
    waiting: PlaceSet,
}

impl JobLine {
    /// Lines jobs up by a key, and by their indices where that is the same. None waits.
    fn new<K: Ord>(jobs: &[Turn], key: impl Fn(&Turn) -> K) -> JobLine {
        let mut order: Vec<u32> = (0..jobs.len() as u32).collect();
        order.sort_unstable_by_key(|&job| (key(&jobs[job as usize]), job));
        JobLine { order, waiting: PlaceSet::new(jobs.len()) }
    }

    /// Returns the job at a place.
    fn job(&self, place: usize) -> usize {
        self.order[place] as usize
    }

    /// Returns the place of a job, given the key that the line was made with.
    fn place<K: Ord>(&self, jobs: &[Turn], key: impl Fn(&Turn) -> K, job: usize) -> usize {
        let sought = (key(&jobs[job]), job);
        self.order.partition_point(|&job| (key(&jobs[job as usize]), job as usize) < sought)
    }
}

/// A set of places as bits, with a bit for each word of them that has any.
#[derive(Debug, Default)]
struct PlaceSet {
    words: Vec<u64>,
    has_any: Vec<u64>,
    count: usize,
}

impl PlaceSet {
    /// Makes an empty set of places below a number.
    fn new(places: usize) -> PlaceSet {
        let words = vec![0; places.div_ceil(64)];
        PlaceSet { has_any: vec![0; words.len().div_ceil(64)], words, count: 0 }
    }

    #[cfg(any(test, debug_assertions))]
    fn contains(&self, place: usize) -> bool {
        self.words[place / 64] >> (place % 64) & 1 == 1
    }

    /// Adds a place, and returns true if it was not there.
    fn insert(&mut self, place: usize) -> bool {
        let (word, bit) = (place / 64, 1 << (place % 64));
        let is_new = self.words[word] & bit == 0;
        self.words[word] |= bit;
        self.has_any[word / 64] |= 1 << (word % 64);
        self.count += usize::from(is_new);
        is_new
    }

    /// Takes a place away, and returns true if it was there.
    fn remove(&mut self, place: usize) -> bool {
        let (word, bit) = (place / 64, 1 << (place % 64));
        let was_there = self.words[word] & bit != 0;
        self.words[word] &= !bit;
        if self.words[word] == 0 {
            self.has_any[word / 64] &= !(1 << (word % 64));
        }
        self.count -= usize::from(was_there);
        was_there
    }

    /// Returns the first place from one on.
    fn next(&self, from: usize) -> Option<usize> {
        let word = from / 64;
        let rest = self.words.get(word)? & (u64::MAX << (from % 64));
        if rest != 0 {
            return Some(word * 64 + rest.trailing_zeros() as usize);
        }
        let after = word + 1;
        let mut mask = u64::MAX << (after % 64);
        for (above, words) in self.has_any.iter().enumerate().skip(after / 64) {
            let found = words & mask;
            if found != 0 {
                let word = above * 64 + found.trailing_zeros() as usize;
                return Some(word * 64 + self.words[word].trailing_zeros() as usize);
            }
            mask = u64::MAX;
        }
        None
    }

    /// Returns the last place.
    fn last(&self) -> Option<usize> {
        let above = self.has_any.iter().rposition(|&words| words != 0)?;
        let word = above * 64 + self.has_any[above].ilog2() as usize;
        Some(word * 64 + self.words[word].ilog2() as usize)
    }

    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.next(0), |place| self.next(place + 1))
    }
}

/// Returns a cost, given its bits, in whole nanoseconds.
fn nanoseconds(cost: u32) -> u128 {
    (f64::from(f32::from_bits(cost)) * 1e9) as u128
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    impl Queue {
        /// Takes the next job out.
        fn take(
            &mut self,
            held: Option<GroupIndex>,
            longest: f64,
            fits: impl Fn(usize) -> bool,
        ) -> Option<(usize, GroupIndex)> {
            let (job, group) = self.next(held, longest, fits)?;
            assert!(self.take_this(job));
            Some((job, group))
        }
    }

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

    /// The queue in plain words: it looks at all jobs.
    struct PlainQueue {
        jobs: Vec<QueuedJob>,
        waiting: Vec<bool>,
    }

    impl PlainQueue {
        fn waiting(&self) -> impl Iterator<Item = usize> + '_ {
            (0..self.jobs.len()).filter(|&job| self.waiting[job])
        }

        fn next(
            &self,
            held: Option<u64>,
            claimed: &[u64],
            longest: f64,
            fits: impl Fn(usize) -> bool,
        ) -> Option<usize> {
            let group = |job: usize| self.jobs[job].group;
            let turn = |group: u64| {
                let all = self.jobs.iter().enumerate().filter(|(_, job)| job.group == group);
                let rank = all.clone().map(|(_, job)| job.rank).min();
                let total: f64 = all.clone().map(|(_, job)| job.cost).sum();
                (rank, Reverse(total.to_bits()), all.map(|(number, _)| number).min())
            };
            let ready = self.waiting().filter(|&job| self.jobs[job].cost <= longest && fits(job));
            ready.min_by_key(|&job| {
                let number = group(job);
                let shared = claimed.contains(&number) as usize;
                let others = self.waiting().filter(|&other| group(other) == number).count();
                let QueuedJob { rank, cost, .. } = self.jobs[job];
                (
                    held != Some(number),
                    shared,
                    Reverse(shared * others),
                    turn(number),
                    rank,
                    Reverse(cost.to_bits()),
                    job,
                )
            })
        }
    }

    proptest! {
        #[test]
        fn the_queue_gives_what_a_look_at_all_jobs_gives(
            jobs in prop::collection::vec((0..12u64, 0..3u32, 1..30u32), 1..150),
            steps in prop::collection::vec(
                (0..3usize, prop::option::of(0..30u32), 1..5usize, prop::option::of(0..150usize)),
                1..300,
            ),
        ) {
            let queued = |&(group, rank, cost): &(u64, u32, u32)| {
                QueuedJob { group, rank, cost: f64::from(cost) }
            };
            let jobs: Vec<QueuedJob> = jobs.iter().map(queued).collect();
            let mut queue = Queue::new(jobs.clone());
            let mut plain = PlainQueue { waiting: vec![true; jobs.len()], jobs };
            let mut holders: [Option<usize>; 3] = [None; 3];
            for (worker, longest, kept, back) in steps {
                let longest = longest.map_or(f64::INFINITY, f64::from);
                let number = |job: usize| plain.jobs[job].group;
                let claimed: Vec<u64> = holders.iter().flatten().map(|&job| number(job)).collect();
                let held = holders[worker].map(number);
                let expected = plain.next(held, &claimed, longest, |job| job % kept == 0);
                let group = holders[worker].map(|job| queue.group(job));
                let found = queue.take(group, longest, |job| job % kept == 0);
                prop_assert_eq!(found.map(|(job, _)| job), expected);
                if let Some((job, new)) = found {
                    plain.waiting[job] = false;
                    queue.hold(group, Some(new));
                    holders[worker] = Some(job);
                }
                if let Some(job) = back.map(|job| job % plain.jobs.len()) {
                    queue.put(job);
                    plain.waiting[job] = true;
                    prop_assert!(queue.contains(job));
                }
                let costs = || plain.waiting().map(|job| (plain.jobs[job].cost.to_bits(), job));
                prop_assert_eq!(queue.shortest(), costs().min().map(|(_, job)| job));
                prop_assert_eq!(queue.longest(), costs().max().map(|(_, job)| job));
                prop_assert_eq!(queue.len(), plain.waiting().count());
            }
        }
    }

    #[test]
    fn places_are_found_across_empty_words() {
        let mut places = PlaceSet::new(20_000);
        assert_eq!((places.next(0), places.last()), (None, None));
        let all = [0, 63, 64, 4095, 4096, 9000, 19_999];
        assert!(all.iter().all(|&place| places.insert(place)));
        assert!(!places.insert(9000));
        assert_eq!(places.iter().collect::<Vec<_>>(), all);
        assert_eq!((places.next(4097), places.next(9001)), (Some(9000), Some(19_999)));
        assert!(places.remove(19_999) && !places.remove(19_999));
        assert_eq!((places.last(), places.next(9001), places.count), (Some(9000), None, 6));
    }
}
