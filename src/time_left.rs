//! The time that a run still takes, from the forecasts of its jobs, from those that have ended and
//! from those in flight.
//!
//! Forecasts are within a factor of a few, and off by other factors for small jobs than for large
//! ones. So they are held against the times of the jobs that have ended, those of a like size
//! first. What is left is shared by the workers, and takes no less than the longest job.

use std::collections::{BTreeMap, VecDeque};

use identity::JobKey;
use runner::{Event, EventKind};

/// The size class of a job: the power of two of its predicted time.
type SizeClass = i32;

/// The weight of a job that is a class larger or smaller beside one of the same class.
const WEIGHT_OF_NEIGHBOUR: f64 = 0.2;

/// The share of the time beyond its expected end that a job has taken which it still takes.
const OVERTIME: f64 = 0.5;

/// The share of the time that a job has taken which it still takes at least.
const LEAST_REST: f64 = 0.1;

/// The least share of their time that workers are taken to compute.
const LEAST_BUSY: f64 = 0.2;

/// The times that jobs took beside those that were predicted, by class.
#[derive(Clone, Debug, Default)]
pub(crate) struct Calibration(BTreeMap<SizeClass, Experience>);

/// The times of the jobs of a class.
#[derive(Clone, Copy, Debug, Default)]
struct Experience {
    jobs: f64,
    /// The sum of the times that were predicted \[s\].
    predicted: f64,
    /// The sum of the times that the jobs took \[s\].
    took: f64,
}

impl Calibration {
    fn learn(&mut self, predicted: f64, took: f64) {
        let experience = self.0.entry(class(predicted)).or_default();
        experience.jobs += 1.0;
        experience.predicted += predicted;
        experience.took += took;
    }

    /// Returns the factor by which jobs of a class take longer than predicted: the geometric mean
    /// of what is known, or 1 as long as nothing is.
    fn factor(&self, class: SizeClass) -> f64 {
        let (mut weights, mut sum) = (0.0, 0.0);
        for (of, experience) in &self.0 {
            let weight = experience.jobs * WEIGHT_OF_NEIGHBOUR.powi((of - class).abs());
            weights += weight;
            sum += weight * (experience.took / experience.predicted).max(1e-9).ln();
        }
        if weights > 0.0 { (sum / weights).exp() } else { 1.0 }
    }
}

/// The jobs of a class that stand in one place.
#[derive(Clone, Copy, Debug, Default)]
struct JobClass {
    jobs: usize,
    /// The sum of their predicted times \[s\].
    predicted: f64,
}

/// Jobs by their class.
#[derive(Clone, Debug, Default)]
struct JobsBySize(BTreeMap<SizeClass, JobClass>);

impl JobsBySize {
    fn add(&mut self, predicted: f64) {
        let of_class = self.0.entry(class(predicted)).or_default();
        of_class.jobs += 1;
        of_class.predicted += predicted;
    }

    fn remove(&mut self, predicted: f64) {
        let class = class(predicted);
        let Some(of_class) = self.0.get_mut(&class) else { return };
        of_class.jobs = of_class.jobs.saturating_sub(1);
        of_class.predicted = (of_class.predicted - predicted).max(0.0);
        if of_class.jobs == 0 {
            self.0.remove(&class);
        }
    }
}

/// A job that a worker holds.
#[derive(Clone, Copy, Debug)]
struct HeldJob {
    key: JobKey,
    /// The predicted time \[s\].
    predicted: f64,
}

/// The jobs that a worker holds, the one that it is doing first.
#[derive(Clone, Debug, Default)]
struct HeldJobs {
    jobs: VecDeque<HeldJob>,
    by_size: JobsBySize,
    /// The time since which it does the first of them \[s\].
    since: f64,
}

/// The estimate of the time that a run still takes. Of the jobs that wait it knows sums alone,
/// since there may be a million.
#[derive(Debug)]
pub(crate) struct TimeLeft {
    waiting: JobsBySize,
    held: BTreeMap<u32, HeldJobs>,
    /// The worker that holds each job in flight.
    holders: BTreeMap<JobKey, u32>,
    /// The predicted times of the jobs that lost workers held and that wait again, as far as is
    /// known: the results of some may be on their way \[s\].
    returned: BTreeMap<JobKey, f64>,
    calibration: Calibration,
    /// The number of workers that there will be.
    workers: usize,
    /// The time at which the first job was handed out \[s\].
    began: Option<f64>,
    /// The time that the jobs that have ended took \[s\].
    busy: f64,
}

impl TimeLeft {
    /// Returns the estimate for jobs of some predicted times \[s\] on so many workers, with what is
    /// known of earlier jobs.
    pub(crate) fn new(
        predicted: impl IntoIterator<Item = f64>,
        workers: usize,
        calibration: Calibration,
    ) -> Self {
        let mut waiting = JobsBySize::default();
        predicted.into_iter().for_each(|predicted| waiting.add(sane(predicted)));
        Self {
            waiting,
            held: BTreeMap::new(),
            holders: BTreeMap::new(),
            returned: BTreeMap::new(),
            calibration,
            workers: workers.max(1),
            began: None,
            busy: 0.0,
        }
    }

    /// Returns what was learnt of the times that jobs take.
    pub(crate) fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Takes note of an event.
    pub(crate) fn hear(&mut self, event: &Event) {
        let now = event.seconds;
        match &event.kind {
            EventKind::Leased { key, worker, predicted, .. } => {
                self.began.get_or_insert(now);
                self.hand_out(*key, *worker, sane(*predicted), now);
            }
            EventKind::Done { key, seconds, .. } => {
                if let Some(predicted) = self.end(key, now) {
                    self.calibration.learn(predicted, *seconds);
                    self.busy += seconds;
                }
            }
            EventKind::Quarantined { key, .. } => {
                self.end(key, now);
            }
            EventKind::Postponed { key, predicted, .. } => {
                let is_handed_out = self.end(key, now).is_some();
                if !is_handed_out {
                    self.waiting.remove(sane(*predicted));
                }
            }
            EventKind::Retried { key, .. } | EventKind::Returned { key, .. } => {
                if let Some(predicted) = self.take_back(key, now) {
                    self.waiting.add(predicted);
                }
            }
            EventKind::WorkersLimited { workers, .. } => self.workers = *workers,
            EventKind::WorkerLost { worker, .. } => {
                for HeldJob { key, predicted } in self.held.remove(worker).unwrap_or_default().jobs
                {
                    self.holders.remove(&key);
                    self.returned.insert(key, predicted);
                    self.waiting.add(predicted);
                }
            }
            _ => {}
        }
    }

    /// Notes that a worker gets a job that waited.
    fn hand_out(&mut self, key: JobKey, worker: u32, predicted: f64, now: f64) {
        self.returned.remove(&key);
        self.waiting.remove(predicted);
        let fresh = HeldJobs { since: now, ..HeldJobs::default() };
        let held = self.held.entry(worker).or_insert(fresh);
        held.jobs.push_back(HeldJob { key, predicted });
        held.by_size.add(predicted);
        self.holders.insert(key, worker);
    }

    /// Takes a job from its worker, and returns its predicted time \[s\]; `None` if nobody holds
    /// it.
    fn take_back(&mut self, key: &JobKey, now: f64) -> Option<f64> {
        let worker = self.holders.remove(key)?;
        let held = self.held.get_mut(&worker)?;
        let turn = held.jobs.iter().position(|job| job.key == *key)?;
        let HeldJob { predicted, .. } = held.jobs.remove(turn)?;
        held.by_size.remove(predicted);
        // Only the end of the first job is the begin of another.
        if turn == 0 {
            held.since = now;
        }
        if held.jobs.is_empty() {
            self.held.remove(&worker);
        }
        Some(predicted)
    }

    /// Notes that a job has ended, and returns its predicted time \[s\]; `None` if it was never
    /// handed out.
    fn end(&mut self, key: &JobKey, now: f64) -> Option<f64> {
        if let Some(predicted) = self.take_back(key, now) {
            return Some(predicted);
        }
        let predicted = self.returned.remove(key)?;
        self.waiting.remove(predicted);
        Some(predicted)
    }

    /// Returns the time that a run takes which has not begun \[s\].
    pub(crate) fn seconds_from_start(mut self) -> f64 {
        self.began = Some(0.0);
        self.seconds(0.0).unwrap_or_default()
    }

    /// Returns the time that the run still takes at a time since its start \[s\]; `None` before its
    /// first job is handed out.
    pub(crate) fn seconds(&self, now: f64) -> Option<f64> {
        let began = self.began?;
        let (mut work, mut busy) = (0.0, self.busy);
        // The ends of the workers' hands, the last and the first.
        let (mut last, mut first) = (0.0_f64, f64::INFINITY);
        // As long as nothing has ended, a job that takes longer than it should tells of the others.
        let mut slowest = 1.0_f64;
        for held in self.held.values() {
            let Some(job) = held.jobs.front() else { continue };
            let expected = job.predicted * self.calibration.factor(class(job.predicted));
            let elapsed = (now - held.since).max(0.0);
            let overtime = OVERTIME * (elapsed - expected);
            let rest_of_job = (expected - elapsed).max(overtime).max(LEAST_REST * elapsed);
            busy += elapsed;
            slowest = slowest.max((elapsed + rest_of_job) / job.predicted);
            let all: f64 = held
                .by_size
                .0
                .iter()
                .map(|(class, held)| self.calibration.factor(*class) * held.predicted)
                .sum();
            let rest = rest_of_job + (all - expected).max(0.0);
            work += rest;
            last = last.max(rest);
            first = first.min(rest);
        }
        let is_new = self.calibration.0.is_empty();
        let free = if self.held.len() < self.workers { 0.0 } else { first };
        for (class, waiting) in &self.waiting.0 {
            let factor = if is_new { slowest } else { self.calibration.factor(*class) };
            work += factor * waiting.predicted;
            last = last.max(free + factor * waiting.predicted / waiting.jobs as f64);
        }
        let workers = self.workers as f64;
        let elapsed = workers * (now - began);
        let share = if elapsed > 0.0 { (busy / elapsed).clamp(LEAST_BUSY, 1.0) } else { 1.0 };
        Some((work / workers).max(last) / share)
    }
}

/// Returns the class of a predicted time, which is sane.
fn class(predicted: f64) -> SizeClass {
    predicted.log2().floor() as SizeClass
}

/// Returns a predicted time that has a logarithm.
fn sane(predicted: f64) -> f64 {
    if predicted.is_finite() { predicted.clamp(1e-6, 1e12) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use runner::Counts;

    use super::*;

    /// A run of jobs whose true times are known, played by the rules of the coordinator: workers
    /// take the longest job that waits.
    struct PlayedRun {
        left: TimeLeft,
        now: f64,
        /// The predicted and the true time of each job that waits, those to go first last.
        waiting: Vec<(JobKey, [f64; 2])>,
        /// The end of each job in work.
        running: Vec<(JobKey, f64)>,
    }

    fn key(job: usize) -> JobKey {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&job.to_le_bytes());
        JobKey(bytes)
    }

    /// Returns the event that a worker gets a job of a second.
    fn leased(job: usize, worker: u32) -> EventKind {
        EventKind::Leased { key: key(job), worker, attempt: 1, predicted: 1.0 }
    }

    /// Plays a run of jobs given as their predicted and their true times, and returns the worst
    /// ratio between estimate and truth, from a tenth of the run on until the last tenth.
    fn worst_ratio(jobs: &[[f64; 2]], workers: usize) -> f64 {
        let mut order: Vec<usize> = (0..jobs.len()).collect();
        order.sort_by(|a, b| jobs[*a][0].total_cmp(&jobs[*b][0]));
        let waiting = order.into_iter().map(|job| (key(job), jobs[job])).collect();
        let left =
            TimeLeft::new(jobs.iter().map(|[cost, _]| *cost), workers, Calibration::default());
        let mut run = PlayedRun { left, now: 0.0, waiting, running: Vec::new() };
        let mut estimates = Vec::new();
        (0..workers).for_each(|worker| run.hand_out(worker as u32));
        while !run.running.is_empty() {
            let end = run.running.iter().map(|(_, end)| *end).fold(f64::INFINITY, f64::min);
            for part in 0..10 {
                let now = run.now + (end - run.now) * f64::from(part) / 10.0;
                estimates.push((now, run.left.seconds(now).unwrap()));
            }
            let worker = run.running.iter().position(|(_, other)| *other == end).unwrap();
            run.finish(worker);
        }
        let whole = run.now;
        let told = estimates.iter().filter(|(now, _)| (0.1..0.9).contains(&(now / whole)));
        told.map(|(now, left)| (left / (whole - now)).max((whole - now) / left)).fold(1.0, f64::max)
    }

    impl PlayedRun {
        fn hear(&mut self, kind: EventKind) {
            let event = Event { seconds: self.now, kind, counts: Counts::default() };
            self.left.hear(&event);
        }

        fn hand_out(&mut self, worker: u32) {
            let Some((key, [predicted, seconds])) = self.waiting.pop() else { return };
            self.hear(EventKind::Leased { key, worker, attempt: 1, predicted });
            self.running.push((key, self.now + seconds));
        }

        fn finish(&mut self, index: usize) {
            let (key, end) = self.running.remove(index);
            self.now = end;
            let worker = self.left.holders[&key];
            let since = self.left.held[&worker].since;
            let seconds = end - since;
            self.hear(EventKind::Done { key, worker, seconds, attempts: 1 });
            self.hand_out(worker);
        }
    }

    #[test]
    fn the_time_left_is_within_a_factor_of_two_from_a_tenth_on() {
        // Meshes from 16 to 128 differ 64 times in elements; there are six jobs of each.
        let meshes = |factor: fn(f64) -> f64| -> Vec<[f64; 2]> {
            [16.0_f64, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0]
                .into_iter()
                .flat_map(|n| [n * n * 1e-4; 6])
                .map(|cost| [cost, cost * factor(cost)])
                .collect()
        };
        let equal: Vec<[f64; 2]> = vec![[1.0, 3.0]; 40];
        // With as many workers as there are large jobs, nothing has ended after a tenth of the run:
        // then only forecasts tell.
        let (few, many): (&[usize], &[usize]) = (&[1, 2], &[1, 2, 7]);
        for (name, jobs, counts) in [
            ("forecasts that hold", meshes(|_| 1.0), many),
            ("a machine that is a little slow", meshes(|_| 1.7), many),
            ("equal jobs", equal, many),
            ("a slow machine", meshes(|_| 4.0), few),
            ("small jobs slower than large ones", meshes(|cost| 2.0 * cost.powf(-0.3)), few),
            ("large jobs slower than small ones", meshes(|cost| 2.0 * cost.powf(0.3)), few),
        ] {
            for &workers in counts {
                let ratio = worst_ratio(&jobs, workers);
                assert!(ratio < 2.0, "{name} on {workers} workers: a factor {ratio:.2}");
            }
        }
    }

    #[test]
    fn a_job_is_in_work_since_the_one_before_it_ended() {
        let mut left = TimeLeft::new([1.0; 3], 1, Calibration::default());
        let mut hear = |seconds: f64, kind: EventKind| {
            left.hear(&Event { seconds, kind, counts: Counts::default() });
            left.held.get(&1).map(|held| held.since)
        };
        for job in 0..3 {
            hear(0.0, leased(job, 1));
        }
        let returned = EventKind::Returned { key: key(2), reason: String::new() };
        assert_eq!(hear(0.5, returned), Some(0.0), "the first goes on");
        let done = EventKind::Done { key: key(0), worker: 1, seconds: 1.0, attempts: 1 };
        assert_eq!(hear(1.0, done), Some(1.0));
    }

    #[test]
    fn jobs_that_come_back_count_again() {
        let mut left = TimeLeft::new([1.0; 3], 1, Calibration::default());
        assert_eq!(left.seconds(0.0), None, "nothing has begun");
        let mut hear = |seconds: f64, kind: EventKind| {
            left.hear(&Event { seconds, kind, counts: Counts::default() });
            left.seconds(seconds)
        };
        assert_eq!(hear(0.0, leased(0, 1)), Some(3.0));
        assert_eq!(hear(0.0, leased(1, 1)), Some(3.0));
        let lost = EventKind::WorkerLost { worker: 1, pid: None, how: String::new() };
        assert!(hear(0.5, lost).unwrap() >= 3.0);
        hear(0.5, leased(0, 2));
        let reason = String::new();
        hear(0.5, EventKind::Postponed { key: key(2), predicted: 1.0, reason });
        let done = EventKind::Done { key: key(0), worker: 2, seconds: 1.0, attempts: 2 };
        hear(1.5, done);
        assert_eq!(left.waiting.0.values().map(|class| class.jobs).sum::<usize>(), 1);
        assert!(left.held.is_empty());
    }
}
