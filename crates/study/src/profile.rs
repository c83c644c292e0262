//! Profiles of wheels and rails, which are read from SIMPACK files and kept as blobs under the hash
//! of their content.

use contact::punch::{Profile, ProfileError, ProfileKind};

use crate::encoding::{DecodeError, decode, encode};

/// The longest profile that is believed \[bytes\]; a corrupt length must not allocate.
const LIMIT: usize = 16 << 20;

/// The reason why a file holds no profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileFileError {
    /// The content breaks the rules of the format.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A stored profile does not decode.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The content is no text.
    #[error("it is not text: it must be a profile in SIMPACK's format, .prw or .prr")]
    NotText,
}

/// Reads a profile from SIMPACK's text, or from the bytes that [`encode_profile`] wrote; no text
/// begins like those.
///
/// # Errors
///
/// Returns an error if the bytes are neither.
pub fn read(bytes: &[u8]) -> Result<Profile, ProfileFileError> {
    if bytes.first().is_some_and(|byte| *byte < b'\t') {
        return Ok(decode_profile(bytes)?);
    }
    let text = std::str::from_utf8(bytes).map_err(|_| ProfileFileError::NotText)?;
    Ok(Profile::from_simpack(text.strip_prefix('\u{feff}').unwrap_or(text))?)
}

/// Returns the name of a profile in jobs and stores: the BLAKE3 hash of its bytes, in hexadecimal.
pub fn name(profile: &Profile) -> String {
    blake3::hash(&encode_profile(profile)).to_hex().to_string()
}

/// Returns the bytes of a profile.
pub fn encode_profile(profile: &Profile) -> Vec<u8> {
    encode(&(profile.kind() == ProfileKind::Wheel, profile.curve().points()))
}

/// Reads the bytes that [`encode_profile`] wrote.
///
/// # Errors
///
/// Returns an error if the bytes do not decode, or if their points are no profile.
pub fn decode_profile(bytes: &[u8]) -> Result<Profile, DecodeError> {
    const ITEM: &str = "the profile";
    let (is_wheel, points) = decode::<(bool, Vec<[f64; 2]>), LIMIT>(ITEM, bytes)?;
    let kind = if is_wheel { ProfileKind::Wheel } else { ProfileKind::Rail };
    Profile::from_points(kind, points)
        .map_err(|error| DecodeError::Malformed { item: ITEM, reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const WHEEL: &[u8] = include_bytes!("../../../sweeps/profiles/MBench_S1002_v3.prw");

    #[test]
    fn stored_profiles_are_those_of_the_file() {
        let wheel = read(WHEEL).unwrap();
        assert_eq!(wheel.kind(), ProfileKind::Wheel);
        let stored = read(&encode_profile(&wheel)).unwrap();
        assert_eq!((name(&stored), &stored), (name(&wheel), &wheel));
        let text = String::from_utf8(WHEEL.to_vec()).unwrap();
        let remarked = format!("! a remark\n{text}");
        assert_eq!(
            read(remarked.as_bytes()).map(|profile| name(&profile)).ok(),
            Some(name(&wheel)),
            "the content counts"
        );
        assert!(read(b"\xff\xfe").unwrap_err().to_string().contains("not text"));
        assert!(read(b"").is_err());
        assert!(decode_profile(&encode(&(true, vec![[0.0, f64::NAN]; 4]))).is_err());
    }

    proptest! {
        #[test]
        fn damaged_profiles_never_panic(
            at in any::<prop::sample::Index>(),
            byte: u8,
            cut in any::<prop::sample::Index>(),
        ) {
            for mut bytes in [WHEEL.to_vec(), encode_profile(&read(WHEEL).unwrap())] {
                let at = at.index(bytes.len());
                bytes[at] = byte;
                let _ = read(&bytes);
                bytes.truncate(cut.index(bytes.len()));
                let _ = read(&bytes);
            }
        }
    }
}
