//! Reading a store through the process that has it open.
//!
//! sled admits one process, so the holder answers readers on an abstract Unix socket: it has no
//! file that could be left behind or whose path could be too long, and it is gone with the process.
//! Only records and keys travel: the manifest and the blobs are plain files, which readers read
//! themselves.
//!
//! A message is a frame: length of the body (u32, little-endian), protocol version (u8), body
//! (bincode 2, standard configuration). A reader sends one [`ReadRequest`] and gets one [`ReadResponse`],
//! any number of times. A response ends where it would grow beyond [`RESPONSE_LIMIT`], and the reader asks
//! for the rest: neither side holds more of a store than that.

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;

use bincode::config::standard;
use bincode::{Decode, Encode};

use identity::{JobKey, STORED_LIMIT};

use crate::error::ReadError;

/// 1 answered every key of a request in one response.
pub(crate) const PROTOCOL: u8 = 2;

/// Bytes of content after which a response takes up nothing more.
pub(crate) const RESPONSE_LIMIT: usize = 8 * STORED_LIMIT;

/// No honest frame is larger: a response one byte short of [`RESPONSE_LIMIT`] and the largest record, with
/// as much again for lengths and reasons.
const FRAME_LIMIT: u32 = (RESPONSE_LIMIT + 2 * STORED_LIMIT) as u32;

/// Bytes that are counted for an answer besides its record: lengths, and the words for what is
/// wrong with it.
pub(crate) const ANSWER_OVERHEAD: usize = 256;

/// Keys in one request; a reader splits larger ones.
pub(crate) const KEYS_PER_REQUEST: usize = 4096;

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum ReadRequest {
    /// The first keys after this one, or of all, ascending.
    Keys(Option<[u8; 32]>),
    /// For each key, whether there is a record.
    Contains(Vec<[u8; 32]>),
    /// For each of the first keys, its record.
    Get(Vec<[u8; 32]>),
}

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum ReadResponse {
    /// None after the last one.
    Keys(Vec<[u8; 32]>),
    Contains(Vec<bool>),
    /// At least one, if any was asked for.
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
    // Grown while reading: a length is not believed before the bytes are there.
    let mut body = Vec::new();
    stream.take(u64::from(length)).read_to_end(&mut body)?;
    if body.len() != length as usize {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    match bincode::decode_from_slice(&body, standard().with_limit::<{ 2 * FRAME_LIMIT as usize }>())
    {
        Ok((message, read)) if read == body.len() => Ok(message),
        Ok(_) => Err(invalid("a message goes on after its end")),
        Err(error) => Err(invalid(error.to_string())),
    }
}
