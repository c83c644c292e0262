//! The manifest says what the store promises to hold. It stands outside the database, so that the
//! database can be checked against it.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::access::{is_damage, read_within};
use crate::digest::Digest;
use crate::durable;

pub(crate) const FILE: &str = "manifest.json";

/// The latest version of the layout of the whole directory.
pub(crate) const FORMAT: u32 = 2;

/// The version of a store without labels, which earlier programs read too.
const UNLABELLED: u32 = 1;

/// The largest manifest that is read \[bytes\]. It has room for half a million studies.
const LIMIT: u64 = 64 << 20;

/// The words that people have put to a study in a store.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyLabels {
    /// Words by which studies are told apart.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub tags: BTreeSet<String>,
    /// A remark.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl StudyLabels {
    /// Returns true if there is neither a tag nor a remark.
    pub fn is_empty(&self) -> bool {
        self.tags.is_empty() && self.note.is_none()
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Manifest {
    format: u32,
    /// A lower bound of the number of durable records, which is exact when the store is closed.
    pub(crate) records: u64,
    /// The blob that holds the definition of each study.
    pub(crate) studies: BTreeMap<String, Digest>,
    /// The labels of the studies that have some.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) labels: BTreeMap<String, StudyLabels>,
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
    /// Makes a manifest. Labels of studies that are not there are left out.
    pub(crate) fn new(
        records: u64,
        studies: BTreeMap<String, Digest>,
        mut labels: BTreeMap<String, StudyLabels>,
    ) -> Self {
        labels.retain(|name, labels| studies.contains_key(name) && !labels.is_empty());
        let format = if labels.is_empty() { UNLABELLED } else { FORMAT };
        Manifest { format, records, studies, labels, checksum: String::new() }
    }

    /// Returns the manifest with another number of records.
    pub(crate) fn promising(&self, records: u64) -> Self {
        Manifest { records, ..self.clone() }
    }

    fn sum(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("tribosweep manifest {} {}\n", self.format, self.records).as_bytes());
        let text = |hasher: &mut blake3::Hasher, text: &str| {
            hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        };
        for (name, digest) in &self.studies {
            text(&mut hasher, name);
            hasher.update(&digest.0);
        }
        for (name, StudyLabels { tags, note }) in &self.labels {
            text(&mut hasher, &format!("labels of {name}"));
            hasher.update(&(tags.len() as u64).to_le_bytes()).update(&[u8::from(note.is_some())]);
            tags.iter().chain(note).for_each(|word| text(&mut hasher, word));
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
            Some(format) if [UNLABELLED, FORMAT].map(u64::from).contains(&format) => {}
            Some(format) => return Err(Unreadable::Format(format)),
            None => return Err(Unreadable::Damaged("it has no format number".to_owned())),
        }
        let manifest: Manifest =
            serde_json::from_value(json).map_err(|e| Unreadable::Damaged(e.to_string()))?;
        if manifest.checksum != manifest.sum() {
            return Err(Unreadable::Damaged("its checksum does not match its content".to_owned()));
        }
        if manifest.format == UNLABELLED && !manifest.labels.is_empty() {
            return Err(Unreadable::Damaged("a store of its format has no labels".to_owned()));
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

    fn example(labels: StudyLabels) -> Manifest {
        let name = "stick zone".to_owned();
        let studies = BTreeMap::from([(name.clone(), Digest([0xab; 32]))]);
        Manifest::new(120, studies, BTreeMap::from([(name, labels)]))
    }

    fn labels() -> StudyLabels {
        let tags = ["draft", "paper"].map(str::to_owned).into();
        StudyLabels { tags, note: Some("compare with 2024".to_owned()) }
    }

    #[test]
    fn golden_text() {
        let text = String::from_utf8(example(StudyLabels::default()).to_json().unwrap()).unwrap();
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
        assert_eq!(
            Manifest::from_json(golden.as_bytes()).unwrap(),
            example(StudyLabels::default())
        );
    }

    #[test]
    fn golden_text_with_labels() {
        let text = String::from_utf8(example(labels()).to_json().unwrap()).unwrap();
        let golden = r#"{
  "format": 2,
  "records": 120,
  "studies": {
    "stick zone": "abababababababababababababababababababababababababababababababab"
  },
  "labels": {
    "stick zone": {
      "tags": [
        "draft",
        "paper"
      ],
      "note": "compare with 2024"
    }
  },
  "checksum": "488dc5f7cf74418006976d60ef8d5d0a"
}
"#;
        assert_eq!(text, golden);
        // A manifest that claims to be of the format before has none.
        let claimed = Manifest { format: UNLABELLED, ..example(labels()) };
        let text = claimed.to_json().unwrap();
        assert!(matches!(Manifest::from_json(&text), Err(Unreadable::Damaged(_))));
    }

    #[test]
    fn labels_of_a_study_that_is_gone_are_forgotten() {
        let Manifest { records, labels, .. } = example(labels());
        let left = Manifest::new(records, BTreeMap::new(), labels);
        assert_eq!((left.format, left.labels.len()), (UNLABELLED, 0));
    }

    #[test]
    fn no_flipped_bit_passes_unnoticed() {
        let text = example(labels()).to_json().unwrap();
        assert_eq!(Manifest::from_json(&text).unwrap(), example(labels()));
        for offset in 0..text.len() {
            for bit in 0..8 {
                let mut flipped = text.clone();
                flipped[offset] ^= 1 << bit;
                // A flip in the white space may leave the same document. Nothing else may be
                // accepted.
                if let Ok(manifest) = Manifest::from_json(&flipped) {
                    assert_eq!(manifest, example(labels()), "byte {offset}, bit {bit}");
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
            Manifest::from_json(br#"{"format": 3, "shards": []}"#),
            Err(Unreadable::Format(3))
        ));
        assert!(matches!(Manifest::from_json(b"{}"), Err(Unreadable::Damaged(_))));
    }
}
