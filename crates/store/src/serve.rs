//! The process that has the store open answers the readers of other processes here.

use std::io;
use std::net::Shutdown;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use identity::JobKey;

use crate::core::Core;
use crate::error::Answer;
use crate::lock::admitted;
use crate::wire::{
    ANSWER_OVERHEAD, Fetched, RESPONSE_LIMIT, ReadRequest, ReadResponse, receive, send,
};

/// Returns the answers for the first of `keys`, in their order. There is at least one, and no more
/// are added once they have [`RESPONSE_LIMIT`] bytes.
pub(crate) fn first_records<'a>(
    keys: impl IntoIterator<Item = &'a JobKey>,
    get: impl Fn(&JobKey) -> Answer,
) -> Vec<Answer> {
    let mut records = Vec::new();
    let mut bytes = 0;
    for key in keys {
        let record = get(key);
        bytes +=
            record.as_ref().ok().and_then(Option::as_ref).map_or(0, Vec::len) + ANSWER_OVERHEAD;
        records.push(record);
        if bytes >= RESPONSE_LIMIT {
            break;
        }
    }
    records
}

/// A socket that is bound and listens, so that readers may connect while the database is still
/// being opened.
pub(crate) struct Listening {
    pub(crate) listener: UnixListener,
    pub(crate) address: String,
}

impl Listening {
    pub(crate) fn bind() -> io::Result<Self> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let pid = std::process::id();
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        // Containers may share the name space of the sockets and not that of the process ids, so
        // the time tells them apart.
        let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
        let address = format!("tribosweep-store-{pid}-{number}-{time:x}");
        let listener = UnixListener::bind_addr(&SocketAddr::from_abstract_name(&address)?)?;
        Ok(Listening { listener, address })
    }
}

type Connections = Arc<Mutex<Vec<(UnixStream, JoinHandle<()>)>>>;

/// The threads that answer readers. They are ended and joined on drop.
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
        // Shutting down a listening socket wakes the thread that is in accept().
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
    // After a shutdown accept() fails with EINVAL. Without descriptors it fails and may succeed
    // later.
    loop {
        let stream = match listener.accept() {
            Ok((stream, _)) => stream,
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => return,
            Err(_) => {
                thread::sleep(Duration::from_millis(20));
                continue;
            }
        };
        // An abstract socket has no permissions, so the content must not be told to everybody.
        if !admitted(&stream, rustix::process::geteuid()) {
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

fn answer(stream: UnixStream, core: &Core) {
    // Any failure means that the reader is gone or is no reader. The end of the stream tells it.
    while let Ok(request) = receive::<ReadRequest>(&stream) {
        let response = match request {
            ReadRequest::Keys(after) => {
                let after = after.map(JobKey);
                let index = core.records.index();
                let keys = index.above(after.as_ref()).take(RESPONSE_LIMIT / size_of::<JobKey>());
                ReadResponse::Keys(keys.map(|key| key.0).collect())
            }
            ReadRequest::Contains(keys) => ReadResponse::Contains(
                keys.into_iter().map(|key| core.records.contains(&JobKey(key))).collect(),
            ),
            ReadRequest::Get(keys) => {
                let keys: Vec<_> = keys.into_iter().map(JobKey).collect();
                ReadResponse::Get(
                    first_records(&keys, |key| core.records.get(key))
                        .into_iter()
                        .map(Fetched::from)
                        .collect(),
                )
            }
        };
        if send(&stream, &response).is_err() {
            return;
        }
    }
}
