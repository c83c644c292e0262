//! The coordinator and a worker say these messages to each other, as bytes.
//!
//! A message is the format version (one byte) followed by bincode 2 in its standard configuration.
//! Both ends are the same binary, so a version that differs means that a stranger is on the line.

use bincode::{Decode, Encode};

use crate::lease::LeaseId;

/// The format version, which changes with every change of the layout below.
const FORMAT: u8 = 2;
/// The limit of the size of a message \[bytes\]. Without it, a length in garbage would be allocated
/// before its content is missed.
const LARGEST: usize = 64 << 20;

fn layout() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<LARGEST>()
}

/// Bytes that travel in the message or, if there are many, beside it.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub(crate) enum Body {
    /// The bytes are in the message.
    Inline(Vec<u8>),
    /// The bytes are in a file of the run's root that is named after the lease.
    File {
        /// The BLAKE3 digest of the content.
        hash: [u8; 32],
        /// The length of the content \[bytes\].
        length: u64,
    },
}

/// The end of one attempt at a job.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub(crate) enum AttemptOutcome<B> {
    /// The attempt gave the result of the job.
    Completed(B),
    /// The attempt failed for this reason. The worker lives on.
    Failed(String),
    /// The job or its result could not be handed over for this reason. It says nothing about the
    /// job.
    Undelivered(String),
}

/// The report of a worker about the end of one lease.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub(crate) struct Report<B> {
    pub(crate) lease: LeaseId,
    /// The wall-clock time that the job took \[s\].
    pub(crate) seconds: f64,
    pub(crate) outcome: AttemptOutcome<B>,
}

/// A message from a worker to the coordinator: these jobs are done, and more are wanted.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub(crate) struct Request<B> {
    pub(crate) reports: Vec<Report<B>>,
    /// It is true if the worker holds neither jobs nor unreported results.
    pub(crate) idle: bool,
}

/// One job for a worker.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub(crate) struct Assignment<B> {
    pub(crate) lease: LeaseId,
    pub(crate) payload: B,
}

/// A message from the coordinator to a worker: everything reported is durable, and this is next.
#[derive(Clone, Debug, PartialEq, Encode, Decode)]
pub(crate) enum Reply<B> {
    /// The worker gets more jobs after those that it still holds. There may be none if it holds
    /// some.
    Jobs(Vec<Assignment<B>>),
    /// The worker must leave.
    Stop,
}

/// The reason why bytes are not a message.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MessageError {
    #[error("message format {0}, expected {FORMAT}: coordinator and worker are different builds")]
    Format(u8),
    #[error("an empty message")]
    Empty,
    #[error("{0} bytes left over after the message")]
    Rest(usize),
    #[error("not a message: {0}")]
    Bincode(#[from] bincode::error::DecodeError),
}

/// Encodes a message as bytes.
pub(crate) fn encode(message: &impl Encode) -> Result<Vec<u8>, bincode::error::EncodeError> {
    let mut bytes = vec![FORMAT];
    bincode::encode_into_std_write(message, &mut bytes, layout())?;
    Ok(bytes)
}

/// Decodes the message in these bytes.
pub(crate) fn decode<M: Decode<()>>(bytes: &[u8]) -> Result<M, MessageError> {
    match bytes {
        [] => Err(MessageError::Empty),
        [FORMAT, rest @ ..] => {
            let (message, used) = bincode::decode_from_slice(rest, layout())?;
            if used == rest.len() {
                Ok(message)
            } else {
                Err(MessageError::Rest(rest.len() - used))
            }
        }
        [format, ..] => Err(MessageError::Format(*format)),
    }
}

/// Tells whether bytes that follow the format version are a message between a coordinator and a
/// worker.
pub fn is_message(content: &[u8]) -> bool {
    let bytes = [&[FORMAT], content].concat();
    decode::<Request<Body>>(&bytes).is_ok() || decode::<Reply<Body>>(&bytes).is_ok()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_bytes_of_a_request_are_these() {
        let request = Request {
            reports: vec![
                Report {
                    lease: 7,
                    seconds: 0.5,
                    outcome: AttemptOutcome::Completed(Body::Inline(vec![1, 2])),
                },
                Report {
                    lease: 300,
                    seconds: 0.0,
                    outcome: AttemptOutcome::Completed(Body::File { hash: [9; 32], length: 5 }),
                },
                Report { lease: 8, seconds: 0.0, outcome: AttemptOutcome::Failed("no".into()) },
                Report { lease: 9, seconds: 0.0, outcome: AttemptOutcome::Undelivered("x".into()) },
            ],
            idle: true,
        };
        let mut golden = vec![2, 4];
        golden.extend([7, 0, 0, 0, 0, 0, 0, 0xe0, 0x3f, 0, 0, 2, 1, 2]);
        golden.extend([251, 0x2c, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
        golden.extend([9; 32]);
        golden.push(5);
        golden.extend([8, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, b'n', b'o']);
        golden.extend([9, 0, 0, 0, 0, 0, 0, 0, 0, 2, 1, b'x']);
        golden.push(1);
        assert_eq!(encode(&request).unwrap(), golden);
        assert_eq!(decode::<Request<Body>>(&golden).unwrap(), request);
    }

    #[test]
    fn the_bytes_of_a_reply_are_these() {
        let reply = Reply::Jobs(vec![Assignment { lease: 1, payload: Body::Inline(vec![4]) }]);
        assert_eq!(encode(&reply).unwrap(), [2, 0, 1, 1, 0, 1, 4]);
        assert_eq!(encode(&Reply::<Body>::Stop).unwrap(), [2, 1]);
    }

    #[test]
    fn what_is_not_a_message_is_refused() {
        assert!(matches!(decode::<Reply<Body>>(&[]), Err(MessageError::Empty)));
        assert!(matches!(decode::<Reply<Body>>(&[1, 1]), Err(MessageError::Format(1))));
        assert!(matches!(decode::<Reply<Body>>(&[2, 1, 0]), Err(MessageError::Rest(1))));
        assert!(matches!(decode::<Reply<Body>>(&[2, 5]), Err(MessageError::Bincode(_))));
    }

    proptest! {
        #[test]
        fn no_bytes_make_decoding_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode::<Request<Body>>(&bytes);
            let _ = decode::<Reply<Body>>(&bytes);
        }
    }
}
