//! This file writes exports: it starts one, or goes on with what is sound of an earlier one.
//!
//! Writing takes no locks and maps no memory, and nothing is written but at the end of the file, so
//! an export may lie on a parallel file system.

mod appender;
mod error;

use std::collections::HashMap;
use std::path::Path;

use identity::JobKey;

use crate::blob::Blobs;
use crate::digest::Digest;
use crate::durable;
use crate::error::OpenError;
use crate::exports::{ExportHeader, ExportSet, open_export};
use crate::frame::{Checksum, FrameKind, FrameStep, FrameWalk};

use self::appender::short_digest;
pub(crate) use self::appender::{ExportAppender, directory_of};
pub use self::error::ExportError;

/// An export that is being written. Records are gathered into frames, which are written when they
/// are large enough or by [`flush`](ExportWriter::flush).
pub struct ExportWriter {
    appender: ExportAppender,
    /// The beginning of the digest of the last record of each job.
    records_of: HashMap<JobKey, Checksum>,
    damage: Vec<String>,
}

fn described(header: &ExportHeader) -> String {
    header
        .shard
        .as_ref()
        .map_or_else(|| "an export that is not of a shard".to_owned(), ToString::to_string)
}

impl ExportWriter {
    /// Starts the file, or goes on with it: what is sound of an existing file is copied into a new
    /// one that takes its place. So a writer that still lives elsewhere writes to a file without a
    /// name, and finds that out when it flushes. The earlier note is not copied. The directory is
    /// created if it is absent.
    ///
    /// # Errors
    /// [`ExportError::Name`] if the name does not end as it must, [`ExportError::OtherShard`] if
    /// the file is that of another shard, [`ExportError::Open`] if it is one of another format or
    /// no file, and others if the system refuses. A file that is no export is put aside, as
    /// [`damage`](ExportWriter::damage) says.
    pub fn open(path: &Path, header: &ExportHeader) -> Result<ExportWriter, ExportError> {
        let appender = ExportAppender::beside(path, header)?;
        let mut writer = ExportWriter { appender, records_of: HashMap::new(), damage: Vec::new() };
        if durable::is_present(path) {
            writer.take_over(path, header)?;
        }
        writer.appender.settle()?;
        Ok(writer)
    }

    /// Copies what is sound of an earlier export.
    fn take_over(&mut self, path: &Path, header: &ExportHeader) -> Result<(), ExportError> {
        let failed = |source| ExportError::io("go on with", path, source);
        let (earlier, damage) = match open_export(path) {
            // What is there is kept, and is in nobody's way.
            Err(OpenError::NotAnExport { reason, .. }) if durable::is_file(path) => {
                let aside = durable::put_aside(path).map_err(failed)?;
                let aside = aside.unwrap_or_default();
                let aside = aside.file_name().unwrap_or_default().to_string_lossy();
                self.damage.push(format!(
                    "what was there is no export ({reason}) and is put aside as {aside}"
                ));
                return Ok(());
            }
            opened => opened?,
        };
        self.damage.extend(damage);
        let length = earlier.metadata().map_err(failed)?.len();
        let mut walk = FrameWalk::new(&earlier, length);
        while let Some(step) = walk.next_step().map_err(failed)? {
            let frame = match step {
                FrameStep::Frame(frame) => frame,
                FrameStep::Damaged(reason) => {
                    self.damage.push(reason);
                    continue;
                }
                FrameStep::Unfinished(_) => continue,
            };
            match frame.kind {
                FrameKind::Header => {
                    let Ok(found) = serde_json::from_slice::<ExportHeader>(&frame.table) else {
                        continue;
                    };
                    if found.shard != header.shard {
                        return Err(ExportError::OtherShard {
                            path: path.to_owned(),
                            found: described(&found),
                            wanted: described(header),
                        });
                    }
                }
                // Whoever goes on says anew how far it is, so the shard counts as unfinished until
                // then.
                FrameKind::Note | FrameKind::End => {}
                FrameKind::Study | FrameKind::Records | FrameKind::Blob | FrameKind::Part => {
                    match self.appender.copy_frame(&earlier, &frame)? {
                        Ok(records) => self.records_of.extend(records),
                        Err(reason) => {
                            let start = frame.start;
                            self.damage.push(format!("the frame at byte {start} {reason}"));
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        self.appender.path()
    }

    /// Returns the damage of the earlier file that was left out, in words.
    pub fn damage(&self) -> &[String] {
        &self.damage
    }

    /// Returns true if the file has a record of the job.
    pub fn contains(&self, key: &JobKey) -> bool {
        self.records_of.contains_key(key)
    }

    /// Returns true if the last record of the job in the file has these very bytes.
    pub fn holds(&self, key: &JobKey, record: &[u8]) -> bool {
        self.records_of.get(key) == Some(&short_digest(record))
    }

    /// Returns true if the file has the blob.
    pub fn has_blob(&self, digest: &Digest) -> bool {
        self.appender.has_blob(digest)
    }

    /// Returns the number of jobs that have a record in the file.
    pub fn len(&self) -> usize {
        self.records_of.len()
    }

    /// Returns true if the file has no record.
    pub fn is_empty(&self) -> bool {
        self.records_of.is_empty()
    }

    /// Adds the definition of a study. Nothing happens if it is there already.
    ///
    /// # Errors
    /// [`ExportError::StudyDiffers`] if there is another definition under the name, and others if
    /// the system refuses.
    pub fn put_study(&mut self, name: &str, definition: &[u8]) -> Result<(), ExportError> {
        self.appender.put_study(name, definition)
    }

    /// Returns the definition of a study that the file has.
    ///
    /// # Errors
    /// [`ExportError::Open`] if the file cannot be read any more, [`ExportError::Blob`] if the
    /// definition is damaged.
    pub fn study(&self, name: &str) -> Result<Option<Vec<u8>>, ExportError> {
        let Some(digest) = self.appender.study(name) else { return Ok(None) };
        let Some(set) = ExportSet::open(self.path(), None)? else { return Ok(None) };
        Ok(Some(Blobs::in_exports(set).definition(name, digest)?))
    }

    /// Adds the record of a job, after the blobs of `source` that it refers to and that are not in
    /// the file yet. A later record of a job takes the place of an earlier one.
    ///
    /// # Errors
    /// [`ExportError::TooLarge`] if the record may not be kept, [`ExportError::Blob`] if a blob is
    /// missing or damaged, and others if the system refuses.
    pub fn append(
        &mut self,
        key: &JobKey,
        record: &[u8],
        source: &Blobs,
        references: impl IntoIterator<Item = Digest>,
    ) -> Result<(), ExportError> {
        for digest in references {
            self.appender.put_blob(&digest, source)?;
        }
        self.appender.gather(key, record)?;
        self.records_of.insert(*key, short_digest(record));
        self.appender.write_large()
    }

    /// Adds a blob of `source` that goes along with records, and returns whether the file has it
    /// now: one that is missing or damaged there is left out.
    ///
    /// # Errors
    /// The system refuses.
    pub fn accompany(&mut self, digest: &Digest, source: &Blobs) -> Result<bool, ExportError> {
        match self.appender.put_blob(digest, source) {
            Ok(_) => Ok(true),
            Err(ExportError::Blob(_)) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Keeps a note about the state of whoever writes; the last one counts. It is written by the
    /// next [`flush`](ExportWriter::flush), which refuses one of more than a quarter of a MiB.
    pub fn note(&mut self, state: &[u8]) {
        self.appender.note(state);
    }

    /// Says that the file is whole, durably.
    ///
    /// # Errors
    /// Those of [`flush`](ExportWriter::flush).
    pub fn close(&mut self) -> Result<(), ExportError> {
        self.appender.write_end(self.records_of.len())?;
        self.appender.flush()
    }

    /// Writes everything that was added. Once it has returned `Ok`, it survives a kill and a power
    /// failure.
    ///
    /// # Errors
    /// [`ExportError::Full`] if there is no room: the file then ends with the last frame that had
    /// room, and flushing may be tried again. [`ExportError::TakenOver`] if another process has
    /// gone on with the file.
    pub fn flush(&mut self) -> Result<(), ExportError> {
        self.appender.flush()
    }
}
