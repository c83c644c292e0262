//! Jobs that bring their workers down, and workers that are lost by no fault of a job.

use super::*;

#[test]
fn a_job_that_kills_its_worker_is_tried_again() {
    let dir = tempfile::tempdir().unwrap();
    let mut tasks = squares(40);
    tasks.push(task(40, format!("crash-once {}", dir.path().join("mark").display())));
    let (summary, kept, events) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.failures, summary.workers_lost), (41, 1, 1));
    assert_eq!((kept.text(40).as_str(), kept.results[&40].attempts), ("survived", 2));
    let lost = events.iter().find_map(|event| {
        if let EventKind::WorkerLost { how, .. } = &event.kind { Some(how.as_str()) } else { None }
    });
    assert_eq!(lost, Some("signal 9, SIGKILL"));
    assert!(
        kept.results.values().all(|done| number(done.key) == 40 || done.attempts == 1),
        "only the culprit is charged"
    );
}

#[test]
fn a_job_that_always_kills_is_set_aside_and_the_rest_goes_on() {
    let mut tasks = squares(60);
    tasks.push(task(60, "crash"));
    let (summary, mut kept, events) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!(
        (summary.done, summary.quarantined, summary.failures, summary.workers_lost),
        (60, 1, 3, 3)
    );
    let set_aside = kept.results.remove(&60).unwrap();
    assert_eq!(set_aside.attempts, 3);
    assert_eq!(
        set_aside.verdict,
        Verdict::Quarantined { reason: "its worker was lost: signal 9, SIGKILL".into() }
    );
    assert_squares(&kept, 60);
    assert!(events.iter().any(|event| matches!(event.kind, EventKind::WorkerReplaced { .. })));
}

#[test]
fn a_panic_costs_the_attempt_and_not_the_worker() {
    let mut tasks = squares(20);
    tasks.push(task(20, "panic"));
    let (summary, kept, _) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!(
        (summary.done, summary.quarantined, summary.failures, summary.workers_lost),
        (20, 1, 3, 0)
    );
    let reason = kept.text(20);
    assert!(
        reason.starts_with("panicked at ")
            && reason.contains("main.rs:")
            && reason.ends_with(": no such punch"),
        "{reason}"
    );
}

#[test]
fn a_job_that_hangs_misses_its_deadline() {
    let options =
        Options { grace: Duration::from_secs(3), patience: 1.0, attempts: 1, ..options() };
    let mut tasks = squares(20);
    tasks.push(task(20, "hang"));
    let (summary, kept, _) = run(tasks, &options);
    assert_eq!(summary.unwrap().quarantined, 1);
    assert!(
        kept.text(20).contains("finished nothing within its deadline of 3."),
        "{}",
        kept.text(20)
    );
}

#[test]
fn a_stopped_worker_is_noticed_by_its_silence() {
    let options = Options {
        heartbeat: Duration::from_millis(200),
        silence: Duration::from_secs(4),
        attempts: 1,
        ..options()
    };
    let (summary, kept, _) =
        run(vec![task(0, "stop"), task(1, "square 3"), task(2, "sleep 6000 x")], &options);
    assert_eq!(summary.unwrap().quarantined, 1);
    assert!(
        kept.text(0).contains("gave no sign of life for 4s (signal 9, SIGKILL)"),
        "{}",
        kept.text(0)
    );
    assert_eq!(
        (kept.text(1).as_str(), kept.text(2).as_str()),
        ("9", "x"),
        "a job longer than the silence is no silence"
    );
}

#[test]
fn a_job_cannot_take_more_memory_than_its_worker_may() {
    let options =
        Options { memory_limit: 1 << 30, address_space_margin: 1 << 30, attempts: 2, ..options() };
    let mut hungry = task(2, "square 2");
    hungry.memory = 2 << 30;
    let (summary, kept, events) =
        run(vec![task(0, "allocate 3000000000"), task(1, "allocate 1000"), hungry], &options);
    let error = summary.unwrap_err().to_string();
    assert!(error.starts_with("2 jobs are left for another run: "), "{error}");
    assert_eq!(kept.text(1), "1000");
    assert_eq!(kept.results.len(), 1, "nothing is recorded of what had too little memory");
    let reasons: BTreeMap<u64, &str> = events
        .iter()
        .filter_map(|event| match &event.kind {
            EventKind::Postponed { key, reason, .. } => Some((number(*key), reason.as_str())),
            _ => None,
        })
        .collect();
    assert!(reasons[&0].ends_with("SIGABRT: out of memory"), "{reasons:?}");
    assert_eq!(reasons[&2], "needs 2.0 GiB of memory by prediction, and the run may use 1.0 GiB");
}

#[test]
fn a_job_that_aborts_its_worker_is_set_aside_unless_it_lacked_memory() {
    let mut tasks = squares(20);
    tasks.extend([task(20, "abort"), task(21, "recurse")]);
    let (summary, mut kept, _) = run(tasks, &options());
    let summary = summary.unwrap();
    assert_eq!((summary.done, summary.quarantined, summary.failures), (20, 2, 6));
    let lost = "its worker was lost: signal 6, SIGABRT: ";
    assert_eq!(kept.text(20), format!("{lost}a panic in a panic, or a call of abort"));
    assert_eq!(kept.text(21), format!("{lost}a stack overflow"));
    kept.results.retain(|&number, _| number < 20);
    assert_squares(&kept, 20);
}

#[test]
fn many_jobs_that_lack_memory_are_left_one_by_one_and_the_rest_is_done() {
    let options =
        Options { workers: 1, memory_limit: 1 << 30, address_space_margin: 1 << 30, ..options() };
    let mut tasks = squares(5);
    tasks.extend((5..12).map(|number| Task { cost: 9.0, ..task(number, "allocate 3000000000") }));
    let (summary, kept, events) = run(tasks, &options);
    let error = summary.unwrap_err().to_string();
    assert!(error.starts_with("7 jobs are left for another run: "), "{error}");
    assert!(error.ends_with("SIGABRT: out of memory"), "{error}");
    assert_squares(&kept, 5);
    assert_eq!(events.last().unwrap().counts.failures, 0);
}

#[test]
fn a_job_whose_worker_always_leaves_is_left_for_another_run_and_the_rest_is_done() {
    let mut tasks = squares(20);
    tasks.push(Task { cost: 9.0, ..task(20, "leave") });
    let (summary, kept, _) = run(tasks, &options());
    assert_eq!(
        summary.unwrap_err().to_string(),
        "1 job is left for another run: its worker was lost: exit status 3 (3 times)"
    );
    assert_squares(&kept, 20);
}

#[test]
fn a_result_that_cannot_be_handed_over_stops_the_run_and_charges_no_job() {
    // A write beyond the limit is an error, and not a signal, once the process is prepared.
    runner::prepare_process().unwrap();
    let mut command = vec!["prlimit".into(), "--fsize=2000000".into()];
    command.extend(ourselves("worker"));
    let options = Options { worker_command: command, ..options() };
    let mut tasks = squares(20);
    tasks.extend((20..24).map(|number| Task { cost: 9.0, ..task(number, "huge 3000000") }));
    let (summary, kept, events) = run(tasks, &options);
    let error = summary.unwrap_err().to_string();
    assert!(
        error.contains("cannot be handed over: cannot write 3000000 bytes to ")
            && error.ends_with("File too large (os error 27)"),
        "{error}"
    );
    assert!(kept.results.keys().all(|&number| number < 20), "nothing is recorded as failed");
    assert_eq!(events.last().unwrap().counts.failures, 0);
    assert!(!options.bodies.exists());
}

#[test]
fn a_job_that_the_system_kills_for_want_of_memory_is_left_for_another_run() {
    let group = PathBuf::from(format!("/sys/fs/cgroup/memory/runner-test-{}", std::process::id()));
    if std::fs::create_dir(&group).is_err() {
        eprintln!("skipped, because no group of limited memory can be made here");
        return;
    }
    std::fs::write(group.join("memory.limit_in_bytes"), "200000000").unwrap();
    let join = format!("echo $$ > {}/cgroup.procs; exec \"$0\" \"$@\"", group.display());
    let mut command = vec!["sh".into(), "-c".into(), join.into()];
    command.extend(ourselves("worker"));
    let options = Options { worker_command: command, ..options() };
    let mut tasks: Vec<_> =
        (0..20).map(|number| task(number, format!("sleep 20 {number}"))).collect();
    tasks.push(Task { cost: 9.0, ..task(20, "allocate 600000000") });
    let (summary, kept, events) = run(tasks, &options);
    let error = summary.unwrap_err().to_string();
    assert!(error.contains("the system had too little memory and killed it"), "{error}");
    assert_eq!(kept.results.len(), 20, "the others are done");
    let last = events.last().unwrap();
    assert_eq!((last.counts.postponed, last.counts.failures), (1, 0));
    assert!(
        events.iter().any(|event| matches!(&event.kind, EventKind::Returned { reason, .. }
            if reason.ends_with("it will run while no other job does"))),
        "it is tried alone before"
    );
    std::fs::remove_dir(&group).unwrap();
}
