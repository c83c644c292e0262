//! The results and files of a store that no study refers to.

use std::collections::{HashMap, HashSet};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use answers::choice::visit_jobs;
use anyhow::{Context, Result};
use identity::JobKey;
use serde::{Serialize, Serializer};
use store::{Digest, Garbage, ReadError, References, StoreReader};
use study::Record;

use crate::merge_rules::references;
use crate::proposal;
use crate::stored::{StoreSource, stored_large_study};

/// The limits to what counts as garbage.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GarbageLimits {
    /// The least age.
    pub(crate) older_than: Option<Duration>,
    /// The size beyond which something must be \[bytes\].
    pub(crate) larger_than: Option<u64>,
}

/// A result that no study refers to.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct UnusedResult {
    #[serde(serialize_with = "as_text")]
    pub(crate) key: JobKey,
    /// The size of the record, and of the files that go with it and with nothing else \[bytes\].
    pub(crate) bytes: u64,
    /// The time when it was finished, in seconds since 1970-01-01 UTC; 0 if that is not known.
    pub(crate) finished: u64,
    /// The run that computed it.
    #[serde(skip)]
    pub(crate) run: Option<[u8; 32]>,
    #[serde(skip)]
    files: Vec<Digest>,
}

/// A file that neither a result nor a study refers to.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct UnusedFile {
    #[serde(serialize_with = "as_text")]
    pub(crate) digest: Digest,
    /// The size \[bytes\].
    pub(crate) bytes: u64,
    /// The time of the last change, in seconds since 1970-01-01 UTC; 0 if that is not known.
    pub(crate) changed: u64,
}

/// The garbage in a store.
#[derive(Clone, Debug, Default)]
pub(crate) struct FoundGarbage {
    /// The results, the oldest first.
    pub(crate) results: Vec<UnusedResult>,
    /// The files that go with these results alone: their fields, and the accounts of their runs.
    pub(crate) files_of_results: Vec<UnusedFile>,
    /// The other files, the oldest first.
    pub(crate) files: Vec<UnusedFile>,
    /// The number of records that this program cannot read. They stay, and so do all files, any of
    /// which they may refer to.
    pub(crate) unread: usize,
}

impl FoundGarbage {
    /// Finds what no study refers to, within some limits.
    ///
    /// # Errors
    /// A study or what it refers to cannot be read, so that nobody knows what it needs.
    pub(crate) fn find(reader: &StoreReader, limits: &GarbageLimits) -> Result<Self> {
        let unused = unused_jobs(reader)?;
        let cutoff = limits.cutoff();
        let sizes: HashMap<Digest, UnusedFile> = stored_files(reader)?;
        let mut found = Self::default();
        let mut needed: HashSet<Digest> = reader.studies()?.into_values().collect();
        for (key, bytes) in reader.records()? {
            let bytes = match bytes {
                Ok(bytes) => bytes,
                Err(gone @ (ReadError::Gone(_) | ReadError::Unanswered { .. })) => {
                    return Err(gone.into());
                }
                Err(_) => {
                    found.unread += 1;
                    continue;
                }
            };
            let Ok(record) = Record::decode(&bytes) else {
                found.unread += 1;
                continue;
            };
            let References { needed: fields, companions } = references(&record);
            let files = fields.into_iter().chain(companions);
            if !unused.contains(&key) {
                needed.extend(files);
                continue;
            }
            found.results.push(UnusedResult {
                key,
                bytes: bytes.len() as u64,
                finished: record.provenance.finished,
                run: record.provenance.run,
                files: files.collect(),
            });
        }
        let size = |file: &Digest| match needed.contains(file) || found.unread > 0 {
            true => 0,
            false => sizes.get(file).map_or(0, |file| file.bytes),
        };
        // The account of a run goes with many results, and its size is that of none of them.
        let fields = |result: &UnusedResult| {
            let accounts: Vec<Digest> = result.run.map(Digest).into_iter().collect();
            let others = result.files.iter().filter(|file| !accounts.contains(file));
            others.map(size).sum::<u64>()
        };
        let (mut chosen, mut left): (Vec<_>, Vec<_>) = (Vec::new(), Vec::new());
        for mut result in std::mem::take(&mut found.results) {
            result.bytes += fields(&result);
            let is_chosen = limits.allows(result.bytes) && result.finished <= cutoff;
            if is_chosen { chosen.push(result) } else { left.push(result) }
        }
        needed.extend(left.into_iter().flat_map(|result| result.files));
        chosen.sort_by_key(|result| (result.finished, result.key));
        found.results = chosen;
        if found.unread == 0 {
            let of_results: HashSet<Digest> =
                found.results.iter().flat_map(|result| &result.files).copied().collect();
            for (digest, file) in sizes {
                if needed.contains(&digest) {
                    continue;
                }
                if of_results.contains(&digest) {
                    found.files_of_results.push(file);
                } else if limits.allows(file.bytes) && file.changed <= cutoff {
                    found.files.push(file);
                }
            }
            let by_age = |file: &UnusedFile| (file.changed, file.digest);
            found.files_of_results.sort_by_key(by_age);
            found.files.sort_by_key(by_age);
        }
        Ok(found)
    }

    /// Returns the garbage as the store removes it.
    pub(crate) fn garbage(&self) -> Garbage {
        Garbage {
            records: self.results.iter().map(|result| result.key).collect(),
            blobs: self.all_files().map(|file| file.digest).collect(),
        }
    }

    /// Returns whether there is nothing to remove.
    pub(crate) fn is_empty(&self) -> bool {
        self.results.is_empty() && self.all_files().next().is_none()
    }

    /// Iterates over the files.
    pub(crate) fn all_files(&self) -> impl Iterator<Item = &UnusedFile> {
        self.files_of_results.iter().chain(&self.files)
    }
}

impl GarbageLimits {
    /// Returns the time before which something must have been made.
    fn cutoff(&self) -> u64 {
        let Some(age) = self.older_than else { return u64::MAX };
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        now.saturating_sub(age.as_secs())
    }

    fn allows(&self, bytes: u64) -> bool {
        self.larger_than.is_none_or(|limit| bytes > limit)
    }
}

/// Returns the jobs that have a record, and to which no study refers.
fn unused_jobs(reader: &StoreReader) -> Result<HashSet<JobKey>> {
    let mut unused: HashSet<JobKey> = reader.keys()?.into_iter().collect();
    let source = StoreSource::Reader(reader);
    for name in reader.study_names()? {
        if unused.is_empty() {
            break;
        }
        let unknown = || {
            format!(
                "nothing is removed, because nobody knows what the study `{name}` needs (`{}` gives \
                 it up)",
                proposal::command(reader.blobs().store(), ["rm", &name])
            )
        };
        let study = stored_large_study(reader, &name).with_context(unknown)?;
        visit_jobs(&study, &source, |key| {
            unused.remove(&key);
        })
        .with_context(unknown)?;
    }
    Ok(unused)
}

/// Returns the files of a store.
fn stored_files(reader: &StoreReader) -> Result<HashMap<Digest, UnusedFile>> {
    let file = |file: store::StoredBlob| {
        let since = file.changed.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let changed = since.map_or(0, |since| since.as_secs());
        (file.digest, UnusedFile { digest: file.digest, bytes: file.bytes, changed })
    };
    Ok(reader.blobs().stored()?.into_iter().map(file).collect())
}

fn as_text<S: Serializer>(name: &impl std::fmt::Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(name)
}
