//! The name of a job.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The identity of a job. It has 32 bytes and is shown as 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JobKey(pub [u8; 32]);

impl JobKey {
    /// Computes the key of a job: the BLAKE3 digest of the version of the physics and the canonical
    /// text.
    pub fn of(physics: u32, canonical: &str) -> JobKey {
        let mut hasher = JobKeyHasher::new(physics);
        hasher.update(canonical);
        hasher.key()
    }

    /// Returns the first half of the key. It takes less room and tells 10⁶ jobs apart but for one
    /// chance in 10²⁶.
    pub fn half(&self) -> u128 {
        self.0.first_chunk().map_or(0, |bytes| u128::from_be_bytes(*bytes))
    }
}

/// Computes the key of a job whose canonical text comes in pieces. A clone goes on from what both
/// have in common, which is then hashed once.
#[derive(Clone, Debug)]
pub struct JobKeyHasher(blake3::Hasher);

impl JobKeyHasher {
    /// Begins a key with the version of the physics.
    pub fn new(physics: u32) -> JobKeyHasher {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"tribosweep job ");
        hasher.update(&physics.to_le_bytes());
        JobKeyHasher(hasher)
    }

    /// Adds the next piece of the canonical text.
    pub fn update(&mut self, piece: &str) {
        self.0.update(piece.as_bytes());
    }

    /// Returns the key of the job whose text was added.
    pub fn key(&self) -> JobKey {
        JobKey(*self.0.finalize().as_bytes())
    }
}

/// The error for a text that is not the key of a job.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a job's key: it must be 64 hexadecimal digits")]
pub struct ParseKeyError(pub String);

impl FromStr for JobKey {
    type Err = ParseKeyError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let hash = blake3::Hash::from_hex(text).map_err(|_| ParseKeyError(text.to_owned()))?;
        Ok(JobKey(*hash.as_bytes()))
    }
}

impl fmt::Display for JobKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for JobKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "JobKey({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_survives_its_text_and_other_texts_are_refused() {
        let key = JobKey([0xa7; 32]);
        assert_eq!(key.to_string(), "a7".repeat(32));
        assert_eq!(format!("{key:?}"), format!("JobKey({key})"));
        assert_eq!(key.to_string().parse(), Ok(key));
        assert_eq!(
            "12ab".parse::<JobKey>().unwrap_err().to_string(),
            "`12ab` is not a job's key: it must be 64 hexadecimal digits"
        );
    }

    #[test]
    fn the_version_and_the_text_are_both_in_the_key() {
        let key = JobKey::of(3, "a job");
        assert_eq!(key, JobKey::of(3, "a job"));
        assert_ne!(key, JobKey::of(4, "a job"));
        assert_ne!(key, JobKey::of(3, "another job"));
        let mut hasher = JobKeyHasher::new(3);
        hasher.update("a ");
        let mut other = hasher.clone();
        hasher.update("job");
        other.update("j");
        assert_eq!(hasher.key(), key);
        assert_eq!(other.key(), JobKey::of(3, "a j"));
    }
}
