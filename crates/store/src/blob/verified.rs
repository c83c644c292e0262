//! This file decompresses a blob piece by piece and verifies it against its name.

use std::io::{self, BufReader, Read};

use crate::digest::Digest;
use crate::frame::{BodySum, Checksum};

/// The size of the pieces in which a blob is read \[bytes\].
pub(super) const PIECE: usize = 128 << 10;

/// The receiver of the content of a blob, which forgets what it got of a copy that is damaged.
pub(super) trait BlobSink {
    fn add(&mut self, piece: &[u8]);
    fn start_again(&mut self);
}

impl BlobSink for Vec<u8> {
    fn add(&mut self, piece: &[u8]) {
        self.extend_from_slice(piece);
    }

    fn start_again(&mut self) {
        self.clear();
    }
}

impl BlobSink for io::Sink {
    fn add(&mut self, _: &[u8]) {}

    fn start_again(&mut self) {}
}

/// A reader that computes the checksum of what it reads.
struct Summing<R> {
    inner: R,
    sum: BodySum,
}

impl<R: Read> Read for Summing<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        self.sum.add(&buffer[..count]);
        Ok(count)
    }
}

/// Decompresses a blob into `content` and returns the checksum of its `length` compressed bytes.
///
/// # Errors
/// The content is not that of `digest` or has more than `limit` bytes; it is then not decompressed
/// to its end.
pub(super) fn verified(
    compressed: impl Read,
    length: u64,
    digest: &Digest,
    limit: u64,
    content: &mut dyn BlobSink,
) -> io::Result<Checksum> {
    let invalid = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
    if length > zstd::zstd_safe::compress_bound(limit as usize) as u64 {
        return Err(invalid("its file is longer than that of any blob".to_owned()));
    }
    let compressed = Summing { inner: compressed, sum: BodySum::new() };
    let buffered = BufReader::with_capacity(PIECE, compressed);
    let mut decoder = zstd::Decoder::with_buffer(buffered)?;
    let (mut hasher, mut piece, mut count) = (blake3::Hasher::new(), vec![0; PIECE], 0);
    loop {
        let read = decoder.read(&mut piece)?;
        if read == 0 {
            break;
        }
        count += read as u64;
        if count > limit {
            return Err(invalid(format!(
                "its content has more than {limit} bytes, as many as a blob may have"
            )));
        }
        hasher.update(&piece[..read]);
        content.add(&piece[..read]);
    }
    if *hasher.finalize().as_bytes() != digest.0 {
        return Err(invalid("its content does not match its name".to_owned()));
    }
    Ok(decoder.finish().into_inner().sum.get())
}
