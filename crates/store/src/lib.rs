//! Durable results: records in sled, fields in content-addressed files.
//!
//! A store is a directory:
//!
//! | path            | what it is                                                                                  |
//! |-----------------|---------------------------------------------------------------------------------------------|
//! | `manifest.json` | format version, least number of records, study names with the digest of their definition     |
//! | `records/`      | the sled database: job key → sealed record (see [`STORED_LIMIT`](identity::STORED_LIMIT))                            |
//! | `blobs/ab/…`    | fields, height maps and study definitions: zstd files named by the BLAKE3 of their content   |
//! | `lock`          | locked by the process that has the store open; says who it is and where it answers readers   |
//!
//! What holds, whatever happens to the process or the machine:
//!
//! - What [`Store::commit`] acknowledged is on the disk: the log is flushed and its file fsync'ed
//!   before it returns.
//! - `manifest.json` never promises more records than the database durably has: its count is raised
//!   after a commit is durable — during a run within half a second of commits, else on closing —
//!   and lowered before a removal. So a kill at any moment raises no false alarm, and a database
//!   file that was truncated or replaced — which sled may open as an empty one — is refused with
//!   [`OpenError::Damaged`].
//! - Every record, blob and study definition carries a checksum and is verified whenever it is
//!   read.
//! - One process has the store open. While it is a run, others read through it ([`Store::read`]).
//!
//! Deliberately absent: transactions over several records (one job is one record), any reliance on
//! sled's own flushing, and network file systems, whose locks and caches void all of the above.
#![forbid(unsafe_code)]

mod blob;
mod connection;
mod core;
mod database;
mod digest;
mod durable;
mod error;
mod lock;
mod manifest;
mod reader;
mod record;
mod salvage;
mod serve;
mod store;
mod verify;
mod volume;
mod wire;

pub use blob::Blobs;
pub use digest::{Digest, ParseDigestError};
pub use error::{OpenError, ReadError, WriteError};
pub use reader::{RecordOrigin, StoreReader};
pub use salvage::Salvage;
pub use store::Store;
pub use verify::{CompactError, Compaction, Verification};
