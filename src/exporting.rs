//! The export that a run writes while it goes on.
//!
//! Results are added after they are durable in the store, and reach the file within [`LAG`]. A run
//! that starts again goes on from the file, wherever it runs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use identity::JobKey;
use runner::Interrupt;
use store::{ExportError, ExportHeader, ExportWriter, ShardName, Store};
use study::{Record, Study};

use crate::merge_rules::{RULES, ShardNote, references};
use crate::output;
use crate::words::count;

/// The longest time for which a result waits to be written \[s\].
const LAG: Duration = Duration::from_secs(10);

/// The export of a run.
pub(crate) struct Exporter {
    path: PathBuf,
    shared: Arc<SharedExport>,
    /// The thread that writes what waits.
    writing: Option<JoinHandle<()>>,
}

/// The part of an exporter that its thread shares.
struct SharedExport {
    state: Mutex<ExportState>,
    changed: Condvar,
}

struct ExportState {
    writer: ExportWriter,
    /// The path of the study file as it was given.
    file: PathBuf,
    /// The results in the file, and whether each is certified.
    results: HashMap<JobKey, bool>,
    /// The number of jobs that the study is known to have.
    jobs: usize,
    /// The time since which something waits to be written.
    waiting: Option<Instant>,
    /// True when the run is over.
    is_over: bool,
    /// True when nothing is left to run.
    is_finished: bool,
    /// True if a failure to write was said already.
    has_complained: bool,
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
}

impl ExportPlace {
    /// Returns the export of a shard in a directory.
    pub(crate) fn of(directory: &Path, shard: ShardName, file: &Path) -> Self {
        let ShardName { study, index, count } = &shard;
        let path = directory.join(format!("{study}.{index}-of-{count}.tribosweep"));
        Self { path, shard, file: file.to_owned() }
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
        let ExportPlace { path, shard, file } = place;
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
            let earlier = Store::read_by(&path, &RULES)?;
            let report = store.import(&[&earlier], &RULES)?;
            if report.added > 0 {
                output::say(&format!(
                    "goes on from {} in {}",
                    count(report.added, "result", "results"),
                    path.display()
                ));
            }
        }
        let shared = Arc::new(SharedExport {
            state: Mutex::new(ExportState {
                writer,
                file,
                results: HashMap::new(),
                jobs: 0,
                waiting: None,
                is_over: false,
                is_finished: false,
                has_complained: false,
                interrupt: interrupt.clone(),
            }),
            changed: Condvar::new(),
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
        for key in cached {
            if state.results.contains_key(key) {
                continue;
            }
            if let Ok(Some(bytes)) = store.get(key) {
                let is_there = state.writer.contains(key);
                state.add(store, key, &bytes, is_there);
            }
        }
        self.shared.changed.notify_all();
    }

    /// Adds results that are durable in the store.
    pub(crate) fn add(&self, store: &Store, records: &[(JobKey, Vec<u8>)]) {
        let mut state = self.shared.state();
        for (key, bytes) in records {
            state.add(store, key, bytes, false);
        }
        self.shared.changed.notify_all();
    }

    /// Writes everything, and whether the run has nothing left to do; returns how many results the
    /// file has.
    pub(crate) fn close(
        mut self,
        store: &Store,
        keys: &[JobKey],
        is_finished: bool,
    ) -> Result<usize> {
        // What could not be written before is tried once more.
        self.expect(store, keys.len(), keys);
        self.stop();
        let mut state = self.shared.state();
        state.is_finished = is_finished;
        let outcome = state.flush().and_then(|()| match is_finished {
            true => state.writer.close(),
            false => Ok(()),
        });
        outcome.with_context(|| format!("the export {} is not whole", self.path.display()))?;
        Ok(state.writer.len())
    }

    fn stop(&mut self) {
        self.shared.state().is_over = true;
        self.shared.changed.notify_all();
        if let Some(writing) = self.writing.take() {
            let _ = writing.join(); // It ends by itself, and leaves the rest to `close`.
        }
    }
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
    fn state(&self) -> MutexGuard<'_, ExportState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes what has waited long enough, until the run is over.
    fn write_in_time(&self) {
        let mut state = self.state();
        while !state.is_over {
            let left = state.waiting.map(|since| LAG.saturating_sub(since.elapsed()));
            match left {
                Some(left) if left.is_zero() => {
                    let outcome = state.flush();
                    state.complain(outcome.err());
                    // A disk that is full is tried again later.
                    state.waiting = state.waiting.map(|_| Instant::now());
                }
                left => {
                    let wait = left.unwrap_or(Duration::MAX.min(LAG));
                    let waited = self.changed.wait_timeout(state, wait);
                    state = waited.unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        }
    }
}

impl ExportState {
    /// Adds a result, unless the file has it already.
    fn add(&mut self, store: &Store, key: &JobKey, bytes: &[u8], is_there: bool) {
        if !is_there {
            let blobs = Record::decode(bytes).map(|record| references(&record));
            let blobs = blobs.unwrap_or_default();
            if let Err(error) = self.writer.append(key, bytes, store.blobs(), blobs) {
                return self.complain(Some(error));
            }
        }
        let is_certified = Record::decode(bytes).is_ok_and(|record| record.is_certified());
        self.results.insert(*key, is_certified);
        self.waiting.get_or_insert_with(Instant::now);
    }

    /// Writes everything durably, with how far the shard is.
    fn flush(&mut self) -> Result<(), ExportError> {
        let done = self.results.values().filter(|is_certified| **is_certified).count();
        let note = ShardNote {
            jobs: self.jobs as u64,
            done: done as u64,
            failed: (self.results.len() - done) as u64,
            left: self.jobs.saturating_sub(self.results.len()) as u64,
            finished: self.is_finished,
            file: Some(self.file.display().to_string()),
        };
        self.writer.note(&note.to_bytes());
        self.writer.flush()?;
        self.waiting = None;
        Ok(())
    }

    /// Says once that results cannot be written. If another process goes on with the file, the run
    /// ends.
    fn complain(&mut self, error: Option<ExportError>) {
        let Some(error) = error else { return };
        if matches!(error, ExportError::TakenOver { .. }) {
            self.interrupt.raise();
        }
        if !std::mem::replace(&mut self.has_complained, true) {
            output::say(&format!("warning: {error}; it is tried again"));
        }
    }
}
