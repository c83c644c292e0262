//! The rules by which the records of several machines become one: what a record refers to, and what
//! two machines must agree on.

use identity::KeptFields;
use serde::{Deserialize, Serialize};
use store::{Blobs, Digest, Examination, MergeRules, RecordRank, References};
use study::encoding::DecodeError;
use study::{Record, Standing, Study};

/// The rules of this program.
pub(crate) const RULES: MergeRules = MergeRules {
    examine: |key, bytes| match Record::decode(bytes) {
        Ok(record) if record.key() == *key => {
            let rank = match record.standing() {
                Standing::Certified | Standing::Failed => RecordRank::Finished,
                Standing::Quarantined => RecordRank::Unfinished,
            };
            Ok(Examination { rank, references: references(&record) })
        }
        Ok(_) => Err("it is the record of another job".to_owned()),
        // The record is sound for the version of the program that wrote it.
        Err(DecodeError::Version { .. }) => {
            Ok(Examination { rank: RecordRank::Foreign, references: References::default() })
        }
        Err(error) => Err(error.to_string()),
    },
    fingerprint: |bytes| {
        let Ok(mut record) = Record::decode(bytes) else { return Digest::of(bytes) };
        // Equal fields may be kept in a file here and in the record there.
        if let Some(Ok(digest)) = record.fields.as_ref().map(Blobs::kept_digest) {
            record.fields = Some(KeptFields::Blob(digest.0));
        }
        Digest::of(&record.result_bytes())
    },
    definition: |bytes| match Study::definition_content(bytes) {
        Some(content) => Digest::of(&content),
        None => Digest::of(bytes),
    },
    progress: |bytes| match ShardNote::of(bytes) {
        Some(note) if note.finished => u64::MAX,
        Some(note) => note.done + note.failed,
        None => 0,
    },
    unfinished: |bytes| match ShardNote::of(bytes) {
        Some(note) if note.finished => ShardNote { finished: false, ..note }.to_bytes(),
        _ => bytes.to_vec(),
    },
};

/// Returns the files that a record refers to: it needs its fields, and the account of its run only
/// goes along with it.
pub(crate) fn references(record: &Record) -> References {
    let needed = match record.fields {
        Some(KeptFields::Blob(digest)) => vec![Digest(digest)],
        Some(KeptFields::Inside(_)) | None => Vec::new(),
    };
    let companions = record.provenance.run.map(Digest).into_iter().collect();
    References { needed, companions }
}

/// The largest number of jobs of a shard that is believed. The sum over all shards that may be is
/// a number, too.
const MOST_JOBS: u64 = 1 << 40;

/// The note that a shard leaves in its export.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ShardNote {
    /// The jobs that the shard is known to have.
    pub(crate) jobs: u64,
    /// The jobs that are solved.
    pub(crate) done: u64,
    /// The jobs that have ended without a solution.
    pub(crate) failed: u64,
    /// The jobs without a result.
    pub(crate) left: u64,
    /// True if the shard has nothing more to do.
    pub(crate) finished: bool,
    /// The path of the study's file as it was given.
    pub(crate) file: Option<String>,
    /// The digest of the partition; shards of different ones may leave out points.
    pub(crate) partition: Option<String>,
}

impl ShardNote {
    /// Reads a note; `None` if it is none that this program knows.
    pub(crate) fn of(bytes: &[u8]) -> Option<Self> {
        let note: Self = serde_json::from_slice(bytes).ok()?;
        let possible = |number: u64| number.min(MOST_JOBS);
        Some(Self {
            jobs: possible(note.jobs),
            done: possible(note.done),
            failed: possible(note.failed),
            left: possible(note.left),
            ..note
        })
    }

    /// Returns the bytes of the note.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("a note is plain data")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_read_leniently() {
        let note = ShardNote::of(br#"{"done": 3, "finished": true, "later": [1]}"#).unwrap();
        assert_eq!(note, ShardNote { done: 3, finished: true, ..ShardNote::default() });
        assert_eq!(ShardNote::of(b"{}"), Some(ShardNote::default()));
        assert_eq!(ShardNote::of(b"done"), None);
        let progress = RULES.progress;
        assert_eq!(progress(br#"{"done": 3, "failed": 1}"#), 4);
        assert!(progress(br#"{"finished": true}"#) > progress(br#"{"done": 300}"#));
        assert_eq!(progress(b"done"), 0);
        // No figure of a note overflows a sum, and none is further than the end.
        let huge = format!(r#"{{"done": {0}, "failed": {0}, "left": {0}}}"#, u64::MAX);
        assert!(progress(huge.as_bytes()) < progress(br#"{"finished": true}"#));
        let note = ShardNote::of(huge.as_bytes()).unwrap();
        let shard = note.jobs + note.done + note.failed + note.left;
        assert!(shard.checked_mul(store::SHARD_LIMIT.into()).is_some());
        let reopened = (RULES.unfinished)(br#"{"done": 3, "finished": true}"#);
        assert_eq!(ShardNote::of(&reopened), Some(ShardNote { done: 3, ..ShardNote::default() }));
        assert_eq!((RULES.unfinished)(b"done"), b"done");
    }

    #[test]
    fn fields_are_the_same_wherever_they_are_kept() {
        let directory = tempfile::tempdir().unwrap();
        let store = store::Store::open(directory.path()).unwrap();
        let record = |fields| study::Record {
            physics: 1,
            job: "a job".to_owned(),
            ending: study::Ending::Quarantined { reason: "a reason".to_owned(), attempts: 3 },
            fields: Some(fields),
            provenance: study::Provenance::default(),
        };
        let inside = store.blobs().keep(&[7; 100]).unwrap();
        assert!(matches!(inside, KeptFields::Inside(_)));
        let fingerprint = |fields| (RULES.fingerprint)(&record(fields).encode());
        let in_file = |content: &[u8]| KeptFields::Blob(Digest::of(content).0);
        assert_eq!(fingerprint(inside.clone()), fingerprint(in_file(&[7; 100])));
        assert_ne!(fingerprint(inside), fingerprint(in_file(&[8; 100])));
    }

    #[test]
    fn records_have_a_rank_and_are_bound_to_their_job() {
        let record = study::Record {
            physics: 1,
            job: "a job".to_owned(),
            ending: study::Ending::Quarantined { reason: "a reason".to_owned(), attempts: 3 },
            fields: Some(KeptFields::Blob([7; 32])),
            provenance: study::Provenance::default(),
        };
        let examine = |key: &identity::JobKey, bytes: &[u8]| (RULES.examine)(key, bytes);
        let found = examine(&record.key(), &record.encode()).unwrap();
        assert_eq!(found.rank, RecordRank::Unfinished);
        assert_eq!(found.references, vec![Digest([7; 32])].into());
        let mut with_run = record.clone();
        with_run.provenance.run = Some([8; 32]);
        assert_eq!(references(&with_run).companions, [Digest([8; 32])]);
        assert_eq!((RULES.fingerprint)(&with_run.encode()), (RULES.fingerprint)(&record.encode()));
        let other = identity::JobKey([1; 32]);
        let reason = examine(&other, &record.encode()).unwrap_err();
        assert_eq!(reason, "it is the record of another job");
        assert_eq!(examine(&other, &[1, 1]).unwrap().rank, RecordRank::Foreign);
        assert!(examine(&other, &record.encode()[..9]).is_err());
    }

    #[test]
    fn a_definition_is_the_same_wherever_its_file_is() {
        let text = "name = \"x\"\n[scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson \
                    = 0.3 }\npunch = { shape = \"sphere\", radius = \"1 mm\" }\nloading.steps = [{ \
                    approach = \"1 um\" }]\n[numerics]\nmesh = 6\n";
        let study = |path: &str, text: &str| {
            Study::parse(text, path, &mut |_| Err("there are none".to_owned()))
                .unwrap()
                .definition()
        };
        let (here, there) = (study("x.toml", text), study("/home/x.toml", text));
        assert_ne!(here, there);
        assert_eq!((RULES.definition)(&here), (RULES.definition)(&there));
        let other = study("x.toml", &text.replace("mesh = 6", "mesh = 8"));
        assert_ne!((RULES.definition)(&here), (RULES.definition)(&other));
        assert_ne!((RULES.definition)(b"rubbish"), (RULES.definition)(b"other"));
    }
}
