//! Shared memory: the only place that uses iceoryx2.
//!
//! Every worker has a channel of its own: a request–response service in which the coordinator is the server and the
//! worker the one client, an event service for each direction, and a name prefix. A worker killed in the middle of an
//! operation can leave a service in a state that iceoryx2 never repairs, and its slots taken; with a channel each,
//! that dies with the worker: the coordinator drops its end and removes the files by their prefix.
//!
//! The coordinator waits in one poll(2) for all channels, all processes and the interrupt; a worker waits for its event.

use crate::coordinator::Input;
use crate::interrupt::Interrupt;
use crate::lease::{LeaseId, WorkerId};
use crate::protocol::{Assignment, Body, Outcome, Reply, Report, Request, decode, encode};
use crate::root::{Root, SHARED_MEMORY, free_shared_memory};
use crate::supervise::{Process, die_with, is_parent, limit_address_space};
use crate::transport::{Bytes, Link, Transport, TransportError};
use crate::worker::{Work, report_panics, serve};
use crate::{Options, RunError, spill};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::collections::BTreeMap;
use std::fs::File;
use std::os::fd::BorrowedFd;
use std::os::unix::fs::FileExt;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

/// The thread-safe variant, so that a worker's heart can beat on a thread of its own.
type Shm = ipc_threadsafe::Service;
type Received = ActiveRequest<Shm, [u8], (), [u8], ()>;
type Awaited = PendingResponse<Shm, [u8], (), [u8], ()>;

const JOBS: &str = "jobs";
/// Worker → coordinator.
const UP: &str = "up";
/// Coordinator → worker.
const DOWN: &str = "down";

const TALK: EventId = EventId::new(0);
const HEARTBEAT: EventId = EventId::new(1);

/// Bytes of a message for which shared memory is set aside from the start.
const INITIAL: usize = 16 << 10;
/// Bodies beyond this travel as files.
const LARGEST_INLINE: usize = 256 << 10;
/// Shared memory that one channel takes from the start, with room to spare (measured: 0.1 MiB).
const CHANNEL: u64 = 1 << 20;
/// What must stay free in shared memory after growing, so that others do not meet SIGBUS either.
const RESERVE: u64 = 16 << 20;
/// How often a waiting worker looks whether it still has a parent, should the signal of its death have been missed.
const DOUBT: Duration = Duration::from_secs(30);

/// What the coordinator tells a worker process on its command line: one argument of the form
/// `root,prefix,coordinator,address-space,heartbeat`.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkerArguments {
    prefix: String,
    coordinator: u32,
    address_space: u64,
    heartbeat: Duration,
    root: PathBuf,
}

/// Why a worker ended without being told to.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The command line is not one that the runner made.
    #[error("`{0}` does not describe a worker; workers are started by a run, not by hand")]
    Arguments(String),
    /// The process could not be set up.
    #[error("the worker could not set itself up: {0}")]
    Setup(String),
    /// The coordinator cannot be reached any more.
    #[error("the worker lost its coordinator")]
    Transport(#[from] TransportError),
}

impl WorkerArguments {
    /// Reads the argument that the runner appended to the worker command.
    pub fn parse(argument: &str) -> Result<WorkerArguments, WorkerError> {
        let read = || {
            let mut parts = argument.splitn(5, ',');
            Some(WorkerArguments {
                prefix: parts.next().filter(|prefix| !prefix.is_empty())?.into(),
                coordinator: parts.next()?.parse().ok()?,
                address_space: parts.next()?.parse().ok()?,
                heartbeat: Duration::from_nanos(parts.next()?.parse().ok()?),
                root: parts.next().filter(|root| !root.is_empty())?.into(),
            })
        };
        read().ok_or_else(|| WorkerError::Arguments(argument.into()))
    }
}

impl std::fmt::Display for WorkerArguments {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let WorkerArguments { prefix, coordinator, address_space, heartbeat, root } = self;
        write!(f, "{prefix},{coordinator},{address_space},{},{}", heartbeat.as_nanos(), root.display())
    }
}

/// One end's view of a channel's names.
#[derive(Clone, Debug)]
struct Names {
    root: PathBuf,
    prefix: String,
}

impl Names {
    fn node(&self) -> Result<Node<Shm>, TransportError> {
        let what = "cannot set up shared memory";
        let mut config = Config::default();
        let root = Path::new(self.root.as_os_str().as_encoded_bytes()).map_err(TransportError::when(what))?;
        config.global.set_root_path(&root);
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(TransportError::when(what))?;
        config.global.creation_timeout = Duration::from_secs(10);
        // What a dead worker leaves is removed by its prefix, whatever state it is in.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        // Its complaints would mix with ours; every error comes back as a value.
        set_log_level(LogLevel::Fatal);
        // Signals are the caller's business.
        NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled).create().map_err(TransportError::when(what))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.root.join(format!("{}{name}", self.prefix))
    }

    fn body(&self, lease: LeaseId, direction: &str) -> PathBuf {
        self.file(&format!("{lease}-{direction}"))
    }

    /// Where the worker notes which lease it began last.
    fn marker(&self) -> PathBuf {
        self.file("begun")
    }
}

fn service(name: &str) -> Result<ServiceName, TransportError> {
    ServiceName::new(name).map_err(TransportError::when("cannot name a service"))
}

/// With one open request per client the buffers are never full; should they be, give up rather than wait for the dead.
fn backpressure(info: &BackpressureInfo) -> BackpressureAction {
    if info.elapsed_time < Duration::from_secs(1) { BackpressureAction::Retry } else { BackpressureAction::DiscardDataAndFail }
}

/// Puts a body into the message, or beside it.
fn pack(bytes: &[u8], largest: usize, file: impl FnOnce() -> PathBuf) -> Result<Body, String> {
    if bytes.len() <= largest { Ok(Body::Inline(bytes.to_vec())) } else { spill::store(&file(), bytes) }
}

/// How large messages through a port have been, and so how much shared memory it has.
#[derive(Debug)]
struct Grown(usize);

impl Grown {
    /// Whether a message of this size can be written without running out of shared memory. Segments grow by powers of
    /// two, old ones stay, and each holds a handful of messages.
    fn admits(&mut self, length: usize, free: impl FnOnce() -> Option<u64>) -> bool {
        let needed = 8 * (length as u64).next_power_of_two() + RESERVE;
        if length > self.0 {
            if free().is_some_and(|free| free < needed) {
                return false;
            }
            self.0 = length.next_power_of_two();
        }
        true
    }

    /// Encodes a message with bodies inside as far as they are small, or none inside if shared memory is short.
    fn encode<M: bincode::Encode>(
        &mut self,
        free: impl Fn() -> Option<u64>,
        build: impl Fn(usize) -> Result<M, TransportError>,
    ) -> Result<Vec<u8>, TransportError> {
        let doing = "cannot encode a message";
        let message = encode(&build(LARGEST_INLINE)?).map_err(TransportError::when(doing))?;
        if self.admits(message.len(), &free) {
            return Ok(message);
        }
        let message = encode(&build(0)?).map_err(TransportError::when(doing))?;
        if self.admits(message.len(), &free) {
            return Ok(message);
        }
        Err(TransportError { doing: "cannot send a message", why: format!("{SHARED_MEMORY} is full") })
    }
}

/// The coordinator's end of a channel, and the worker process. Fields are dropped in this order.
#[derive(Debug)]
struct Channel {
    process: Process,
    request: Option<Received>,
    server: Server<Shm, [u8], (), [u8], ()>,
    up: Listener<Shm>,
    down: Notifier<Shm>,
    grown: Grown,
    names: Names,
    _node: Node<Shm>,
}

/// All workers of a run.
#[derive(Debug)]
pub(crate) struct Processes {
    channels: BTreeMap<WorkerId, Channel>,
    options: Options,
    interrupt: Interrupt,
    /// Last, so that it is removed after everything that lives in it.
    root: Root,
}

impl Processes {
    pub(crate) fn new(options: &Options, interrupt: Interrupt) -> Result<Processes, RunError> {
        let needed = options.workers as u64 * CHANNEL + RESERVE;
        if let Some(free) = free_shared_memory().filter(|&free| free < needed) {
            return Err(RunError::SharedMemory { free, needed, workers: options.workers });
        }
        Ok(Processes { channels: BTreeMap::new(), options: options.clone(), interrupt, root: Root::new()? })
    }

    fn open(&self, worker: WorkerId) -> Result<Channel, String> {
        let names = Names { root: self.root.path().into(), prefix: self.root.prefix(worker) };
        let create = || {
            if free_shared_memory().is_some_and(|free| free < CHANNEL + RESERVE) {
                return Err(TransportError { doing: "cannot make a channel", why: format!("{SHARED_MEMORY} is nearly full") });
            }
            let node = names.node()?;
            let jobs = node.service_builder(&service(JOBS)?).request_response::<[u8], [u8]>();
            let jobs = jobs.enable_safe_overflow_for_requests(false).enable_safe_overflow_for_responses(false);
            let jobs = jobs.max_servers(1).max_clients(1).max_nodes(2).max_active_requests_per_client(1).max_loaned_requests(1);
            let jobs = jobs.max_response_buffer_size(1).max_borrowed_responses_per_pending_response(1);
            let jobs = jobs.create().map_err(TransportError::when("cannot create a channel"))?;
            let server = jobs.server_builder().initial_max_slice_len(INITIAL).allocation_strategy(AllocationStrategy::PowerOfTwo);
            let server = server.max_loaned_responses_per_request(1).set_backpressure_handler(backpressure);
            let server = server.create().map_err(TransportError::when("cannot create a server"))?;
            let event = |name| {
                let event = node.service_builder(&service(name)?).event().max_listeners(1).max_notifiers(1).max_nodes(2);
                event.event_id_max_value(HEARTBEAT.as_value()).create().map_err(TransportError::when("cannot create an event"))
            };
            let up = event(UP)?.listener_builder().create().map_err(TransportError::when("cannot create a listener"))?;
            let down = event(DOWN)?.notifier_builder().create().map_err(TransportError::when("cannot create a notifier"))?;
            Ok((node, server, up, down))
        };
        let (node, server, up, down) = create().map_err(|error: TransportError| error.to_string())?;
        let arguments = WorkerArguments {
            prefix: names.prefix.clone(),
            coordinator: std::process::id(),
            address_space: self.options.memory_limit.saturating_add(self.options.address_space_margin),
            heartbeat: self.options.heartbeat,
            root: names.root.clone(),
        };
        let process = Process::start(&self.options.worker_command, &arguments.to_string())?;
        Ok(Channel { process, request: None, server, up, down, grown: Grown(INITIAL), names, _node: node })
    }
}

impl Transport for Processes {
    fn start(&mut self, worker: WorkerId) -> Result<u32, String> {
        match self.open(worker) {
            Ok(channel) => {
                let pid = channel.process.id();
                self.channels.insert(worker, channel);
                Ok(pid)
            }
            Err(reason) => {
                self.root.remove_channel(worker);
                Err(reason)
            }
        }
    }

    fn kill(&mut self, worker: WorkerId) {
        if let Some(channel) = self.channels.get_mut(&worker) {
            channel.process.kill();
        }
    }

    fn reply(&mut self, worker: WorkerId, reply: Reply<&[u8]>) -> Result<(), TransportError> {
        let Some(channel) = self.channels.get_mut(&worker) else { return Ok(()) };
        let Some(request) = channel.request.take() else { return Ok(()) };
        let names = &channel.names;
        let packed = |largest| match &reply {
            Reply::Stop => Ok(Reply::Stop),
            Reply::Jobs(jobs) => {
                let pack = |job: &Assignment<&[u8]>| {
                    let payload = pack(job.payload, largest, || names.body(job.lease, "payload"))
                        .map_err(TransportError::when("cannot hand out a job"))?;
                    Ok(Assignment { lease: job.lease, payload })
                };
                Ok(Reply::Jobs(jobs.iter().map(pack).collect::<Result<_, _>>()?))
            }
        };
        let message = channel.grown.encode(free_shared_memory, packed)?;
        let sent = request.loan_slice_uninit(message.len()).map_err(|error| error.to_string());
        let sent = sent.and_then(|loan| loan.write_from_slice(&message).send().map_err(|error| error.to_string()));
        let sent = sent.and_then(|()| channel.down.notify().map_err(|error| error.to_string()));
        if sent.is_err() {
            // It does not listen, so it is dead or as good as dead.
            channel.process.kill();
        }
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>) -> Result<Vec<Input>, TransportError> {
        let ready = {
            let mut fds = vec![PollFd::from_borrowed_fd(self.interrupt.wake(), PollFlags::IN)];
            for channel in self.channels.values() {
                fds.push(PollFd::from_borrowed_fd(descriptor(&channel.up), PollFlags::IN));
                fds.push(PollFd::from_borrowed_fd(channel.process.end(), PollFlags::IN));
            }
            let timeout = timeout.and_then(|timeout| Timespec::try_from(timeout).ok());
            match poll(&mut fds, timeout.as_ref()) {
                Ok(_) => fds[1..].chunks(2).map(|pair| (!pair[0].revents().is_empty(), !pair[1].revents().is_empty())).collect(),
                Err(Errno::INTR) => Vec::new(),
                Err(error) => return Err(TransportError { doing: "cannot wait for workers", why: error.to_string() }),
            }
        };
        let mut inputs = Vec::new();
        let mut gone = Vec::new();
        for ((&worker, channel), (talked, ended)) in self.channels.iter_mut().zip(ready) {
            if talked || ended {
                channel.hear(worker, &mut inputs);
            }
            if let Some(how) = if ended { channel.process.ended() } else { None } {
                let running = channel.begun();
                inputs.push(Input::Exited { worker, how, running });
                gone.push(worker);
            }
        }
        for worker in gone {
            self.channels.remove(&worker);
            self.root.remove_channel(worker);
        }
        Ok(inputs)
    }
}

/// The descriptor on which a listener is woken.
#[allow(unsafe_code)]
fn descriptor(listener: &Listener<Shm>) -> BorrowedFd<'_> {
    // SAFETY: the descriptor is open as long as the listener lives, and the result borrows the listener. iceoryx2 has
    // no safe way to hand it to poll(2), and its own WaitSet cannot wait for a changing set of processes as well.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

impl Channel {
    /// Takes in all that the worker said.
    fn hear(&mut self, worker: WorkerId, inputs: &mut Vec<Input>) {
        let nonsense = |reason| Input::Nonsense { worker, reason };
        let mut beat = false;
        // Every event must be consumed, or poll returns at once forever.
        if let Err(error) = self.up.try_wait(|event| beat |= event.id == HEARTBEAT) {
            inputs.push(nonsense(format!("its events cannot be read: {error:?}")));
        }
        if beat {
            inputs.push(Input::Heartbeat { worker });
        }
        loop {
            match self.server.receive() {
                Ok(None) => return,
                Ok(Some(request)) => {
                    inputs.push(self.read(worker, request.payload()).unwrap_or_else(nonsense));
                    self.request = Some(request);
                }
                Err(error) => return inputs.push(nonsense(format!("its requests cannot be received: {error}"))),
            }
        }
    }

    fn read(&self, worker: WorkerId, message: &[u8]) -> Result<Input, String> {
        let Request { reports, idle } = decode::<Request<Body>>(message).map_err(|error| error.to_string())?;
        let unpack = |Report { lease, seconds, outcome }| {
            let outcome = match outcome {
                Outcome::Completed(body) => {
                    spill::load(&self.names.body(lease, "result"), body).map_or_else(Outcome::Failed, Outcome::Completed)
                }
                Outcome::Failed(reason) => Outcome::Failed(reason),
            };
            Report { lease, seconds, outcome }
        };
        Ok(Input::Request { worker, idle, reports: reports.into_iter().map(unpack).collect() })
    }

    /// The lease that the worker began last.
    fn begun(&self) -> Option<LeaseId> {
        let bytes = std::fs::read(self.names.marker()).ok()?;
        Some(LeaseId::from_le_bytes(bytes.try_into().ok()?))
    }
}

/// Runs jobs for the coordinator that started this process, until told to stop. `fresh` makes the work, once at the
/// start and again after a panic.
///
/// From here on the process dies when the coordinator does, its address space is limited, and panics of jobs are
/// reported instead of printed.
pub fn work<W: Work>(arguments: &WorkerArguments, fresh: impl Fn() -> W) -> Result<(), WorkerError> {
    die_with(arguments.coordinator).map_err(WorkerError::Setup)?;
    limit_address_space(arguments.address_space).map_err(WorkerError::Setup)?;
    report_panics();
    let mut wire = Wire::open(arguments)?;
    Ok(serve(&mut wire, fresh)?)
}

/// The worker's end of a channel. Fields are dropped in this order.
#[derive(Debug)]
struct Wire {
    pulse: Pulse,
    response: Option<Awaited>,
    client: Client<Shm, [u8], (), [u8], ()>,
    down: Listener<Shm>,
    up: Arc<Notifier<Shm>>,
    marker: File,
    grown: Grown,
    names: Names,
    coordinator: u32,
    _node: Node<Shm>,
}

impl Wire {
    fn open(arguments: &WorkerArguments) -> Result<Wire, TransportError> {
        let names = Names { root: arguments.root.clone(), prefix: arguments.prefix.clone() };
        let node = names.node()?;
        let jobs = node.service_builder(&service(JOBS)?).request_response::<[u8], [u8]>();
        let jobs = jobs.open().map_err(TransportError::when("cannot open the channel"))?;
        let client = jobs.client_builder().initial_max_slice_len(INITIAL).allocation_strategy(AllocationStrategy::PowerOfTwo);
        let client = client.set_backpressure_handler(backpressure).create().map_err(TransportError::when("cannot create a client"))?;
        let event = |name| node.service_builder(&service(name)?).event().open().map_err(TransportError::when("cannot open an event"));
        let down = event(DOWN)?.listener_builder().create().map_err(TransportError::when("cannot create a listener"))?;
        let up = Arc::new(event(UP)?.notifier_builder().create().map_err(TransportError::when("cannot create a notifier"))?);
        let marker = File::create(names.marker()).map_err(TransportError::when("cannot create the marker"))?;
        let pulse = Pulse::new(arguments.heartbeat, up.clone())?;
        let (grown, coordinator) = (Grown(INITIAL), arguments.coordinator);
        Ok(Wire { pulse, response: None, client, down, up, marker, grown, names, coordinator, _node: node })
    }

    fn unpack(&self, reply: Reply<Body>) -> Reply<Result<Bytes, String>> {
        match reply {
            Reply::Stop => Reply::Stop,
            Reply::Jobs(jobs) => {
                let load =
                    |Assignment { lease, payload }| Assignment { lease, payload: spill::load(&self.names.body(lease, "payload"), payload) };
                Reply::Jobs(jobs.into_iter().map(load).collect())
            }
        }
    }
}

impl Link for Wire {
    fn send(&mut self, request: Request<Bytes>) -> Result<(), TransportError> {
        let names = &self.names;
        let packed = |largest| {
            let pack = |report: &Report<Bytes>| {
                let outcome = match &report.outcome {
                    Outcome::Failed(reason) => Outcome::Failed(reason.clone()),
                    // A result that cannot be handed over is a failed attempt, not a broken worker.
                    Outcome::Completed(bytes) => {
                        pack(bytes, largest, || names.body(report.lease, "result")).map_or_else(Outcome::Failed, Outcome::Completed)
                    }
                };
                Report { lease: report.lease, seconds: report.seconds, outcome }
            };
            Ok(Request { idle: request.idle, reports: request.reports.iter().map(pack).collect() })
        };
        let message = self.grown.encode(free_shared_memory, packed)?;
        let doing = "cannot send a request";
        let loan = self.client.loan_slice_uninit(message.len()).map_err(TransportError::when(doing))?;
        let response = loan.write_from_slice(&message).send().map_err(TransportError::when(doing))?;
        // Delivery to nobody is no error to iceoryx2.
        if response.number_of_server_connections() == 0 {
            return Err(TransportError { doing, why: "nobody receives it".into() });
        }
        self.response = Some(response);
        self.up.notify_with_custom_event_id(TALK).map_err(TransportError::when(doing))?;
        Ok(())
    }

    fn receive(&mut self, block: bool) -> Result<Option<Reply<Result<Bytes, String>>>, TransportError> {
        let doing = "cannot receive a reply";
        let Some(response) = &self.response else {
            return Err(TransportError { doing, why: "nothing was asked".into() });
        };
        loop {
            if let Some(message) = response.receive().map_err(TransportError::when(doing))? {
                let reply = decode(message.payload()).map_err(TransportError::when(doing))?;
                drop(message);
                self.response = None;
                self.pulse.beat(true);
                return Ok(Some(self.unpack(reply)));
            }
            if !block {
                return Ok(None);
            }
            if !is_parent(self.coordinator) {
                return Err(TransportError { doing, why: "the coordinator is dead".into() });
            }
            self.pulse.beat(false);
            self.down.timed_wait(|_| {}, DOUBT).map_err(TransportError::when(doing))?;
        }
    }

    fn begin(&mut self, lease: LeaseId) -> Result<(), TransportError> {
        self.marker.write_all_at(&lease.to_le_bytes(), 0).map_err(TransportError::when("cannot mark the job as begun"))
    }
}

/// Signs of life from a thread of its own, while the worker is busy and only then.
#[derive(Debug)]
struct Pulse(Arc<(Mutex<Beat>, Condvar)>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Beat {
    Rest,
    Busy,
    End,
}

impl Pulse {
    fn new(interval: Duration, up: Arc<Notifier<Shm>>) -> Result<Pulse, TransportError> {
        let shared = Arc::new((Mutex::new(Beat::Rest), Condvar::new()));
        let state = shared.clone();
        let beat = move || {
            let (state, changed) = &*state;
            let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
            loop {
                now = match *now {
                    Beat::End => return,
                    Beat::Rest => changed.wait(now).unwrap_or_else(PoisonError::into_inner),
                    Beat::Busy => {
                        // A failure shows as silence, which is what it is.
                        let _ = up.notify_with_custom_event_id(HEARTBEAT);
                        changed.wait_timeout_while(now, interval, |beat| *beat == Beat::Busy).unwrap_or_else(PoisonError::into_inner).0
                    }
                };
            }
        };
        let thread = std::thread::Builder::new().name("heartbeat".into()).stack_size(256 << 10);
        thread.spawn(beat).map_err(TransportError::when("cannot start the heartbeat"))?;
        Ok(Pulse(shared))
    }

    fn set(&self, beat: Beat) {
        let (state, changed) = &*self.0;
        let mut now = state.lock().unwrap_or_else(PoisonError::into_inner);
        if *now != beat {
            *now = beat;
            changed.notify_one();
        }
    }

    fn beat(&self, busy: bool) {
        self.set(if busy { Beat::Busy } else { Beat::Rest });
    }
}

impl Drop for Pulse {
    fn drop(&mut self) {
        self.set(Beat::End);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_read_as_they_were_written() {
        let arguments = WorkerArguments {
            prefix: "tribo0_".into(),
            coordinator: 42,
            address_space: 1 << 33,
            heartbeat: Duration::from_millis(1500),
            root: "/tmp/a, b".into(),
        };
        assert_eq!(WorkerArguments::parse(&arguments.to_string()).unwrap(), arguments);
        for wrong in ["", "p", "p,1,2,3", "p,1,2,3,", ",1,2,3,/r", "p,-1,2,3,/r", "p,1,2,x,/r"] {
            assert!(WorkerArguments::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn when_shared_memory_is_short_bodies_travel_as_files() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("body");
        let bytes = vec![7; 100_000];
        let build = |largest| Ok(pack(&bytes, largest, || path.clone()).unwrap());
        let sent = |grown: &mut Grown, free| decode::<Body>(&grown.encode(|| Some(free), build).unwrap()).unwrap();
        let mut grown = Grown(INITIAL);
        assert!(matches!(sent(&mut grown, RESERVE), Body::File { length: 100_000, .. }));
        assert_eq!(sent(&mut grown, 1 << 30), Body::Inline(bytes.clone()));
        assert_eq!(sent(&mut grown, 0), Body::Inline(bytes.clone()), "the memory that it grew to is there");
        let none = Grown(4).encode(|| Some(0), build).unwrap_err().to_string();
        assert_eq!(none, "cannot send a message: /dev/shm is full");
    }
}
