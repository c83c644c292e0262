//! Faults are played to the pure step.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use proptest::prelude::*;

use identity::JobKey;

use super::messages::{Action, Hopeless, Input};
use super::state::{Coordinator, EarlyEnd, Postponement};
use crate::error::Want;
use crate::event::EventKind;
use crate::lease::{LeaseId, WorkerId};
use crate::ledger::{Done, Verdict};
use crate::loss::{Cause, Loss};
use crate::options::Options;
use crate::protocol::{AttemptOutcome, Report};
use crate::task::Task;

fn tasks(count: usize) -> Vec<Task> {
    let task = |number: usize| Task {
        key: JobKey([number as u8; 32]),
        payload: vec![0; number % 3],
        group: (number % 4) as u64,
        cost: [0.001, 0.02, 5.0, f64::NAN][number % 4],
        memory: [10, 40, 70, 120][number % 7 % 4],
    };
    (0..count).map(task).collect()
}

fn options(workers: usize) -> Options {
    Options { workers, ..Options::new(vec!["unused".into()], "unused".into(), 100) }
}

/// Generates any input, sensible or not.
fn input() -> impl Strategy<Value = Input> {
    let worker = 0..8u32;
    let outcome = prop_oneof![
        9 => Just(AttemptOutcome::Completed(vec![1])),
        3 => Just(AttemptOutcome::Failed("no".to_string())),
        1 => Just(AttemptOutcome::Undelivered("full".to_string())),
    ];
    let cause = prop_oneof![Just(Cause::Job), Just(Cause::Memory), Just(Cause::Circumstances)];
    let seconds =
        prop_oneof![Just(0.0), Just(0.01), Just(f64::NAN), Just(f64::INFINITY), Just(-1.0)];
    let report = (0..40u64, seconds, outcome).prop_map(|(lease, seconds, outcome)| Report {
        lease,
        seconds,
        outcome,
    });
    prop_oneof![
        6 => Just(Input::Settled),
        4 => (worker.clone(), any::<bool>(), proptest::collection::vec(report, 0..5))
            .prop_map(|(worker, idle, reports)| Input::Request { worker, idle, reports }),
        6 => worker.clone().prop_map(|worker| Input::Request { worker, idle: false, reports: Vec::new() }),
        2 => Just(Input::Committed),
        1 => Just(Input::Clock),
        1 => worker.clone().prop_map(|worker| Input::Heartbeat { worker }),
        1 => (worker.clone(), cause, proptest::option::of(0..40u64))
            .prop_map(|(worker, cause, running)| Input::Exited { worker, loss: gone(cause), running }),
        1 => Just(Input::StoodStill(Duration::from_secs(3))),
        1 => worker.clone().prop_map(|worker| Input::Spawned { worker, pid: worker }),
        1 => worker.clone().prop_map(|worker| Input::Nonsense { worker, reason: "babbles".into() }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_sequence_of_inputs_breaks_a_rule(
        inputs in proptest::collection::vec((input(), 0..20_000u64), 0..120),
        (workers, jobs) in (1..5usize, 0..20usize),
        interrupts in proptest::collection::btree_set(0..240usize, 0..3),
        ends in proptest::collection::btree_set(0..240usize, 0..2),
        until in proptest::option::of(0..1000u64),
    ) {
        let tasks = tasks(jobs);
        let until = until.map(Duration::from_secs);
        let mut coordinator = Coordinator::new(&tasks, &Options { until, ..options(workers) });
        let (mut now, mut durable, mut given) = (0, BTreeSet::new(), BTreeSet::new());
        let first = [(Input::Begin, 0), (Input::Settled, 0)];
        for (number, (input, later)) in first.into_iter().chain(inputs).enumerate() {
            now += later;
            let interrupt = interrupts.contains(&number).then_some(Input::Interrupt);
            let end = ends.contains(&number).then_some(Input::End);
            for input in interrupt.into_iter().chain(end).chain([input]) {
                for action in coordinator.step(input, Duration::from_millis(now)) {
                    if let Action::Commit(done) = action {
                        for done in done {
                            prop_assert!(given.insert(done.key), "{} is committed twice", done.key);
                        }
                    }
                }
                prop_assert_eq!(coordinator.check(), Ok(()));
                let after: BTreeSet<_> = coordinator.durable().into_iter().collect();
                prop_assert!(durable.is_subset(&after), "done is final");
                durable = after;
            }
        }
    }

    #[test]
    fn every_run_ends_with_every_job_done_or_set_aside(seed in any::<u64>(), faults in 0..40u64, workers in 1..5usize, jobs in 0..40usize) {
        let mut world = World::new(seed, faults, &tasks(jobs), &options(workers));
        world.run();
        let counts = world.coordinator.counts();
        if !world.given_up {
            prop_assert_eq!(counts.done + counts.quarantined + counts.postponed, jobs);
        }
        prop_assert_eq!(world.committed.len(), counts.done + counts.quarantined);
        for done in world.committed.values() {
            prop_assert!(done.attempts <= 3);
            if let Verdict::Quarantined { reason } = &done.verdict {
                prop_assert!(done.attempts == 3, "{}", reason);
            }
        }
    }
}

proptest! {
    #[test]
    fn every_run_ends_in_time_and_records_no_more_than_it_should(
        seed in any::<u64>(),
        (faults, workers, jobs) in (0..40u64, 1..5usize, 0..40usize),
        until in 0..20_000u64,
    ) {
        let until = Duration::from_millis(until);
        let overtime = Duration::from_secs(2);
        let options = Options { until: Some(until), overtime, ..options(workers) };
        let mut world = World::new(seed, faults, &tasks(jobs), &options);
        world.run();
        let late = world.begun.iter().filter(|&&time| time >= until).count();
        prop_assert!(late <= usize::from(late == world.begun.len()), "{:?}", world.begun);
        let counts = world.coordinator.counts();
        let ended = counts.done + counts.quarantined;
        prop_assert_eq!(world.committed.len(), ended);
        prop_assert_eq!(ended + counts.postponed + counts.waiting, jobs);
        if counts.waiting > 0 && !world.given_up {
            prop_assert_eq!(world.coordinator.early_end(), Some(EarlyEnd::InTime));
        }
    }
}

/// The simulated workers, which keep to the protocol until they fail.
struct World {
    coordinator: Coordinator,
    workers: BTreeMap<WorkerId, Simulated>,
    /// The requests that were still on their way when their worker died.
    late: Vec<Input>,
    committed: BTreeMap<JobKey, Done>,
    given_up: bool,
    /// The time at which each lease began.
    begun: Vec<Duration>,
    random: u64,
    faults: u64,
    now: Duration,
}

#[derive(Default)]
struct Simulated {
    leases: VecDeque<LeaseId>,
    awaits: bool,
    reports: Vec<Report<Vec<u8>>>,
    hangs: bool,
}

impl World {
    fn new(seed: u64, faults: u64, tasks: &[Task], options: &Options) -> World {
        let coordinator = Coordinator::new(tasks, options);
        World {
            coordinator,
            workers: BTreeMap::new(),
            late: Vec::new(),
            committed: BTreeMap::new(),
            given_up: false,
            begun: Vec::new(),
            random: seed,
            faults,
            now: Duration::ZERO,
        }
    }

    fn random(&mut self, below: u64) -> u64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 33) % below
    }

    fn fault(&mut self) -> bool {
        self.random(200) < self.faults
    }

    fn run(&mut self) {
        let mut inbox = VecDeque::from([Input::Begin]);
        for _ in 0..200_000 {
            let input = inbox.pop_front().unwrap_or(Input::Settled);
            let settled = input == Input::Settled;
            for action in self.coordinator.step(input, self.now) {
                self.act(action, &mut inbox);
            }
            assert_eq!(self.coordinator.check(), Ok(()));
            if settled && inbox.is_empty() {
                if self.coordinator.finished() {
                    return;
                }
                self.advance(&mut inbox);
            }
        }
        panic!("the run does not end: {:?}", self.coordinator);
    }

    fn act(&mut self, action: Action, inbox: &mut VecDeque<Input>) {
        match action {
            Action::Start(worker) => {
                self.workers.insert(worker, Simulated::default());
                inbox.push_back(Input::Spawned { worker, pid: worker });
            }
            Action::Kill(worker) | Action::Dismiss(worker) => self.end(worker, inbox),
            Action::Assign(worker, jobs) => {
                self.begun.extend(jobs.iter().map(|_| self.now));
                if let Some(Simulated { leases, awaits, .. }) = self.workers.get_mut(&worker) {
                    assert!(*awaits, "a reply that nobody asked for");
                    leases.extend(jobs.into_iter().map(|(lease, _)| lease));
                    *awaits = false;
                }
            }
            Action::Commit(done) => {
                for done in done {
                    assert!(self.committed.insert(done.key, done).is_none(), "committed twice");
                }
                inbox.push_back(Input::Committed);
            }
            Action::Emit(_) => {}
            Action::GiveUp(_) => self.given_up = true,
        }
    }

    fn end(&mut self, worker: WorkerId, inbox: &mut VecDeque<Input>) {
        if let Some(Simulated { leases, reports, .. }) = self.workers.remove(&worker) {
            // Its computed results may still arrive after its death.
            self.late.push(Input::Request { worker, idle: false, reports });
            let running = leases.front().copied().filter(|_| self.random(2) == 0);
            let causes = [Cause::Job, Cause::Job, Cause::Memory, Cause::Circumstances];
            let cause = causes[self.random(4) as usize];
            inbox.push_back(Input::Exited { worker, loss: gone(cause), running });
        }
    }

    /// Lets one worker do something, or lets time pass.
    fn advance(&mut self, inbox: &mut VecDeque<Input>) {
        let later = 1 + self.random(50);
        self.now += Duration::from_millis(later);
        let count = self.workers.len() as u64;
        let chosen = if count > 0 { self.random(count) as usize } else { 0 };
        let Some(worker) = self.workers.keys().nth(chosen).copied() else {
            return inbox.push_back(Input::Clock);
        };
        if self.fault() {
            return self.end(worker, inbox);
        }
        if self.fault() {
            inbox.extend(self.late.pop());
        }
        let (fails, stops) = (self.fault(), self.fault());
        let Simulated { leases, awaits, reports, hangs } = self.workers.get_mut(&worker).unwrap();
        *hangs |= stops;
        if *hangs {
            // Only its deadline ends this.
            self.now += Duration::from_secs(40);
            inbox.extend(
                self.workers
                    .keys()
                    .filter(|&&other| other != worker)
                    .map(|&worker| Input::Heartbeat { worker }),
            );
            return inbox.push_back(Input::Clock);
        }
        if let Some(lease) = leases.pop_front() {
            let outcome = if fails {
                AttemptOutcome::Failed("no".into())
            } else {
                AttemptOutcome::Completed(vec![7])
            };
            reports.push(Report { lease, seconds: 0.01, outcome });
        }
        if !*awaits {
            *awaits = true;
            let request = Input::Request {
                worker,
                idle: leases.is_empty(),
                reports: std::mem::take(reports),
            };
            if fails {
                inbox.push_back(request.clone());
            }
            inbox.push_back(request);
        }
    }
}

fn gone(cause: Cause) -> Loss {
    Loss { how: "gone".into(), cause }
}

fn requests(worker: WorkerId, leases: &[LeaseId]) -> Input {
    let reports = leases.iter().map(|&lease| Report {
        lease,
        seconds: 1e-6,
        outcome: AttemptOutcome::Completed(vec![7]),
    });
    Input::Request { worker, idle: true, reports: reports.collect() }
}

fn assigned(actions: &[Action]) -> Vec<(WorkerId, Vec<LeaseId>)> {
    let assigned = actions.iter().filter_map(|action| match action {
        Action::Assign(worker, jobs) => {
            Some((*worker, jobs.iter().map(|&(lease, _)| lease).collect()))
        }
        _ => None,
    });
    assigned.collect()
}

fn alike(count: usize, cost: f64, memory: u64) -> Vec<Task> {
    let task = |number: usize| Task {
        key: JobKey([number as u8; 32]),
        payload: Vec::new(),
        group: 0,
        cost,
        memory,
    };
    (0..count).map(task).collect()
}

/// Returns a coordinator whose workers are up.
fn started(tasks: &[Task], workers: usize) -> Coordinator {
    let mut coordinator = Coordinator::new(tasks, &options(workers));
    coordinator.step(Input::Begin, Duration::ZERO);
    coordinator.step(Input::Settled, Duration::ZERO);
    coordinator
}

#[test]
fn a_reply_waits_until_what_it_acknowledges_is_durable() {
    let mut coordinator = started(&alike(200, 1.0, 1), 2);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    assert_eq!(
        assigned(&coordinator.step(Input::Settled, now)),
        [(1, vec![1])],
        "one job, while nothing is known of its length"
    );
    coordinator.step(requests(1, &[1]), now);
    let actions = coordinator.step(Input::Settled, now);
    assert!(matches!(&actions[..], [Action::Commit(done)] if done.len() == 1), "{actions:?}");
    assert_eq!(coordinator.step(Input::Settled, now), [], "not durable, no reply");
    coordinator.step(Input::Committed, now);
    let next = assigned(&coordinator.step(Input::Settled, now));
    assert_eq!(
        next[0].1.len(),
        49,
        "short jobs go in batches, but not more than a fair share of what is left"
    );
}

#[test]
fn a_long_job_is_not_held_behind_another() {
    let mut tasks = alike(10, 0.001, 1);
    tasks[0].cost = 0.5;
    tasks[1].cost = 0.5;
    let mut coordinator = started(&tasks, 1);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [(1, vec![1])]);
    let report = Report { lease: 1, seconds: 0.5, outcome: AttemptOutcome::Completed(Vec::new()) };
    coordinator.step(Input::Request { worker: 1, idle: true, reports: vec![report] }, now);
    coordinator.step(Input::Settled, now);
    coordinator.step(Input::Committed, now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [(1, vec![2])]);
}

#[test]
fn endless_patience_and_any_number_of_workers_are_options() {
    let options = Options {
        start_timeout: Duration::MAX,
        silence: Duration::MAX,
        grace: Duration::MAX,
        ..options(usize::MAX)
    };
    let mut coordinator = Coordinator::new(&alike(3, 1.0, 1), &options);
    let now = Duration::from_secs(1);
    coordinator.step(Input::Begin, now);
    let starts = coordinator.step(Input::Settled, now);
    assert_eq!(starts.iter().filter(|action| matches!(action, Action::Start(_))).count(), 3);
    assert_eq!(coordinator.alarm(), Some(Duration::MAX), "of the start");
    coordinator.step(requests(1, &[]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now))[0].1.len(), 1);
    assert_eq!(coordinator.alarm(), Some(Duration::MAX), "of a sign of life");
}

#[test]
fn what_does_not_fit_together_waits() {
    let mut coordinator = started(&alike(3, 1.0, 60), 2);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    coordinator.step(requests(2, &[]), now);
    assert_eq!(
        assigned(&coordinator.step(Input::Settled, now)),
        [(1, vec![1])],
        "the second worker waits: 60 + 60 > 100"
    );
    coordinator.step(requests(1, &[1]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [(2, vec![2])]);
}

#[test]
fn the_result_of_a_lost_lease_is_dropped() {
    let mut coordinator = started(&alike(1, 1.0, 1), 1);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    coordinator.step(Input::Settled, now);
    coordinator.step(Input::Exited { worker: 1, loss: gone(Cause::Job), running: Some(1) }, now);
    coordinator.step(requests(1, &[1]), now);
    assert_eq!(
        (coordinator.tally.stale, coordinator.counts().waiting, coordinator.counts().failures),
        (1, 1, 1)
    );
    let actions = coordinator.step(Input::Settled, now);
    assert!(
        actions.contains(&Action::Start(2))
            && !actions.iter().any(|action| matches!(action, Action::Commit(_)))
    );
}

#[test]
fn a_worker_that_dies_before_it_begins_charges_its_first_job() {
    let mut coordinator = started(&alike(1, 1.0, 1), 1);
    let now = Duration::from_secs(1);
    for worker in 1..=3 {
        coordinator.step(requests(worker, &[]), now);
        coordinator.step(Input::Settled, now);
        coordinator.step(Input::Exited { worker, loss: gone(Cause::Job), running: None }, now);
        assert_eq!(coordinator.counts().failures, worker as usize, "or it would be tried for ever");
        coordinator.step(Input::Settled, now);
    }
    assert_eq!(coordinator.counts().saving, 1);
}

#[test]
fn a_worker_that_forgets_its_jobs_is_killed() {
    let mut coordinator = started(&alike(2, 1.0, 1), 1);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    coordinator.step(Input::Settled, now);
    assert_eq!(coordinator.step(requests(1, &[]), now), [Action::Kill(1)]);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [], "and gets no more");
}

#[test]
fn the_first_interrupt_dismisses_and_the_second_kills() {
    let mut coordinator = started(&alike(5, 1.0, 1), 2);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    coordinator.step(Input::Settled, now);
    coordinator.step(Input::Interrupt, now);
    coordinator.step(requests(2, &[]), now);
    let actions = coordinator.step(Input::Settled, now);
    assert!(actions.contains(&Action::Dismiss(2)) && assigned(&actions).is_empty(), "{actions:?}");
    let actions = coordinator.step(Input::Interrupt, now);
    assert!(actions.contains(&Action::Kill(1)), "{actions:?}");
}

/// Lets a worker take a job and be lost, and returns what the coordinator does then.
fn loses(coordinator: &mut Coordinator, worker: WorkerId, cause: Cause) -> Vec<Action> {
    let now = Duration::from_secs(1);
    coordinator.step(requests(worker, &[]), now);
    coordinator.step(Input::Settled, now);
    let mut actions =
        coordinator.step(Input::Exited { worker, loss: gone(cause), running: None }, now);
    actions.extend(coordinator.step(Input::Settled, now));
    assert_eq!(coordinator.check(), Ok(()));
    actions
}

#[test]
fn a_job_that_lacks_memory_is_tried_alone_and_then_left_for_another_run() {
    let mut coordinator = started(&alike(2, 1.0, 40), 2);
    let now = Duration::from_secs(1);
    coordinator.step(requests(2, &[]), now);
    coordinator.step(Input::Settled, now);
    loses(&mut coordinator, 1, Cause::Memory);
    let counts = coordinator.counts();
    assert_eq!((counts.failures, counts.waiting, counts.postponed), (0, 1, 0), "no attempt counts");
    // Worker 3 replaces worker 1, and gets nothing while worker 2 is busy.
    coordinator.step(requests(3, &[]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), []);
    coordinator.step(requests(2, &[1]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [(3, vec![3])]);
    coordinator.step(Input::Exited { worker: 3, loss: gone(Cause::Memory), running: None }, now);
    let counts = coordinator.counts();
    assert_eq!((counts.postponed, counts.quarantined, counts.failures), (1, 0, 0));
    let Postponement { reason, want } = coordinator.postponed_for().unwrap();
    assert_eq!((reason.as_str(), *want), ("its worker was lost: gone", Want::Memory));
}

#[test]
fn a_job_that_needs_more_than_the_limit_is_left_for_another_run() {
    let mut coordinator = started(&alike(1, 1.0, 101), 1);
    assert_eq!(coordinator.counts().postponed, 1);
    assert!(coordinator.finished());
    let Postponement { reason, .. } = coordinator.postponed_for().unwrap();
    assert_eq!(reason, "needs 101 bytes of memory by prediction, and the run may use 100 bytes");
    assert_eq!(coordinator.step(Input::Settled, Duration::ZERO), [], "and nothing is recorded");
}

#[test]
fn workers_that_are_lost_by_no_fault_of_a_job_charge_nothing_and_end_the_run_at_last() {
    let mut coordinator = started(&alike(9, 1.0, 1), 1);
    for worker in 1..12 {
        let actions = loses(&mut coordinator, worker, Cause::Circumstances);
        assert!(actions.contains(&Action::Start(worker + 1)), "{actions:?}");
    }
    let actions = loses(&mut coordinator, 12, Cause::Circumstances);
    assert!(actions.contains(&Action::GiveUp(Hopeless::Losses("gone".into()))), "{actions:?}");
    let counts = coordinator.counts();
    assert_eq!((counts.waiting, counts.failures, counts.saving), (5, 0, 0));
    assert_eq!(counts.postponed, 4, "three losses each");
    assert!(coordinator.finished());
}

#[test]
fn a_job_that_always_loses_its_worker_is_left_and_the_others_go_on() {
    let mut coordinator = started(&alike(2, 1.0, 1), 1);
    for worker in 1..=3 {
        assert_eq!(coordinator.counts().postponed, 0);
        loses(&mut coordinator, worker, Cause::Circumstances);
    }
    let counts = coordinator.counts();
    assert_eq!((counts.postponed, counts.waiting, counts.failures), (1, 1, 0));
    let Postponement { reason, want } = coordinator.postponed_for().unwrap();
    assert_eq!(reason, "its worker was lost: gone (3 times)");
    assert_eq!(*want, Want::Luck);
    let now = Duration::from_secs(1);
    coordinator.step(requests(4, &[]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [(4, vec![4])], "the other job");
    reports(&mut coordinator, 4, 4, 1.0, now);
    assert_eq!(coordinator.counts().done, 1);
}

/// Each of them has its worker twice, so together they lose more than are lost in vain.
#[test]
fn many_jobs_that_lack_memory_do_not_stop_the_run() {
    let mut coordinator = started(&alike(8, 1.0, 40), 1);
    for worker in 1..=14 {
        let actions = loses(&mut coordinator, worker, Cause::Memory);
        let has_given_up = actions.iter().any(|action| matches!(action, Action::GiveUp(_)));
        assert!(!has_given_up && actions.contains(&Action::Start(worker + 1)), "{actions:?}");
    }
    let counts = coordinator.counts();
    assert_eq!((counts.postponed, counts.waiting, counts.failures), (7, 1, 0));
    let now = Duration::from_secs(1);
    coordinator.step(requests(15, &[]), now);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [(15, vec![15])]);
    reports(&mut coordinator, 15, 15, 1.0, now);
    assert_eq!(coordinator.counts().done, 1, "the job that has enough is done");
}

#[test]
fn a_result_that_cannot_be_handed_over_stops_the_run_and_charges_nothing() {
    let mut coordinator = started(&alike(3, 1.0, 1), 2);
    let now = Duration::from_secs(1);
    for worker in [1, 2] {
        coordinator.step(requests(worker, &[]), now);
    }
    coordinator.step(Input::Settled, now);
    let outcome = AttemptOutcome::Undelivered("no room".into());
    let reports = vec![Report { lease: 1, seconds: 1.0, outcome }];
    let actions = coordinator.step(Input::Request { worker: 1, idle: true, reports }, now);
    assert!(actions.contains(&Action::GiveUp(Hopeless::Delivery("no room".into()))));
    assert!(actions.contains(&Action::Kill(2)), "nobody waits for the long job of another");
    for worker in [1, 2] {
        coordinator.step(Input::Exited { worker, loss: gone(Cause::Job), running: None }, now);
    }
    let counts = coordinator.counts();
    assert_eq!((counts.waiting, counts.failures), (3, 0));
    assert!(coordinator.finished());
}

/// Returns tasks with these predicted times, which need little memory.
fn lasting(costs: &[f64]) -> Vec<Task> {
    let tasks = alike(costs.len(), 0.0, 1).into_iter();
    tasks.zip(costs).map(|(task, &cost)| Task { cost, ..task }).collect()
}

/// Returns a coordinator with time `until` so many seconds, whose workers are up.
fn started_until(tasks: &[Task], workers: usize, until: u64) -> Coordinator {
    let until = Some(Duration::from_secs(until));
    let options = Options { until, overtime: Duration::from_secs(5), ..options(workers) };
    let mut coordinator = Coordinator::new(tasks, &options);
    coordinator.step(Input::Begin, Duration::ZERO);
    coordinator.step(Input::Settled, Duration::ZERO);
    coordinator
}

/// Lets a worker report that the job of a lease took so long, and commits it. Returns what the
/// coordinator does then.
fn reports(
    coordinator: &mut Coordinator,
    worker: WorkerId,
    lease: LeaseId,
    seconds: f64,
    now: Duration,
) -> Vec<Action> {
    let report = Report { lease, seconds, outcome: AttemptOutcome::Completed(Vec::new()) };
    let mut actions =
        coordinator.step(Input::Request { worker, idle: true, reports: vec![report] }, now);
    for input in [Input::Settled, Input::Committed, Input::Settled] {
        actions.extend(coordinator.step(input, now));
    }
    assert_eq!(coordinator.check(), Ok(()));
    actions
}

/// Returns whether the time is told to be up in these actions, once for each time.
fn told(actions: &[Action]) -> Vec<bool> {
    let told = actions.iter().filter_map(|action| match action {
        Action::Emit(event) => match event.kind {
            EventKind::TimeUp { now } => Some(now),
            _ => None,
        },
        _ => None,
    });
    told.collect()
}

#[test]
fn after_the_time_no_job_is_begun_and_what_is_in_flight_is_given_up_at_last() {
    let mut coordinator = started_until(&lasting(&[10.0; 4]), 2, 100);
    let second = Duration::from_secs;
    for worker in [1, 2] {
        coordinator.step(requests(worker, &[]), second(80));
    }
    assert_eq!(
        assigned(&coordinator.step(Input::Settled, second(80))),
        [(1, vec![1]), (2, vec![2])]
    );
    assert_eq!(coordinator.alarm(), Some(second(100)));
    let actions = coordinator.step(Input::Clock, second(100));
    assert_eq!(told(&actions), [false]);
    assert_eq!(coordinator.alarm(), Some(second(105)), "jobs in flight have 5 s");
    let actions = reports(&mut coordinator, 1, 1, 10.0, second(102));
    assert!(actions.contains(&Action::Dismiss(1)) && assigned(&actions).is_empty(), "{actions:?}");
    assert_eq!(coordinator.step(Input::Clock, second(104)), []);
    let actions = coordinator.step(Input::Clock, second(105));
    assert_eq!(told(&actions), [true]);
    assert!(actions.contains(&Action::Kill(2)), "{actions:?}");
    assert_eq!(coordinator.early_end(), Some(EarlyEnd::InTime));
    for worker in [1, 2] {
        let gone = Input::Exited { worker, loss: gone(Cause::Job), running: None };
        coordinator.step(gone, second(105));
    }
    let counts = coordinator.counts();
    assert_eq!((counts.done, counts.waiting, counts.failures), (1, 3, 0), "no attempt is charged");
    assert!(coordinator.finished());
    assert_eq!(coordinator.alarm(), None);
}

#[test]
fn what_does_not_fit_into_the_time_left_is_passed_over() {
    let mut coordinator = started_until(&lasting(&[50.0, 8.0, 2.0, 30.0]), 1, 20);
    let second = Duration::from_secs;
    coordinator.step(requests(1, &[]), second(1));
    let actions = coordinator.step(Input::Settled, second(1));
    assert!(matches!(&actions[..], [Action::Assign(1, jobs), _] if jobs[..] == [(1, 1)]));
    let actions = reports(&mut coordinator, 1, 1, 8.0, second(9));
    assert_eq!(assigned(&actions), [(1, vec![2])], "the third, which takes 2 s");
    let actions = reports(&mut coordinator, 1, 2, 2.0, second(11));
    assert_eq!(told(&actions), [false], "nothing is left that fits into 9 s");
    assert!(actions.contains(&Action::Dismiss(1)), "{actions:?}");
    assert_eq!((coordinator.counts().done, coordinator.counts().waiting), (2, 2));
}

#[test]
fn times_that_jobs_took_correct_what_fits() {
    let mut coordinator = started_until(&lasting(&[1.0; 3]), 1, 20);
    let second = Duration::from_secs;
    coordinator.step(requests(1, &[]), Duration::ZERO);
    coordinator.step(Input::Settled, Duration::ZERO);
    let actions = reports(&mut coordinator, 1, 1, 9.0, second(9));
    assert_eq!(assigned(&actions), [(1, vec![2])], "9 s fit into 11 s");
    let actions = reports(&mut coordinator, 1, 2, 9.0, second(18));
    assert_eq!((assigned(&actions), told(&actions)), (Vec::new(), vec![false]));
}

#[test]
fn with_no_time_at_all_the_shortest_job_is_begun_and_no_other() {
    let second = Duration::from_secs;
    let mut coordinator = started_until(&lasting(&[50.0, 8.0, 30.0]), 2, 0);
    assert_ne!(coordinator.alarm(), Some(Duration::ZERO), "or it would spin");
    for worker in [1, 2] {
        coordinator.step(requests(worker, &[]), second(3));
    }
    let actions = coordinator.step(Input::Settled, second(3));
    assert!(
        actions
            .iter()
            .any(|action| matches!(action, Action::Assign(1, jobs) if jobs[..] == [(1, 1)])),
        "{actions:?}"
    );
    assert_eq!(assigned(&actions).len(), 1);
    coordinator.step(Input::Settled, second(3));
    assert_eq!(coordinator.alarm(), Some(second(8)), "its time counts from here");
    let actions = reports(&mut coordinator, 1, 1, 4.0, second(7));
    assert!(assigned(&actions).is_empty() && coordinator.counts().done == 1, "{actions:?}");
}

#[test]
fn a_run_that_owes_no_job_and_has_no_time_starts_nothing() {
    let options = Options { until: Some(Duration::ZERO), begins_one: false, ..options(2) };
    let mut coordinator = Coordinator::new(&lasting(&[1.0; 3]), &options);
    coordinator.step(Input::Begin, Duration::ZERO);
    let actions = coordinator.step(Input::Settled, Duration::ZERO);
    assert_eq!(told(&actions), [false]);
    assert!(!actions.iter().any(|action| matches!(action, Action::Start(_))), "{actions:?}");
    assert!(coordinator.finished());
}

#[test]
fn the_end_of_time_comes_nearer_while_the_process_stands_still() {
    let mut coordinator = started_until(&lasting(&[1.0; 3]), 1, 100);
    let second = Duration::from_secs;
    coordinator.step(requests(1, &[]), second(1));
    coordinator.step(Input::Settled, second(1));
    coordinator.step(Input::StoodStill(second(90)), second(2));
    assert_eq!(told(&coordinator.step(Input::Clock, second(9))), Vec::<bool>::new());
    assert_eq!(told(&coordinator.step(Input::Clock, second(10))), [false]);
    coordinator.step(Input::StoodStill(second(4)), second(10));
    assert_eq!(told(&coordinator.step(Input::Clock, second(11))), [true]);
}

#[test]
fn a_request_for_an_end_leaves_some_time_and_a_second_leaves_none() {
    for twice in [false, true] {
        let mut coordinator = started(&alike(5, 1.0, 1), 1);
        let second = Duration::from_secs;
        coordinator.step(requests(1, &[]), second(1));
        coordinator.step(Input::Settled, second(1));
        assert_eq!(told(&coordinator.step(Input::End, second(2))), [false]);
        let overtime = coordinator.options.overtime;
        assert_eq!(coordinator.alarm(), Some(second(2) + overtime));
        let actions = if twice {
            coordinator.step(Input::End, second(3))
        } else {
            coordinator.step(Input::Clock, second(2) + overtime)
        };
        assert_eq!(told(&actions), [true]);
        assert!(actions.contains(&Action::Kill(1)), "{actions:?}");
        assert_eq!(coordinator.early_end(), Some(EarlyEnd::InTime));
    }
}

#[test]
fn a_run_that_is_done_in_time_ends_like_any_other() {
    let mut coordinator = started_until(&lasting(&[1.0; 1]), 1, 100);
    let second = Duration::from_secs;
    coordinator.step(requests(1, &[]), second(1));
    coordinator.step(Input::Settled, second(1));
    coordinator.step(Input::Clock, second(100));
    reports(&mut coordinator, 1, 1, 1.0, second(101));
    assert_eq!(coordinator.early_end(), None, "the job in flight was the last");
}
