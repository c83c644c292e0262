//! The results of a large study whose points are compared with nothing, read in blocks, of which
//! one is in memory at a time.

use identity::KeptFields;
use report::DataTable;
use study::columns::Role;
use study::{Column, Figure, Record, Study};

use crate::accounts::Accounts;
use crate::block::{POINTS_AT_ONCE, ResultBlock, visit};
use crate::error::AnswerError;
use crate::path::PathColumns;
use crate::progress::{Failures, Progress};
use crate::records::Records;
use crate::rows::heads;
use crate::study_rows::HeldRows;
use crate::tabled::{RowKeeper, SurveyNotes, TabledRows, rows_of_table, tabled_columns};
use crate::undrawn::IS_CERTIFIED;
use crate::variation::{FigureRanges, answering_figures, columns_of, first_varying, noise};
use crate::warnings::{ElementDoubts, EstimateDoubts, InteriorDoubts, RequiredError, Subject};

/// The number of rows that are kept of a study that is too large for a figure.
const FIRST_ROWS: usize = 1000;

/// The number of failed jobs that are kept where results are read in blocks.
const MOST_FAILURES: usize = 10_000;

/// The notes of the results of a study, as they pass by.
pub(crate) struct Surveyor<'s> {
    study: &'s Study,
    progress: Progress,
    elements: ElementDoubts,
    interiors: InteriorDoubts,
    estimates: EstimateDoubts,
    noise: f64,
    /// The columns that the jobs ask for.
    requests: Vec<&'static str>,
    path: PathColumns,
    has_files: bool,
    fieldless: usize,
    has_paths: bool,
    /// The columns from which it follows what the suggested figures show.
    columns: Vec<Column>,
    ranges: Vec<FigureRanges<'s>>,
}

impl<'s> Surveyor<'s> {
    /// Begins to take notes of a study; `None` if its points are compared or chosen.
    pub(crate) fn of(study: &'s Study) -> Option<Self> {
        if !study.has_independent_points() {
            return None;
        }
        let suggestions = if study.is_listed() { study.suggestions() } else { &[] };
        let names = columns_of(suggestions);
        let mut columns = study.columns();
        columns.retain(|column| names.contains(&&*column.name));
        Some(Surveyor {
            study,
            progress: Progress::default(),
            elements: ElementDoubts::new(Subject::Points),
            interiors: InteriorDoubts::new(Subject::Points),
            estimates: EstimateDoubts::new(Subject::Points, RequiredError::LARGE),
            noise: 0.0,
            requests: Vec::new(),
            path: PathColumns::default(),
            has_files: false,
            fieldless: 0,
            has_paths: false,
            columns,
            ranges: suggestions.iter().map(FigureRanges::of).collect(),
        })
    }

    /// Adds the next points with their records.
    pub(crate) fn add(&mut self, block: &ResultBlock<'_>) -> Result<(), AnswerError> {
        self.noise = self.noise.max(noise(block.points));
        for point in block.points {
            let record = block.records.get(&point.key);
            self.progress.add(record);
            self.path.add(point);
            for name in point.job.asked_columns() {
                if !self.requests.contains(&name) {
                    self.requests.push(name);
                }
            }
            let Some(record) = record else { continue };
            self.elements.add(record);
            self.interiors.add(record);
            self.estimates.add(record);
            self.has_files |= has_file(record);
            self.has_paths |= record.outcome().is_some_and(|outcome| outcome.steps.len() > 1);
            self.fieldless += usize::from(record.is_certified() && !leaves_fields(record));
        }
        if self.ranges.is_empty() {
            return Ok(());
        }
        let rows = DataTable::new(heads(&self.columns), block.rows(&self.columns))?;
        let certified = rows.filter(IS_CERTIFIED)?;
        self.ranges.iter_mut().try_for_each(|ranges| ranges.add(&certified))
    }

    /// Returns the figures that answer the study's question.
    fn figures(&self) -> Result<Vec<Figure>, AnswerError> {
        answering_figures(self.study, |_| Ok(first_varying(&self.ranges, self.noise)))
    }

    /// Returns what was noted.
    pub(crate) fn notes(self) -> Result<SurveyNotes, AnswerError> {
        let mut warnings = self.elements.warnings();
        warnings.extend(self.interiors.warning());
        warnings.extend(self.estimates.warnings());
        let figures = self.figures()?;
        let (study, noise) = (self.study, self.noise);
        let requests = &self.requests[..];
        let usual = |path| usual_names(study, &figures, path, requests);
        Ok(SurveyNotes {
            done: self.progress.done,
            failed: self.progress.failed,
            left: self.progress.left,
            warnings,
            noise,
            has_files: self.has_files,
            fieldless: self.fieldless,
            has_paths: self.has_paths,
            usual: [usual(None), usual(Some(self.path.names()))],
        })
    }
}

impl SurveyNotes {
    /// Returns how far the study is.
    pub(crate) fn progress(&self, study: &Study) -> Progress {
        let SurveyNotes { done, failed, left, .. } = *self;
        Progress { points: done + failed + left, done, failed, left, excluded: study.excluded() }
    }
}

/// Reads the results of a study whose points are compared with nothing, a block of them at a time,
/// and returns what is noted of them. The keeper keeps all rows.
///
/// # Errors
/// A record cannot be read, or the points of the study are compared or chosen.
pub fn survey(
    study: &Study,
    source: &dyn Records,
    keeper: Option<&dyn RowKeeper>,
) -> Result<SurveyNotes, AnswerError> {
    let none = AnswerError::Inconsistent("the points of the study depend on each other");
    let mut surveyor = Surveyor::of(study).ok_or(none)?;
    let tabled = tabled_columns(study);
    keeper.into_iter().for_each(|keeper| keeper.begin(&tabled));
    let accounts = visit(study, source, POINTS_AT_ONCE, &mut |block| {
        keeper.into_iter().for_each(|keeper| block.keep(&tabled, keeper));
        surveyor.add(&block).map(|()| true)
    })?;
    let notes = surveyor.notes()?;
    keeper.into_iter().for_each(|keeper| keeper.end(&accounts, Some(&notes)));
    Ok(notes)
}

/// Returns the columns that answer a study's question at a glance: the axes, those of its figures,
/// the usual observables and what its jobs ask for; of increments, with the columns of their
/// `path`.
pub(crate) fn usual_names(
    study: &Study,
    figures: &[Figure],
    path: Option<Vec<String>>,
    requests: &[&str],
) -> Vec<String> {
    let columns = study.columns();
    let axes = columns.iter().filter(|column| column.role == Role::Axis);
    let mut names: Vec<String> = axes.map(|column| column.name.to_string()).collect();
    let figures = figures.iter().filter(|figure| path.is_some() || !figure.steps);
    let of_figures: Vec<String> = figures
        .flat_map(|figure| {
            let x = Some(&figure.x).filter(|x| !x.is_empty());
            x.into_iter().chain(&figure.y).chain(figure.band.iter().flatten())
        })
        .cloned()
        .collect();
    let names_after = match path {
        // The place on the path comes first.
        Some(path) => [path, of_figures],
        None => {
            let usual = study.kind().usual_columns().iter().chain(requests);
            [of_figures, usual.map(|name| (*name).to_owned()).collect()]
        }
    };
    for name in names_after.into_iter().flatten() {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The knowledge of the results of a study of which none is in memory.
pub(crate) struct Survey<'r> {
    pub(crate) notes: SurveyNotes,
    /// The figures that answer the study's question; `None` if only its rows tell.
    pub(crate) figures: Option<Vec<Figure>>,
    /// The jobs that have failed; `None` if only the records tell.
    failures: Option<Failures>,
    /// The accounts of the runs, unless the table has them.
    accounts: Accounts,
    rows: SurveyedRows<'r>,
}

/// The rows of a study that was surveyed.
enum SurveyedRows<'r> {
    /// The columns that figures and summaries show, of all points or of the first.
    Shown(DataTable),
    /// A table of all of them.
    Tabled(&'r dyn TabledRows),
}

/// Returns whether a record has fields: its own, or those of a solution that a search has found.
pub(crate) fn leaves_fields(record: &Record) -> bool {
    match record.multiplicity() {
        Some(found) => !found.solutions.is_empty(),
        None => record.fields.is_some(),
    }
}

/// Returns whether a record has its fields in a file.
pub(crate) fn has_file(record: &Record) -> bool {
    matches!(record.fields, Some(KeptFields::Blob(_)))
}

impl<'r> Survey<'r> {
    /// Reads the results of a study block by block.
    pub(crate) fn of(study: &Study, source: &dyn Records) -> Result<Self, AnswerError> {
        let none = AnswerError::Inconsistent("the points of the study depend on each other");
        let mut surveyor = Surveyor::of(study).ok_or(none)?;
        let mut columns = study.columns();
        columns.retain(|column| is_shown(study, column));
        let mut failures = Failures::default();
        let most = if study.is_listed() { usize::MAX } else { FIRST_ROWS };
        let mut rows = Vec::new();
        let accounts = visit(study, source, POINTS_AT_ONCE, &mut |block| {
            block.computed().for_each(|(_, record)| failures.add(record, MOST_FAILURES));
            if rows.len() < most {
                rows.extend(block.rows(&columns));
                rows.truncate(most);
            }
            surveyor.add(&block).map(|()| true)
        })?;
        let rows = SurveyedRows::Shown(DataTable::new(heads(&columns), rows)?);
        let (figures, failures) = (Some(surveyor.figures()?), Some(failures));
        Ok(Survey { notes: surveyor.notes()?, figures, failures, accounts, rows })
    }

    /// Takes a table of a study for its results, with what was noted of them.
    pub(crate) fn of_table(notes: SurveyNotes, table: &'r dyn TabledRows) -> Self {
        let (accounts, rows) = (Accounts::default(), SurveyedRows::Tabled(table));
        Survey { notes, figures: None, failures: None, accounts, rows }
    }

    /// Returns the jobs that have ended without a solution.
    pub(crate) fn failures(
        &self,
        study: &Study,
        source: &dyn Records,
    ) -> Result<Failures, AnswerError> {
        if let Some(failures) = &self.failures {
            return Ok(failures.clone());
        }
        let mut failures = Failures::default();
        visit(study, source, POINTS_AT_ONCE, &mut |block| {
            block.computed().for_each(|(_, record)| failures.add(record, MOST_FAILURES));
            Ok::<bool, AnswerError>(true)
        })?;
        Ok(failures)
    }

    /// Returns the accounts of the runs that computed the results.
    pub(crate) fn accounts(&self) -> Accounts {
        match self.rows {
            SurveyedRows::Shown(_) => self.accounts.clone(),
            SurveyedRows::Tabled(table) => table.accounts(),
        }
    }

    /// Returns the place where every row with every column comes from.
    pub(crate) fn held(&self, source: &'r dyn Records) -> HeldRows<'r> {
        match self.rows {
            SurveyedRows::Shown(_) => HeldRows::Records(source),
            SurveyedRows::Tabled(table) => HeldRows::Table(table),
        }
    }

    /// Returns the first `most` rows of a study with some columns: those that were kept, else they
    /// are read again. Of a study that makes no figure there may be still fewer.
    pub(crate) fn table(
        &self,
        study: &Study,
        source: &dyn Records,
        columns: Vec<Column>,
        most: usize,
    ) -> Result<DataTable, AnswerError> {
        match &self.rows {
            SurveyedRows::Shown(table) => {
                let names: Vec<&str> = columns.iter().map(|column| column.name.as_ref()).collect();
                if names.iter().all(|name| table.column(name).is_ok()) {
                    return Ok(table.first_rows(most).select(&names)?);
                }
            }
            SurveyedRows::Tabled(table) => {
                let first: Vec<usize> = (0..table.row_count().min(most)).collect();
                // What is damaged is read of the records.
                if let Ok(rows) = rows_of_table(*table, &columns, &first) {
                    return Ok(rows);
                }
            }
        }
        let mut rows = Vec::new();
        visit(study, source, POINTS_AT_ONCE, &mut |block| {
            rows.extend(block.rows(&columns));
            Ok::<bool, AnswerError>(rows.len() < most)
        })?;
        rows.truncate(most);
        Ok(DataTable::new(heads(&columns), rows)?)
    }
}

/// Returns whether a column is kept for summaries and figures.
fn is_shown(study: &Study, column: &Column) -> bool {
    let name = column.name.as_ref();
    let figures = study.figures().iter().chain(study.suggestions());
    let is_drawn = |figure: &Figure| {
        let apart = figure.series.iter().chain(&figure.panels).chain(&figure.names);
        let filter = figure.filtered(None);
        let mut names = apart.chain([&figure.x]).chain(figure.shown());
        names.any(|shown| shown == name) || filter.is_some_and(|filter| filter.contains(name))
    };
    column.role == Role::Axis
        || name == "status"
        || study.kind().usual_columns().contains(&name)
        || figures.clone().any(is_drawn)
}
