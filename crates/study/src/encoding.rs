//! Bytes with a version: every format begins with a version byte, and bincode's standard
//! configuration follows.

use serde::{Serialize, de::DeserializeOwned};

/// The reason why bytes cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// There are no bytes.
    #[error("{item} is empty")]
    Empty {
        /// The name of what was read.
        item: &'static str,
    },
    /// Another version of the program wrote the bytes.
    #[error("{item} has format {found}, this program reads {}", formats(known))]
    Version {
        /// The name of what was read.
        item: &'static str,
        /// The version of the bytes.
        found: u8,
        /// The versions that this program reads.
        known: &'static [u8],
    },
    /// The bytes do not decode.
    #[error("{item} does not decode: {reason}")]
    Malformed {
        /// The name of what was read.
        item: &'static str,
        /// The fault.
        reason: String,
    },
}

/// Lists versions in words.
fn formats(known: &[u8]) -> String {
    let numbers: Vec<String> = known.iter().map(u8::to_string).collect();
    match &numbers[..] {
        [] => "no format".to_owned(),
        [only] => format!("format {only}"),
        [others @ .., last] => format!("formats {} and {last}", others.join(", ")),
    }
}

/// The format of fields, surfaces and definitions of studies.
pub(crate) const VERSION: u8 = 1;

/// The longest text or list in fields and definitions of studies that is believed \[bytes\]: six
/// doubles for each element of the largest grid, and room to spare.
pub(crate) const BLOB_LIMIT: usize = 2 << 30;

pub(crate) fn encode(value: &impl Serialize) -> Vec<u8> {
    encode_as(VERSION, value)
}

pub(crate) fn encode_as(version: u8, value: &impl Serialize) -> Vec<u8> {
    let mut bytes = vec![version];
    let body = bincode::serde::encode_to_vec(value, bincode::config::standard());
    bytes.extend(body.expect("plain data without skipped or borrowed parts always encodes"));
    bytes
}

pub(crate) fn decode<T: DeserializeOwned, const LIMIT: usize>(
    item: &'static str,
    bytes: &[u8],
) -> Result<T, DecodeError> {
    decode_as::<T, LIMIT>(&[VERSION], item, bytes)
}

pub(crate) fn decode_as<T: DeserializeOwned, const LIMIT: usize>(
    known: &'static [u8],
    item: &'static str,
    bytes: &[u8],
) -> Result<T, DecodeError> {
    let (version, body) = bytes.split_first().ok_or(DecodeError::Empty { item })?;
    if !known.contains(version) {
        return Err(DecodeError::Version { item, found: *version, known });
    }
    let malformed = |reason: String| DecodeError::Malformed { item, reason };
    let config = bincode::config::standard().with_limit::<LIMIT>();
    let (value, read) = bincode::serde::decode_from_slice(body, config)
        .map_err(|error| malformed(error.to_string()))?;
    match body.len() - read {
        0 => Ok(value),
        rest => Err(malformed(format!("{rest} bytes too many"))),
    }
}
