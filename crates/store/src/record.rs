//! A record lies in the database sealed, with a format version and a checksum that binds it to its
//! key.
//!
//! ```text
//! byte 0        format version, 1
//! bytes 1..17   first 16 bytes of BLAKE3("tribosweep record" ‖ version ‖ key ‖ payload)
//! bytes 17..    payload: the encoded record, which carries its own schema version
//! ```
//! The key is part of the checksum, so a record that sled returns under a wrong key is detected.

use identity::JobKey;

const VERSION: u8 = 1;
const HEADER: usize = 17;

/// The reason why sealed bytes do not open.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Unsealable {
    /// A version of this crate wrote them that this one does not know.
    Version(u8),
    /// The bytes differ from those that were written.
    Corrupt(&'static str),
}

fn checksum(version: u8, key: &JobKey, payload: &[u8]) -> [u8; 16] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"tribosweep record").update(&[version]).update(&key.0).update(payload);
    let mut sum = [0; 16];
    sum.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
    sum
}

pub(crate) fn seal(key: &JobKey, payload: &[u8]) -> Vec<u8> {
    let mut sealed = Vec::with_capacity(HEADER + payload.len());
    sealed.push(VERSION);
    sealed.extend_from_slice(&checksum(VERSION, key, payload));
    sealed.extend_from_slice(payload);
    sealed
}

pub(crate) fn unseal<'a>(key: &JobKey, sealed: &'a [u8]) -> Result<&'a [u8], Unsealable> {
    let (header, payload) =
        sealed.split_at_checked(HEADER).ok_or(Unsealable::Corrupt("shorter than its header"))?;
    // The checksum is checked first, because a version counts only if it is what was written.
    if header[1..] != checksum(header[0], key, payload) {
        return Err(Unsealable::Corrupt("its checksum does not match"));
    }
    if header[0] != VERSION {
        return Err(Unsealable::Version(header[0]));
    }
    Ok(payload)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const KEY: JobKey = JobKey([7; 32]);

    #[test]
    fn golden_bytes() {
        let hex: String = seal(&KEY, b"Hertz").iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, "0105b395aaadf5dcacac0a01afd0062e28486572747a");
    }

    #[test]
    fn a_later_version_is_named_and_not_called_corrupt() {
        let mut sealed = vec![2];
        sealed.extend_from_slice(&checksum(2, &KEY, b"Hertz"));
        sealed.extend_from_slice(b"Hertz");
        assert_eq!(unseal(&KEY, &sealed), Err(Unsealable::Version(2)));
    }

    #[test]
    fn a_record_under_another_key_does_not_open() {
        assert!(matches!(
            unseal(&JobKey([8; 32]), &seal(&KEY, b"Hertz")),
            Err(Unsealable::Corrupt(_))
        ));
    }

    proptest! {
        #[test]
        fn every_flipped_bit_and_every_truncation_is_found(
            payload in proptest::collection::vec(any::<u8>(), 0..200), place in any::<prop::sample::Index>(), bit in 0..8u8,
        ) {
            let sealed = seal(&KEY, &payload);
            prop_assert_eq!(unseal(&KEY, &sealed), Ok(&payload[..]));
            let offset = place.index(sealed.len());
            let mut flipped = sealed.clone();
            flipped[offset] ^= 1u8 << bit;
            prop_assert!(matches!(unseal(&KEY, &flipped), Err(Unsealable::Corrupt(_))));
            prop_assert!(matches!(unseal(&KEY, &sealed[..offset]), Err(Unsealable::Corrupt(_))));
        }
    }
}
