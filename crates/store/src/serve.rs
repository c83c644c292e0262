//! Reading a store through the process that has it open.
//!
//! sled admits one process, so the holder answers readers on an abstract Unix socket: it has no
//! file that could be left behind or whose path could be too long, and it is gone with the process.
//! Only records and keys travel: the manifest and the blobs are plain files, which readers read
//! themselves.
//!
//! A message is a frame: length of the body (u32, little-endian), protocol version (u8), body
//! (bincode 2, standard configuration). A reader sends one [`Request`] and gets one [`Response`],
//! any number of times. A response ends where it would grow beyond [`REPLY`], and the reader asks
//! for the rest: neither side holds more of a store than that.

use crate::record::RECORD_LIMIT;
use crate::store::{Core, PATIENCE};
use crate::{ReadError, lock::Holder};
use bincode::config::standard;
use bincode::{Decode, Encode};
use identity::JobKey;
use std::io::{self, Read, Write};
use std::net::Shutdown;
use std::ops::Bound;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// 1 answered every key of a request in one response.
const PROTOCOL: u8 = 2;

/// Bytes of content after which a response takes up nothing more.
const REPLY: usize = 8 * RECORD_LIMIT;

/// No honest frame is larger: a response one byte short of [`REPLY`] and the largest record, with
/// as much again for lengths and reasons.
const FRAME_LIMIT: u32 = (REPLY + 2 * RECORD_LIMIT) as u32;

/// Bytes that are counted for an answer besides its record: lengths, and the words for what is
/// wrong with it.
const OTHERS: usize = 256;

/// Keys in one request; a reader splits larger ones.
pub(crate) const BATCH: usize = 4096;

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum Request {
    /// The first keys after this one, or of all, ascending.
    Keys(Option<[u8; 32]>),
    /// For each key, whether there is a record.
    Contains(Vec<[u8; 32]>),
    /// For each of the first keys, its record.
    Get(Vec<[u8; 32]>),
}

#[derive(Debug, PartialEq, Encode, Decode)]
pub(crate) enum Response {
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
    fn from(result: Result<Option<Vec<u8>>, ReadError>) -> Self {
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

/// What there is of the first of `keys`, in their order: at least of one, and of no more once
/// [`REPLY`] bytes are together.
pub(crate) fn first_records<'a>(
    core: &Core,
    keys: impl IntoIterator<Item = &'a JobKey>,
) -> Vec<Result<Option<Vec<u8>>, ReadError>> {
    let mut records = Vec::new();
    let mut bytes = 0;
    for key in keys {
        let record = core.get(key);
        bytes += record.as_ref().ok().and_then(Option::as_ref).map_or(0, Vec::len) + OTHERS;
        records.push(record);
        if bytes >= REPLY {
            break;
        }
    }
    records
}

fn invalid(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

fn send(mut stream: &UnixStream, message: &impl Encode) -> io::Result<()> {
    let mut frame = vec![0; 5];
    bincode::encode_into_std_write(message, &mut frame, standard())
        .map_err(|e| invalid(e.to_string()))?;
    let length = u32::try_from(frame.len() - 5).ok().filter(|length| *length <= FRAME_LIMIT);
    let length = length.ok_or_else(|| invalid("too much for one message"))?;
    frame[..4].copy_from_slice(&length.to_le_bytes());
    frame[4] = PROTOCOL;
    stream.write_all(&frame)
}

fn receive<T: Decode<()>>(mut stream: &UnixStream) -> io::Result<T> {
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

/// A socket bound and listening, so that readers may connect while the database is still being
/// opened.
pub(crate) struct Listening {
    listener: UnixListener,
    pub(crate) address: String,
}

impl Listening {
    pub(crate) fn bind() -> io::Result<Self> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let pid = std::process::id();
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        // Containers may share the socket's name space and not that of the process ids: the time
        // tells them apart.
        let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
        let address = format!("tribosweep-store-{pid}-{number}-{time:x}");
        let listener = UnixListener::bind_addr(&SocketAddr::from_abstract_name(&address)?)?;
        Ok(Listening { listener, address })
    }
}

type Connections = Arc<Mutex<Vec<(UnixStream, JoinHandle<()>)>>>;

/// The threads that answer readers; ended and joined on drop.
pub(crate) struct Server {
    listener: UnixListener,
    accepting: Option<JoinHandle<()>>,
    connections: Connections,
}

impl Server {
    pub(crate) fn start(listening: Listening, core: &Arc<Core>) -> io::Result<Self> {
        let listener = listening.listener;
        let connections = Connections::default();
        let accepting = thread::Builder::new().name("store readers".to_owned()).spawn({
            let (listener, connections, core) =
                (listener.try_clone()?, connections.clone(), core.clone());
            move || accept(&listener, &connections, &core)
        })?;
        Ok(Server { listener, accepting: Some(accepting), connections })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // Shutting a listening socket down wakes whoever is in accept().
        let _ = rustix::net::shutdown(&self.listener, rustix::net::Shutdown::Both);
        if let Some(thread) = self.accepting.take() {
            let _ = thread.join();
        }
        let connections =
            std::mem::take(&mut *self.connections.lock().unwrap_or_else(PoisonError::into_inner));
        for (stream, thread) in connections {
            let _ = stream.shutdown(Shutdown::Both);
            let _ = thread.join();
        }
    }
}

fn accept(listener: &UnixListener, connections: &Connections, core: &Arc<Core>) {
    // Shut down, accept() fails with EINVAL; out of descriptors, it fails and may succeed later.
    loop {
        let stream = match listener.accept() {
            Ok((stream, _)) => stream,
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => return,
            Err(_) => {
                thread::sleep(Duration::from_millis(20));
                continue;
            }
        };
        if !admitted(&stream) {
            continue;
        }
        let Ok(handle) = stream.try_clone() else { continue };
        let core = core.clone();
        let answering = thread::Builder::new()
            .name("store reader".to_owned())
            .spawn(move || answer(stream, &core));
        let mut connections = connections.lock().unwrap_or_else(PoisonError::into_inner);
        connections.retain(|(_, thread)| !thread.is_finished());
        if let Ok(thread) = answering {
            connections.push((handle, thread));
        }
    }
}

/// An abstract socket has no permissions: whoever could not read the files of the store is not told
/// what is in them.
fn admitted(stream: &UnixStream) -> bool {
    let ours = rustix::process::geteuid();
    rustix::net::sockopt::socket_peercred(stream)
        .is_ok_and(|peer| peer.uid == ours || peer.uid.is_root())
}

fn answer(stream: UnixStream, core: &Core) {
    // Any failure means that the reader is gone or is none of ours; it learns by the end of the
    // stream.
    while let Ok(request) = receive::<Request>(&stream) {
        let response = match request {
            Request::Keys(after) => {
                let after = after.map_or(Bound::Unbounded, |key| Bound::Excluded(JobKey(key)));
                let index = core.index();
                let keys = index.range((after, Bound::Unbounded)).take(REPLY / size_of::<JobKey>());
                Response::Keys(keys.map(|key| key.0).collect())
            }
            Request::Contains(keys) => Response::Contains(
                keys.into_iter().map(|key| core.contains(&JobKey(key))).collect(),
            ),
            Request::Get(keys) => {
                let keys: Vec<_> = keys.into_iter().map(JobKey).collect();
                Response::Get(first_records(core, &keys).into_iter().map(Fetched::from).collect())
            }
        };
        if send(&stream, &response).is_err() {
            return;
        }
    }
}

/// A reader's end.
pub(crate) struct Connection {
    stream: Mutex<UnixStream>,
    pub(crate) holder: Holder,
}

impl Connection {
    /// Connects to `holder` and makes sure that it answers within `patience`.
    pub(crate) fn open(holder: &Holder, address: &str, patience: Duration) -> io::Result<Self> {
        let stream = UnixStream::connect_addr(&SocketAddr::from_abstract_name(address)?)?;
        let wait_up_to = |time| {
            stream.set_read_timeout(Some(time)).and_then(|()| stream.set_write_timeout(Some(time)))
        };
        wait_up_to(patience)?;
        match ask(&stream, &Request::Contains(Vec::new()))? {
            Response::Contains(none) if none.is_empty() => {}
            _ => return Err(invalid("it did not answer the question")),
        }
        // What was left of the patience with its start says nothing of how long it may take over an
        // answer.
        wait_up_to(PATIENCE)?;
        Ok(Connection { stream: Mutex::new(stream), holder: holder.clone() })
    }

    /// The answer to `request`. After a failure there is none to anything.
    pub(crate) fn ask(&self, request: &Request) -> io::Result<Response> {
        let stream = self.stream.lock().unwrap_or_else(PoisonError::into_inner);
        ask(&stream, request).inspect_err(|_| {
            // An answer that comes late must not pass for that to the next question.
            let _ = stream.shutdown(Shutdown::Both);
        })
    }
}

fn ask(stream: &UnixStream, request: &Request) -> io::Result<Response> {
    send(stream, request)?;
    receive(stream)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A connection to a holder that answers the first question as it should and every later one as
    /// `answer` does.
    fn connected(
        patience: Duration,
        mut answer: impl FnMut(&mut UnixStream) + Send + 'static,
    ) -> Connection {
        let listening = Listening::bind().unwrap();
        let address = listening.address.clone();
        thread::spawn(move || {
            let (mut stream, _) = listening.listener.accept().unwrap();
            receive::<Request>(&stream).unwrap();
            send(&stream, &Response::Contains(Vec::new())).unwrap();
            while receive::<Request>(&stream).is_ok() {
                answer(&mut stream);
            }
        });
        Connection::open(&Holder::this_process(Some(address.clone())), &address, patience).unwrap()
    }

    #[test]
    fn an_answer_is_waited_for_longer_than_what_was_left_of_the_start() {
        let connection = connected(Duration::from_secs(77), |_| ());
        let stream = connection.stream.lock().unwrap();
        assert_eq!(stream.read_timeout().unwrap(), Some(PATIENCE));
        assert_eq!(stream.write_timeout().unwrap(), Some(PATIENCE));
    }

    #[test]
    fn a_late_answer_is_not_taken_for_that_to_the_next_question() {
        let connection = connected(PATIENCE, |stream| {
            // Two answers to one question stand for one that came too late and the next one.
            let _ = stream.write_all(&[0, 0, 0, 0, PROTOCOL]);
            let _ = send(stream, &Response::Contains(vec![true]));
        });
        let question = Request::Contains(vec![[7; 32]]);
        assert!(connection.ask(&question).is_err());
        assert!(connection.ask(&question).is_err());
    }

    #[test]
    fn a_reply_ends_where_it_would_grow_too_long() {
        let directory = tempfile::tempdir().unwrap();
        let store = crate::Store::open(directory.path()).unwrap();
        let keys: Vec<JobKey> = (0..20).map(|i| JobKey([i; 32])).collect();
        for key in &keys[..19] {
            store.commit(&[(*key, vec![key.0[0]; REPLY / 8])]).unwrap();
        }
        let lengths = |keys: &[JobKey]| -> Vec<_> {
            first_records(store.core(), keys)
                .into_iter()
                .map(|record| record.unwrap().map(|record| record.len()))
                .collect()
        };
        assert_eq!(lengths(&keys), [Some(REPLY / 8); 8]);
        assert_eq!(lengths(&keys[17..]), [Some(REPLY / 8), Some(REPLY / 8), None]);
        assert_eq!(lengths(&[]), []);
    }
}
