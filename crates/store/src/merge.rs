//! This file merges stores and exports into a store or into one export.
//!
//! The order of the sources does not matter, and neither does it how often they are merged, as long
//! as no two of them have different results of one job. Of such results none is taken if they are
//! merged at once; in several steps the one that came first stays, and every merge reports it.
//! First the keys of all sources are compared, which takes some 90 bytes for each record. Then the
//! jobs that have several records are decided without keeping any record, and at last every source
//! is read once more, from its beginning to its end, and what it has to give is written.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use identity::JobKey;

use crate::blob::Blobs;
use crate::digest::Digest;
use crate::durable;
use crate::error::{OpenError, ReadError, WriteError};
use crate::export::{ExportError, ExportWriter};
use crate::exports::{ExportHeader, ExportSet, FileIdentity, ShardName, ShardState};
use crate::parts;
use crate::reader::StoreReader;
use crate::rules::{Candidate, Examination, LostCompanion, MergeRules, RecordChoice, RecordRank};
use crate::store::Store;

/// The size of the records that are committed together \[bytes\]. They are sorted first, so that a
/// page of the database is written less often (measured with a million records of 800 bytes: 12 400
/// records a second in groups of 4 MiB, 19 400 in these).
const GROUP_BYTES: usize = 32 << 20;

/// The largest number of records that are committed together.
const GROUP_RECORDS: usize = 65_536;

/// The number of the target where the sources are numbered.
const TARGET: u32 = u32::MAX;

/// The choice of what is merged.
#[derive(Clone, Debug, Default)]
pub struct MergeSelection {
    /// The names of the studies, if not all.
    pub studies: Option<BTreeSet<String>>,
    /// The jobs, if not all.
    pub keys: Option<BTreeSet<JobKey>>,
}

/// A job of which two sources have different results. Nothing of it is changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordConflict {
    /// The job.
    pub key: JobKey,
    /// A source with a result.
    pub first: PathBuf,
    /// A source with another result.
    pub second: PathBuf,
}

/// The result of a merge.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MergeReport {
    /// The number of jobs that had no record before.
    pub added: usize,
    /// The number of jobs whose record took the place of one of lower rank.
    pub replaced: usize,
    /// The number of records in the sources that repeat what is there.
    pub already_there: usize,
    /// The number of records that were added and that another version of the program wrote. They
    /// lie beside the others.
    pub foreign: usize,
    /// The number of blobs that were added, without the definitions of studies.
    pub blobs: usize,
    /// The number of studies that were added.
    pub studies: usize,
    /// The jobs with different results.
    pub conflicts: Vec<RecordConflict>,
    /// The faults of what was left out, in words.
    pub faults: Vec<String>,
    /// The records that are in the target without a blob that they refer to, in words.
    pub incomplete: Vec<String>,
    /// The blobs that go along with records of the target and that no source has.
    pub lost_companions: Vec<LostCompanion>,
    /// The shards whose results are in the target, with their last notes.
    pub shards: Vec<ShardState>,
    /// The shards of which nothing is remembered any more, because their study is in another number
    /// of shards now. Their results stay.
    pub forgotten: Vec<ShardName>,
}

/// The reason why nothing, or nothing more, is merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// Two sources have studies of one name that differ. Nothing was written.
    #[error(
        "{} and {} have different studies called {name:?}, and nothing was merged; rename one of \
         them, or merge them into different places",
        .first.display(), .second.display()
    )]
    StudiesDiffer {
        /// The name of the studies.
        name: String,
        /// A source with the study.
        first: PathBuf,
        /// A source with the other study.
        second: PathBuf,
    },
    /// A study came in shards of different numbers. Nothing was written.
    #[error(
        "{} is {first_shard} and {} is {second_shard}: the shards are of different numbers, and \
         nothing was merged; merge those of one number",
        .first.display(), .second.display()
    )]
    ShardCounts {
        /// A source with a shard.
        first: PathBuf,
        /// The shard.
        first_shard: ShardName,
        /// A source with a shard of another number.
        second: PathBuf,
        /// The other shard.
        second_shard: ShardName,
    },
    /// A source or the target cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A source cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The target cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The target cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
}

/// A place from which records come: a store, or one of several exports.
struct MergeSource<'s> {
    reader: &'s StoreReader,
    /// The exports and the number of the one among them, if it is one.
    export: Option<(Arc<ExportSet>, u32)>,
    path: PathBuf,
    /// True if this is what the target held before, of which everything stays.
    is_target: bool,
}

impl MergeSource<'_> {
    /// Lists what is read by `reader`.
    fn all_of(reader: &StoreReader) -> Vec<MergeSource<'_>> {
        let Some(set) = reader.export_set() else {
            let path = reader.path().to_owned();
            return vec![MergeSource { reader, export: None, path, is_target: false }];
        };
        let paths = set.files.iter().map(|file| file.path().to_owned());
        paths
            .zip(0..)
            .map(|(path, number)| {
                let export = Some((set.clone(), number));
                MergeSource { reader, export, path, is_target: false }
            })
            .collect()
    }

    fn keys(&self) -> Result<Vec<JobKey>, ReadError> {
        match &self.export {
            Some((set, number)) => Ok(set.keys_of(*number).collect()),
            None => self.reader.keys(),
        }
    }

    /// Returns the jobs among `keys` that have a record here, be it a damaged one.
    fn having(&self, keys: &[JobKey]) -> Result<Vec<JobKey>, ReadError> {
        let is_there = match &self.export {
            Some((set, number)) => {
                let is_in = |key| set.places(key).iter().any(|place| place.file == *number);
                keys.iter().map(is_in).collect()
            }
            None => self.reader.contains(keys)?,
        };
        let found = keys.iter().zip(is_there).filter(|(_, is_there)| *is_there);
        Ok(found.map(|(key, _)| *key).collect())
    }

    fn studies(&self) -> Result<BTreeMap<String, Digest>, ReadError> {
        match &self.export {
            Some((set, number)) => Ok(set.files[*number as usize].studies.clone()),
            None => self.reader.studies(),
        }
    }

    fn shards(&self) -> Vec<ShardState> {
        match &self.export {
            Some((set, number)) => set.files[*number as usize].summary.shards(),
            None => parts::read(&self.path),
        }
    }

    /// Visits the records that are `wanted`.
    fn visit(
        &self,
        wanted: impl Fn(&JobKey) -> bool,
        mut visit: impl FnMut(&JobKey, Result<&[u8], ReadError>) -> Result<(), MergeError>,
    ) -> Result<(), MergeError> {
        if let Some((set, number)) = &self.export {
            return set.visit(*number, wanted, visit);
        }
        let keys = self.reader.keys()?.into_iter().filter(wanted).collect();
        for (key, record) in self.reader.select(keys) {
            match record {
                Err(gone @ (ReadError::Gone(_) | ReadError::Unanswered { .. })) => {
                    return Err(gone.into());
                }
                Ok(record) => visit(&key, Ok(&record))?,
                Err(error) => visit(&key, Err(error))?,
            }
        }
        Ok(())
    }
}

/// A job of which several sources, or a source and the target, have a record.
struct SharedJob {
    key: JobKey,
    best: Option<Candidate>,
    /// The number of the source of the best record.
    holder: u32,
    /// The number of a source whose result differs from the best.
    rival: Option<u32>,
    /// The rank of the record in the target.
    before: Option<RecordRank>,
}

impl SharedJob {
    fn meet(&mut self, source: u32, candidate: Candidate) {
        match self.best.map_or(RecordChoice::Second, |best| best.against(&candidate)) {
            RecordChoice::First => {}
            RecordChoice::Second => (self.best, self.holder) = (Some(candidate), source),
            RecordChoice::Conflict => self.rival = self.rival.or(Some(source)),
        }
    }
}

/// The place into which is merged.
enum MergeTarget<'t> {
    Store(&'t Store),
    Export(&'t mut ExportWriter),
}

impl MergeTarget<'_> {
    fn keeps(&self, key: &JobKey) -> bool {
        match self {
            MergeTarget::Store(store) => store.contains(key),
            MergeTarget::Export(_) => false,
        }
    }

    /// Returns true if a sound record of the job is there, and those blobs.
    fn has(&self, key: &JobKey, blobs: &BTreeSet<Digest>, rules: &MergeRules) -> bool {
        match self {
            MergeTarget::Store(store) => {
                let record = store.get(key).ok().flatten();
                record.is_some_and(|record| (rules.examine)(key, &record).is_ok())
                    && blobs.iter().all(|digest| store.blobs().contains(digest))
            }
            MergeTarget::Export(writer) => {
                writer.contains(key) && blobs.iter().all(|digest| writer.has_blob(digest))
            }
        }
    }

    fn path(&self) -> &Path {
        match self {
            MergeTarget::Store(store) => store.blobs().store(),
            MergeTarget::Export(writer) => writer.path(),
        }
    }

    /// Stores a blob of `source` and returns true if it was not there.
    fn adopt(
        &mut self,
        digest: &Digest,
        source: &Blobs,
    ) -> Result<Result<bool, ReadError>, MergeError> {
        match self {
            MergeTarget::Store(store) => Ok(store.blobs().adopt(digest, source)?),
            MergeTarget::Export(writer) => match writer.put_blob(digest, source) {
                Ok(is_new) => Ok(Ok(is_new)),
                Err(ExportError::Blob(fault)) => Ok(Err(fault)),
                Err(error) => Err(error.into()),
            },
        }
    }

    fn commit(&mut self, group: &mut Vec<(JobKey, Vec<u8>)>) -> Result<(), MergeError> {
        match self {
            MergeTarget::Store(store) => {
                group.sort_unstable_by_key(|(key, _)| *key);
                store.commit(group)?;
            }
            MergeTarget::Export(writer) => {
                for (key, record) in group.iter() {
                    writer.put_record(key, record)?;
                }
            }
        }
        group.clear();
        Ok(())
    }
}

/// The definition of a study that will be in the target.
struct ChosenStudy {
    digest: Digest,
    /// The digest of what machines must agree on.
    said: Digest,
    /// The number of the first source that has the study.
    source: u32,
}

/// A merge that is going on.
struct Merge<'m> {
    sources: Vec<MergeSource<'m>>,
    rules: &'m MergeRules,
    selection: &'m MergeSelection,
    report: MergeReport,
    /// The number of records of each source that are left out.
    lost: Vec<usize>,
    /// The blobs that records of the target refer to and that are not there.
    lost_blobs: BTreeSet<(Digest, JobKey)>,
    /// The jobs of which something was lost in some source, with their blobs that were.
    losses: BTreeMap<JobKey, BTreeSet<Digest>>,
    companions: Companions,
    /// The blobs that go along with records of the target, with the number of these.
    target_companions: BTreeMap<Digest, usize>,
    shards: ShardUse,
}

/// The blobs that go along with records, each of which is looked for once: `None` for one that the
/// target has, else the number of records without it and the reason.
#[derive(Default)]
struct Companions(BTreeMap<Digest, Option<LostCompanion>>);

impl Companions {
    /// Brings a blob along with so many more records, and returns true if the target did not have
    /// it.
    fn bring(
        &mut self,
        digest: &Digest,
        records: usize,
        first: Option<&MergeSource>,
        sources: &[MergeSource],
        target: &mut MergeTarget,
    ) -> Result<bool, MergeError> {
        if let Some(known) = self.0.get_mut(digest) {
            known.iter_mut().for_each(|lost| lost.records += records);
            return Ok(false);
        }
        let brought = adopted(digest, first, sources, target)?;
        let is_new = brought.as_ref().is_ok_and(|is_new| *is_new);
        let lost = brought.err().map(|error| {
            let reason = match error {
                ReadError::Blob { reason, .. } => reason,
                other => other.to_string(),
            };
            LostCompanion { digest: *digest, records, reason }
        });
        self.0.insert(*digest, lost);
        Ok(is_new)
    }
}

/// The use of what the sources say of shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ShardUse {
    /// The target remembers the shards, and words can be said about what is missing.
    Remember,
    /// The results count, and whose they were does not matter.
    Ignore,
}

/// A shard that is known, and from where.
struct KnownShard {
    path: PathBuf,
    state: ShardState,
    origin: ShardOrigin,
}

/// The origin of the knowledge of a shard. What comes later in this list counts more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ShardOrigin {
    /// The target remembers it.
    Target,
    /// A store that is merged remembers it.
    Store,
    /// An export that is merged names it.
    Export,
}

impl<'m> Merge<'m> {
    fn new(
        readers: &[&'m StoreReader],
        rules: &'m MergeRules,
        selection: &'m MergeSelection,
        target: &Path,
        earlier: Option<&'m StoreReader>,
    ) -> Self {
        // What is named twice counts once, and nothing is merged into itself.
        let same = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let mut seen = BTreeSet::from([same(target)]);
        let earlier = earlier.into_iter().flat_map(MergeSource::all_of);
        let mut sources: Vec<_> =
            earlier.map(|source| MergeSource { is_target: true, ..source }).collect();
        let others = readers.iter().flat_map(|reader| MergeSource::all_of(reader));
        sources.extend(others.filter(|source| seen.insert(same(&source.path))));
        let lost = vec![0; sources.len()];
        Merge {
            sources,
            rules,
            selection,
            report: MergeReport::default(),
            lost,
            lost_blobs: BTreeSet::new(),
            losses: BTreeMap::new(),
            companions: Companions::default(),
            target_companions: BTreeMap::new(),
            shards: ShardUse::Remember,
        }
    }

    fn path(&self, source: u32, target: &Path) -> PathBuf {
        let source = self.sources.get(source as usize);
        source.map_or(target, |source| &source.path).to_owned()
    }

    fn run(mut self, target: &mut MergeTarget) -> Result<MergeReport, MergeError> {
        let store = match target {
            MergeTarget::Store(store) => Some(*store),
            MergeTarget::Export(_) => None,
        };
        if self.shards == ShardUse::Remember {
            self.unite_shards(store)?;
        }
        let studies = self.compare_studies(store)?;
        let shared = self.shared_jobs(target)?;
        self.copy(&shared, target)?;
        for job in &shared {
            if let Some(rival) = job.rival {
                let place = target.path();
                let (first, second) = (self.path(job.holder, place), self.path(rival, place));
                self.report.conflicts.push(RecordConflict { key: job.key, first, second });
                self.losses.entry(job.key).or_default();
            }
        }
        let companions = std::mem::take(&mut self.companions).0;
        self.report.lost_companions = companions.into_values().flatten().collect();
        self.doubt_shards(target)?;
        // The studies are named last: a merge that was cut short shows none that is not whole.
        self.put_studies(studies, target)?;
        let shards = &self.report.shards;
        match target {
            MergeTarget::Store(store) if !shards.is_empty() => {
                let directory = store.blobs().store();
                parts::write(directory, shards).map_err(|source| {
                    WriteError::io("write", &directory.join(parts::FILE), source)
                })?;
            }
            MergeTarget::Store(_) => {}
            MergeTarget::Export(writer) => {
                shards.iter().try_for_each(|shard| writer.put_part(shard))?;
            }
        }
        Ok(self.report)
    }

    /// Unites what the sources and the target know of shards.
    fn unite_shards(&mut self, target: Option<&Store>) -> Result<(), MergeError> {
        let mut shards: Vec<KnownShard> = Vec::new();
        if let Some(store) = target {
            let path = store.blobs().store().to_owned();
            let origin = ShardOrigin::Target;
            let known = parts::read(&path).into_iter();
            shards.extend(known.map(|state| KnownShard { path: path.clone(), state, origin }));
        }
        for source in &self.sources {
            let names = self.selection.studies.as_ref().filter(|_| !source.is_target);
            let found = source.shards().into_iter();
            let chosen =
                found.filter(|state| names.is_none_or(|names| names.contains(&state.shard.study)));
            let origin = match &source.export {
                _ if source.is_target => ShardOrigin::Target,
                Some(_) => ShardOrigin::Export,
                None => ShardOrigin::Store,
            };
            let known = |state| KnownShard { path: source.path.clone(), state, origin };
            shards.extend(chosen.map(known));
        }
        // A study may be divided anew: what stores remember of another division is forgotten.
        let mut valid: BTreeMap<String, (ShardOrigin, u32)> = BTreeMap::new();
        for found in &shards {
            let ShardName { study, count, .. } = &found.state.shard;
            let weight = (found.origin, *count);
            let known = valid.entry(study.clone()).or_insert(weight);
            *known = weight.max(*known);
        }
        let is_valid = |found: &KnownShard| {
            let ShardName { study, count, .. } = &found.state.shard;
            valid.get(study).is_some_and(|(_, valid)| valid == count)
        };
        let of_exports = || shards.iter().filter(|found| found.origin == ShardOrigin::Export);
        if let Some(odd) = of_exports().find(|found| !is_valid(found)) {
            let of_study =
                || of_exports().filter(|found| found.state.shard.study == odd.state.shard.study);
            let first = of_study().next().unwrap_or(odd);
            let differs = |found: &&KnownShard| found.state.shard.count != first.state.shard.count;
            let second = of_study().find(differs).unwrap_or(odd);
            return Err(MergeError::ShardCounts {
                first: first.path.clone(),
                first_shard: first.state.shard.clone(),
                second: second.path.clone(),
                second_shard: second.state.shard.clone(),
            });
        }
        let (kept, others): (Vec<_>, Vec<_>) = shards.into_iter().partition(is_valid);
        let forgotten: BTreeSet<_> = others.into_iter().map(|found| found.state.shard).collect();
        self.report.forgotten = forgotten.into_iter().collect();
        let states = kept.into_iter().map(|found| found.state);
        self.report.shards = parts::united(states, self.rules.progress);
        Ok(())
    }

    /// Takes for unfinished the shards of sources that have a job of which the target lacks
    /// something.
    fn doubt_shards(&mut self, target: &MergeTarget) -> Result<(), MergeError> {
        let losses = std::mem::take(&mut self.losses).into_iter();
        let mut lost: Vec<JobKey> = losses
            .filter(|(key, blobs)| !target.has(key, blobs, self.rules))
            .map(|(key, _)| key)
            .collect();
        if lost.is_empty() {
            return Ok(());
        }
        let mut doubtful: BTreeSet<ShardName> = BTreeSet::new();
        // What an earlier file of the target has lost is a loss of its own if no other source has
        // it; otherwise that one says more precisely whose it was.
        let of_target = self.sources.iter().filter(|source| source.is_target);
        let others = self.sources.iter().filter(|source| !source.is_target);
        let mut explained: BTreeSet<JobKey> = BTreeSet::new();
        for source in others.chain(of_target) {
            if source.is_target {
                lost.retain(|key| !explained.contains(key));
            }
            let found = source.having(&lost)?;
            if !found.is_empty() {
                doubtful.extend(source.shards().into_iter().map(|state| state.shard));
                explained.extend(found);
            }
        }
        for state in &mut self.report.shards {
            if let Some(note) = state.note.as_mut().filter(|_| doubtful.contains(&state.shard)) {
                *note = (self.rules.unfinished)(note);
            }
        }
        Ok(())
    }

    /// Compares the definitions of studies and returns those that the target must get.
    fn compare_studies(
        &mut self,
        target: Option<&Store>,
    ) -> Result<BTreeMap<String, ChosenStudy>, MergeError> {
        let mut chosen: BTreeMap<String, ChosenStudy> = BTreeMap::new();
        let place = target.map_or(Path::new(""), |store| store.blobs().store());
        if let Some(store) = target {
            for name in store.study_names() {
                // A definition that is damaged is healed by any other.
                if let Ok(Some(bytes)) = store.study(&name) {
                    let (digest, said) = (Digest::of(&bytes), (self.rules.definition)(&bytes));
                    chosen.insert(name, ChosenStudy { digest, said, source: TARGET });
                }
            }
        }
        for (source, number) in self.sources.iter().zip(0..) {
            for (name, digest) in source.studies()? {
                let names = self.selection.studies.as_ref().filter(|_| !source.is_target);
                if names.is_some_and(|names| !names.contains(&name)) {
                    continue;
                }
                if chosen.get(&name).is_some_and(|known| known.digest == digest) {
                    continue;
                }
                let said = match source.reader.blobs().definition(&name, &digest) {
                    Ok(bytes) => (self.rules.definition)(&bytes),
                    Err(error) => {
                        let path = source.path.display();
                        self.report.faults.push(format!("study {name} of {path}: {error}"));
                        continue;
                    }
                };
                let found = ChosenStudy { digest, said, source: number };
                match chosen.get_mut(&name) {
                    None => drop(chosen.insert(name, found)),
                    Some(known) if known.said != said => {
                        return Err(MergeError::StudiesDiffer {
                            name,
                            first: self.path(known.source, place),
                            second: source.path.clone(),
                        });
                    }
                    // Only the path of its file differs.
                    Some(known) if known.digest > digest => *known = found,
                    Some(_) => {}
                }
            }
        }
        chosen.retain(|_, study| study.source != TARGET);
        Ok(chosen)
    }

    fn put_studies(
        &mut self,
        studies: BTreeMap<String, ChosenStudy>,
        target: &mut MergeTarget,
    ) -> Result<(), MergeError> {
        let mut definitions = BTreeMap::new();
        for (name, ChosenStudy { digest, source, .. }) in studies {
            let source = &self.sources[source as usize];
            let bytes = source.reader.blobs().definition(&name, &digest)?;
            match target {
                MergeTarget::Store(_) => drop(definitions.insert(name, bytes)),
                MergeTarget::Export(writer) => writer.put_study(&name, &bytes)?,
            }
            self.report.studies += usize::from(!source.is_target);
        }
        if let MergeTarget::Store(store) = target {
            store.put_studies(&definitions)?;
        }
        Ok(())
    }

    /// Decides the jobs that have several records, in the order of their keys.
    fn shared_jobs(&mut self, target: &MergeTarget) -> Result<Vec<SharedJob>, MergeError> {
        let mut all: Vec<JobKey> = Vec::new();
        for source in &self.sources {
            let keys = source.keys()?.into_iter();
            all.extend(keys.filter(|key| is_selected(self.selection, source, key)));
        }
        all.sort_unstable();
        let mut shared: Vec<SharedJob> = all
            .chunk_by(|one, next| one == next)
            .filter(|records| records.len() > 1 || target.keeps(&records[0]))
            .map(|records| SharedJob {
                key: records[0],
                best: None,
                holder: TARGET,
                rival: None,
                before: None,
            })
            .collect();
        drop(all);
        if let MergeTarget::Store(store) = target {
            for job in &mut shared {
                // A record that is damaged counts as absent, and a sound one heals it.
                if let Ok(Some(record)) = store.get(&job.key)
                    && let Ok(found) = (self.rules.examine)(&job.key, &record)
                {
                    // Its file may have been lost meanwhile, and is taken from any source.
                    for digest in found.references.companions {
                        *self.target_companions.entry(digest).or_default() += 1;
                    }
                    let blobs = found.references.needed.into_iter();
                    let lost = blobs.filter(|digest| !store.blobs().contains(digest));
                    self.lost_blobs.extend(lost.map(|digest| (digest, job.key)));
                    job.before = Some(found.rank);
                    job.meet(TARGET, Candidate::of(self.rules, found.rank, &record));
                }
            }
        }
        let keys: Vec<JobKey> = shared.iter().map(|job| job.key).collect();
        let Merge { sources, rules, selection, report, lost, losses, .. } = self;
        for ((source, number), lost) in sources.iter().zip(0..).zip(lost) {
            let is_shared = |key: &JobKey| {
                is_selected(selection, source, key) && keys.binary_search(key).is_ok()
            };
            source.visit(is_shared, |key, record| {
                let Ok(place) = keys.binary_search(key) else { return Ok(()) };
                match examined(rules, key, record) {
                    Ok((found, record)) => {
                        if source.is_target {
                            shared[place].before = Some(found.rank);
                        }
                        shared[place].meet(number, Candidate::of(rules, found.rank, record));
                    }
                    Err(reason) => {
                        *lost += 1;
                        losses.entry(*key).or_default();
                        report.faults.push(format!("{}: {reason}", source.path.display()));
                    }
                }
                Ok(())
            })?;
        }
        Ok(shared)
    }

    /// Writes the records that the target must get, with the blobs that they refer to.
    fn copy(&mut self, shared: &[SharedJob], target: &mut MergeTarget) -> Result<(), MergeError> {
        let Merge { sources, rules, selection, report, lost, lost_blobs, losses, .. } = self;
        let (companions, target_companions) = (&mut self.companions, &self.target_companions);
        // An export gathers its frames itself.
        let is_store = matches!(target, MergeTarget::Store(_));
        for (digest, key) in &*lost_blobs {
            match adopted(digest, None, sources, target)? {
                Ok(is_new) => report.blobs += usize::from(is_new),
                Err(error) => {
                    report.incomplete.push(format!("job {key}: {error}"));
                    losses.entry(*key).or_default().insert(*digest);
                }
            }
        }
        for (digest, records) in target_companions {
            let is_new = companions.bring(digest, *records, None, sources, target)?;
            report.blobs += usize::from(is_new);
        }
        let job = |key: &JobKey| {
            shared.binary_search_by_key(key, |job| job.key).ok().map(|place| &shared[place])
        };
        for ((source, number), lost) in sources.iter().zip(0..).zip(lost) {
            let is_decided = |key: &JobKey| {
                is_selected(selection, source, key)
                    && job(key).is_none_or(|job| job.rival.is_none())
            };
            let given = source.keys()?.into_iter().filter(is_decided).count();
            let (added, replaced) = (report.added, report.replaced);
            let (mut group, mut bytes) = (Vec::new(), 0);
            let is_wanted = |key: &JobKey| match job(key) {
                None => is_decided(key),
                // What the target had of a job in conflict stays.
                Some(job) if job.rival.is_some() => source.is_target,
                Some(job) => is_decided(key) && job.holder == number,
            };
            source.visit(is_wanted, |key, record| {
                let (found, record) = match examined(rules, key, record) {
                    Ok(examined) => examined,
                    Err(reason) => {
                        *lost += 1;
                        losses.entry(*key).or_default();
                        report.faults.push(format!("{}: {reason}", source.path.display()));
                        return Ok(());
                    }
                };
                for digest in &found.references.companions {
                    let is_new = companions.bring(digest, 1, Some(source), sources, target)?;
                    report.blobs += usize::from(is_new && !source.is_target);
                }
                for digest in &found.references.needed {
                    match adopted(digest, Some(source), sources, target)? {
                        Ok(is_new) => report.blobs += usize::from(is_new && !source.is_target),
                        Err(error) => {
                            report.incomplete.push(format!("job {key}: {error}"));
                            losses.entry(*key).or_default().insert(*digest);
                        }
                    }
                }
                match job(key).and_then(|job| Some((job.before?, job.best?.rank))) {
                    _ if source.is_target => {}
                    None => {
                        report.added += 1;
                        report.foreign += usize::from(found.rank == RecordRank::Foreign);
                    }
                    Some((before, rank)) if before < rank => report.replaced += 1,
                    // An equal result, with another provenance.
                    Some(_) => {}
                }
                bytes += record.len();
                group.push((*key, record.to_vec()));
                if !is_store || bytes >= GROUP_BYTES || group.len() >= GROUP_RECORDS {
                    bytes = 0;
                    target.commit(&mut group)?;
                }
                Ok(())
            })?;
            target.commit(&mut group)?;
            if !source.is_target {
                let written = report.added - added + report.replaced - replaced;
                report.already_there += given.saturating_sub(written + *lost);
            }
        }
        Ok(())
    }
}

/// Returns true if the record of a job is taken from a source.
fn is_selected(selection: &MergeSelection, source: &MergeSource, key: &JobKey) -> bool {
    source.is_target || selection.keys.as_ref().is_none_or(|keys| keys.contains(key))
}

/// Stores a blob of the first of the sources that has a sound copy, and returns true if it was not
/// there.
fn adopted(
    digest: &Digest,
    first: Option<&MergeSource>,
    sources: &[MergeSource],
    target: &mut MergeTarget,
) -> Result<Result<bool, ReadError>, MergeError> {
    let mut outcome = None;
    // The exports that one reader reads have their blobs together.
    let groups = sources.chunk_by(|one, next| std::ptr::eq(one.reader, next.reader));
    for source in first.into_iter().chain(groups.filter_map(<[_]>::first)) {
        match (target.adopt(digest, source.reader.blobs())?, &outcome) {
            (Ok(is_new), _) => return Ok(Ok(is_new)),
            // The fault of the source of the record says most.
            (Err(error), None) => outcome = Some(Err(error)),
            (Err(_), Some(_)) => {}
        }
    }
    Ok(outcome.unwrap_or(Ok(false)))
}

/// Examines a record that was read, or says what is wrong with it.
fn examined<'r>(
    rules: &MergeRules,
    key: &JobKey,
    record: Result<&'r [u8], ReadError>,
) -> Result<(Examination, &'r [u8]), String> {
    let record = record.map_err(|error| error.to_string())?;
    let found = (rules.examine)(key, record);
    found.map(|found| (found, record)).map_err(|reason| format!("record {key}: {reason}"))
}

impl Store {
    /// Adds the studies, the records and the blobs of stores and exports to this store. The order
    /// of the sources does not matter, and to do it again changes nothing. A merge that was cut
    /// short is completed by the next one. Two different results of one job are a conflict: nothing
    /// of that job is changed. What is damaged is left out and said.
    ///
    /// # Errors
    /// [`MergeError::StudiesDiffer`] and [`MergeError::ShardCounts`] before anything is written,
    /// and others if reading or writing fails as a whole.
    pub fn import(
        &self,
        sources: &[&StoreReader],
        rules: &MergeRules,
    ) -> Result<MergeReport, MergeError> {
        let selection = MergeSelection::default();
        let merge = Merge::new(sources, rules, &selection, self.blobs().store(), None);
        merge.run(&mut MergeTarget::Store(self))
    }

    /// Adds what stores and exports hold like [`import`](Store::import), without regard to whose
    /// shards they are: no number of shards is refused, and the store does not remember them.
    ///
    /// # Errors
    /// Those of [`import`](Store::import), but for [`MergeError::ShardCounts`].
    pub fn import_results(
        &self,
        sources: &[&StoreReader],
        rules: &MergeRules,
    ) -> Result<MergeReport, MergeError> {
        let selection = MergeSelection::default();
        let merge = Merge::new(sources, rules, &selection, self.blobs().store(), None);
        let merge = Merge { shards: ShardUse::Ignore, ..merge };
        merge.run(&mut MergeTarget::Store(self))
    }
}

/// Checks that stores and exports belong together before there is a store to merge them into.
///
/// # Errors
/// [`MergeError::StudiesDiffer`] and [`MergeError::ShardCounts`], and [`MergeError::Read`] if a
/// source cannot be read.
pub fn require_mergeable(sources: &[&StoreReader], rules: &MergeRules) -> Result<(), MergeError> {
    let all = MergeSelection::default();
    let mut merge = Merge::new(sources, rules, &all, Path::new(""), None);
    merge.unite_shards(None)?;
    merge.compare_studies(None).map(drop)
}

/// Merges stores and exports into the export `target`, which takes its place when it is whole. What
/// an export there holds already stays. Otherwise it is like [`Store::import`].
///
/// # Errors
/// Those of [`Store::import`], and [`ExportError`] if the file at `target` is the export of a shard
/// or no export at all, or if another process writes it meanwhile.
pub fn merge_into_export(
    target: &Path,
    program: &str,
    sources: &[&StoreReader],
    rules: &MergeRules,
    selection: &MergeSelection,
) -> Result<MergeReport, MergeError> {
    // A merge that goes on at the same time and ends first removes this file, and so this one ends
    // without having taken the place of what it has not read.
    let header = ExportHeader { program: program.to_owned(), shard: None };
    let mut writer = ExportWriter::beside(target, &header)?;
    let before = FileIdentity::of_path(target);
    let earlier = durable::is_present(target).then(|| Store::read_by(target, rules)).transpose()?;
    if let Some(shard) =
        earlier.iter().flat_map(StoreReader::exports).find_map(|export| export.header.shard)
    {
        return Err(ExportError::OtherShard {
            path: target.to_owned(),
            found: shard.to_string(),
            wanted: "a merge".to_owned(),
        }
        .into());
    }
    let merge = Merge::new(sources, rules, selection, target, earlier.as_ref());
    let mut report = merge.run(&mut MergeTarget::Export(&mut writer))?;
    for export in earlier.iter().flat_map(StoreReader::exports) {
        let words = export.damage.iter().map(|reason| format!("{}: {reason}", target.display()));
        report.faults.extend(words);
    }
    writer.write_end()?;
    let changed = || ExportError::Changed { path: target.to_owned() };
    if FileIdentity::of_path(target) != before {
        return Err(changed().into());
    }
    writer.settle().map_err(|error| match error {
        ExportError::TakenOver { .. } => changed(),
        error => error,
    })?;
    Ok(report)
}
