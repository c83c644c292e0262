//! This file holds a reader's connection to the process that has the store open.

use std::io;
use std::net::Shutdown;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixStream};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::core::PATIENCE;
use crate::lock::Holder;
use crate::wire::{ReadRequest, ReadResponse, invalid, receive, send};

/// The reader's end of a connection.
pub(crate) struct Connection {
    stream: Mutex<UnixStream>,
    pub(crate) holder: Holder,
}

impl Connection {
    /// Connects to `holder` and checks that it answers within `patience`.
    pub(crate) fn open(holder: &Holder, address: &str, patience: Duration) -> io::Result<Self> {
        let stream = UnixStream::connect_addr(&SocketAddr::from_abstract_name(address)?)?;
        let wait_up_to = |time| {
            stream.set_read_timeout(Some(time)).and_then(|()| stream.set_write_timeout(Some(time)))
        };
        wait_up_to(patience)?;
        match ask(&stream, &ReadRequest::Contains(Vec::new()))? {
            ReadResponse::Contains(none) if none.is_empty() => {}
            _ => return Err(invalid("it did not answer the question")),
        }
        // The patience that was left for the start says nothing about how long an answer may take.
        wait_up_to(PATIENCE)?;
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
    fn connected(
        patience: Duration,
        mut answer: impl FnMut(&mut UnixStream) + Send + 'static,
    ) -> Connection {
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
            // Two answers to one request stand for a late answer and the next one.
            let _ = stream.write_all(&[0, 0, 0, 0, PROTOCOL]);
            let _ = send(stream, &ReadResponse::Contains(vec![true]));
        });
        let question = ReadRequest::Contains(vec![[7; 32]]);
        assert!(connection.ask(&question).is_err());
        assert!(connection.ask(&question).is_err());
    }
}
