//! Long and short jobs are played to the step by workers without processes, on a clock of their
//! own.

use super::*;

/// A worker as the coordinator sees it: it does its jobs one after another, and reports as soon as
/// its last request is answered.
#[derive(Default)]
struct Played {
    jobs: VecDeque<(LeaseId, usize)>,
    results: Vec<Report<Vec<u8>>>,
    /// It is true while its request is not answered.
    open: bool,
    /// The time at which the first of its jobs ends.
    end: Option<Duration>,
}

impl Played {
    fn request(&mut self, worker: WorkerId) -> Option<Input> {
        if self.open || !self.jobs.is_empty() && self.results.is_empty() {
            return None;
        }
        self.open = true;
        let reports = std::mem::take(&mut self.results);
        Some(Input::Request { worker, idle: self.jobs.is_empty(), reports })
    }
}

/// Plays tasks that take so many seconds to some workers, and returns the time after which the last
/// one has ended.
fn end_of(tasks: &[Task], seconds: &[f64], workers: usize) -> f64 {
    let options = Options { memory_limit: u64::MAX, ..options(workers) };
    let mut coordinator = Coordinator::new(tasks.to_vec(), &options);
    let mut played: BTreeMap<WorkerId, Played> = BTreeMap::new();
    let mut now = Duration::ZERO;
    let mut inbox = VecDeque::from([Input::Begin]);
    loop {
        loop {
            let is_settled = inbox.is_empty();
            let input = inbox.pop_front().unwrap_or(Input::Settled);
            for action in coordinator.step(input, now) {
                match action {
                    Action::Start(id) => drop(played.insert(id, Played::default())),
                    Action::Assign(id, jobs) => {
                        let worker = played.get_mut(&id).unwrap();
                        worker.jobs.extend(jobs);
                        worker.open = false;
                    }
                    Action::Dismiss(id) => drop(played.remove(&id)),
                    Action::Commit(_) => inbox.push_back(Input::Committed),
                    Action::Emit(_) => {}
                    action => panic!("{action:?}"),
                }
            }
            for (&id, worker) in &mut played {
                if worker.end.is_none()
                    && let Some((_, job)) = worker.jobs.front()
                {
                    worker.end = Some(now + Duration::from_secs_f64(seconds[*job]));
                }
                inbox.extend(worker.request(id));
            }
            if is_settled && inbox.is_empty() {
                break;
            }
        }
        let next = played.values_mut().filter_map(|worker| Some((worker.end?, worker)));
        let Some((end, worker)) = next.min_by_key(|(end, _)| *end) else { break };
        now = end;
        worker.end = None;
        let (lease, job) = worker.jobs.pop_front().unwrap();
        worker.results.push(Report {
            lease,
            seconds: seconds[job],
            outcome: AttemptOutcome::Completed(Vec::new()),
        });
        for (&id, worker) in &mut played {
            inbox.extend(worker.request(id));
        }
    }
    assert_eq!(coordinator.counts().done, tasks.len());
    now.as_secs_f64()
}

/// Returns tasks with their true times: groups of so many jobs of so many seconds each, the later
/// ones of a higher rank and with another operator.
fn groups(groups: &[(usize, f64)]) -> (Vec<Task>, Vec<f64>) {
    let (mut tasks, mut seconds) = (Vec::new(), Vec::new());
    for (number, &(jobs, cost)) in groups.iter().enumerate() {
        for _ in 0..jobs {
            let mut key = JobKey([0; 32]);
            key.0[..8].copy_from_slice(&tasks.len().to_be_bytes());
            tasks.push(Task {
                key,
                payload: Vec::new(),
                group: number as u64,
                rank: number as u32,
                cost,
                memory: 1,
            });
            seconds.push(cost);
        }
    }
    (tasks, seconds)
}

/// A run takes no longer than its longest job or its share of all work, but for a twentieth.
#[test]
fn long_and_short_jobs_end_together() {
    let mixtures: [(usize, &[(usize, f64)]); 7] = [
        (2, &[(10_000, 0.001), (1, 10.0)]),
        (2, &[(10_000, 0.001), (1, 5.0)]),
        (2, &[(5_000, 0.002), (1, 1.0)]),
        (4, &[(10_000, 0.001), (3, 10.0)]),
        (3, &[(3_000, 0.001), (300, 0.01), (30, 0.1), (3, 1.0), (1, 2.0)]),
        (8, &[(10_000, 0.001), (7, 1.5), (7, 0.2)]),
        (2, &[(1, 10.0), (10_000, 0.001)]),
    ];
    for (workers, mixture) in mixtures {
        let (mut tasks, seconds) = groups(mixture);
        let longest = seconds.iter().copied().fold(0.0, f64::max);
        let least = longest.max(seconds.iter().sum::<f64>() / workers as f64);
        // The prediction of the longest jobs may be too short by a factor of two.
        for wrong in [1.0, 0.5] {
            for task in tasks.iter_mut().filter(|task| task.cost > 0.9 * longest) {
                task.cost = wrong * longest;
            }
            let end = end_of(&tasks, &seconds, workers);
            assert!(end < 1.05 * least, "{workers} {mixture:?}: {end} s, at least {least} s");
        }
    }
}

/// A worker leaves its group only for a job that is much longer.
#[test]
fn jobs_of_like_length_stay_with_their_group() {
    let (mut tasks, _) = groups(&[(40, 1.0), (40, 1.9)]);
    tasks.iter_mut().for_each(|task| task.rank = 0);
    let mut coordinator = started(tasks, 1);
    let now = Duration::from_secs(1);
    coordinator.step(requests(1, &[]), now);
    let mut order = Vec::new();
    let mut actions = coordinator.step(Input::Settled, now);
    while let Some((_, leases)) = assigned(&actions).first() {
        let lease = leases[0];
        order.push(coordinator.leases.get(lease).unwrap().job / 40);
        actions = reports(&mut coordinator, 1, lease, 1.0, now);
    }
    assert!(order.is_sorted_by(|first, second| first >= second), "{order:?}");
    assert_eq!(order.len(), 80);
}
