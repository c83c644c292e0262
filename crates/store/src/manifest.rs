//! The manifest says what the store promises to hold. It stands outside the database, so that the
//! database can be checked against it.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::access::{is_damage, read_within};
use crate::digest::Digest;
use crate::durable;

pub(crate) const FILE: &str = "manifest.json";

/// The version of the layout of the whole directory that this crate writes.
pub(crate) const FORMAT: u32 = 1;

/// The largest manifest that is read \[bytes\]. It has room for half a million studies.
const LIMIT: u64 = 64 << 20;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Manifest {
    pub(crate) format: u32,
    /// A lower bound of the number of durable records, which is exact when the store is closed.
    pub(crate) records: u64,
    /// The blob that holds the definition of each study.
    pub(crate) studies: BTreeMap<String, Digest>,
    /// The checksum of the other fields, so that a damaged count does not pass for a count.
    checksum: String,
}

/// The reason why the manifest cannot be read.
#[derive(Debug)]
pub(crate) enum Unreadable {
    Absent,
    Format(u64),
    Damaged(String),
    Io(io::Error),
}

impl Manifest {
    pub(crate) fn new(records: u64, studies: BTreeMap<String, Digest>) -> Self {
        Manifest { format: FORMAT, records, studies, checksum: String::new() }
    }

    fn sum(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("tribosweep manifest {} {}\n", self.format, self.records).as_bytes());
        for (name, digest) in &self.studies {
            hasher
                .update(&(name.len() as u64).to_le_bytes())
                .update(name.as_bytes())
                .update(&digest.0);
        }
        hasher.finalize().to_hex()[..32].to_owned()
    }

    fn to_json(&self) -> io::Result<Vec<u8>> {
        let sealed = Manifest { checksum: self.sum(), ..self.clone() };
        let mut text = serde_json::to_vec_pretty(&sealed)?;
        text.push(b'\n');
        Ok(text)
    }

    fn from_json(text: &[u8]) -> Result<Self, Unreadable> {
        // The format is checked first, because a later one may have any other fields.
        let json: serde_json::Value =
            serde_json::from_slice(text).map_err(|e| Unreadable::Damaged(e.to_string()))?;
        match json.get("format").and_then(serde_json::Value::as_u64) {
            Some(format) if format == u64::from(FORMAT) => {}
            Some(format) => return Err(Unreadable::Format(format)),
            None => return Err(Unreadable::Damaged("it has no format number".to_owned())),
        }
        let manifest: Manifest =
            serde_json::from_value(json).map_err(|e| Unreadable::Damaged(e.to_string()))?;
        if manifest.checksum != manifest.sum() {
            return Err(Unreadable::Damaged("its checksum does not match its content".to_owned()));
        }
        Ok(Manifest { checksum: String::new(), ..manifest })
    }

    pub(crate) fn read(store: &Path) -> Result<Self, Unreadable> {
        match read_within(&store.join(FILE), LIMIT) {
            Ok(text) => Self::from_json(&text),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Err(Unreadable::Absent),
            Err(error) if is_damage(&error) => Err(Unreadable::Damaged(error.to_string())),
            Err(error) => Err(Unreadable::Io(error)),
        }
    }

    /// Replaces the manifest of the store durably.
    pub(crate) fn write(&self, store: &Path) -> io::Result<()> {
        durable::write(&store.join(FILE), &self.to_json()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Manifest {
        Manifest::new(120, BTreeMap::from([("stick zone".to_owned(), Digest([0xab; 32]))]))
    }

    #[test]
    fn golden_text() {
        let text = String::from_utf8(example().to_json().unwrap()).unwrap();
        let golden = r#"{
  "format": 1,
  "records": 120,
  "studies": {
    "stick zone": "abababababababababababababababababababababababababababababababab"
  },
  "checksum": "9b9eba565522b67753b60e9ec55f79a3"
}
"#;
        assert_eq!(text, golden);
    }

    #[test]
    fn no_flipped_bit_passes_unnoticed() {
        let text = example().to_json().unwrap();
        assert_eq!(Manifest::from_json(&text).unwrap(), example());
        for offset in 0..text.len() {
            for bit in 0..8 {
                let mut flipped = text.clone();
                flipped[offset] ^= 1 << bit;
                // A flip in the white space may leave the same document. Nothing else may be
                // accepted.
                if let Ok(manifest) = Manifest::from_json(&flipped) {
                    assert_eq!(manifest, example(), "byte {offset}, bit {bit}");
                }
            }
            assert!(
                offset + 1 == text.len() || Manifest::from_json(&text[..offset]).is_err(),
                "truncated to {offset}"
            );
        }
    }

    #[test]
    fn a_later_format_is_named_whatever_else_it_holds() {
        assert!(matches!(
            Manifest::from_json(br#"{"format": 2, "shards": []}"#),
            Err(Unreadable::Format(2))
        ));
        assert!(matches!(Manifest::from_json(b"{}"), Err(Unreadable::Damaged(_))));
    }
}
