//! The messages between a reader and the process that has the store open.
//!
//! sled admits one process, so the holder answers readers on an abstract Unix socket. Such a socket
//! has no file that could be left behind or whose path could be too long, and it is gone with the
//! process. Only records and keys travel: the manifest and the blobs are plain files, which readers
//! read themselves.
//!
//! A message is a frame: length of the body (u32, little-endian), protocol version (u8), body
//! (bincode 2, standard configuration). A reader sends one [`ReadRequest`] and gets one
//! [`ReadResponse`], any number of times. A response ends where it would grow beyond
//! [`RESPONSE_LIMIT`], and the reader asks for the rest, so neither side holds more of a store than
//! that.

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;

use bincode::config::standard;
use bincode::{Decode, Encode};

use identity::{JobKey, STORED_LIMIT};

use crate::error::ReadError;

/// The version of the protocol. Version 1 answered every key of a request in one response.
pub(crate) const PROTOCOL: u8 = 2;

/// The size of the content after which a response takes up nothing more \[bytes\].
pub(crate) const RESPONSE_LIMIT: usize = 8 * STORED_LIMIT;

/// The largest frame that is accepted \[bytes\]. A response has at most one byte less than
/// [`RESPONSE_LIMIT`] and the largest record, and as much again is allowed for lengths and reasons.
const FRAME_LIMIT: u32 = (RESPONSE_LIMIT + 2 * STORED_LIMIT) as u32;

/// The size that is counted for an answer besides its record \[bytes\], for lengths and error
/// messages.
pub(crate) const ANSWER_OVERHEAD: usize = 256;

/// The largest number of keys in one request. A reader splits larger ones.
pub(crate) const KEYS_PER_REQUEST: usize = 4096;

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum ReadRequest {
    /// Asks for the first keys after this one in ascending order, or for the first of all.
    Keys(Option<[u8; 32]>),
    /// Asks for each key whether there is a record.
    Contains(Vec<[u8; 32]>),
    /// Asks for the record of each of the first keys.
    Get(Vec<[u8; 32]>),
}

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum ReadResponse {
    /// The keys, of which there are none after the last one.
    Keys(Vec<[u8; 32]>),
    Contains(Vec<bool>),
    /// The answers, of which there is at least one if the request had a key.
    Get(Vec<Fetched>),
}

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum Fetched {
    Absent,
    Record(Vec<u8>),
    Corrupt(String),
    Version(u8),
    Failed(String),
}

impl Fetched {
    pub(crate) fn from(result: Result<Option<Vec<u8>>, ReadError>) -> Self {
        match result {
            Ok(None) => Fetched::Absent,
            Ok(Some(record)) => Fetched::Record(record),
            Err(ReadError::Corrupt { reason, .. }) => Fetched::Corrupt(reason),
            Err(ReadError::Version { found, .. }) => Fetched::Version(found),
            Err(other) => Fetched::Failed(other.to_string()),
        }
    }

    pub(crate) fn into_result(self, key: &JobKey) -> Result<Option<Vec<u8>>, ReadError> {
        match self {
            Fetched::Absent => Ok(None),
            Fetched::Record(record) => Ok(Some(record)),
            Fetched::Corrupt(reason) => Err(ReadError::Corrupt { key: *key, reason }),
            Fetched::Version(found) => Err(ReadError::Version { key: *key, found }),
            Fetched::Failed(reason) => Err(ReadError::Database(reason)),
        }
    }
}

pub(crate) fn invalid(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

/// Tells whether bytes are the body of a message between a reader and the holder of a store.
pub fn is_message(body: &[u8]) -> bool {
    decode::<ReadRequest>(body).is_ok() || decode::<ReadResponse>(body).is_ok()
}

pub(crate) fn send(mut stream: &UnixStream, message: &impl Encode) -> io::Result<()> {
    let mut frame = vec![0; 5];
    bincode::encode_into_std_write(message, &mut frame, standard())
        .map_err(|e| invalid(e.to_string()))?;
    let length = u32::try_from(frame.len() - 5).ok().filter(|length| *length <= FRAME_LIMIT);
    let length = length.ok_or_else(|| invalid("too much for one message"))?;
    frame[..4].copy_from_slice(&length.to_le_bytes());
    frame[4] = PROTOCOL;
    stream.write_all(&frame)
}

pub(crate) fn receive<T: Decode<()>>(mut stream: &UnixStream) -> io::Result<T> {
    let mut header = [0; 5];
    stream.read_exact(&mut header)?;
    let [a, b, c, d, version] = header;
    let length = u32::from_le_bytes([a, b, c, d]);
    if version != PROTOCOL {
        return Err(invalid(format!(
            "it speaks version {version} of the protocol, this program version {PROTOCOL}"
        )));
    }
    if length > FRAME_LIMIT {
        return Err(invalid(format!("a message of {length} bytes was announced")));
    }
    // The body grows while it is read: a length is not believed before the bytes are there.
    let mut body = Vec::new();
    stream.take(u64::from(length)).read_to_end(&mut body)?;
    if body.len() != length as usize {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    decode(&body)
}

/// Decodes the body of a frame.
fn decode<T: Decode<()>>(body: &[u8]) -> io::Result<T> {
    match bincode::decode_from_slice(body, standard().with_limit::<{ 2 * FRAME_LIMIT as usize }>())
    {
        Ok((message, read)) if read == body.len() => Ok(message),
        Ok(_) => Err(invalid("a message goes on after its end")),
        Err(error) => Err(invalid(error.to_string())),
    }
}
