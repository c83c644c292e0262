//! The export that a run writes while it goes on.
//!
//! Results are added after they are durable in the store, and reach the file within [`LAG`]. A
//! thread writes them, so that a file system that hangs holds up no run. A run that starts again
//! goes on from the file, wherever it runs. The file counts as finished only if it has a result of
//! every job.

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use identity::JobKey;
use runner::Interrupt;
use store::{Blobs, ExportError, ExportHeader, ExportWriter, References, ShardName, Store};
use study::{Record, Study};

use crate::merge_rules::{RULES, ShardNote, references};
use crate::output;
use crate::words::count;

/// The longest time for which a result waits to be written \[s\].
const LAG: Duration = Duration::from_secs(10);

/// The size of the results that may wait to be written \[bytes\]. What is beyond it is taken from
/// the store when the run ends.
const MOST_WAITING: usize = 64 << 20;

/// The export of a run.
pub(crate) struct Exporter {
    path: PathBuf,
    shared: Arc<SharedExport>,
    /// The thread that writes what waits.
    writing: Option<JoinHandle<()>>,
}

/// The part of an exporter that its thread shares.
struct SharedExport {
    waiting: Mutex<WaitingResults>,
    changed: Condvar,
    /// The file. It is locked while it is written, and never by whoever only adds results.
    state: Mutex<ExportState>,
}

/// The results that wait to be written.
#[derive(Default)]
struct WaitingResults {
    records: Vec<(JobKey, Vec<u8>)>,
    bytes: usize,
    /// The time since which the first one waits.
    since: Option<Instant>,
    /// True when the run is over.
    is_over: bool,
}

/// The file, and what is known of it.
struct ExportState {
    writer: ExportWriter,
    /// The files of fields in the store.
    blobs: Blobs,
    /// The path of the study file as it was given.
    file: PathBuf,
    partition: Option<String>,
    /// The results in the file, and whether each is certified.
    results: HashMap<JobKey, bool>,
    /// The number of jobs that the study is known to have; 0 as long as that is not known.
    jobs: usize,
    /// The last failure to write, in words, until it has gone.
    fault: Option<String>,
    interrupt: Interrupt,
}

/// The path of an export, and what it is an export of.
pub(crate) struct ExportPlace {
    /// The path of the file.
    pub(crate) path: PathBuf,
    /// The shard.
    pub(crate) shard: ShardName,
    /// The path of the study file as it was given.
    pub(crate) file: PathBuf,
    /// The digest of the partition, if the study was cut.
    pub(crate) partition: Option<String>,
}

impl ExportPlace {
    /// Returns the export of a shard in a directory.
    pub(crate) fn of(
        directory: &Path,
        shard: ShardName,
        file: &Path,
        partition: Option<String>,
    ) -> Self {
        let ShardName { study, index, count } = &shard;
        let path = directory.join(format!("{study}.{index}-of-{count}.tribosweep"));
        Self { path, shard, file: file.to_owned(), partition }
    }
}

impl Exporter {
    /// Starts an export or goes on with it: the store gets what it holds.
    pub(crate) fn open(
        place: ExportPlace,
        study: &Study,
        store: &Store,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        let ExportPlace { path, shard, file, partition } = place;
        let header =
            ExportHeader { program: env!("CARGO_PKG_VERSION").to_owned(), shard: Some(shard) };
        let mut writer = ExportWriter::open(&path, &header)?;
        if !is_defined(&writer, study)? {
            writer.put_study(study.name(), &study.definition())?;
        }
        for damage in writer.damage() {
            output::say(&format!("{}: {damage}", path.display()));
        }
        writer.flush()?;
        if !writer.is_empty() {
            restore(&path, store)?;
        }
        let shared = Arc::new(SharedExport {
            waiting: Mutex::default(),
            changed: Condvar::new(),
            state: Mutex::new(ExportState {
                writer,
                blobs: store.blobs().clone(),
                file,
                partition,
                results: HashMap::new(),
                jobs: 0,
                fault: None,
                interrupt: interrupt.clone(),
            }),
        });
        let seen = shared.clone();
        let writing = std::thread::Builder::new()
            .name("export".to_owned())
            .spawn(move || seen.write_in_time())
            .context("cannot start the thread that writes the export")?;
        Ok(Self { path, shared, writing: Some(writing) })
    }

    /// Returns the path of the file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Says how many jobs the study is known to have, and adds the results that the store has
    /// already.
    pub(crate) fn expect(&self, store: &Store, jobs: usize, cached: &[JobKey]) {
        let mut state = self.shared.state();
        state.jobs = jobs;
        for key in cached.iter().filter(|key| store.contains(key)) {
            if state.results.contains_key(key) {
                continue;
            }
            let outcome = match store.get(key) {
                Ok(Some(bytes)) => state.add(key, &bytes).map_err(|error| state.explain(&error)),
                Ok(None) => Ok(()),
                Err(error) => Err(error.to_string()),
            };
            state.remember(outcome);
        }
    }

    /// Adds results that are durable in the store.
    pub(crate) fn add(&self, records: Vec<(JobKey, Vec<u8>)>) {
        let mut waiting = self.shared.waiting();
        let bytes: usize = records.iter().map(|(_, bytes)| bytes.len()).sum();
        if waiting.bytes + bytes <= MOST_WAITING {
            waiting.bytes += bytes;
            waiting.records.extend(records);
            waiting.since.get_or_insert_with(Instant::now);
            self.shared.changed.notify_all();
        }
    }

    /// Writes everything that the store has of these jobs, and whether the run has nothing left to
    /// do; returns how many results the file has.
    ///
    /// # Errors
    /// A result that the store has cannot be written.
    pub(crate) fn close(
        mut self,
        store: &Store,
        keys: &[JobKey],
        is_finished: bool,
    ) -> Result<usize> {
        self.stop();
        // What could not be written before is tried once more.
        self.shared.state().fault = None;
        self.expect(store, keys.len(), keys);
        let mut state = self.shared.state();
        let is_whole = keys
            .iter()
            .filter(|key| store.contains(key))
            .all(|key| state.results.contains_key(key));
        let is_finished = is_finished && is_whole && state.results.len() >= state.jobs;
        let outcome = state.flush(is_finished).and_then(|()| match is_finished {
            true => state.writer.close(),
            false => Ok(()),
        });
        let not_whole = || format!("the export {} is not whole", self.path.display());
        outcome.with_context(not_whole)?;
        match state.fault.take() {
            Some(fault) if !is_whole => Err(anyhow!(fault).context(not_whole())),
            _ if !is_whole => bail!("{}", not_whole()),
            _ => Ok(state.results.len()),
        }
    }

    fn stop(&mut self) {
        self.shared.waiting().is_over = true;
        self.shared.changed.notify_all();
        if let Some(writing) = self.writing.take() {
            let _ = writing.join(); // It ends by itself, and leaves the rest to `close`.
        }
    }
}

/// Gives a store what an export holds.
fn restore(path: &Path, store: &Store) -> Result<()> {
    let earlier = Store::read_by(path, &RULES)?;
    let report = store.import_results(&[&earlier], &RULES)?;
    if let Some(conflict) = report.conflicts.first() {
        bail!(
            "{} has another result of job {} than the store in {}; remove one of them",
            path.display(),
            conflict.key,
            store.blobs().store().display()
        );
    }
    for fault in &report.faults {
        output::say(&format!("{}: {fault}", path.display()));
    }
    if report.added > 0 {
        let results = count(report.added, "result", "results");
        output::say(&format!("goes on from {results} in {}", path.display()));
    }
    Ok(())
}

/// Returns true if an export has the definition of a study, whatever the path of its file was.
fn is_defined(writer: &ExportWriter, study: &Study) -> Result<bool, ExportError> {
    let content = |definition: &[u8]| Study::definition_content(definition);
    let stored = writer.study(study.name())?;
    Ok(stored.is_some_and(|stored| content(&stored) == content(&study.definition())))
}

impl Drop for Exporter {
    fn drop(&mut self) {
        self.stop();
    }
}

impl SharedExport {
    fn waiting(&self) -> MutexGuard<'_, WaitingResults> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn state(&self) -> MutexGuard<'_, ExportState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes what has waited long enough, until the run is over.
    fn write_in_time(&self) {
        loop {
            let mut waiting = self.waiting();
            while !waiting.is_over && waiting.since.is_none_or(|since| since.elapsed() < LAG) {
                let left = waiting.since.map_or(LAG, |since| LAG.saturating_sub(since.elapsed()));
                let waited = self.changed.wait_timeout(waiting, left);
                waiting = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
            let WaitingResults { records, is_over, .. } = std::mem::take(&mut *waiting);
            waiting.is_over = is_over;
            drop(waiting);
            let mut state = self.state();
            for (key, bytes) in records {
                let outcome = state.add(&key, &bytes).map_err(|error| state.explain(&error));
                state.remember(outcome);
            }
            if is_over {
                return;
            }
            let outcome = state.flush(false).map_err(|error| state.explain(&error));
            state.remember(outcome);
        }
    }
}

impl ExportState {
    /// Adds a result, unless the file has it already.
    fn add(&mut self, key: &JobKey, bytes: &[u8]) -> Result<(), ExportError> {
        let record = Record::decode(bytes).ok();
        let References { needed, companions } = record.as_ref().map(references).unwrap_or_default();
        let is_there = self.writer.holds(key, bytes)
            && needed.iter().all(|digest| self.writer.has_blob(digest));
        for digest in &companions {
            self.writer.accompany(digest, &self.blobs)?;
        }
        if !is_there {
            self.writer.append(key, bytes, &self.blobs, needed)?;
        }
        self.results.insert(*key, record.is_some_and(|record| record.is_certified()));
        Ok(())
    }

    /// Writes everything durably, with how far the shard is.
    fn flush(&mut self, is_finished: bool) -> Result<(), ExportError> {
        if self.jobs > 0 || is_finished {
            let done = self.results.values().filter(|is_certified| **is_certified).count();
            let note = ShardNote {
                jobs: self.jobs as u64,
                done: done as u64,
                failed: (self.results.len() - done) as u64,
                left: self.jobs.saturating_sub(self.results.len()) as u64,
                finished: is_finished,
                file: Some(self.file.display().to_string()),
                partition: self.partition.clone(),
            };
            self.writer.note(&note.to_bytes());
        }
        self.writer.flush()
    }

    /// Says what a failure means. If the file is another's now or gone, the run ends.
    fn explain(&self, error: &ExportError) -> String {
        let is_gone = match error {
            ExportError::TakenOver { .. } => true,
            ExportError::Io { source, .. } => source.kind() == io::ErrorKind::NotFound,
            _ => false,
        };
        if is_gone {
            self.interrupt.raise();
            return format!("{error}; this run ends");
        }
        error.to_string()
    }

    /// Remembers a failure and says it, once as long as it lasts.
    fn remember(&mut self, outcome: Result<(), String>) {
        if let Err(fault) = outcome
            && self.fault.as_ref() != Some(&fault)
        {
            output::say(&format!("warning: {fault}"));
            self.fault = Some(fault);
        }
    }
}
