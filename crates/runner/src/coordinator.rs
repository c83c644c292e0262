//! The coordinator's decisions are a pure function of its knowledge, its inputs and the time.
//!
//! It has no sockets, no clock, no processes and no database, so every fault can be played to it in
//! a test. [`Coordinator::step`] takes one [`Input`] and returns the [`Action`]s that the driver
//! must carry out, in order. The files build on each other: messages, state, attempt, dealing,
//! step. They know leases, the queue and the protocol, and no transport.
//!
//! - A job waits, is leased, is being saved, or is done. Done is final.
//! - A reply to a worker is an acknowledgement: it is sent only when everything that the worker
//!   reported is durable.
//! - Commits clock themselves. While one is being written, further results gather and form the
//!   next; they gather a little longer while their workers have other work. So a result for which a
//!   worker waits never waits for a timer, and one commit serves many jobs.
//! - A worker holds a little work ahead ([`dealing`]), according to the prediction corrected by the
//!   real times of the jobs, so that neither transport nor disk stalls short jobs. A job longer
//!   than that is never held behind another.
//! - When a worker dies, the attempt is charged to the job that was running if the job is to blame.
//!   The others that it held go back uncharged.
//! - What is no fault of a job leaves no record of it. A job whose worker lacked memory is tried
//!   again with all memory for itself. If that is not enough, or the prediction is beyond the
//!   limit, it is postponed: left for another run. So is a job that loses its workers to other
//!   circumstances as often as it may be tried.
//! - A run that must end in time ([`time`]) begins no job that does not fit into what is left of
//!   it, and gives up at last what is in flight.

mod attempt;
mod dealing;
#[cfg(any(test, debug_assertions))]
mod invariants;
mod messages;
mod state;
mod step;
#[cfg(test)]
mod tests;
mod time;

pub(crate) use messages::{Action, Hopeless, Input};
pub use state::EarlyEnd;
pub(crate) use state::{Coordinator, Postponement, Tally};
