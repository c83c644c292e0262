//! This file holds a reader's connection to the process that has the store open.

use std::io;
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::lock::Holder;
use crate::wire::{ReadRequest, ReadResponse, invalid, receive, send};

/// The longest time for which an answer is waited for. A process that is stopped gives none, and
/// the store is read from disk instead.
const PATIENCE: Duration = Duration::from_secs(5);

/// The reader's end of a connection.
pub(crate) struct Connection {
    stream: Mutex<UnixStream>,
    pub(crate) holder: Holder,
}

impl Connection {
    /// Connects to `holder` and checks that it answers.
    pub(crate) fn open(holder: &Holder) -> io::Result<Self> {
        let stream = holder.connect()?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        match ask(&stream, &ReadRequest::Contains(Vec::new()))? {
            ReadResponse::Contains(none) if none.is_empty() => {}
            _ => return Err(invalid("it did not answer the question")),
        }
        Ok(Connection { stream: Mutex::new(stream), holder: holder.clone() })
    }

    /// Returns the answer to `request`. After a failure nothing is answered any more.
    pub(crate) fn ask(&self, request: &ReadRequest) -> io::Result<ReadResponse> {
        let stream = self.stream.lock().unwrap_or_else(PoisonError::into_inner);
        ask(&stream, request).inspect_err(|_| {
            // A late answer must not pass for the answer to the next request.
            let _ = stream.shutdown(Shutdown::Both);
        })
    }
}

fn ask(stream: &UnixStream, request: &ReadRequest) -> io::Result<ReadResponse> {
    send(stream, request)?;
    receive(stream)
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::thread;

    use super::*;
    use crate::serve::Listening;
    use crate::wire::PROTOCOL;

    /// Returns a connection to a holder that answers the first request as it should and every later
    /// one as `answer` does.
    fn connected(mut answer: impl FnMut(&mut UnixStream) + Send + 'static) -> Connection {
        let listening = Listening::bind().unwrap();
        let address = listening.address.clone();
        thread::spawn(move || {
            let (mut stream, _) = listening.listener.accept().unwrap();
            receive::<ReadRequest>(&stream).unwrap();
            send(&stream, &ReadResponse::Contains(Vec::new())).unwrap();
            while receive::<ReadRequest>(&stream).is_ok() {
                answer(&mut stream);
            }
        });
        Connection::open(&Holder::this_process(Some(address), true)).unwrap()
    }

    #[test]
    fn a_late_answer_is_not_taken_for_that_to_the_next_question() {
        let connection = connected(|stream| {
            // Two answers to one request stand for a late answer and the next one.
            let _ = stream.write_all(&[0, 0, 0, 0, PROTOCOL]);
            let _ = send(stream, &ReadResponse::Contains(vec![true]));
        });
        let question = ReadRequest::Contains(vec![[7; 32]]);
        assert!(connection.ask(&question).is_err());
        assert!(connection.ask(&question).is_err());
    }
}
