//! Workers are threads and messages are channels here, so the whole runner works without a process.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::Duration;

use super::{Bytes, Link, Transport};
use crate::coordinator::Input;
use crate::error::TransportError;
use crate::lease::{LeaseId, WorkerId};
use crate::loss::{Cause, Loss};
use crate::protocol::{Assignment, Reply, Request};
use crate::worker::{Executor, serve};

type WorkerReply = Reply<Result<Bytes, String>>;

/// The workers as threads. `dies` tells at which lease a worker ends without a word.
pub(crate) struct Threads<F> {
    fresh: F,
    dies: fn(LeaseId) -> bool,
    live: BTreeMap<WorkerId, (Sender<WorkerReply>, Arc<AtomicU64>)>,
    to_us: Sender<Input>,
    heard: Receiver<Input>,
}

impl<F> Threads<F> {
    pub(crate) fn new(fresh: F, dies: fn(LeaseId) -> bool) -> Threads<F> {
        let (to_us, heard) = channel();
        Threads { fresh, dies, live: BTreeMap::new(), to_us, heard }
    }

    fn exit(&mut self, worker: WorkerId, how: &str) -> Option<Input> {
        let (_, begun) = self.live.remove(&worker)?;
        let running = Some(begun.load(Ordering::SeqCst)).filter(|&lease| lease != 0);
        Some(Input::Exited { worker, loss: lost(how), running })
    }
}

impl<E: Executor, F: Fn() -> E + Clone + Send + 'static> Transport for Threads<F> {
    fn start(&mut self, worker: WorkerId) -> Result<u32, String> {
        let (to_worker, replies) = channel();
        let begun = Arc::new(AtomicU64::new(0));
        let mut end = ThreadLink {
            worker,
            replies,
            to_us: self.to_us.clone(),
            begun: begun.clone(),
            dies: self.dies,
        };
        self.live.insert(worker, (to_worker, begun));
        let fresh = self.fresh.clone();
        std::thread::spawn(move || {
            let _ = serve(&mut end, fresh);
            let _ = end.to_us.send(Input::Exited {
                worker,
                loss: lost("the thread ended"),
                running: None,
            });
        });
        Ok(worker)
    }

    /// Ends a worker. The thread goes on until it talks again, like a process whose last message is
    /// still on its way.
    fn kill(&mut self, worker: WorkerId) {
        if let Some(exit) = self.exit(worker, "killed") {
            let _ = self.to_us.send(exit);
        }
    }

    fn reply(&mut self, worker: WorkerId, reply: Reply<&[u8]>) -> Result<(), TransportError> {
        let Some((to_worker, _)) = self.live.get(&worker) else { return Ok(()) };
        let owned = |job: Assignment<&[u8]>| Assignment {
            lease: job.lease,
            payload: Ok(job.payload.to_vec()),
        };
        let _ = to_worker.send(match reply {
            Reply::Stop => Reply::Stop,
            Reply::Jobs(jobs) => Reply::Jobs(jobs.into_iter().map(owned).collect()),
        });
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>) -> Result<Vec<Input>, TransportError> {
        let first = match timeout {
            None => self.heard.recv().ok(),
            Some(timeout) => self.heard.recv_timeout(timeout).ok(),
        };
        let mut inputs = Vec::new();
        let mut next = first;
        while let Some(input) = next {
            match input {
                // A thread that was killed reports its end as well, but the exit was told already.
                Input::Exited { worker, loss, running: None } => {
                    inputs.extend(self.exit(worker, &loss.how))
                }
                input => inputs.push(input),
            }
            next = self.heard.try_recv().ok();
        }
        Ok(inputs)
    }
}

struct ThreadLink {
    worker: WorkerId,
    replies: Receiver<WorkerReply>,
    to_us: Sender<Input>,
    begun: Arc<AtomicU64>,
    dies: fn(LeaseId) -> bool,
}

fn lost(how: &str) -> Loss {
    Loss { how: how.into(), cause: Cause::Job }
}

fn broken() -> TransportError {
    TransportError { doing: "talking", why: "nobody is there".into() }
}

impl Link for ThreadLink {
    fn send(&mut self, Request { reports, idle }: Request<Bytes>) -> Result<(), TransportError> {
        self.to_us.send(Input::Request { worker: self.worker, idle, reports }).map_err(|_| broken())
    }

    fn receive(&mut self, block: bool) -> Result<Option<WorkerReply>, TransportError> {
        if block {
            return self.replies.recv().map(Some).map_err(|_| broken());
        }
        match self.replies.try_recv() {
            Ok(reply) => Ok(Some(reply)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(broken()),
        }
    }

    fn begin(&mut self, lease: LeaseId) -> Result<(), TransportError> {
        self.begun.store(lease, Ordering::SeqCst);
        if (self.dies)(lease) { Err(broken()) } else { Ok(()) }
    }
}

mod tests {
    use std::error::Error;

    use identity::JobKey;

    use super::*;
    use crate::drive::{Summary, drive};
    use crate::interrupt::Interrupt;
    use crate::ledger::{Done, Ledger, Verdict};
    use crate::options::Options;
    use crate::task::Task;

    struct Reverse;

    impl Executor for Reverse {
        fn run(&mut self, payload: &[u8]) -> Vec<u8> {
            if payload == b"panic" {
                std::panic::resume_unwind(Box::new("no such punch"));
            }
            payload.iter().rev().copied().collect()
        }
    }

    #[derive(Default)]
    struct KeptResults(BTreeMap<JobKey, Done>);

    impl Ledger for KeptResults {
        fn commit(&mut self, results: Vec<Done>) -> Result<(), Box<dyn Error + Send + Sync>> {
            for done in results {
                assert!(self.0.insert(done.key, done).is_none(), "committed twice");
            }
            Ok(())
        }
    }

    fn tasks(count: u32) -> Vec<Task> {
        let task = |number: u32| {
            let mut key = [0; 32];
            key[..4].copy_from_slice(&number.to_be_bytes());
            Task {
                key: JobKey(key),
                payload: number.to_be_bytes().into(),
                group: u64::from(number % 5),
                rank: 0,
                cost: 0.001,
                memory: 1,
            }
        };
        (0..count).map(task).collect()
    }

    fn run(
        tasks: &[Task],
        workers: usize,
        attempts: u32,
        dies: fn(LeaseId) -> bool,
    ) -> (Summary, KeptResults) {
        let options = Options {
            workers,
            attempts,
            ..Options::new(vec!["unused".into()], "unused".into(), 1 << 30)
        };
        let mut kept = KeptResults::default();
        let mut threads = Threads::new(|| Reverse, dies);
        let summary = drive(
            &tasks.to_vec(),
            &mut kept,
            &options,
            &mut threads,
            &Interrupt::new().unwrap(),
            &mut |_| {},
        )
        .unwrap();
        (summary, kept)
    }

    #[test]
    fn results_are_the_same_for_any_number_of_workers_and_any_deaths() {
        let tasks = tasks(100);
        let results = |kept: KeptResults| {
            kept.0.into_iter().map(|(key, done)| (key, done.verdict)).collect::<Vec<_>>()
        };
        let one = results(run(&tasks, 1, 3, |_| false).1);
        let expected = tasks.iter().map(|task| {
            (task.key, Verdict::Completed(task.payload.iter().rev().copied().collect()))
        });
        assert_eq!(one, expected.collect::<Vec<_>>());
        assert_eq!(one, results(run(&tasks, 4, 3, |_| false).1));
        let (summary, kept) = run(&tasks, 4, u32::MAX, |lease| lease % 5 == 0);
        assert_eq!(one, results(kept));
        assert!(
            summary.workers_lost >= 20 && summary.failures == summary.workers_lost,
            "{summary:?}"
        );
    }

    #[test]
    fn a_panic_is_a_failed_attempt_with_its_message() {
        let mut tasks = tasks(10);
        tasks[3].payload = b"panic".to_vec();
        let (summary, kept) = run(&tasks, 2, 3, |_| false);
        assert_eq!(
            (summary.done, summary.quarantined, summary.failures, summary.workers_lost),
            (9, 1, 3, 0)
        );
        assert_eq!(
            kept.0[&tasks[3].key].verdict,
            Verdict::Quarantined { reason: "panicked: no such punch".into() }
        );
    }
}
