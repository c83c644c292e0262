//! The results and files of a store that no study refers to.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use answers::Records;
use answers::choice::visit_jobs;
use anyhow::{Context, Result};
use identity::JobKey;
use serde::{Serialize, Serializer};
use store::{Digest, Garbage, ReadError, References, StoreReader};
use study::Record;
use study::job::PHYSICS_VERSION;

use crate::earlier_results::EarlierResults;
use crate::job_pattern::JobPattern;
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
    /// Results of earlier versions of the physics, to whose jobs a study refers, are garbage if
    /// this is true.
    pub(crate) earlier_physics: bool,
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
    /// The version of the physics that computed it.
    pub(crate) physics: u32,
    /// A study refers to its job if this is true, so that it can be compared with the result of
    /// this physics.
    pub(crate) is_comparable: bool,
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

/// Results that no study refers to and that stay.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct KeptResults {
    /// The number of them.
    pub(crate) results: usize,
    /// The size of their records \[bytes\].
    pub(crate) bytes: u64,
}

/// The needs of studies of results in a store to whose jobs none refers.
#[derive(Debug, Default)]
struct Needs {
    /// The records to whose jobs no study refers.
    unused: HashSet<JobKey>,
    /// Those of earlier versions of the physics to whose jobs one does.
    comparable: HashSet<JobKey>,
    /// The jobs that each study may choose beyond a result that is missing, by its name.
    awaited: BTreeMap<String, JobPattern>,
    /// The jobs that each may choose where results of earlier versions of the physics stand in for
    /// those that are missing.
    awaited_to_compare: BTreeMap<String, JobPattern>,
}

/// The garbage in a store.
#[derive(Clone, Debug, Default)]
pub(crate) struct FoundGarbage {
    /// The results that are to be removed, the oldest first.
    pub(crate) results: Vec<UnusedResult>,
    /// The files that go with these results alone: their fields, and the accounts of their runs.
    pub(crate) files_of_results: Vec<UnusedFile>,
    /// The other files, the oldest first.
    pub(crate) files: Vec<UnusedFile>,
    /// The results of earlier versions of the physics that stay, to be compared with those of this
    /// one.
    pub(crate) comparable: KeptResults,
    /// The results that studies may yet refer to, by the name of the study. Its choice of points
    /// stops where a result is missing.
    pub(crate) awaited: BTreeMap<String, KeptResults>,
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
        let needs = Needs::of(reader)?;
        let age = limits.cutoff();
        let is_old = |time: u64| age.is_none_or(|cutoff| time > 0 && time <= cutoff);
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
            if !needs.unused.contains(&key) {
                needed.extend(files);
                continue;
            }
            let is_comparable = needs.is_comparable(&key, &record);
            let awaits = needs.awaited.iter().find(|(_, jobs)| jobs.matches(&record.job));
            let kept = match awaits {
                _ if is_comparable && !limits.earlier_physics => Some(&mut found.comparable),
                Some((name, _)) if record.is_current() => {
                    Some(found.awaited.entry(name.clone()).or_default())
                }
                _ => None,
            };
            if let Some(kept) = kept {
                kept.results += 1;
                kept.bytes += bytes.len() as u64;
                needed.extend(files);
                continue;
            }
            found.results.push(UnusedResult {
                key,
                bytes: bytes.len() as u64,
                finished: record.provenance.finished,
                physics: record.physics,
                is_comparable,
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
            let is_chosen = limits.allows(result.bytes) && is_old(result.finished);
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
                } else if limits.allows(file.bytes) && is_old(file.changed) {
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
            blobs: self.files_of_results.iter().map(|file| file.digest).collect(),
            loose_blobs: self.files.iter().map(|file| file.digest).collect(),
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
    /// Returns the time before which something must have been made, if that matters. What has no
    /// known time was not made before it.
    fn cutoff(&self) -> Option<u64> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        Some(now.saturating_sub(self.older_than?.as_secs()))
    }

    fn allows(&self, bytes: u64) -> bool {
        self.larger_than.is_none_or(|limit| bytes > limit)
    }
}

impl Needs {
    /// Determines what studies need of the results that `reader` has.
    fn of(reader: &StoreReader) -> Result<Self> {
        let mut needs = Self { unused: reader.keys()?.into_iter().collect(), ..Self::default() };
        let source = StoreSource::Reader(reader);
        needs.awaited = visit_studies(reader, &source, |key| {
            needs.unused.remove(&key);
        })?;
        // The keys that the jobs of earlier results have today.
        let mut earlier: HashMap<JobKey, Vec<JobKey>> = HashMap::new();
        for (key, bytes) in reader.select(needs.unused.iter().copied().collect()) {
            // Where one cannot be read, that is met when all are.
            let Some(record) = bytes.ok().and_then(|bytes| Record::decode(&bytes).ok()) else {
                continue;
            };
            if record.physics < PHYSICS_VERSION {
                let today = JobKey::of(PHYSICS_VERSION, &record.job);
                earlier.entry(today).or_default().push(key);
            }
        }
        if !earlier.is_empty() {
            let source = EarlierResults::of(source);
            needs.awaited_to_compare = visit_studies(reader, &source, |key| {
                needs.comparable.extend(earlier.remove(&key).into_iter().flatten());
            })?;
        }
        Ok(needs)
    }

    /// Returns whether a result is of an earlier version of the physics, and a study has its job.
    fn is_comparable(&self, key: &JobKey, record: &Record) -> bool {
        let is_awaited = || self.awaited_to_compare.values().any(|jobs| jobs.matches(&record.job));
        record.physics < PHYSICS_VERSION && (self.comparable.contains(key) || is_awaited())
    }
}

/// Visits the jobs of all studies by the results that `source` has, and returns what those may yet
/// choose whose choice stops where a result is missing.
fn visit_studies(
    reader: &StoreReader,
    source: &dyn Records,
    mut visitor: impl FnMut(JobKey),
) -> Result<BTreeMap<String, JobPattern>> {
    let mut awaited = BTreeMap::new();
    for name in reader.study_names()? {
        let unknown = || {
            format!(
                "nothing is removed, because nobody knows what the study `{name}` needs (`{}` gives \
                 it up)",
                proposal::command(reader.blobs().store(), ["rm", &name])
            )
        };
        let study = stored_large_study(reader, &name).with_context(unknown)?;
        let open = visit_jobs(&study, source, &mut visitor).with_context(unknown)?;
        if !open.is_empty() {
            let jobs = open.iter().map(|point| point.job.canonical());
            awaited.insert(name, JobPattern::of(jobs));
        }
    }
    Ok(awaited)
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
