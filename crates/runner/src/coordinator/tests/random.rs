//! Random faults are played to the pure step, and no rule breaks.

use super::*;

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
        1 => Just(Input::Enough),
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
    coordinator: KnownCoordinator,
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
        let coordinator = Coordinator::new(tasks.to_vec(), options);
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
