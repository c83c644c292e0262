//! This file holds the worker's end of a channel.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::sync::Arc;
use std::time::Duration;

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;

use super::arguments::{WorkerArguments, WorkerError};
use super::channel::{
    ChannelNames, DOWN, EncodedMessage, INITIAL, JOBS, PortMemory, Shm, TALK, UP, backpressure,
    pack, service,
};
use super::pulse::Pulse;
use crate::error::TransportError;
use crate::lease::LeaseId;
use crate::protocol::{Assignment, AttemptOutcome, Body, Reply, Report, Request, decode};
use crate::root::free_shared_memory;
use crate::signals::leave_ends_to_the_coordinator;
use crate::spill;
use crate::supervise::{
    die_with, is_parent, keep_name, limit_address_space, volunteer_for_want_of_memory,
};
use crate::transport::{Bytes, Link};
use crate::worker::{Executor, report_panics, serve};

type Awaited = PendingResponse<Shm, [u8], (), [u8], ()>;

/// The interval at which a waiting worker checks that its parent still lives, in case the signal of
/// its death was missed.
const DOUBT: Duration = Duration::from_secs(30);

/// Runs jobs for the coordinator that started this process until it is told to stop. `fresh` makes
/// the executor, once at the start and again after a panic.
///
/// From here on the process dies when the coordinator does, its address space is limited, and
/// panics of jobs are reported instead of printed.
///
/// # Errors
/// [`WorkerError::Setup`] if the process cannot be set up, [`WorkerError::Transport`] if the
/// coordinator cannot be reached any more.
pub fn work<E: Executor>(
    arguments: &WorkerArguments,
    fresh: impl Fn() -> E,
) -> Result<(), WorkerError> {
    die_with(arguments.coordinator).map_err(WorkerError::Setup)?;
    keep_name();
    volunteer_for_want_of_memory();
    limit_address_space(arguments.address_space).map_err(WorkerError::Setup)?;
    leave_ends_to_the_coordinator().map_err(|error| WorkerError::Setup(error.to_string()))?;
    report_panics();
    let mut wire = Wire::open(arguments)?;
    Ok(serve(&mut wire, fresh)?)
}

/// The worker's end of a channel. The fields are dropped in this order.
#[derive(Debug)]
struct Wire {
    pulse: Pulse,
    response: Option<Awaited>,
    client: Client<Shm, [u8], (), [u8], ()>,
    down: Listener<Shm>,
    up: Arc<Notifier<Shm>>,
    marker: File,
    memory: PortMemory,
    names: ChannelNames,
    coordinator: u32,
    _node: Node<Shm>,
}

impl Wire {
    fn open(arguments: &WorkerArguments) -> Result<Wire, TransportError> {
        let names = ChannelNames::new(&arguments.root, &arguments.prefix);
        let node = names.node()?;
        let jobs = node.service_builder(&service(JOBS)?).request_response::<[u8], [u8]>();
        let jobs = jobs.open().map_err(names.when("cannot open the channel"))?;
        let client = jobs
            .client_builder()
            .initial_max_slice_len(INITIAL)
            .allocation_strategy(AllocationStrategy::PowerOfTwo);
        let client = client
            .set_backpressure_handler(backpressure)
            .create()
            .map_err(names.when("cannot create a client"))?;
        let event = |name| {
            node.service_builder(&service(name)?)
                .event()
                .open()
                .map_err(names.when("cannot open an event"))
        };
        let down = event(DOWN)?
            .listener_builder()
            .create()
            .map_err(names.when("cannot create a listener"))?;
        let up = Arc::new(
            event(UP)?
                .notifier_builder()
                .create()
                .map_err(names.when("cannot create a notifier"))?,
        );
        let marker = File::create(names.marker())
            .map_err(TransportError::when("cannot create the marker"))?;
        names.reserve()?;
        let pulse = Pulse::new(arguments.heartbeat, up.clone())?;
        let (memory, coordinator) = (PortMemory::new(INITIAL), arguments.coordinator);
        Ok(Wire {
            pulse,
            response: None,
            client,
            down,
            up,
            marker,
            memory,
            names,
            coordinator,
            _node: node,
        })
    }

    fn unpack(&self, reply: Reply<Body>) -> Reply<Result<Bytes, String>> {
        match reply {
            Reply::Stop => Reply::Stop,
            Reply::Jobs(jobs) => {
                let load = |Assignment { lease, payload }| Assignment {
                    lease,
                    payload: spill::load(&self.names.body(lease, "payload"), payload),
                };
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
                    AttemptOutcome::Failed(reason) => AttemptOutcome::Failed(reason.clone()),
                    AttemptOutcome::Undelivered(reason) => {
                        AttemptOutcome::Undelivered(reason.clone())
                    }
                    AttemptOutcome::Completed(bytes) => {
                        pack(bytes, largest, || names.body(report.lease, "result"))
                            .map_or_else(AttemptOutcome::Undelivered, AttemptOutcome::Completed)
                    }
                };
                Report { lease: report.lease, seconds: report.seconds, outcome }
            };
            Ok(Request { idle: request.idle, reports: request.reports.iter().map(pack).collect() })
        };
        let EncodedMessage { bytes, grows } = self.memory.encode(free_shared_memory, packed)?;
        let doing = "cannot send a request";
        let loan =
            self.client.loan_slice_uninit(bytes.len()).map_err(TransportError::when(doing))?;
        if grows {
            names.reserve()?;
        }
        let response = loan.write_from_slice(&bytes).send().map_err(TransportError::when(doing))?;
        // iceoryx2 does not report a delivery to nobody as an error.
        if response.number_of_server_connections() == 0 {
            return Err(TransportError { doing, why: "nobody receives it".into() });
        }
        self.response = Some(response);
        self.up.notify_with_custom_event_id(TALK).map_err(TransportError::when(doing))?;
        Ok(())
    }

    fn receive(
        &mut self,
        block: bool,
    ) -> Result<Option<Reply<Result<Bytes, String>>>, TransportError> {
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
        self.marker
            .write_all_at(&lease.to_le_bytes(), 0)
            .map_err(TransportError::when("cannot mark the job as begun"))
    }
}
