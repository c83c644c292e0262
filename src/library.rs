//! The functions that other languages use in process: one scene is solved, and a store is read, in
//! the same ways and with the same words as by the commands `solve`, `query` and `show`.
//!
//! Nothing here prints or starts a process, and no store is written. Studies are run by the
//! command, whose coordinator and workers are processes of their own.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use answers::{AnswerError, POINTS_IN_MEMORY, Results, RowSource, Selection, forecast, survey};
use anyhow::{Context, Result, bail};
use contact::model::Fields;
use contact::{Cancellation, FrictionProblem, Operators};
use indicatif::BinaryBytes;
use report::{DataTable, TableError};
use store::{OpenError, ReadError, StoreReader};
use study::columns::Role;
use study::{Column, DefinitionError, Job, MOST_POINTS, Study};

use crate::account::study_file;
use crate::increments::PathJob;
use crate::one_result::{self, UsedFiles};
use crate::solving::{SolvedScene, require_wanted, solve_scene, usable_memory};
use crate::stored::{
    self, StoreSource, find_key, open_to_read, reader_notes, stored_large_study, study_with_files,
};
use crate::study_file::{parse_with_files, read_text};
use crate::study_table::StudyTable;
use crate::{fields, output};

/// The text of a study with the files that stand nowhere else, by name. Other files that it names
/// are looked for beside `path`.
#[derive(Clone, Debug, Default)]
pub struct StudyText {
    /// The text; `None` if it is that of the file at `path`.
    pub text: Option<String>,
    /// The path that messages name.
    pub path: String,
    /// The files by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

impl StudyText {
    /// Reads the study, and refuses what makes no sense.
    ///
    /// # Errors
    /// The file cannot be read, or the text is no study.
    pub fn study(&self) -> Result<Study> {
        let path = Path::new(&self.path);
        let text = match &self.text {
            Some(text) => text.clone(),
            None => read_text(path)?,
        };
        Ok(parse_with_files(&text, path, &self.files)?)
    }
}

/// The result of a scene that was solved here.
pub struct SolvedResult {
    /// The JSON that `solve --json` prints.
    pub json: serde_json::Value,
    /// The canonical text of the job.
    pub job: String,
    /// The columns of the figures in it.
    pub columns: Vec<Column>,
    /// The fields, if it has some.
    pub fields: Option<Fields>,
    /// The doubts about it, in words.
    pub doubts: Vec<String>,
}

/// Solves the only scene of a study, until `cancellation` is requested.
///
/// # Errors
/// The study is none or has several points, it takes more memory than there is, its scene has no
/// meaning, or the solve was given up.
pub fn solve(text: &StudyText, cancellation: &Cancellation) -> Result<SolvedResult> {
    let study = &text.study()?;
    let is_file = text.text.is_none();
    let file = is_file.then(|| study_file(Path::new(&text.path), study.text()));
    if study.len() != 1 {
        bail!("the study `{}` has {} points; run it, or fix its axes", study.name(), study.len());
    }
    let solution = solve_scene(study, file, &mut Operators::cancelled_by(cancellation))?;
    require_wanted(cancellation)?;
    let SolvedScene { record, fields, account, .. } = &solution;
    let job = record.parse_job()?;
    let files = UsedFiles::of(study, &job);
    let json = one_result::json(record, fields.as_ref(), &files, Some(account))?;
    let of_search = match record.multiplicity() {
        Some(found) if !found.solutions.is_empty() => Some(fields::solution_fields(found, None)?),
        _ => None,
    };
    let (columns, doubts) = (job.kind().columns([], []), solution.doubts());
    let job = record.job.clone();
    Ok(SolvedResult { json, job, columns, fields: of_search.or(solution.fields), doubts })
}

pub use crate::typed_values::{TypedTable, TypedValues};

/// Returns the fields of every increment of a job's path, which is solved for them. `study` has the
/// files that the job names.
///
/// # Errors
/// The text is no job, the job follows no path, its fields take more memory than there is, or the
/// solve was given up.
pub fn path_fields(study: &Study, job: &str, cancellation: &Cancellation) -> Result<Vec<Fields>> {
    all_fields(&path_job(study, job)?, cancellation)
}

/// Returns the discrete friction problem of an increment of a job's path, of the last one by
/// default; the path is solved for it. `study` has the files that the job names.
///
/// # Errors
/// The text is no job, the job follows no path, it has no such increment or this one has no such
/// problem, or the solve was given up.
pub fn friction_problem(
    study: &Study,
    job: &str,
    increment: Option<u64>,
    cancellation: &Cancellation,
) -> Result<FrictionProblem> {
    problem_of(&path_job(study, job)?, increment, cancellation)
}

fn path_job<'s>(study: &'s Study, job: &str) -> Result<PathJob<'s>> {
    Ok(PathJob { job: Job::parse(job)?, surfaces: study.surfaces(), record: None })
}

/// The bytes of an element in [`Fields`].
const ELEMENT_BYTES: u64 = 6 * 8 + 1;

fn all_fields(path: &PathJob<'_>, cancellation: &Cancellation) -> Result<Vec<Fields>> {
    let increments = path.increments()?;
    let elements = forecast(&path.job, path.surfaces)?.elements;
    let needed = increments * elements.iter().map(|n| *n as u64).product::<u64>() * ELEMENT_BYTES;
    // They are made of a second copy, as arrays over all increments.
    if let Some(limit) = usable_memory().filter(|&limit| 2 * needed > limit) {
        bail!(
            "the fields of {increments} increments take twice {}, and this process may use {}: \
             write them to files one after the other, `show KEY --output NAME.pvd`",
            BinaryBytes(needed),
            BinaryBytes(limit)
        );
    }
    let mut fields = Vec::new();
    path.follow(cancellation, &mut |increment| {
        fields.push(increment.fields.clone());
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(fields)
}

fn problem_of(
    path: &PathJob<'_>,
    increment: Option<u64>,
    cancellation: &Cancellation,
) -> Result<FrictionProblem> {
    let increments = path.increments()?;
    let wanted = increment.unwrap_or(increments);
    if !(1..=increments).contains(&wanted) {
        bail!("there is no increment {wanted}: the path has {increments}, counted from 1");
    }
    let mut found = None;
    path.follow(cancellation, &mut |increment| {
        if increment.number < wanted {
            return Ok(ControlFlow::Continue(()));
        }
        found = Some(increment.friction_problem()?);
        Ok(ControlFlow::Break(()))
    })?;
    found.with_context(|| format!("the path ended before its increment {wanted}"))
}

/// The fields of a stored result.
pub struct StoredFields {
    /// The fields.
    pub fields: Fields,
    /// The key of the job in full.
    pub key: String,
    /// True if they are those of a solution, false if they are those of a last iterate.
    pub is_certified: bool,
}

/// A store that is read, or exports. Each question is answered from what is there at that moment.
pub struct ReadStore {
    directory: PathBuf,
    opened: Mutex<OpenedReader>,
}

/// A reader, and the process that has opened it.
struct OpenedReader {
    process: u32,
    reader: Arc<StoreReader>,
}

impl OpenedReader {
    fn new(directory: &Path) -> Result<Self> {
        let reader = Arc::new(open_to_read(directory)?);
        Ok(OpenedReader { process: std::process::id(), reader })
    }

    /// Returns true if this process has opened it. A forked child shares its parent's connection,
    /// on which each would take the answers to the other.
    fn is_ours(&self) -> bool {
        self.process == std::process::id()
    }
}

impl Drop for OpenedReader {
    fn drop(&mut self) {
        if !self.is_ours() {
            // The parent goes on with its connection and its private copy, which stay as they are.
            std::mem::forget(self.reader.clone());
        }
    }
}

impl ReadStore {
    /// Opens a store beside whatever run is writing it.
    ///
    /// # Errors
    /// There is no store, or it cannot be read.
    pub fn open(directory: &Path) -> Result<Self> {
        let opened = Mutex::new(OpenedReader::new(directory)?);
        Ok(ReadStore { directory: directory.to_owned(), opened })
    }

    /// Returns the reader for one question: the one that is open, or a new one if records may have
    /// come since or another process has opened it. To look takes 0.2 ms, to open a small store
    /// takes 4 ms.
    fn reader(&self) -> Result<Arc<StoreReader>> {
        let opened = || self.opened.lock().unwrap_or_else(PoisonError::into_inner);
        let present = {
            let opened = opened();
            opened.is_ours().then(|| opened.reader.clone())
        };
        if let Some(reader) = present.filter(|reader| reader.is_current()) {
            return Ok(reader);
        }
        let new = OpenedReader::new(&self.directory)?;
        let reader = new.reader.clone();
        // The lock is held for moments only: a child that is forked meanwhile would wait for ever.
        let before = std::mem::replace(&mut *opened(), new);
        drop(before);
        Ok(reader)
    }

    /// Returns what is to be said of the place from which records are read.
    ///
    /// # Errors
    /// The store cannot be read any more.
    pub fn notes(&self) -> Result<Vec<String>> {
        Ok(reader_notes(&*self.reader()?))
    }

    /// Returns the names of the studies in alphabetical order.
    ///
    /// # Errors
    /// They cannot be read.
    pub fn names(&self) -> Result<Vec<String>> {
        Ok(self.reader()?.study_names()?)
    }

    /// Returns a study.
    ///
    /// # Errors
    /// There is none of this name, or it is damaged.
    pub fn study(&self, name: &str) -> Result<Study> {
        stored_large_study(&*self.reader()?, name)
    }

    /// Returns what is chosen of a study; without columns, those that answer its question at a
    /// glance.
    ///
    /// # Errors
    /// There is no such study or column, a record cannot be read, or the condition cannot be
    /// evaluated.
    pub fn table(&self, name: &str, mut selection: Selection) -> Result<TypedTable> {
        if let Some(table) = self.kept_table(name, selection.clone()) {
            return Ok(table);
        }
        let reader = self.reader()?;
        let source = StoreSource::Reader(&reader);
        let study = stored_large_study(&reader, name)?;
        if selection.columns.is_empty() && !study.is_listed() {
            // Which figures say something is not known of so many.
            selection.columns = columns_of_any(&study);
        }
        if selection.columns.is_empty()
            && study.has_independent_points()
            && study.point_count() > POINTS_IN_MEMORY
        {
            let notes = survey(&study, &source, None)?;
            selection.columns = notes.usual_columns(selection.steps).to_vec();
        }
        if !selection.columns.is_empty() && selection.is_separable(&study) {
            let mut table = TypedTable::new(selection.typed_columns(&study)?);
            let rows = RowSource::Records { records: &source, keeper: None };
            selection.visit(&study, rows, |block| {
                table.add(block);
                Ok::<(), AnswerError>(())
            })?;
            return Ok(table);
        }
        if !study.is_listed() {
            bail!(
                "the study `{name}` has {} points, and {MOST_POINTS} at most are sorted or compared \
                 with each other: ask without `sort`, and sort what comes",
                study.len()
            );
        }
        let results = Results::read(study, &source)?;
        if selection.columns.is_empty() {
            selection.columns = results.usual_columns(selection.steps)?;
        }
        let mut table = TypedTable::new(selection.typed_columns(results.study())?);
        table.add(&selection.of(&results)?);
        Ok(table)
    }

    /// Returns what is chosen of the table that is kept of a study; `None` if that takes the
    /// records, or if something is wrong with the choice, which they tell.
    fn kept_table(&self, name: &str, mut selection: Selection) -> Option<TypedTable> {
        let (table, study) = StudyTable::of(&self.directory, name)?;
        if selection.columns.is_empty() {
            selection.columns = match study.is_listed() {
                true => table.usual_columns()?.to_vec(),
                false => columns_of_any(&study),
            };
        }
        if !selection.is_in_table(&study, &table) {
            return None;
        }
        let mut typed = TypedTable::new(selection.typed_columns(&study).ok()?);
        if selection.is_separable(&study) {
            let add = |block: &DataTable| {
                typed.add(block);
                Ok::<(), AnswerError>(())
            };
            selection.visit(&study, RowSource::Table(&table), add).ok()?;
        } else if study.is_listed() {
            typed.add(&selection.of_table(&study, &table).ok()?);
        } else {
            return None;
        }
        Some(typed)
    }

    /// Returns the only key that begins with some characters.
    ///
    /// # Errors
    /// There is no such result, or there are several.
    pub fn key(&self, beginning: &str) -> Result<String> {
        Ok(find_key(&*self.reader()?, beginning)?.to_string())
    }

    /// Returns the fields of the result whose key begins with some characters.
    ///
    /// # Errors
    /// There is no such result or there are several, or it has no fields.
    pub fn fields(&self, key: &str) -> Result<StoredFields> {
        let reader = self.reader()?;
        let key = find_key(&reader, key)?;
        let record = stored::record(&reader, &key)?;
        let fields = match record.multiplicity() {
            Some(found) => fields::solution_fields(found, None)?,
            None => stored::fields(reader.blobs(), &record)?,
        };
        Ok(StoredFields { fields, key: key.to_string(), is_certified: record.is_certified() })
    }

    /// Returns everything about the result whose key begins with some characters, as `show --json`
    /// prints it for a scene without files.
    ///
    /// # Errors
    /// There is no such result, or there are several.
    pub fn show(&self, key: &str) -> Result<serde_json::Value> {
        let reader = self.reader()?;
        let record = stored::record(&reader, &find_key(&reader, key)?)?;
        let run = record.provenance.run.as_ref();
        let account = run.and_then(|run| stored::account(reader.blobs(), run));
        one_result::json(&record, None, &UsedFiles::default(), account.as_ref())
    }

    /// Returns the fields of every increment of the result whose key begins with some characters.
    /// Its path is solved again, and every increment is the one that its record has.
    ///
    /// # Errors
    /// There is no such result or there are several, or the errors of [`path_fields`].
    pub fn path_fields(&self, key: &str, cancellation: &Cancellation) -> Result<Vec<Fields>> {
        self.with_path(key, |path| all_fields(path, cancellation))
    }

    /// Returns the discrete friction problem of an increment of the result whose key begins with
    /// some characters, of the last one by default. Its path is solved again, and every increment
    /// is the one that its record has.
    ///
    /// # Errors
    /// There is no such result or there are several, or the errors of [`friction_problem`].
    pub fn friction_problem(
        &self,
        key: &str,
        increment: Option<u64>,
        cancellation: &Cancellation,
    ) -> Result<FrictionProblem> {
        self.with_path(key, |path| problem_of(path, increment, cancellation))
    }

    fn with_path<T>(&self, key: &str, of: impl FnOnce(&PathJob<'_>) -> Result<T>) -> Result<T> {
        let reader = self.reader()?;
        let record = stored::record(&reader, &find_key(&reader, key)?)?;
        let job = record.parse_job()?;
        let study = study_with_files(&reader, &job)?;
        let surfaces = study.as_ref().map(Study::surfaces).cloned().unwrap_or_default();
        of(&PathJob { job, surfaces: &surfaces, record: Some(&record) })
    }
}

/// Returns the names of the axes and of the figures that a study of its kind shows in any case.
fn columns_of_any(study: &Study) -> Vec<String> {
    let columns = study.columns();
    let axes = columns.iter().filter(|column| column.role == Role::Axis);
    let mut names: Vec<String> = axes.map(|column| column.name.to_string()).collect();
    for name in study.kind().usual_columns() {
        if !names.iter().any(|known| known == name) {
            names.push((*name).to_owned());
        }
    }
    names
}

/// The kind of a fault, for languages that tell errors apart by type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The study makes no sense; the places say where.
    Study,
    /// The store cannot be read.
    Store,
    /// The question to a study cannot be answered.
    Query,
    /// Anything else.
    Other,
}

/// A mistake in a study and its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MistakePlace {
    /// The mistake in words.
    pub message: String,
    /// The line, counted from 1.
    pub line: usize,
    /// The column in characters, counted from 1.
    pub column: usize,
}

/// Returns the words that the command would say about an error.
pub fn words(error: &anyhow::Error) -> String {
    output::words(error)
}

/// Returns the kind of an error.
pub fn kind(error: &anyhow::Error) -> FaultKind {
    if output::study_error(error).is_some() || error.downcast_ref::<DefinitionError>().is_some() {
        return FaultKind::Study;
    }
    if error.is::<OpenError>() || error.is::<ReadError>() {
        return FaultKind::Store;
    }
    match error.downcast_ref::<AnswerError>() {
        Some(AnswerError::Records(_)) => FaultKind::Store,
        Some(_) => FaultKind::Query,
        None if error.is::<TableError>() => FaultKind::Query,
        None => FaultKind::Other,
    }
}

/// Returns the mistakes of an error about a study with their places.
pub fn places(error: &anyhow::Error) -> Vec<MistakePlace> {
    let Some(error) = output::study_error(error) else { return Vec::new() };
    let place = |mistake: &study::Mistake| {
        let (line, column) = error.position(mistake);
        MistakePlace { message: mistake.message.clone(), line, column }
    };
    error.mistakes().iter().map(place).collect()
}
