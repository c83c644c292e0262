//! Faults are played to the pure step.

mod mixed;
mod random;
mod time;

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

/// A coordinator of jobs in memory.
type KnownCoordinator = Coordinator<Vec<Task>>;

fn tasks(count: usize) -> Vec<Task> {
    let task = |number: usize| Task {
        key: JobKey([number as u8; 32]),
        payload: vec![0; number % 3],
        group: (number % 4) as u64,
        rank: (number % 3) as u32,
        cost: [0.001, 0.02, 5.0, f64::NAN][number % 4],
        memory: [10, 40, 70, 120][number % 7 % 4],
    };
    (0..count).map(task).collect()
}

fn options(workers: usize) -> Options {
    Options { workers, ..Options::new(vec!["unused".into()], "unused".into(), 100) }
}

fn gone(cause: Cause) -> Loss {
    Loss { how: "gone".into(), cause }
}

/// Lets a worker report that the job of a lease took so long, and commits it. Returns what the
/// coordinator does then.
fn reports(
    coordinator: &mut KnownCoordinator,
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
        rank: 0,
        cost,
        memory,
    };
    (0..count).map(task).collect()
}

/// Returns a coordinator whose workers are up.
fn started(tasks: Vec<Task>, workers: usize) -> KnownCoordinator {
    let mut coordinator = Coordinator::new(tasks, &options(workers));
    coordinator.step(Input::Begin, Duration::ZERO);
    coordinator.step(Input::Settled, Duration::ZERO);
    coordinator
}

#[test]
fn a_reply_waits_until_what_it_acknowledges_is_durable() {
    let mut coordinator = started(alike(200, 1.0, 1), 2);
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
    let mut coordinator = started(tasks, 1);
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
    let mut coordinator = Coordinator::new(alike(3, 1.0, 1), &options);
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
    let mut coordinator = started(alike(3, 1.0, 60), 2);
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
    let mut coordinator = started(alike(1, 1.0, 1), 1);
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
    let mut coordinator = started(alike(1, 1.0, 1), 1);
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
    let mut coordinator = started(alike(2, 1.0, 1), 1);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    coordinator.step(Input::Settled, now);
    assert_eq!(coordinator.step(requests(1, &[]), now), [Action::Kill(1)]);
    assert_eq!(assigned(&coordinator.step(Input::Settled, now)), [], "and gets no more");
}

#[test]
fn the_first_interrupt_dismisses_and_the_second_kills() {
    let mut coordinator = started(alike(5, 1.0, 1), 2);
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
fn loses(coordinator: &mut KnownCoordinator, worker: WorkerId, cause: Cause) -> Vec<Action> {
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
    let mut coordinator = started(alike(2, 1.0, 40), 2);
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
    let mut coordinator = started(alike(1, 1.0, 101), 1);
    assert_eq!(coordinator.counts().postponed, 1);
    assert!(coordinator.finished());
    let Postponement { reason, .. } = coordinator.postponed_for().unwrap();
    assert_eq!(reason, "needs 101 bytes of memory by prediction, and the run may use 100 bytes");
    assert_eq!(coordinator.step(Input::Settled, Duration::ZERO), [], "and nothing is recorded");
}

#[test]
fn workers_that_are_lost_by_no_fault_of_a_job_charge_nothing_and_end_the_run_at_last() {
    let mut coordinator = started(alike(9, 1.0, 1), 1);
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
    let mut coordinator = started(alike(2, 1.0, 1), 1);
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
    let mut coordinator = started(alike(8, 1.0, 40), 1);
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
    let mut coordinator = started(alike(3, 1.0, 1), 2);
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
