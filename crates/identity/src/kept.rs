//! Where the fields of a record are, and how large a record may be.

use serde::{Deserialize, Serialize};

/// Most bytes of a record that a store keeps: room for the 1000 increments that a loading path may
/// have. sled's memory grows with what was written, however it is cut (measured: 117 MB take about
/// as much in records of 6 kB and of 300 kB); fields, a hundred times that, belong in blobs.
pub const STORED_LIMIT: usize = 1 << 20;

/// Where the bytes of a record's fields are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum KeptFields {
    /// In a blob, whose name is their BLAKE3 digest.
    Blob([u8; 32]),
    /// In the record itself, compressed.
    Inside(Vec<u8>),
}
