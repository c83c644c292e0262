//! This file merges stores and exports into a store or into one export.
//!
//! The order of the sources does not matter, and neither does it how often they are merged, as long
//! as no two of them have different results of one job. Of such results none is taken if they are
//! merged at once; in several steps the one that came first stays, and every merge reports it.
//! First the keys of all sources are compared, which takes some 90 bytes for each record. Then the
//! jobs that have several records are decided without keeping any record, and at last every source
//! is read once more, from its beginning to its end, and what it has to give is written.

mod report;
mod source;
mod target;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use identity::JobKey;

use crate::digest::Digest;
use crate::durable;
use crate::error::{ReadError, WriteError};
use crate::export::{ExportError, ExportWriter};
use crate::exports::{ExportHeader, FileIdentity, ShardName, ShardState};
use crate::parts;
use crate::reader::StoreReader;
use crate::rules::{Candidate, Examination, MergeRules, RecordChoice, RecordRank};
use crate::store::Store;

pub use self::report::{MergeError, MergeReport, MergeSelection, RecordConflict};
use self::source::MergeSource;
use self::target::MergeTarget;

/// The size of the records that are committed together \[bytes\]. They are sorted first, so that a
/// page of the database is written less often (measured with a million records of 800 bytes: 12 400
/// records a second in groups of 4 MiB, 19 400 in these).
const GROUP_BYTES: usize = 32 << 20;

/// The largest number of records that are committed together.
const GROUP_RECORDS: usize = 65_536;

/// The number of the target where the sources are numbered.
const TARGET: u32 = u32::MAX;

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
    shards: ShardUse,
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
                    let blobs = found.references.into_iter();
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
                for digest in &found.references {
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
