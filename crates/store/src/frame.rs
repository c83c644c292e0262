//! The format of an export: one file that only grows, made of frames.
//!
//! ```text
//! bytes 0..18   "tribosweep export\n"
//! bytes 18..20  format version, 1, little-endian like every number here
//! then frames, each of a head, a table and a body:
//!   bytes 0..8    the mark of a frame
//!   byte  8       kind
//!   bytes 9..12   0
//!   bytes 12..16  length of the table
//!   bytes 16..24  length of the body
//!   bytes 24..40  first 16 bytes of BLAKE3("tribosweep table" ‖ table)
//!   bytes 40..56  first 16 bytes of BLAKE3("tribosweep body" ‖ body)
//!   bytes 56..64  first 8 bytes of BLAKE3("tribosweep frame" ‖ bytes 0..56)
//! ```
//!
//! | kind    | table                                             | body                        |
//! |---------|---------------------------------------------------|-----------------------------|
//! | header  | JSON                                              |                             |
//! | study   | digest of the definition, name                    | zstd of the definition      |
//! | records | key and length of each, 36 bytes                  | zstd of all of them         |
//! | blob    | digest of the content                             | zstd, as a store keeps it   |
//! | note    | bytes of the caller                               |                             |
//! | part    | length of a JSON, a JSON, bytes of the caller     |                             |
//! | end     | number of records, of studies and of blobs        |                             |
//!
//! Whoever makes an index reads heads and tables and seeks over the bodies. A frame that is damaged
//! hides no other: the next one is found by its mark. The end of a file that is being written, or
//! whose writer was killed, is the beginning of a frame.
//!
//! A later format has another mark of its frames, so that a first line that does not fit to its
//! frames is damage, and not one of another format.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

use identity::{JobKey, STORED_LIMIT};

use crate::digest::Digest;

/// The first bytes of every export.
pub(crate) const MAGIC: &[u8; 18] = b"tribosweep export\n";

/// The version of the format that this crate writes.
pub(crate) const EXPORT_FORMAT: u16 = 1;

/// The length of what stands before the first frame \[bytes\].
pub(crate) const PREAMBLE: u64 = 20;

/// The length of the head of a frame \[bytes\].
pub(crate) const HEAD: usize = 64;

/// The first bytes of every frame. The first of them begins no text in UTF-8.
const MARK: [u8; 8] = *b"\x89tsframe";

/// The longest table that is believed \[bytes\].
pub(crate) const TABLE_LIMIT: usize = 1 << 20;

/// The size of the records after which a frame takes up no more \[bytes\]. A record is read by
/// decompressing its frame, and a smaller one would compress less.
pub(crate) const FRAME_TARGET: usize = 128 << 10;

/// The largest number of records in a frame.
pub(crate) const RECORDS_PER_FRAME: usize = 4096;

/// The largest size of the records of a frame together \[bytes\].
pub(crate) const FRAME_LIMIT: usize = FRAME_TARGET + STORED_LIMIT;

/// The size of a record's entry in the table of its frame \[bytes\].
pub(crate) const TABLE_ENTRY: usize = 36;

/// The size of the pieces in which a damaged file is searched for the next frame \[bytes\].
const PIECE: usize = 64 << 10;

/// The kind of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameKind {
    Header = 1,
    Study = 2,
    Records = 3,
    Blob = 4,
    Note = 5,
    Part = 6,
    End = 7,
}

impl FrameKind {
    pub(crate) const ALL: [FrameKind; 7] = [
        FrameKind::Header,
        FrameKind::Study,
        FrameKind::Records,
        FrameKind::Blob,
        FrameKind::Note,
        FrameKind::Part,
        FrameKind::End,
    ];

    fn of(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == byte)
    }
}

/// The first 16 bytes of a BLAKE3 digest.
pub(crate) type Checksum = [u8; 16];

fn hasher(domain: &str) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(domain.as_bytes());
    hasher
}

fn checksum(hasher: &blake3::Hasher) -> Checksum {
    let mut sum = [0; 16];
    sum.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
    sum
}

/// The checksum of a body that is read piece by piece.
pub(crate) struct BodySum(blake3::Hasher);

impl BodySum {
    pub(crate) fn new() -> Self {
        BodySum(hasher("tribosweep body"))
    }

    pub(crate) fn add(&mut self, piece: &[u8]) {
        self.0.update(piece);
    }

    pub(crate) fn get(&self) -> Checksum {
        checksum(&self.0)
    }

    pub(crate) fn of(body: &[u8]) -> Checksum {
        let mut sum = Self::new();
        sum.add(body);
        sum.get()
    }
}

/// The head of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameHead {
    kind: u8,
    pub(crate) table_length: u32,
    pub(crate) body_length: u64,
    table_sum: Checksum,
    pub(crate) body_sum: Checksum,
}

impl FrameHead {
    pub(crate) fn new(kind: FrameKind, table: &[u8], body_length: u64, body_sum: Checksum) -> Self {
        let table_sum = Self::table_sum(table);
        let table_length = table.len() as u32;
        FrameHead { kind: kind as u8, table_length, body_length, table_sum, body_sum }
    }

    fn table_sum(table: &[u8]) -> Checksum {
        checksum(hasher("tribosweep table").update(table))
    }

    /// Returns the kind, or `None` for one that this version does not know.
    pub(crate) fn kind(&self) -> Option<FrameKind> {
        FrameKind::of(self.kind)
    }

    pub(crate) fn to_bytes(self) -> [u8; HEAD] {
        let mut bytes = [0; HEAD];
        bytes[..8].copy_from_slice(&MARK);
        bytes[8] = self.kind;
        bytes[12..16].copy_from_slice(&self.table_length.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.body_length.to_le_bytes());
        bytes[24..40].copy_from_slice(&self.table_sum);
        bytes[40..56].copy_from_slice(&self.body_sum);
        let sum = checksum(hasher("tribosweep frame").update(&bytes[..56]));
        bytes[56..].copy_from_slice(&sum[..8]);
        bytes
    }

    /// Reads a head, or returns `None` if the bytes are none.
    fn of(bytes: &[u8; HEAD]) -> Option<Self> {
        let field = |range: std::ops::Range<usize>| bytes[range].try_into();
        let head = FrameHead {
            kind: bytes[8],
            table_length: u32::from_le_bytes(bytes[12..16].try_into().ok()?),
            body_length: u64::from_le_bytes(bytes[16..24].try_into().ok()?),
            table_sum: field(24..40).ok()?,
            body_sum: field(40..56).ok()?,
        };
        (head.to_bytes() == *bytes).then_some(head)
    }

    /// Returns the length of the whole frame \[bytes\].
    pub(crate) fn frame_length(&self) -> u64 {
        (HEAD as u64).saturating_add(u64::from(self.table_length)).saturating_add(self.body_length)
    }
}

/// A frame whose head and table are sound.
pub(crate) struct ExportFrame {
    /// The place of its head in the file \[bytes\].
    pub(crate) start: u64,
    pub(crate) kind: FrameKind,
    pub(crate) head: FrameHead,
    pub(crate) table: Vec<u8>,
}

impl ExportFrame {
    /// Returns the place of the body in the file \[bytes\].
    pub(crate) fn body_start(&self) -> u64 {
        self.start + HEAD as u64 + u64::from(self.head.table_length)
    }
}

/// A step through the frames of a file.
pub(crate) enum FrameStep {
    Frame(ExportFrame),
    /// Bytes that are no sound frame, described in words.
    Damaged(String),
    /// The beginning of a frame that is not all there, and its length \[bytes\].
    Unfinished(u64),
}

/// A walk through the frames of a file, without their bodies.
pub(crate) struct FrameWalk<'f> {
    file: &'f File,
    /// The length of the file when the walk began \[bytes\].
    length: u64,
    position: u64,
}

impl<'f> FrameWalk<'f> {
    /// Begins at the first frame of a file of `length` bytes.
    pub(crate) fn new(file: &'f File, length: u64) -> Self {
        FrameWalk { file, length, position: PREAMBLE }
    }

    /// Reads the head and the table of the frame at `start`, which had `length` bytes when the file
    /// was read before. Returns `None` if it is not there any more.
    pub(crate) fn frame_at(
        file: &File,
        start: u64,
        length: u64,
    ) -> io::Result<Option<ExportFrame>> {
        let end = start.saturating_add(length);
        let step = FrameWalk { file, length: end, position: start }.next_step()?;
        Ok(match step {
            Some(FrameStep::Frame(frame)) if frame.start == start => {
                (frame.head.frame_length() == length).then_some(frame)
            }
            _ => None,
        })
    }

    /// Returns true if a frame stands where the first one must.
    pub(crate) fn begins_with_frame(&self) -> bool {
        let mut bytes = [0; HEAD];
        self.file.read_exact_at(&mut bytes, PREAMBLE).is_ok() && FrameHead::of(&bytes).is_some()
    }

    /// Returns the next step, or `None` at the end. A file that has become shorter ends where it
    /// does now.
    pub(crate) fn next_step(&mut self) -> io::Result<Option<FrameStep>> {
        let rest = self.length.saturating_sub(self.position);
        match self.step() {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                self.position = self.length;
                Ok(Some(FrameStep::Unfinished(rest)))
            }
            step => step,
        }
    }

    fn step(&mut self) -> io::Result<Option<FrameStep>> {
        let (start, rest) = (self.position, self.length.saturating_sub(self.position));
        if rest == 0 {
            return Ok(None);
        }
        let mut bytes = [0; HEAD];
        let there = bytes.len().min(usize::try_from(rest).unwrap_or(HEAD));
        self.file.read_exact_at(&mut bytes[..there], start)?;
        if there < HEAD {
            let marked = there.min(MARK.len());
            let is_begun =
                bytes[..marked] == MARK[..marked] || bytes[..there] == [0; HEAD][..there];
            self.position = self.length;
            return Ok(Some(match is_begun {
                true => FrameStep::Unfinished(rest),
                false => FrameStep::Damaged(format!("the last {rest} bytes are no frame")),
            }));
        }
        let Some(head) = FrameHead::of(&bytes) else { return self.seek_frame(start).map(Some) };
        if head.frame_length() > rest {
            self.position = self.length;
            return Ok(Some(FrameStep::Unfinished(rest)));
        }
        self.position = start + head.frame_length();
        let damaged = |reason: &str| {
            Ok(Some(FrameStep::Damaged(format!("the frame at byte {start} {reason}"))))
        };
        let Some(kind) = head.kind() else {
            return damaged(&format!("is of kind {}, which this program does not know", head.kind));
        };
        if head.table_length as usize > TABLE_LIMIT {
            return damaged("claims a longer table than any has");
        }
        let mut table = vec![0; head.table_length as usize];
        self.file.read_exact_at(&mut table, start + HEAD as u64)?;
        if FrameHead::table_sum(&table) != head.table_sum {
            return damaged("has a table that differs from what was written");
        }
        Ok(Some(FrameStep::Frame(ExportFrame { start, kind, head, table })))
    }

    /// Searches for the next frame after `start`, where there is none.
    fn seek_frame(&mut self, start: u64) -> io::Result<FrameStep> {
        let mut from = start + 1;
        let mut piece = vec![0; PIECE];
        let mut is_blank = true;
        while from + HEAD as u64 <= self.length {
            let there = PIECE.min(usize::try_from(self.length - from).unwrap_or(PIECE));
            self.file.read_exact_at(&mut piece[..there], from)?;
            for offset in 0..=there - HEAD {
                let window: &[u8] = &piece[offset..offset + HEAD];
                is_blank &= window[0] == 0;
                if window.starts_with(&MARK)
                    && window.try_into().is_ok_and(|bytes| FrameHead::of(bytes).is_some())
                {
                    self.position = from + offset as u64;
                    let lost = self.position - start;
                    return Ok(FrameStep::Damaged(format!(
                        "{lost} bytes from byte {start} on are no frame"
                    )));
                }
            }
            from += (there - HEAD + 1) as u64;
        }
        // A crash of the machine leaves a file that is longer than what reached the disk.
        let (mut first, mut last) = ([0; 1], vec![0; (self.length - from) as usize]);
        self.file.read_exact_at(&mut first, start)?;
        self.file.read_exact_at(&mut last, from)?;
        is_blank &= first == [0] && last.iter().all(|byte| *byte == 0);
        self.position = self.length;
        let lost = self.length - start;
        Ok(match is_blank {
            true => FrameStep::Unfinished(lost),
            false => FrameStep::Damaged(format!(
                "the last {lost} bytes, from byte {start} on, are no frame"
            )),
        })
    }
}

/// The entry of a record in the table of its frame.
pub(crate) struct TableEntry {
    pub(crate) key: JobKey,
    /// The place of the record in the decompressed body \[bytes\].
    pub(crate) offset: u32,
    /// The length of the record \[bytes\].
    pub(crate) length: u32,
}

/// Appends the entry of a record to the table of its frame.
pub(crate) fn add_entry(table: &mut Vec<u8>, key: &JobKey, length: usize) {
    table.extend_from_slice(&key.0);
    table.extend_from_slice(&(length as u32).to_le_bytes());
}

/// Reads the table of a frame of records, or says what is wrong with it.
pub(crate) fn entries_of(table: &[u8]) -> Result<Vec<TableEntry>, String> {
    let (rows, rest) = table.as_chunks::<TABLE_ENTRY>();
    if !rest.is_empty() {
        return Err("has a table that ends within an entry".to_owned());
    }
    let (mut entries, mut offset) = (Vec::with_capacity(rows.len()), 0u32);
    for row in rows {
        let (key, length) = row.split_at(32);
        let length = length.try_into().map_or(u32::MAX, u32::from_le_bytes);
        let end = offset.saturating_add(length);
        if length as usize > STORED_LIMIT || end as usize > FRAME_LIMIT {
            return Err("claims more bytes of records than a frame may have".to_owned());
        }
        let mut bytes = [0; 32];
        bytes.copy_from_slice(key);
        entries.push(TableEntry { key: JobKey(bytes), offset, length });
        offset = end;
    }
    Ok(entries)
}

/// Decompresses the records of a frame whose table has `entries`, or says what is wrong with it.
pub(crate) fn content_of(entries: &[TableEntry], body: &[u8]) -> Result<Vec<u8>, String> {
    let length = entries.last().map_or(0, |last| last.offset as usize + last.length as usize);
    if length == 0 {
        return Ok(Vec::new());
    }
    let content = zstd::bulk::decompress(body, length)
        .map_err(|error| format!("has records that cannot be decompressed: {error}"))?;
    match content.len() == length {
        true => Ok(content),
        false => Err("has fewer bytes than its table says".to_owned()),
    }
}

/// Splits the digest from the front of a table.
pub(crate) fn digest_of(table: &[u8]) -> Result<(Digest, &[u8]), String> {
    let (digest, rest) = table.split_first_chunk::<32>().ok_or("has a table without a digest")?;
    Ok((Digest(*digest), rest))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use proptest::prelude::*;

    use super::*;

    fn frame(kind: FrameKind, table: &[u8], body: &[u8]) -> Vec<u8> {
        let head = FrameHead::new(kind, table, body.len() as u64, BodySum::of(body));
        [&head.to_bytes()[..], table, body].concat()
    }

    fn steps(bytes: &[u8]) -> Vec<FrameStep> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[0; PREAMBLE as usize]).unwrap();
        file.write_all(bytes).unwrap();
        let mut walk = FrameWalk::new(&file, PREAMBLE + bytes.len() as u64);
        std::iter::from_fn(|| walk.next_step().unwrap()).collect()
    }

    fn words(steps: &[FrameStep]) -> Vec<String> {
        let word = |step: &FrameStep| match step {
            FrameStep::Frame(frame) => format!("{:?} {:?}", frame.kind, frame.table),
            FrameStep::Damaged(reason) => format!("damaged: {reason}"),
            FrameStep::Unfinished(length) => format!("unfinished: {length}"),
        };
        steps.iter().map(word).collect()
    }

    #[test]
    fn golden_bytes() {
        let hex: String =
            frame(FrameKind::Note, b"12", b"").iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(
            hex,
            "8974736672616d6505000000020000000000000000000000dc361875a1bd72d1ab417f9578678f3c8328b0bf0bf5ddec8e79f9c514f889adc9fb9657ba1d90a93132"
        );
    }

    #[test]
    fn a_damaged_frame_hides_no_other() {
        let frames = [1, 2, 3].map(|i| frame(FrameKind::Note, &[i; 5], &[i; 200]));
        let mut bytes = frames.concat();
        assert_eq!(words(&steps(&bytes)).len(), 3);
        let second = frames[0].len();
        bytes[second + 30] ^= 1;
        let found = words(&steps(&bytes));
        assert_eq!(found[0], "Note [1, 1, 1, 1, 1]");
        assert_eq!(found[1], "damaged: 269 bytes from byte 289 on are no frame");
        assert_eq!(found[2], "Note [3, 3, 3, 3, 3]");
        bytes[second + 30] ^= 1;
        bytes[second + HEAD] ^= 1;
        let found = words(&steps(&bytes));
        assert!(found[1].contains("has a table that differs"), "{found:?}");
        assert_eq!(found[2], "Note [3, 3, 3, 3, 3]");
        // What is blank was never written.
        let found = words(&steps(&[&frames[0][..], &[0; 100_000]].concat()));
        assert_eq!(found[1], "unfinished: 100000");
        let found = words(&steps(&[&frames[0][..], &[7; 100_000]].concat()));
        assert_eq!(found[1], "damaged: the last 100000 bytes, from byte 289 on, are no frame");
    }

    #[test]
    fn a_file_that_has_become_shorter_ends_there() {
        let frames = [1, 2].map(|i| frame(FrameKind::Note, &[i; 500], &[i; 200])).concat();
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[0; PREAMBLE as usize]).unwrap();
        file.write_all(&frames).unwrap();
        let length = PREAMBLE + frames.len() as u64;
        let half = length - frames.len() as u64 / 2;
        // Between two frames, in a head, in a table, and where there was damage to begin with.
        for shorter in [half, half + 10, half + 100, 0] {
            let mut walk = FrameWalk::new(&file, length);
            file.set_len(shorter).unwrap();
            let steps: Vec<_> = std::iter::from_fn(|| walk.next_step().unwrap())
                .map(|step| words(&[step]))
                .collect();
            let is_unfinished = |words: &Vec<String>| words[0].starts_with("unfinished: ");
            assert!(steps.last().is_some_and(is_unfinished), "{shorter}: {steps:?}");
            assert_eq!(steps.len(), if shorter == 0 { 1 } else { 2 });
            file.set_len(0).unwrap();
            file.write_all_at(&frames, PREAMBLE).unwrap();
        }
        let mut walk = FrameWalk::new(&file, length);
        file.write_all_at(&[7], PREAMBLE).unwrap();
        file.set_len(length - 5).unwrap();
        let first = words(&[walk.next_step().unwrap().unwrap()]);
        assert_eq!(first, ["unfinished: 1528"]);
    }

    #[test]
    fn a_claim_of_more_than_there_is_allocates_nothing() {
        let head = |table_length: u32, body_length: u64| FrameHead {
            table_length,
            body_length,
            ..FrameHead::new(FrameKind::Note, &[], 0, BodySum::of(&[]))
        };
        for head in [head(0, 1 << 60), head(0, u64::MAX), head(u32::MAX, 0)] {
            assert_eq!(words(&steps(&head.to_bytes())), ["unfinished: 64"]);
        }
        // The table is there, and longer than any that was ever written.
        let long = [&head(2 << 20, 0).to_bytes()[..], &vec![0; 2 << 20]].concat();
        assert!(words(&steps(&long))[0].contains("claims a longer table"));
        let mut table = Vec::new();
        add_entry(&mut table, &JobKey([1; 32]), STORED_LIMIT + 1);
        assert!(entries_of(&table).is_err());
        let many = table.len() * 3;
        table.truncate(0);
        while table.len() < many {
            add_entry(&mut table, &JobKey([1; 32]), STORED_LIMIT);
        }
        assert!(entries_of(&table).is_err());
        assert!(entries_of(&table[1..]).is_err());
    }

    proptest! {
        #[test]
        fn every_flipped_bit_and_every_torn_tail_is_found(
            table in proptest::collection::vec(any::<u8>(), 0..50), body in proptest::collection::vec(any::<u8>(), 0..100),
            place in any::<prop::sample::Index>(), bit in 0..8u8,
        ) {
            let (first, last) = (frame(FrameKind::Note, b"first", b""), frame(FrameKind::Blob, &table, &body));
            let whole = [&first[..], &last].concat();
            let cut = place.index(last.len());
            let torn = words(&steps(&whole[..first.len() + cut]));
            let expected = if cut == 0 { vec![] } else { vec![format!("unfinished: {cut}")] };
            prop_assert_eq!(&torn[1..], &expected[..]);
            let mut flipped = whole.clone();
            flipped[first.len() + cut] ^= 1 << bit;
            match steps(&flipped).remove(1) {
                FrameStep::Frame(frame) => {
                    let start = (frame.body_start() - PREAMBLE) as usize;
                    prop_assert!(first.len() + cut >= start);
                    prop_assert_ne!(BodySum::of(&flipped[start..]), frame.head.body_sum);
                }
                FrameStep::Damaged(_) => {}
                FrameStep::Unfinished(_) => prop_assert!(false, "taken for unfinished"),
            }
        }
    }
}
