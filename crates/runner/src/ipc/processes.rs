//! The coordinator's end holds the worker processes and a channel to each.

use std::collections::BTreeMap;
use std::os::fd::BorrowedFd;
use std::sync::mpsc::channel;
use std::time::Duration;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::arguments::WorkerArguments;
use super::channel::{
    ChannelNames, DOWN, EncodedMessage, HEARTBEAT, INITIAL, JOBS, PortMemory, Shm, UP,
    backpressure, pack, service,
};
use crate::coordinator::Input;
use crate::error::{RunError, TransportError};
use crate::interrupt::Interrupt;
use crate::lease::{LeaseId, WorkerId};
use crate::limits::{Room, shared_memory_for};
use crate::memory::Starvation;
use crate::options::Options;
use crate::protocol::{Assignment, AttemptOutcome, Body, Reply, Report, Request, decode};
use crate::root::{Root, free_shared_memory};
use crate::spill;
use crate::supervise::Process;
use crate::transport::Transport;

/// The time that the making of a channel may take. iceoryx2 waits without end for a segment whose
/// maker could not give it its size.
const MAKING: Duration = Duration::from_secs(20);

type Received = ActiveRequest<Shm, [u8], (), [u8], ()>;

/// The coordinator's end of a channel, and the worker process. The fields are dropped in this
/// order.
#[derive(Debug)]
struct Channel {
    process: Process,
    request: Option<Received>,
    server: Server<Shm, [u8], (), [u8], ()>,
    up: Listener<Shm>,
    down: Notifier<Shm>,
    memory: PortMemory,
    names: ChannelNames,
    _node: Node<Shm>,
}

/// The services of a new channel.
struct Services {
    node: Node<Shm>,
    server: Server<Shm, [u8], (), [u8], ()>,
    up: Listener<Shm>,
    down: Notifier<Shm>,
}

impl Services {
    fn create(names: &ChannelNames) -> Result<Services, TransportError> {
        if let Some(Room { reason, .. }) = shared_memory_for(1) {
            return Err(TransportError { doing: "cannot make a channel", why: reason });
        }
        let node = names.node()?;
        let jobs = node.service_builder(&service(JOBS)?).request_response::<[u8], [u8]>();
        let jobs =
            jobs.enable_safe_overflow_for_requests(false).enable_safe_overflow_for_responses(false);
        let jobs = jobs
            .max_servers(1)
            .max_clients(1)
            .max_nodes(2)
            .max_active_requests_per_client(1)
            .max_loaned_requests(1);
        let jobs = jobs.max_response_buffer_size(1).max_borrowed_responses_per_pending_response(1);
        let jobs = jobs.create().map_err(names.when("cannot create a channel"))?;
        let server = jobs
            .server_builder()
            .initial_max_slice_len(INITIAL)
            .allocation_strategy(AllocationStrategy::PowerOfTwo);
        let server =
            server.max_loaned_responses_per_request(1).set_backpressure_handler(backpressure);
        let server = server.create().map_err(names.when("cannot create a server"))?;
        let event = |name| {
            let event = node
                .service_builder(&service(name)?)
                .event()
                .max_listeners(1)
                .max_notifiers(1)
                .max_nodes(2);
            event
                .event_id_max_value(HEARTBEAT.as_value())
                .create()
                .map_err(names.when("cannot create an event"))
        };
        let up = event(UP)?
            .listener_builder()
            .create()
            .map_err(names.when("cannot create a listener"))?;
        let down = event(DOWN)?
            .notifier_builder()
            .create()
            .map_err(names.when("cannot create a notifier"))?;
        names.reserve()?;
        Ok(Services { node, server, up, down })
    }

    /// Creates the services of a channel on a thread of its own, which is left behind if that takes
    /// too long.
    fn create_in_time(names: &ChannelNames) -> Result<Services, TransportError> {
        let doing = "cannot make a channel";
        let (made, services) = channel();
        let own_names = names.clone();
        let make = move || drop(made.send(Services::create(&own_names)));
        std::thread::Builder::new().spawn(make).map_err(TransportError::when(doing))?;
        services.recv_timeout(MAKING).unwrap_or_else(|_| {
            Err(names.when(doing)(format!("it is not made after {} s", MAKING.as_secs())))
        })
    }
}

/// The number of descriptors of a channel that are waited for.
const DESCRIPTORS: usize = 3;

/// The descriptors of a channel that are ready.
struct ChannelReady {
    /// The worker sent an event.
    talked: bool,
    /// The process is gone.
    ended: bool,
    /// The process said something on standard error.
    spoke: bool,
}

/// All workers of a run.
#[derive(Debug)]
pub(crate) struct Processes {
    channels: BTreeMap<WorkerId, Channel>,
    options: Options,
    interrupt: Interrupt,
    starvation: Starvation,
    /// The directory is the last field, so that it is removed after everything that lives in it.
    root: Root,
}

impl Processes {
    pub(crate) fn new(options: &Options, interrupt: Interrupt) -> Result<Processes, RunError> {
        Ok(Processes {
            channels: BTreeMap::new(),
            options: options.clone(),
            interrupt,
            starvation: Starvation::watch(),
            root: Root::new(&options.bodies)?,
        })
    }

    fn open(&mut self, worker: WorkerId) -> Result<Channel, String> {
        self.root.restore().map_err(|error| error.to_string())?;
        let (root, prefix) = (self.root.path().to_owned(), self.root.prefix(worker));
        let names = ChannelNames::new(&root, &prefix);
        let Services { node, server, up, down } =
            Services::create_in_time(&names).map_err(|error| error.to_string())?;
        let arguments = WorkerArguments {
            prefix,
            coordinator: std::process::id(),
            address_space: self
                .options
                .memory_limit
                .saturating_add(self.options.address_space_margin),
            heartbeat: self.options.heartbeat,
            root,
        };
        let process = Process::start(&self.options.worker_command, &arguments.to_string())?;
        Ok(Channel {
            process,
            request: None,
            server,
            up,
            down,
            memory: PortMemory::new(INITIAL),
            names,
            _node: node,
        })
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
                    let payload = pack(job.payload, largest, || names.body(job.lease, "payload"))?;
                    Ok(Assignment { lease: job.lease, payload })
                };
                let jobs = jobs.iter().map(pack).collect::<Result<_, String>>();
                Ok(Reply::Jobs(jobs.map_err(TransportError::when("cannot hand out a job"))?))
            }
        };
        let EncodedMessage { bytes, grows } = channel.memory.encode(free_shared_memory, packed)?;
        let loan = request.loan_slice_uninit(bytes.len()).map_err(|error| error.to_string());
        let sent = loan.and_then(|loan| {
            if grows {
                names.reserve().map_err(|error| error.to_string())?;
            }
            loan.write_from_slice(&bytes).send().map_err(|error| error.to_string())
        });
        let sent = sent.and_then(|()| channel.down.notify().map_err(|error| error.to_string()));
        if sent.is_err() {
            // The worker does not listen, so it is dead or as good as dead.
            channel.process.kill();
        }
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>) -> Result<Vec<Input>, TransportError> {
        let ready: Vec<ChannelReady> = {
            let mut fds = vec![PollFd::from_borrowed_fd(self.interrupt.wake(), PollFlags::IN)];
            for channel in self.channels.values() {
                fds.push(PollFd::from_borrowed_fd(descriptor(&channel.up), PollFlags::IN));
                let end = channel.process.end();
                fds.push(PollFd::from_borrowed_fd(end, PollFlags::IN));
                let words = channel.process.words().unwrap_or(end);
                fds.push(PollFd::from_borrowed_fd(words, PollFlags::IN));
            }
            let timeout = timeout.and_then(|timeout| Timespec::try_from(timeout).ok());
            match poll(&mut fds, timeout.as_ref()) {
                Ok(_) => fds[1..]
                    .chunks(DESCRIPTORS)
                    .map(|of_channel| {
                        let [talked, ended, spoke] =
                            std::array::from_fn(|place| !of_channel[place].revents().is_empty());
                        ChannelReady { talked, ended, spoke }
                    })
                    .collect(),
                Err(Errno::INTR) => Vec::new(),
                Err(error) => {
                    return Err(TransportError {
                        doing: "cannot wait for workers",
                        why: error.to_string(),
                    });
                }
            }
        };
        let mut inputs = Vec::new();
        let mut gone = Vec::new();
        for ((&worker, channel), ready) in self.channels.iter_mut().zip(ready) {
            let ChannelReady { talked, ended, spoke } = ready;
            if spoke {
                channel.process.pass_words_on();
            }
            if talked || ended {
                channel.hear(worker, &mut inputs);
            }
            let is_starved = || self.starvation.is_felt();
            if let Some(loss) = if ended { channel.process.ended(is_starved) } else { None } {
                let running = channel.begun();
                inputs.push(Input::Exited { worker, loss, running });
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

/// Returns the descriptor on which a listener is woken.
#[allow(unsafe_code)]
fn descriptor(listener: &Listener<Shm>) -> BorrowedFd<'_> {
    // SAFETY: the descriptor is open as long as the listener lives, and the result borrows the
    // listener. iceoryx2 has no safe way to hand it to poll(2), and its own WaitSet cannot wait for
    // a changing set of processes as well.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}

impl Channel {
    /// Takes in everything that the worker said.
    fn hear(&mut self, worker: WorkerId, inputs: &mut Vec<Input>) {
        let nonsense = |reason| Input::Nonsense { worker, reason };
        let mut beat = false;
        // Every event must be consumed. Otherwise poll returns at once for ever.
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
                Err(error) => {
                    return inputs
                        .push(nonsense(format!("its requests cannot be received: {error}")));
                }
            }
        }
    }

    fn read(&self, worker: WorkerId, message: &[u8]) -> Result<Input, String> {
        let Request { reports, idle } =
            decode::<Request<Body>>(message).map_err(|error| error.to_string())?;
        let unpack = |Report { lease, seconds, outcome }| {
            let outcome = match outcome {
                AttemptOutcome::Completed(body) => {
                    spill::load(&self.names.body(lease, "result"), body)
                        .map_or_else(AttemptOutcome::Undelivered, AttemptOutcome::Completed)
                }
                AttemptOutcome::Failed(reason) => AttemptOutcome::Failed(reason),
                AttemptOutcome::Undelivered(reason) => AttemptOutcome::Undelivered(reason),
            };
            Report { lease, seconds, outcome }
        };
        Ok(Input::Request { worker, idle, reports: reports.into_iter().map(unpack).collect() })
    }

    /// Returns the lease that the worker began last.
    fn begun(&self) -> Option<LeaseId> {
        let bytes = std::fs::read(self.names.marker()).ok()?;
        Some(LeaseId::from_le_bytes(bytes.try_into().ok()?))
    }
}
