//! The coordinator's decisions: a pure function of what it knows, what it hears and the time.
//!
//! It has no sockets, no clock, no processes and no database, so every fault can be played to it in
//! a test. [`Coordinator::step`] takes one [`Input`] and returns the [`Action`]s that the driver
//! must carry out, in order.
//!
//! - A job waits, is leased, is being saved, or is done; done is final.
//! - A reply to a worker is an acknowledgement: it is sent only when everything that the worker
//!   reported is durable.
//! - Commits clock themselves. While one is being written, further results gather and form the
//!   next; so a lone result never waits for a timer, and under load one commit serves many jobs.
//! - A worker holds a little work ahead ([`dealing`]), by the prediction corrected by what jobs
//!   really took, so that neither transport nor disk stalls short jobs; a job longer than that is
//!   never held behind another.
//! - When a worker dies, the attempt is charged to the job that was running. Others that it held go
//!   back uncharged.

mod dealing;
#[cfg(any(test, debug_assertions))]
mod invariants;
mod messages;
mod state;
mod step;
#[cfg(test)]
mod tests;

pub(crate) use messages::{Action, Input};
pub(crate) use state::{Coordinator, Tally};
