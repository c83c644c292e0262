//! The place of the fields of a record, and the bound of its size.

use serde::{Deserialize, Serialize};

/// The largest size of a record that a store keeps \[bytes\]. It leaves room for the 1000
/// increments that a loading path may have. The memory of sled grows with what was written, however
/// it is cut (measured: 117 MB take about as much in records of 6 kB and of 300 kB). Fields are a
/// hundred times larger and belong in blobs.
pub const STORED_LIMIT: usize = 1 << 20;

/// The place of the bytes of a record's fields.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum KeptFields {
    /// The bytes are in the blob with this name, which is their BLAKE3 digest.
    Blob([u8; 32]),
    /// The compressed bytes are in the record itself.
    Inside(#[serde(with = "serde_bytes")] Vec<u8>),
}
