//! Short contents are compressed by contexts that each thread keeps: making one takes longer than
//! a content of some kilobytes does.

use std::cell::RefCell;
use std::io;

use zstd::bulk::{Compressor, Decompressor};

thread_local! {
    static DECOMPRESSOR: RefCell<Option<Decompressor<'static>>> = const { RefCell::new(None) };
    /// The compressor with its level.
    static COMPRESSOR: RefCell<Option<(i32, Compressor<'static>)>> = const { RefCell::new(None) };
}

/// Compresses a content in one call. The bytes are those that a context of its own would give.
pub(crate) fn compress(content: &[u8], level: i32) -> io::Result<Vec<u8>> {
    COMPRESSOR.with(|kept| {
        let mut kept = kept.borrow_mut();
        match kept.as_mut().filter(|(of, _)| *of == level) {
            Some((_, compressor)) => compressor.compress(content),
            None => kept.insert((level, Compressor::new(level)?)).1.compress(content),
        }
    })
}

/// Returns the content of compressed bytes, which has at most so many.
pub(crate) fn decompress(bytes: &[u8], most: usize) -> io::Result<Vec<u8>> {
    DECOMPRESSOR.with(|kept| {
        let mut kept = kept.borrow_mut();
        match kept.as_mut() {
            Some(decompressor) => decompressor.decompress(bytes, most),
            None => kept.insert(Decompressor::new()?).decompress(bytes, most),
        }
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Data compressed before leave no trace.
        #[test]
        fn a_context_that_is_kept_gives_the_bytes_of_a_new_one(
            contents in proptest::collection::vec(
                prop_oneof![
                    proptest::collection::vec(any::<u8>(), 0..3000),
                    proptest::collection::vec(0..3u8, 0..40_000),
                    proptest::collection::vec(any::<f64>(), 0..900)
                        .prop_map(|all| all.iter().flat_map(|x| x.to_le_bytes()).collect()),
                ],
                1..6,
            ),
            level in 1..4i32,
        ) {
            for content in &contents {
                let bytes = compress(content, level).unwrap();
                prop_assert_eq!(&bytes, &zstd::bulk::compress(content, level).unwrap());
                prop_assert_eq!(&decompress(&bytes, content.len()).unwrap(), content);
                if !content.is_empty() {
                    prop_assert!(decompress(&bytes, content.len() - 1).is_err());
                    prop_assert!(decompress(&bytes[..bytes.len() - 1], content.len()).is_err());
                }
            }
        }
    }
}
