//! The end of the time that a run has.

use super::*;

/// Returns tasks with these predicted times, which need little memory.
fn lasting(costs: &[f64]) -> Vec<Task> {
    let tasks = alike(costs.len(), 0.0, 1).into_iter();
    tasks.zip(costs).map(|(task, &cost)| Task { cost, ..task }).collect()
}

/// Returns a coordinator with time `until` so many seconds, whose workers are up.
fn started_until(tasks: Vec<Task>, workers: usize, until: u64) -> KnownCoordinator {
    let until = Some(Duration::from_secs(until));
    let options = Options { until, overtime: Duration::from_secs(5), ..options(workers) };
    let mut coordinator = Coordinator::new(tasks, &options);
    coordinator.step(Input::Begin, Duration::ZERO);
    coordinator.step(Input::Settled, Duration::ZERO);
    coordinator
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
    let mut coordinator = started_until(lasting(&[10.0; 4]), 2, 100);
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
    let mut coordinator = started_until(lasting(&[50.0, 8.0, 2.0, 30.0]), 1, 20);
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
    let mut coordinator = started_until(lasting(&[1.0; 3]), 1, 20);
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
    let mut coordinator = started_until(lasting(&[50.0, 8.0, 30.0]), 2, 0);
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
    let mut coordinator = Coordinator::new(lasting(&[1.0; 3]), &options);
    coordinator.step(Input::Begin, Duration::ZERO);
    let actions = coordinator.step(Input::Settled, Duration::ZERO);
    assert_eq!(told(&actions), [false]);
    assert!(!actions.iter().any(|action| matches!(action, Action::Start(_))), "{actions:?}");
    assert!(coordinator.finished());
}

#[test]
fn the_end_of_time_comes_nearer_while_the_process_stands_still() {
    let mut coordinator = started_until(lasting(&[1.0; 3]), 1, 100);
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
        let mut coordinator = started(alike(5, 1.0, 1), 1);
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
    let mut coordinator = started_until(lasting(&[1.0; 1]), 1, 100);
    let second = Duration::from_secs;
    coordinator.step(requests(1, &[]), second(1));
    coordinator.step(Input::Settled, second(1));
    coordinator.step(Input::Clock, second(100));
    reports(&mut coordinator, 1, 1, 1.0, second(101));
    assert_eq!(coordinator.early_end(), None, "the job in flight was the last");
}
