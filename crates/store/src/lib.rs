//! Keeps results durably: records in sled, fields in content-addressed files.
//!
//! A store is a directory with these entries:
//!
//! - `manifest.json`: the format version, the least number of records, and the names of the studies
//!   with the digests of their definitions and the words that people have put to them.
//! - `records/`: the sled database, from the key of a job to its sealed record of at most
//!   [`STORED_LIMIT`](identity::STORED_LIMIT) bytes.
//! - `blobs/ab/…`: fields, height maps and definitions of studies, as zstd files that are named by
//!   the BLAKE3 digest of their content.
//! - `lock`: a file that is locked by the process that writes the store, and that says who it is
//!   and where it answers readers. Only its owner may open it.
//!
//! - `kept` and `tables/`: what was learnt of the records, as words and as tables of studies. It
//!   counts only as long as the database has not changed, and may be lost.
//!
//! - `shards.json`: the shards of studies whose exports were merged into the store. It only serves
//!   words about what is missing, and may be lost.
//!
//! An export is one file that holds the same: records, blobs and definitions of studies (`frame.rs`
//! has its format). It only grows, needs no lock, and may lie where no store may. [`Store::read`]
//! reads an export, or a directory of them, like a store; [`ExportWriter`] writes one;
//! [`Store::import`] and [`merge_into_export`] unite stores and exports.
//!
//! The following holds whatever happens to the process or the machine:
//!
//! - Everything that [`Store::commit`] acknowledged is on the disk: the log is flushed and its file
//!   fsync'ed before it returns.
//! - `manifest.json` never promises more records than the database durably has. Its count is raised
//!   after a commit is durable (during a run within half a second of commits, else on closing) and
//!   lowered before a removal. So a kill at any moment raises no false alarm, and a database file
//!   that was truncated or replaced, which sled may open as an empty one, is refused with
//!   [`OpenError::Damaged`].
//! - Every record, blob and definition carries a checksum and is verified whenever it is read.
//! - One process writes the store. Others read through it, or from a private copy of the records
//!   ([`Store::read`]): reading changes nothing in the store, needs no right to write to it, and
//!   holds up nobody.
//! - A merge gives the same records whatever the order of its sources and however often it is
//!   repeated or cut short. Two results of one job that differ are reported, and neither is taken;
//!   one that was there before stays.
//! - Of an export that is damaged or torn, everything else is read.
//! - A blob that was lost or damaged is found when it is read, and storing it again heals it.
//! - A record is whole without the blobs that only go along with it ([`References::companions`]):
//!   their loss is said, and no record is given up for it.
//!
//! Three things are deliberately absent: transactions over several records (one job is one record),
//! any reliance on sled's own flushing, and network file systems, whose locks and caches void all
//! of the above.
#![forbid(unsafe_code)]

mod access;
mod blob;
mod collection;
mod compression;
mod connection;
mod core;
mod database;
mod digest;
mod durable;
mod error;
mod export;
mod exports;
mod flat;
mod frame;
mod glance;
mod grouped;
mod kept;
mod key_set;
mod lock;
mod manifest;
mod mark;
mod merge;
mod paged;
mod parts;
mod reader;
mod record;
mod replica;
mod rules;
mod salvage;
mod scratch;
mod sealed;
mod serve;
mod sorted;
mod store;
mod table;
mod traces;
mod verify;
mod volume;
mod wire;

pub use blob::{Blobs, StoredBlob};
pub use collection::{CollectError, Collection, Garbage};
pub use digest::{Digest, ParseDigestError};
pub use error::{OpenError, ReadError, WriteError};
pub use export::{ExportError, ExportWriter};
pub use exports::{ExportHeader, ExportSummary, SHARD_LIMIT, ShardName, ShardState};
pub use glance::Glance;
pub use kept::KeptWords;
pub use manifest::StudyLabels;
pub use merge::{
    MergeError, MergeReport, MergeSelection, RecordConflict, merge_into_export, require_mergeable,
};
pub use reader::{CopyReason, RecordOrigin, StoreReader};
pub use rules::{Examination, LostCompanion, MergeRules, RecordRank, References};
pub use salvage::Salvage;
pub use store::Store;
pub use table::{KeptTable, TableBuilder};
pub use verify::{CompactError, Compaction, Verification};
pub use wire::is_message;
