//! This folder reads exports: one file, or a directory of them that counts as one store. It knows
//! frames and nothing of stores.

mod file;
mod index;
mod set;
mod shard;
mod summary;

pub(crate) use self::file::{EXTENSION, ExportFile, FileIdentity, open_export};
pub(crate) use self::set::{CompressedBlob, ExportSet, are_there, exports_at};
pub use self::shard::{SHARD_LIMIT, ShardName, ShardState};
pub(crate) use self::shard::{part_table, require_possible};
pub use self::summary::{ExportHeader, ExportSummary};

#[cfg(test)]
mod tests {
    use std::io::Write;

    use identity::JobKey;
    use proptest::prelude::*;

    use super::*;
    use crate::blob::Blobs;
    use crate::digest::Digest;
    use crate::frame::{BodySum, EXPORT_FORMAT, FrameHead, FrameKind, MAGIC};

    fn export(frames: &[(FrameKind, Vec<u8>, Vec<u8>)]) -> tempfile::NamedTempFile {
        let mut file = tempfile::Builder::new().suffix(".tribosweep").tempfile().unwrap();
        file.write_all(MAGIC).unwrap();
        file.write_all(&EXPORT_FORMAT.to_le_bytes()).unwrap();
        for (kind, table, body) in frames {
            let head = FrameHead::new(*kind, table, body.len() as u64, BodySum::of(body));
            file.write_all(&[&head.to_bytes()[..], table, body].concat()).unwrap();
        }
        file
    }

    /// Reads everything that an export claims to have.
    fn read(file: &tempfile::NamedTempFile) -> ExportSummary {
        let set = ExportSet::open(file.path(), None).unwrap().unwrap();
        let _ = set.keys().map(|keys| set.first(&keys, 1 << 20));
        let _ = (set.faults_of_replaced(), set.studies(|_| None));
        let blobs = Blobs::in_exports(set.clone());
        for digest in set.files[0].blobs.keys() {
            assert!(blobs.get(digest).is_err());
        }
        set.files[0].summary.clone()
    }

    #[test]
    fn claims_in_sound_tables_are_not_believed() {
        let entry = |length: u32| [&[7; 32][..], &length.to_le_bytes()].concat();
        let bomb = zstd::bulk::compress(&vec![0; 64 << 20], 3).unwrap();
        let shard = br#"{"study":"s","index":3,"count":2}"#;
        let part = [&(shard.len() as u32).to_le_bytes()[..], shard].concat();
        for (kind, table, body) in [
            (FrameKind::Records, entry(u32::MAX), vec![]),
            (FrameKind::Records, entry(5).repeat(30_000), vec![]),
            (
                FrameKind::Header,
                br#"{"program":"x","shard":{"study":"s","index":0,"count":0}}"#.to_vec(),
                vec![],
            ),
            (
                FrameKind::Header,
                br#"{"program":"x","shard":{"study":"s","index":1,"count":4294967295}}"#.to_vec(),
                vec![],
            ),
            (FrameKind::Header, b"[]".to_vec(), vec![]),
            (FrameKind::Study, vec![7; 31], vec![]),
            (FrameKind::Study, vec![0xff; 40], vec![]),
            (FrameKind::Blob, vec![], vec![]),
            (FrameKind::Part, u32::MAX.to_le_bytes().to_vec(), vec![]),
            (FrameKind::Part, part, vec![]),
            (FrameKind::End, vec![9; 24], vec![]),
            (FrameKind::End, vec![9; 3], vec![]),
        ] {
            let frames =
                [(FrameKind::Header, b"{\"program\":\"x\"}".to_vec(), vec![]), (kind, table, body)];
            let summary = read(&export(&frames));
            assert_eq!(summary.damage.len(), 1, "{summary:?}");
        }
        // What a body decompresses to is bounded by its table.
        let set = export(&[(FrameKind::Records, entry(5), bomb.clone())]);
        let set = ExportSet::open(set.path(), None).unwrap().unwrap();
        let answer = set.first(&[JobKey([7; 32])], 1 << 20).unwrap().remove(0).unwrap_err();
        assert!(answer.to_string().contains("is damaged"), "{answer}");
        let set = export(&[(FrameKind::Blob, vec![7; 32], bomb)]);
        let set = ExportSet::open(set.path(), None).unwrap().unwrap();
        assert!(Blobs::in_exports(set).get(&Digest([7; 32])).is_err());
    }

    proptest! {
        #[test]
        fn arbitrary_tables_never_panic(
            frames in proptest::collection::vec(
                (0..FrameKind::ALL.len(), proptest::collection::vec(any::<u8>(), 0..120), proptest::collection::vec(any::<u8>(), 0..40)), 0..6),
        ) {
            let frames: Vec<_> =
                frames.into_iter().map(|(kind, table, body)| (FrameKind::ALL[kind], table, body)).collect();
            read(&export(&frames));
        }
    }
}
